"""What messages do, and what they are told when they can't."""

import math
import time

import pytest

from carom.dsp.engine.state import CONTACTS, OBJECTS, RING
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets.library import ObjectPreset, Presets
from carom.server.osc.addresses import VERBS, table
from carom.server.osc.wire import Message
from carom.server.scene.scene import Scene


@pytest.fixture
def scene():
    return Scene(Engine(48_000), Presets())


def say(scene, address, *args, time=NOW):
    return scene.perform([Message(address, args)], time)


def refusal(scene, address, *args):
    (reply,) = say(scene, address, *args)
    assert reply.address == "/fail" and reply.args[0] == address
    return reply.args[1]


def test_an_object_is_made_and_struck(scene):
    assert say(scene, "/object/new", "a", "church-bell") == [Message("/done", ("/object/new", "a"))]
    assert say(scene, "/object/a/impact", 1.0) == []
    assert scene.engine.process(4800).any()


def test_a_pattern_strikes_all_it_matches(scene):
    for name in ("drum1", "drum2", "bell"):
        say(scene, "/object/new", name, "wood-block")
    say(scene, "/object/drum*/impact", 1)
    scene.engine.process(64)
    assert scene.engine.counter("impacts") == 2
    say(scene, "/object/{bell,drum1}/impact", 1)
    scene.engine.process(64)
    assert scene.engine.counter("impacts") == 4


def test_positional_and_key_arguments_mean_the_same():
    def sound(*args):
        scene = Scene(Engine(48_000), Presets())
        say(scene, "/object/new", "a", "glass-plate")
        assert say(scene, "/object/a/impact", *args) == []
        return scene.engine.process(4800)

    reference = sound(1.0, 0.2, "striker", "wood", "gain", -6)
    assert (sound(1, "gain", -6.0, "position", 0.2, "striker", "wood") == reference).all()
    assert not (sound(1.0, 0.3, "striker", "wood", "gain", -6) == reference).all()


def test_a_velocity_of_zero_does_nothing(scene):
    say(scene, "/object/new", "a", "wood-block")
    assert say(scene, "/object/a/impact", 0.0) == []
    assert not scene.engine.process(4800).any()


def test_keys_change_the_preset(scene):
    say(scene, "/object/new", "a", "steel-plate")
    say(scene, "/object/new", "b", "steel-plate", "length", 0.6, "material", "glass", "tune", -12, "position", 0.1)
    a, b = scene.objects["a"], scene.objects["b"]
    assert b.preset.geometry["length"] == 0.6 and b.preset.material.name == "glass" and b.preset.position == 0.1
    frequency = scene.engine.state["frequency"][0]
    assert frequency[b.handle.first] != frequency[a.handle.first]
    scene.engine.process(64)
    assert scene.engine.state["objects"][0][b.handle.slot]["tune"] == 0.5


@pytest.mark.parametrize(
    ("address", "args", "reason"),
    [
        ("/nothing", (), "no such address; expected one of /object/new"),
        ("/object/new", (), "name is missing: expected /object/new name preset"),
        ("/object/new", ("b",), "preset is missing"),
        ("/object/new", ("b", 3), "preset = 3: expected a name"),
        ("/object/new", ("b", "church-bel"), "no object 'church-bel': did you mean church-bell?"),
        ("/object/new", ("a", "church-bell"), "name = a: there is such an object already"),
        ("/object/new", ("b c", "church-bell"), "name = b c: expected 1 to 64 printable characters"),
        ("/object/new", ("b" * 65, "church-bell"), "expected 1 to 64 printable characters"),
        ("/object/new", ("b\x07", "church-bell"), "expected 1 to 64 printable characters"),
        ("/object/new", ("new", "church-bell"), "name = new: expected 1 to 64"),
        ("/object/new", ("", "church-bell"), "name = : expected a name"),
        ("/object/new", ("b", "church-bell", "length", 1, "length", 2), "length = 2: given twice"),
        ("/object/new", ("b", "church-bell", "striker", "wood", "striker", "felt"), "striker = felt: given twice"),
        ("/object/new", ("b", "church-bell", "gain", "loud"), "gain = loud: expected a number from -120 to 40 dB"),
        ("/object/new", ("b", "glass-plate", "length", -1.0), "length = -1.0: expected a number"),
        ("/object/new", ("b", "glass-plate", "colour", 1), "colour = 1: expected one of"),
        ("/object/new", ("b", "glass-plate", "striker", "feather"), "no striker 'feather'"),
        ("/object/new", ("b", "glass-plate", "length"), "length: its value is missing"),
        ("/object/x/impact", (1.0,), "x: no such object; there are a"),
        ("/object/a/kick", (1.0,), "kick: nothing an object does; expected impact"),
        ("/object/a/impact", (), "velocity is missing"),
        ("/object/a/impact", (-1,), "velocity = -1: expected a number from 0 to 1000 m/s"),
        ("/object/a/impact", (math.nan,), "velocity = nan"),
        ("/object/a/impact", (math.inf,), "velocity = inf"),
        ("/object/a/impact", (1e30,), "velocity = 1e+30"),
        ("/object/a/impact", ("fast",), "velocity = fast"),
        ("/object/a/impact", (None,), "velocity = None"),
        ("/object/a/impact", (1.0, 1.5), "position = 1.5: expected a number from 0 to 1"),
        ("/object/a/impact", (1.0, 0.5, "position", 0.2), "position = 0.2: given twice"),
        ("/object/a/impact", (1.0, "mass", 0.0), "mass = 0: expected a number from 1e-09 to 1e+06 kg"),
        ("/object/a/impact", (1.0, "exponent", 0.5), "exponent = 0.5: expected a number from 1 to 4"),
        ("/object/a/impact", (1.0, "loudness", 1), "loudness: no such key; expected striker, mass"),
        ("/object/a/impact", (1.0, 0.5, 0.5), "0.5: expected a key"),
        ("/object/a/impact", (1.0, "mass", 1e3, "stiffness", 1.0), "the contact would last"),
        ("/quality", (1.5,), "quality = 1.5: expected a whole number"),
        ("/accuracy", (-50,), "accuracy = -50: expected -40, -60, -80, exact"),
        ("/object/a/damp", (2.0,), "damp = 2: expected a number from 0 to 1"),
        ("/object/a/pan", (-2.0,), "pan = -2"),
    ],
)
def test_bad_messages_are_told_why(scene, address, args, reason):
    say(scene, "/object/new", "a", "church-bell")
    before = scene.engine.room(), list(scene.objects)
    assert reason in refusal(scene, address, *args)
    assert (scene.engine.room(), list(scene.objects)) == before


def test_a_bundle_is_carried_out_but_for_what_is_wrong_in_it(scene):
    messages = [
        Message("/object/new", ("a", "wood-block")),
        Message("/object/a/impact", (-1.0,)),
        Message("/object/a/impact", (1.0,)),
    ]
    done, failed = scene.perform(messages, NOW)
    assert done.address == "/done" and failed.address == "/fail"
    scene.engine.process(64)
    assert scene.engine.counter("impacts") == 1


def test_a_full_queue_refuses_whole_bundles_and_forgets_nothing(scene):
    say(scene, "/object/new", "a", "wood-block")
    strikes = [Message("/object/a/impact", (1.0,))] * (RING - 1)
    assert scene.perform(strikes, 1e4) == []
    replies = scene.perform(
        [Message("/object/new", ("b", "wood-block")), Message("/object/a/impact", (1.0,)), Message("/object/a/free")], 0
    )
    assert [r.address for r in replies] == ["/fail"] * 3 and "can be queued now" in replies[0].args[1]
    assert list(scene.objects) == ["a"]
    assert (
        "there is such an object already" in say(scene, "/object/new", "a", "tom")[0].args[1]
    )  # the free came to nothing
    scene.engine.process(64)
    assert say(scene, "/object/new", "b", "wood-block")[0].address == "/done"


def test_what_waits_far_ahead_leaves_room_for_now(scene):
    say(scene, "/object/new", "a", "wood-block")
    later = [Message("/object/a/impact", (1.0,))] * 1000
    replies = []
    while not replies:
        replies = scene.perform(later, 1e8)
        scene.engine.process(64)
    assert "events ahead of their time" in replies[0].args[1]
    say(scene, "/object/a/impact", 1.0)
    scene.engine.process(64)
    assert scene.engine.counter("impacts") == 1
    say(scene, "/panic")
    scene.engine.process(64)
    assert scene.engine.counter("queued") == 0 and scene.perform(later, 1e8) == []


def test_an_object_that_is_yet_to_be_can_be_struck_and_freed(scene):
    say(scene, "/object/new", "a", "wood-block", time=4800.0)
    assert say(scene, "/object/a/impact", 1.0) == []
    scene.engine.process(2400)
    assert scene.engine.counter("impacts") == 0
    scene.engine.process(4800)
    assert scene.engine.counter("impacts") == 1
    for _ in range(OBJECTS + 1):
        assert say(scene, "/object/new", "b", "church-bell", time=scene.engine.position + 500.0)[0].address == "/done"
        say(scene, "/object/b/free", 1)
        scene.engine.process(6400)
    assert scene.engine.counter("active") == 1


def test_a_name_is_free_from_the_free_on_and_not_before(scene):
    say(scene, "/object/new", "a", "wood-block", time=0.0)
    assert say(scene, "/object/a/free", time=9600.0) == []
    assert say(scene, "/object/a/impact", 1.0, time=4800.0) == []
    assert "there is such an object already" in say(scene, "/object/new", "a", "church-bell", time=4800.0)[0].args[1]
    assert say(scene, "/object/new", "a", "church-bell", time=9600.0)[0].address == "/done"
    scene.engine.process(48_000)
    assert scene.engine.counter("impacts") == 1 and scene.engine.counter("active") == 1
    assert len(scene.perform([Message("/object/a/free"), Message("/object/new", ("a", "tom"))], NOW)) == 1


@pytest.mark.parametrize("name", ["b", "b*"])
def test_names_mean_who_has_them_at_the_time(scene, name):
    say(scene, "/object/new", "b", "wood-block")
    say(scene, "/object/b/free", time=48_000.0)
    assert say(scene, "/object/new", "c", "wine-glass", time=50_000.0)[0].address == "/done"
    assert say(scene, "/object/new", "b", "church-bell", time=50_000.0)[0].address == "/done"
    assert say(scene, f"/object/{name}/impact", 1.0) == []
    scene.engine.process(4800)
    assert scene.engine.counter("impacts") == 1  # of the block, not put off until the bell is there
    assert say(scene, "/object/b/impact", 1.0, time=60_000.0) == []
    scene.engine.process(96_000)
    assert scene.engine.counter("impacts") == 2 and scene.engine.counter("active") == 2
    assert say(scene, "/panic") == [] and not scene._displaced


def full(scene, address, *args, time=NOW):
    """Say it while there is no room in the queue; it is refused."""
    scene.perform([Message("/object/b/damp", (0.0,))] * scene.engine.room(), NOW)
    assert [reply.address for reply in say(scene, address, *args, time=time)] == ["/fail"]


def test_what_found_no_room_left_nothing(scene):
    say(scene, "/object/new", "b", "wood-block")
    full(scene, "/object/b/free", 1)
    places = len(scene.engine._slots)
    assert say(scene, "/object/new", "c", "wood-block")[0].address == "/fail"
    assert len(scene.engine._slots) == places
    scene.engine.process(64)
    say(scene, "/object/b/free", time=48_000.0)
    full(scene, "/object/new", "b", "tom", time=50_000.0)
    scene.engine.process(64)
    assert say(scene, "/object/b/impact", 1.0) == [] and not scene._displaced
    scene.engine.process(96_000)
    assert scene.engine.counter("impacts") == 1 and scene.engine.counter("active") == 0
    assert say(scene, "/panic") == [] and not scene.objects
    for name in "bc":
        assert say(scene, "/object/new", name, "wood-block")[0].address == "/done"
    b, c = (scene.objects[name].handle for name in "bc")
    assert b.slot != c.slot and b.first != c.first  # what was given back was given back once


def test_what_is_late_comes_before_what_is_for_now(scene):
    scene.engine.process(4800)
    say(scene, "/object/new", "b", "church-bell", time=4000.0)
    say(scene, "/object/b/impact", 1.0)
    scene.engine.process(64)
    assert scene.engine.counter("impacts") == 1 and scene.engine.counter("late") == 1


def test_an_edited_striker_counts_from_the_next_object_on(tmp_path):
    (tmp_path / "strikers").mkdir()
    striker = tmp_path / "strikers" / "mine.toml"
    law = 'description = "d"\nsource = "s"\nstiffness = 1e8\ndissipation = 0.1\nexponent = 1.5\nmass = '
    scene = Scene(Engine(48_000), Presets([tmp_path]))
    for name, mass in (("a", 0.001), ("b", 0.002)):
        striker.write_text(f"{law}{mass}\n")
        say(scene, "/object/new", name, "wood-block")
        assert say(scene, "/object/a/impact", 1.0, "striker", "mine") == []
        assert scene.engine.state["ring"][0][scene.engine.sent - 1]["values"][2] == mass


def test_what_is_changed_with_an_object_is_its_own(scene):
    """What a message does not say is the object's, and not the preset's nor a middle."""
    say(scene, "/object/new", "a", "glass-plate", "position", 0.1, "striker", "felt")
    say(scene, "/object/new", "b", "glass-plate", "position", 0.9)
    say(scene, "/object/a/impact", 1.0, "by", "b")
    values = scene.engine.state["ring"][0][scene.engine.sent - 1]["values"]
    assert values[1] == 0.1 and values[10] == 0.9
    assert values[3] == scene.presets.striker("felt").contact(scene.objects["a"].preset.material)[1]


@pytest.mark.parametrize("key", ["preset", "striker", "material"])
def test_overlong_names_are_refused(scene, key):
    words = ("b", "a" * 300) if key == "preset" else ("b", "glass-plate", key, "\x01" * 30_000)
    assert len(refusal(scene, "/object/new", *words)) < 1000


def test_objects_run_out_and_come_back(scene):
    for i in range(OBJECTS):
        assert say(scene, "/object/new", f"o{i}", "church-bell")[0].address == "/done"
    assert f"all {OBJECTS} are taken" in refusal(scene, "/object/new", "more", "church-bell")
    say(scene, "/object/*/free", 1)
    scene.engine.process(9600)
    assert say(scene, "/object/new", "more", "church-bell")[0].address == "/done"


def test_modes_run_out(scene, monkeypatch):
    modes = scene.presets.object("tom").modes(scene.engine.top_frequency)
    with monkeypatch.context() as patch:
        patch.setattr(ObjectPreset, "modes", lambda *_: modes)  # found once for all
        for i in range(100):
            (reply,) = say(scene, "/object/new", f"o{i}", "tom")
            if reply.address == "/fail":
                break
    assert "no room for" in reply.args[1]
    assert say(scene, "/object/new", "small", "tuning-fork")[0].address == "/done"


def test_too_many_contacts_leave_the_rest_alone(scene):
    say(scene, "/object/new", "a", "glass-plate")
    say(scene, "/object/new", "b", "wood-block")
    strike = Message("/object/a/impact", (0.01, "mass", 1e-7, "stiffness", 1e-3, "exponent", 1.0))
    scene.perform([strike] * (CONTACTS + 5), NOW)
    scene.engine.process(64)
    assert scene.engine.counter("contacts_dropped") == 5
    scene.engine.process(48_000)
    say(scene, "/object/b/impact", 1.0)
    assert scene.engine.process(480).any()


def test_the_table_names_every_address_and_key():
    text = table()
    for verb in VERBS.values():
        assert f"`{verb.address}`" in text
        for argument in (*verb.required, *verb.optional, *verb.keys):
            assert f"`{argument.name}`" in text


@pytest.mark.parametrize(
    ("pattern", "struck"),
    [
        ("/*/bell/impact", ["bell"]),
        ("/object/b*/{impact,damp}", ["bell", "bar"]),
        ("/obj[a-z]ct/{bell,tom}/i?pact", ["bell", "tom"]),
        ("/*/*/*pact", ["bell", "bar", "tom"]),
        ("/object/b[a]r/impact", ["bar"]),
        ("/object/ba?/impact", ["bar"]),
    ],
)
def test_every_part_of_an_address_may_be_a_pattern(scene, pattern, struck):
    for name in ("bell", "bar", "tom"):
        say(scene, "/object/new", name, "wood-block")
    assert say(scene, pattern, 1.0) == []
    scene.engine.process(4800)
    assert scene.engine.counter("impacts") == len(struck)
    damped = [scene.engine.state[0]["objects"]["damp"][scene.objects[name].handle.slot] for name in ("bell", "tom")]
    assert damped == [float("damp" in pattern), 0.0]


def test_patterns_reach_verbs_without_objects(scene):
    say(scene, "/object/new", "a", "wood-block")
    assert say(scene, "/[op]anic") == []
    assert say(scene, "/con*", "rk4", 4) == []
    assert say(scene, "/{object,}/ne?", "b", "tom") == [Message("/done", ("/object/new", "b"))]
    assert "no such address" in refusal(scene, "/panic*/x")
    assert "no such address" in refusal(scene, "/qui?")
    assert "no such address" in refusal(scene, "/object/{a")
    assert "z*: no such object" in refusal(scene, "/object/z*/impact", 1.0)


def test_what_a_pattern_can_not_do_is_told_for_each(scene):
    say(scene, "/object/new", "a", "wood-block")
    replies = say(scene, "/object/a/{damp,pan,decay}", -0.5)
    assert [reply.args[0] for reply in replies] == ["/object/a/damp", "/object/a/decay"]


def test_a_bundle_that_strikes_everything_without_end_is_refused_in_time(scene):
    for n in range(100):
        say(scene, "/object/new", f"o{n}", "wood-block")
    scene.engine.process(64)
    started = time.process_time()
    replies = scene.perform([Message("/object/*/impact", (1.0,))] * 2_700, NOW)
    assert time.process_time() - started < 1.0
    assert len(replies) == 2_700 and all("no room" in reply.args[1] for reply in replies)
    assert say(scene, "/object/*/impact", 1.0) == []


def test_one_among_many_is_found_at_once(scene):
    for n in range(OBJECTS):
        say(scene, "/object/new", f"o{n}", "wood-block")
        scene.engine.process(64)
    started = time.process_time()
    for n in range(2000):
        assert say(scene, f"/object/o{n % OBJECTS}/impact", 0) == []
    assert time.process_time() - started < 1.0


def test_what_fails_by_a_fault_of_ours_leaves_nothing(scene, monkeypatch):
    assert "self = 1: expected one of" in refusal(scene, "/object/new", "a", "church-bell", "self", 1)

    def broken(*_):
        raise KeyError("a fault")

    monkeypatch.setattr(scene, "_impact", broken)
    new = [Message("/object/new", (f"a{n}", "wood-block")) for n in range(5)]
    with pytest.raises(KeyError):
        scene.perform([*new, Message("/object/a0/impact", (1.0,))], NOW)
    assert scene.objects == {} and say(scene, "/object/new", "a0", "wood-block")[0].address == "/done"
