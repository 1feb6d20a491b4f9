"""Objects by name: made, changed, struck and freed, each at its time."""

import time

import pytest

from carom.dsp.engine.memory.capacity import USUAL_OBJECTS
from carom.dsp.native.system import clock_ns
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets.library import ObjectPreset, Presets
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.dsp.engine.support import active
from tests.server.scene.support import refusal, say


def test_an_object_is_made_and_struck(session):
    assert say(session, "/object/new", "a", "church-bell") == [Message("/done", ("/object/new", "a"))]
    assert say(session, "/object/a/impact", 1.0) == []
    assert session.engine.process(4800).any()


def test_positional_and_key_arguments_mean_the_same():
    def sound(*args):
        session = Session(Engine(48_000), Presets())
        say(session, "/object/new", "a", "glass-plate")
        assert say(session, "/object/a/impact", *args) == []
        return session.engine.process(4800)

    reference = sound(1.0, 0.2, "striker", "wood", "gain", -6)
    assert (sound(1, "gain", -6.0, "position", 0.2, "striker", "wood") == reference).all()
    assert not (sound(1.0, 0.3, "striker", "wood", "gain", -6) == reference).all()


def test_a_velocity_of_zero_does_nothing(session):
    say(session, "/object/new", "a", "wood-block")
    assert say(session, "/object/a/impact", 0.0) == []
    assert not session.engine.process(4800).any()


def test_keys_change_the_preset(session):
    say(session, "/object/new", "a", "steel-plate")
    say(session, "/object/new", "b", "steel-plate", "length", 0.6, "material", "glass", "tune", -12, "position", 0.1)
    a, b = session.objects["a"], session.objects["b"]
    assert b.preset.geometry["length"] == 0.6 and b.preset.material.name == "glass" and b.preset.position == 0.1
    frequency = session.engine.state["bank"]["frequency"][0]
    assert frequency[b.handle.first] != frequency[a.handle.first]
    session.engine.process(64)
    assert session.engine.state["objects"][0][b.handle.slot]["settings"]["tune"] == 0.5


def last_sent(session):
    """Return the last command that the engine was sent."""
    return session.engine.state["ring"]["entries"][0][session.engine.sent - 1]


def test_values_given_with_an_object_are_its_defaults(session):
    """The object has the value that a message leaves out, not the preset or a middle."""
    say(session, "/object/new", "a", "glass-plate", "position", 0.1, "striker", "felt")
    say(session, "/object/new", "b", "glass-plate", "position", 0.9)
    say(session, "/object/a/impact", 1.0, "by", "b")
    strike = last_sent(session)["values"]
    assert strike["position"] == 0.1 and strike["by_position"] == 0.9
    say(session, "/object/a/impact", 1.0)
    felt = session.presets.striker("felt").contact(session.objects["a"].preset.material)
    assert last_sent(session)["values"]["stiffness"] == felt[1]


def test_an_edited_striker_counts_from_the_next_object_on(tmp_path):
    (tmp_path / "strikers").mkdir()
    striker = tmp_path / "strikers" / "mine.toml"
    law = 'description = "d"\nsource = "s"\nstiffness = 1e8\ndissipation = 0.1\nexponent = 1.5\nmass = '
    session = Session(Engine(48_000), Presets([tmp_path]))
    for name, mass in (("a", 0.001), ("b", 0.002)):
        striker.write_text(f"{law}{mass}\n")
        say(session, "/object/new", name, "wood-block")
        assert say(session, "/object/a/impact", 1.0, "striker", "mine") == []
        assert last_sent(session)["values"]["mass"] == mass


@pytest.mark.slow
def test_an_object_that_is_yet_to_be_can_be_struck_and_freed(session):
    say(session, "/object/new", "a", "wood-block", time=4800.0)
    assert say(session, "/object/a/impact", 1.0) == []
    session.engine.process(2400)
    assert session.engine.stats.impacts == 0
    session.engine.process(4800)
    assert session.engine.stats.impacts == 1
    for _ in range(USUAL_OBJECTS + 1):
        (reply,) = say(session, "/object/new", "b", "church-bell", time=session.engine.position + 500.0)
        assert reply.address == "/done"
        say(session, "/object/b/free", 1)
        session.engine.process(6400)
    assert active(session.engine) == 1


def test_a_name_is_free_from_the_free_on_and_not_before(session):
    say(session, "/object/new", "a", "wood-block", time=0.0)
    assert say(session, "/object/a/free", time=9600.0) == []
    assert say(session, "/object/a/impact", 1.0, time=4800.0) == []
    assert "there is such an object already" in say(session, "/object/new", "a", "church-bell", time=4800.0)[0].args[1]
    assert say(session, "/object/new", "a", "church-bell", time=9600.0)[0].address == "/done"
    session.engine.process(48_000)
    assert session.engine.stats.impacts == 1 and active(session.engine) == 1
    assert len(session.perform([Message("/object/a/free"), Message("/object/new", ("a", "tom"))], NOW)) == 1


@pytest.mark.parametrize("name", ["b", "b*"])
def test_names_mean_who_has_them_at_the_time(session, name):
    say(session, "/object/new", "b", "wood-block")
    say(session, "/object/b/free", time=48_000.0)
    assert say(session, "/object/new", "c", "wine-glass", time=50_000.0)[0].address == "/done"
    assert say(session, "/object/new", "b", "church-bell", time=50_000.0)[0].address == "/done"
    assert say(session, f"/object/{name}/impact", 1.0) == []
    session.engine.process(4800)
    assert session.engine.stats.impacts == 1  # of the block, not put off until the bell is there
    assert say(session, "/object/b/impact", 1.0, time=60_000.0) == []
    session.engine.process(96_000)
    assert session.engine.stats.impacts == 2 and active(session.engine) == 2
    assert say(session, "/panic") == [] and not session.objects.replaced


def test_late_messages_come_before_those_for_now(session):
    session.engine.process(4800)
    say(session, "/object/new", "b", "church-bell", time=4000.0)
    say(session, "/object/b/impact", 1.0)
    session.engine.process(64)
    assert session.engine.stats.impacts == 1 and session.engine.stats.late == 1


@pytest.mark.slow
def test_objects_run_out_and_come_back(session):
    for i in range(USUAL_OBJECTS):
        assert say(session, "/object/new", f"o{i}", "church-bell")[0].address == "/done"
    assert f"all {USUAL_OBJECTS} are taken" in refusal(session, "/object/new", "more", "church-bell")
    say(session, "/object/*/free", 1)
    session.engine.process(9600)
    assert say(session, "/object/new", "more", "church-bell")[0].address == "/done"


def test_modes_run_out(session, monkeypatch):
    modes = session.presets.object("tom").modes(session.engine.top_frequency)
    with monkeypatch.context() as patch:
        patch.setattr(ObjectPreset, "modes", lambda *_: modes)  # found once for all
        for i in range(200):
            (reply,) = say(session, "/object/new", f"o{i}", "tom")
            if reply.address == "/fail":
                break
    assert "no capacity for" in reply.args[1]
    say(session, "/object/o0/free", 1)
    session.engine.process(640)
    assert say(session, "/object/new", "small", "tuning-fork")[0].address == "/done"


@pytest.mark.slow
def test_object_among_many_is_found_at_once(session):
    for n in range(USUAL_OBJECTS):
        say(session, "/object/new", f"o{n}", "wood-block")
        session.engine.process(64)
    started = time.process_time()
    for n in range(2000):
        assert say(session, f"/object/o{n % USUAL_OBJECTS}/impact", 0) == []
    assert time.process_time() - started < 1.0


def test_an_object_that_the_clock_holds_back_is_freed_all_the_same(session):
    # Sound that is computed faster than the clock goes sets it again and again: the object comes when the clock says
    # so, thousands of samples after the one that was told for it.
    engine = session.engine
    engine.process(64)
    due = clock_ns() + 100_000_000
    say(session, "/object/new", "a", "wood-block", time=engine.stamp(due))
    while engine.position <= session.objects["a"].born:
        engine.process(64)
    assert clock_ns() < due and not engine.objects["used"].any()
    assert say(session, "/object/a/gain", -6.0) == say(session, "/object/a/free", 1) == []
    while clock_ns() < due + 20_000_000:
        engine.process(64)
    assert not engine.objects["used"].any() and engine.objects["serial"].any()
    assert say(session, "/object/new", "a", "wood-block")[0].address == "/done"
    assert engine.objects.shape == (1,)  # its place was free again
