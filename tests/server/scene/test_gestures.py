"""Gestures over OSC: started, steered, stopped, refused, and told when they end."""

from contextlib import nullcontext

import numpy as np
import pytest

from carom.dsp.engine.state import End
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets.library import Presets
from carom.server.osc.addresses import Refused
from carom.server.osc.wire import Message
from carom.server.scene.gesture_ids import Gestures
from carom.server.scene.limits import GRAVITY, fall, require_rest, require_short
from carom.server.scene.scene import Scene
from tests.support import Running


@pytest.fixture
def scene():
    scene = Scene(Engine(48_000), Presets())
    for name, preset in (("pane", "glass-plate"), ("cup", "plastic-cup")):
        say(scene, "/object/new", name, preset)
    return scene


def say(scene, address, *args, time=NOW, source=None):
    return scene.perform([Message(address, args)], time, source)


def refusal(scene, address, *args):
    (reply,) = say(scene, address, *args)
    assert reply.address == "/fail" and reply.args[0] == address
    return reply.args[1]


def seconds(scene, t):
    scene.engine.process(int(t * 48_000))


def ids(scene):
    return [(ended.id, ended.source) for ended in scene.take_ends()]


@pytest.mark.parametrize("velocity", [0.0, 2.0, -2.0])
def test_a_fall_is_a_parabola(velocity):
    v_in, t = fall(1.5, velocity, GRAVITY)
    assert velocity * t + GRAVITY * t**2 / 2 == pytest.approx(1.5) and v_in == pytest.approx(velocity + GRAVITY * t)
    assert fall(0.0, 0.0, GRAVITY) == (0.0, 0.0)
    assert fall(1e-9, 100.0, GRAVITY)[1] == pytest.approx(1e-11, rel=1e-6, abs=0.0)  # nothing cancels


@pytest.mark.parametrize(
    ("contact", "short"),
    [
        ((0.08, 1.0, 0.0, 1.0), True),  # pi sqrt(m/k) = 0.89 s
        ((0.11, 1.0, 0.0, 1.0), False),  # 1.04 s
        ((0.0225, 1.0, 0.0, 1.0), True),  # 0.47 s,
        ((0.0225, 1.0, 10.0, 1.0), False),  # but it sticks
    ],
)
def test_a_contact_lasts_a_second_at_most(contact, short):
    with nullcontext() if short else pytest.raises(Refused, match="the contact would last"):
        require_short(1.0, contact)


def test_a_bounce_lasts_an_hour_at_most():
    require_rest(1.0, (0.01, 1e9, 0.0012, 1.5), GRAVITY)
    with pytest.raises(Refused, match="the bounce might last"):
        require_rest(1.0, (0.01, 1e9, 0.00085, 1.5), GRAVITY)


def test_a_bounce_touches_again_and_again_and_its_end_is_told(scene):
    assert say(scene, "/object/pane/bounce", 0.05, "striker", "ping-pong", "id", "ball", source="me") == []
    seconds(scene, 1.0)
    assert scene.engine.counter("impacts") > 5 and scene.take_ends() == []
    seconds(scene, 20.0)
    assert ids(scene) == [("ball", "me")] and scene.engine.quiet()


def test_gestures_are_stopped_by_name_or_pattern(scene):
    for i in range(4):
        say(scene, "/object/pane/bounce", 1.0, "id", f"ball{i}")
    say(scene, "/object/cup/bounce", 1.0)
    assert say(scene, "/gesture/ball[0-2]/stop") == []
    seconds(scene, 0.01)
    assert sorted(ids(scene)) == [("ball0", None), ("ball1", None), ("ball2", None)]
    assert say(scene, "/gesture/ball0/stop") == []  # once more does no harm
    assert "no such gesture; there are ball0" in refusal(scene, "/gesture/marble/stop")
    say(scene, "/gesture/cup-*/stop")
    say(scene, "/object/pane/free")
    seconds(scene, 0.01)
    assert sorted(ids(scene)) == [("ball3", None), ("cup-1", None)]


def test_gestures_are_steered(scene):
    say(scene, "/object/pane/bounce", 1.0, "id", "ball", "irregularity", 0.3)
    for what, value in (("gain", -6), ("position", 0.2), ("gravity", 1.62), ("irregularity", 1)):
        assert say(scene, f"/gesture/ball/{what}", value) == []
    seconds(scene, 0.1)
    (contact,) = (c for c in scene.engine.state["contacts"][0] if c["serial"])
    assert contact["loudness"] == pytest.approx(0.501, abs=1e-3) and contact["gravity"] == 1.62
    assert contact["moved_to"] == 0.2 and contact["irregularity"] == 1.0
    assert "gravity = 0: expected a number from 0.01" in refusal(scene, "/gesture/ball/gravity", 0)
    assert "jump: nothing a gesture does; expected stop, gain" in refusal(scene, "/gesture/ball/jump")


def test_an_object_strikes_another(scene):
    assert say(scene, "/object/pane/impact", 0.5, "by", "cup", "by_position", 0.3) == []
    scene.engine.process(640)
    assert scene.engine.counter("sounding") == 2
    assert "by = pane: expected another object; there are cup" in refusal(scene, "/object/pane/impact", 1, "by", "pane")
    for other in ("lid", "c*"):
        assert f"by = {other}: expected another" in refusal(scene, "/object/pane/impact", 1, "by", other)


def touching(scene):
    """The contacts that there are."""
    return [contact for contact in scene.engine.state["contacts"][0] if contact["serial"]]


def test_what_strikes_with_an_object_has_its_mass_and_its_place_and_waits_for_it(scene):
    say(scene, "/object/pane/impact", 0.5, "by", "cup", "id", "x")
    scene.engine.process(64)
    (contact,) = touching(scene)
    cup = scene.objects["cup"]
    assert contact["m"] == cup.mass and contact["body"][1]["slot"] == cup.handle.slot
    say(scene, "/object/new", "later", "plastic-cup", time=scene.engine.position + 4_800.0)
    before = scene.engine.counter("impacts")
    say(scene, "/object/pane/impact", 0.5, "by", "later")
    seconds(scene, 0.05)
    assert scene.engine.counter("impacts") == before
    seconds(scene, 0.1)
    assert scene.engine.counter("impacts") > before


def test_a_rolling_body_loses_what_its_surface_takes(scene):
    for name, *own in (("pane",), ("cup", "dissipation", 0.3)):
        say(scene, f"/object/{name}/roll", 0.5, "striker", "steel", "surface", "glass", *own)
    scene.engine.process(64)
    assert {contact["mu"] for contact in touching(scene)} == {Presets().surface("glass").dissipation, 0.3}


def test_a_roll_that_goes_on_needs_no_ball_to_be_steered(scene):
    assert say(scene, "/object/pane/roll", 0.5, "striker", "steel") == []
    assert say(scene, "/object/pane/roll", 0.7, "striker", "felt-hammer", "roughness", 100) == []
    assert "radius is missing" in refusal(scene, "/object/cup/roll", 0.5, "striker", "felt-hammer")


@pytest.mark.parametrize("striker", ["fingertip", "wood", "steel"])
def test_a_press_goes_on_until_it_is_stopped(scene, striker):
    say(scene, "/object/pane/press", 1.0, "striker", striker, "id", "hand")
    seconds(scene, 1.0)
    assert scene.take_ends() == []
    say(scene, "/gesture/hand/stop")
    seconds(scene, 1.0)
    assert ids(scene) == [("hand", None)]


@pytest.mark.parametrize(
    ("args", "reason"),
    [
        ((), "height is missing"),
        ((-0.1,), "height = -0.1: expected a number from 0 to 1000 m"),
        ((float("nan"),), "height = nan: expected"),
        ((1e9,), "height = 1e+09: expected"),
        ((1, "gravity", 0), "gravity = 0: expected"),
        ((1, "gravity", -9.81), "gravity = -9.81: expected"),
        ((1, "mass", 0), "mass = 0: expected"),
        ((1, "mass", float("inf")), "mass = inf: expected"),
        ((1, "dissipation", 0), "dissipation = 0: the bounce would never end"),
        ((1, "dissipation", 1e-5), "dissipation = 1e-05: the bounce might last"),
        ((1, "irregularity", 2), "irregularity = 2: expected"),
        ((1, "seed", 0.5), "seed = 0.5: expected a whole number"),
        ((1, "id", "a b"), "id = a b: expected 1 to 64"),
        ((1, "id", 3), "id = 3: expected a name"),
        ((1, "stiffness", 1e-3, "mass", 1e6), "the contact would last"),
    ],
)
def test_a_bounce_that_can_not_be_is_refused_and_leaves_nothing(scene, args, reason):
    assert reason in refusal(scene, "/object/pane/bounce", *args)
    assert scene.gestures.known() == [] and scene.engine.room() == 8192 - 2


@pytest.mark.parametrize(
    ("action", "args", "reason"),
    [
        ("roll", ("striker", "felt-hammer"), "radius is missing: the striker has none"),
        ("roll", ("striker", "steel", "radius", 1e-3, "roughness", 100), "radius = 0.001: expected at least"),
        ("roll", ("striker", "steel", "radius", 8e-4, "surface", "corrugated"), "radius = 0.0008: expected at least"),
        ("roll", ("striker", "steel", "corners", 0.5), "corners = 0.5: expected a whole number"),
        ("roll", ("striker", "steel", "surface", "mud"), "no surface 'mud'"),
        ("press", ("mass", 1e6, "stiffness", 1e-3), "the contact would last"),
        ("impact", ("id", "x" * 65), "expected 1 to 64 printable characters"),
        ("impact", ("id", "x\x07"), "expected 1 to 64 printable characters"),
    ],
)
def test_other_gestures_that_can_not_be_leave_nothing_either(scene, action, args, reason):
    assert reason in refusal(scene, f"/object/pane/{action}", 1.0, *args)
    assert scene.gestures.known() == [] and scene.engine.room() == 8192 - 2


class Ending:
    """An engine whose gestures end when one says so."""

    def __init__(self):
        self.ends = []

    def ended(self):
        ends, self.ends = self.ends, []
        return ends


def test_ids_are_remembered_while_something_goes_on_and_for_a_while_after():
    engine = Ending()
    gestures = Gestures(engine)
    gestures.new("on", "/object/a/press", "me")
    for n in range(4_500):
        id = gestures.new(f"g{n}", "/object/a/impact", "me")
        engine.ends.append((id.number, End.RESTED))
        gestures.collect()
    known = [id.name for id in gestures.known()]
    assert len(known) == len(gestures._numbers) == 4_096
    assert known[0] == "on" and known[1:] == [f"g{n}" for n in range(4_500 - 4_095, 4_500)]
    assert gestures.goes_on("on", "/object/a/press") and not gestures.goes_on("on", "/object/a/roll")
    assert not gestures.goes_on("g4499", "/object/a/impact")
    assert [ended.id for ended in gestures.take_ends()] == [f"g{n}" for n in range(4_500)]
    assert gestures.take_ends() == []


def test_the_end_of_a_roll_is_told_to_who_began_it():
    engine = Ending()
    gestures = Gestures(engine)
    for source in ("first", "steers", "second"):
        id = gestures.new("r", "/object/a/roll", source)
    gestures.forget(id)
    engine.ends = [(id.number, End.JOINED)]
    assert gestures.take_ends() == []
    gestures.new("r", "/object/a/roll", "next")
    engine.ends = [(id.number, End.STOPPED), (id.number, End.NO_ROOM)]
    assert [(ended.source, ended.end) for ended in gestures.take_ends()] == [
        ("first", End.STOPPED), ("next", End.NO_ROOM)
    ]  # fmt: skip


def test_ends_are_told_to_those_who_asked(server: Running):
    with server.client() as client, server.client() as other:
        other.ask("/notify", 1)
        client.new("pane", "glass-plate", gain=-40)
        for i in range(600):
            client.send("/object/pane/bounce", 0.2, "id", f"b{i}")
        client.send("/gesture/*/stop")
        ends = [reply for reply in client.replies(1.5) if reply.address in ("/gesture/end", "/fail")]
        assert {reply.args[0] for reply in ends if reply.address == "/gesture/end"} == {f"b{i}" for i in range(600)}
        full = [reply.args[1] for reply in ends if reply.address == "/fail"]
        assert (
            len(full) == 600 - 512 and full[0] == "b512: no room, 512 contacts go on already, or 8192 modes are touched"
        )
        # It did not read meanwhile: its system kept what its buffer holds.
        assert sum(reply.address == "/gesture/end" for reply in other.replies(0.5)) > 100


def test_rolls_of_one_id_are_one_roll_whatever_the_order_of_their_times(scene):
    """What is sent later for sooner, and what waits when it is stopped: the engine decides when its time has come."""
    for args, time in (((0.5,), NOW), ((0.3,), 9_600.0), ((0.0,), 4_800.0), ((0.7,), 2_400.0)):
        assert say(scene, "/object/pane/roll", *args, "striker", "steel", time=time) == []
    most = 0
    for _ in range(40):
        seconds(scene, 0.01)
        most = max(most, scene.engine.counter("rolls_active"))
    assert most == 1 and scene.engine.counter("rolls_active") == 1
    assert say(scene, "/object/pane/roll", 0) == []
    seconds(scene, 1.0)
    assert scene.engine.counter("rolls_active") == 0
    assert set(ids(scene)) == {("pane", None)}
    assert not any(id.started for id in scene.gestures.known())  # each that was sent has ended or joined


def test_every_gesture_that_was_named_is_told_of_once(scene):
    for n, (address, args) in enumerate(
        (
            ("/object/pane/bounce", (0.1,)), ("/object/cup/roll", (0.4, "striker", "steel")),
            ("/object/pane/impact", (1.0,)), ("/object/cup/press", (1.0,)), ("/object/pane/impact", (0.0,)),
            ("/object/pane/bounce", (0.0,)), ("/object/cup/roll", (0.0,)),
        )
    ):  # fmt: skip
        assert say(scene, address, *args, "id", f"g{n}", time=24_000.0) == []
    say(scene, "/panic")
    seconds(scene, 1.0)
    assert sorted(ids(scene)) == [(f"g{n}", None) for n in range(7)]
    say(scene, "/object/pane/bounce", 0.1, "id", "late", time=scene.engine.position + 24_000.0)
    say(scene, "/object/pane/free", 1)
    seconds(scene, 1.0)
    assert ids(scene) == [("late", None)]


def test_a_heavy_striker_is_let_go_of(scene):
    say(scene, "/object/new", "tom", "tom")
    say(scene, "/object/tom/bounce", 0.01, "mass", 1e5, "striker", "steel", "id", "x")
    seconds(scene, 0.5)
    assert say(scene, "/gesture/x/stop") == []
    seconds(scene, 1.0)
    assert ids(scene) == [("x", None)] and scene.engine.counter("contacts_active") == 0
    say(scene, "/object/tom/impact", 0.01, "mass", 1e5, "id", "y")
    seconds(scene, 3.0)
    assert ids(scene) == [("y", None)]


def test_only_what_falls_feels_gravity_and_only_a_hand_a_force(scene):
    say(scene, "/object/pane/impact", 0.3, "striker", "yarn", "id", "i")
    seconds(scene, 0.003)
    assert say(scene, "/gesture/*/gravity", 9.81) == []
    assert say(scene, "/gesture/*/force", 1000) == []
    seconds(scene, 3.0)
    assert ids(scene) == [("i", None)]


@pytest.mark.parametrize("words", [("glass",), ("pane", "by", "glass")])
def test_nothing_is_heard_of_what_is_merely_bent(scene, words):
    """A hand of 10 N on a thin glass, or the glass on a pane: no direct current, and no thump of its coming."""
    name, *by = words
    say(scene, "/object/new", "glass", "wine-glass")
    say(scene, f"/object/{name}/press", 10, *by, "striker", "fingertip", "id", "hand")
    sound = scene.engine.process(96_000)
    assert abs(sound).max() < 0.2 and abs(sound[-4_800:].mean(axis=0)).max() < 1e-3
    say(scene, "/gesture/hand/stop")
    seconds(scene, 2.0)
    assert ids(scene) == [("hand", None)]


@pytest.mark.parametrize(("quality", "sounding"), [(3, 1), (4, 0)])
def test_what_bounces_goes_on_when_the_object_is_left_out(scene, quality, sounding):
    say(scene, "/quality", quality)
    say(scene, "/object/pane/bounce", 3.0, "striker", "ping-pong", "id", "x")
    seconds(scene, 1.5)
    assert scene.engine.counter("impacts") == 1 and scene.engine.counter("sounding") == sounding  # it is in the air
    seconds(scene, 2.0)
    assert scene.engine.counter("impacts") > 3 and scene.engine.counter("sounding") == 1


def peak(scene, t):
    return np.abs(scene.engine.process(round(t * scene.engine.rate))).max()


def test_a_panic_leaves_nothing_of_what_was_bent(scene):
    say(scene, "/object/pane/press", 100.0, "striker", "rubber")
    seconds(scene, 1.0)
    assert np.abs(scene.engine.state["objects"]["lean"]).max() > 0.1
    scene.perform([Message("/panic"), Message("/object/pane/impact", (1e-6,))], NOW)
    assert 0 < peak(scene, 0.01) < 1e-6


def test_an_object_that_presses_and_goes_leaves_its_mass(scene):
    """In the place of one that was bent another is at rest, and what it pressed on comes to rest."""
    say(scene, "/object/new", "bell", "church-bell")
    say(scene, "/object/new", "lid", "tin-lid")
    say(scene, "/object/bell/press", 50.0, "by", "lid", "id", "hand")
    seconds(scene, 2.0)
    say(scene, "/object/lid/free", 1)
    seconds(scene, 1.0)
    assert peak(scene, 0.1) < 1e-6 and scene.engine.counter("contacts_active") == 1
    say(scene, "/object/new", "other", "tin-lid")
    say(scene, "/object/other/impact", 1e-6)
    assert peak(scene, 0.01) < 1e-5


def test_a_hand_that_does_not_press_hovers(scene):
    def ringing():
        say(scene, "/object/bar/impact", 1.0)
        seconds(scene, 0.3)
        return peak(scene, 0.05)

    say(scene, "/object/new", "bar", "triangle")
    say(scene, "/object/bar/press", 0, "id", "hand", "striker", "hand")
    seconds(scene, 3.0)
    free = ringing()
    say(scene, "/gesture/hand/force", 10.0)
    seconds(scene, 1.0)
    muted = ringing()
    say(scene, "/gesture/hand/force", 0)
    seconds(scene, 5.0)
    assert scene.take_ends() == [] and ringing() > 100 * muted and free > 100 * muted


def test_nothing_is_heard_of_modes_that_are_bent_and_silent(scene):
    say(scene, "/object/new", "bar", "marimba-bar", "tune", 60)
    say(scene, "/object/bar/press", 100.0)
    seconds(scene, 1.0)
    assert peak(scene, 0.1) < 1e-8


@pytest.mark.parametrize("rate", [8_000, 48_000, 192_000])
def test_the_heaviest_damping_is_silence_and_no_fault(rate):
    scene = Scene(Engine(rate), Presets())
    for name, preset, *keys in (
        ("cup", "plastic-cup", "decay", 0.001),
        ("block", "wood-block", "beta", 1e-3, "decay", 0.001),
        ("tile", "ceramic-tile", "alpha", 1e4, "decay", 0.001, "damp", 1),
        ("bell", "church-bell"),
    ):
        assert say(scene, "/object/new", name, preset, *keys)[0].address == "/done"
    say(scene, "/object/*/impact", 1.0)
    say(scene, "/object/bell/impact", 1.0, "by", "cup")
    seconds(scene, 0.2)
    assert scene.engine.counter("faults") == 0 and peak(scene, 0.1) > 1e-3


def test_ids_are_kept_and_made_where_they_are_needed(scene):
    long = "x" * 64
    say(scene, "/object/new", long, "wood-block")
    assert say(scene, f"/object/{long}/bounce", 0.01) == [] and say(scene, f"/object/{long}/press", 1.0) == []
    say(scene, "/object/pane/bounce", 0.01, "id", "ball")
    seconds(scene, 20.0)
    assert ("ball", None) in ids(scene)
    refusal(scene, "/object/pane/bounce", 0.01, "id", "ball", "dissipation", 1e-310)
    assert say(scene, "/gesture/ball/stop") == []  # it was known before, and still is


def test_each_object_has_a_roll_of_its_own_by_an_id(scene):
    say(scene, "/object/cup/roll", 0.1, "striker", "steel", "id", "x")
    assert refusal(scene, "/object/pane/roll", 0.1, "striker", "yarn", "id", "x") == (
        "radius is missing: the striker has none"
    )
    assert say(scene, "/object/cup/roll", 0.2, "striker", "yarn", "id", "x") == []
