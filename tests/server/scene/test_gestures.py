"""Gestures over OSC: bounces, rolls, presses, and objects that strike others."""

import numpy as np
import pytest

from carom.dsp.runtime.engine import NOW, Engine
from carom.presets.library import Presets
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.server.scene.support import ends, refusal, say, seconds


def test_a_bounce_touches_again_and_again_and_its_end_is_told(played):
    assert say(played, "/object/pane/bounce", 0.05, "striker", "ping-pong", "id", "ball", source="me") == []
    seconds(played, 1.0)
    assert played.engine.stats.impacts > 5 and list(played.take_ends()) == []
    seconds(played, 20.0)
    assert ends(played) == [("ball", "me")] and played.engine.quiet()


def test_a_strikers_file_is_read_for_its_first_blow_alone(played, monkeypatch):
    say(played, "/object/pane/impact", 0.5, "striker", "steel")
    monkeypatch.setattr(Presets, "striker", lambda presets, name: pytest.fail(f"{name} was read again"))
    assert say(played, "/object/pane/impact", 0.7, "striker", "steel") == []


def test_an_object_strikes_another(played):
    assert say(played, "/object/pane/impact", 0.5, "by", "cup", "by_position", 0.3) == []
    played.engine.process(640)
    assert played.engine.stats.sounding == 2
    for other in ("pane", "lid", "c*"):
        reason = refusal(played, "/object/pane/impact", 1, "by", other)
        assert reason == f"by = {other}: expected another object; there is cup"


def touching(played):
    """Return the contacts that there are."""
    return [contact for contact in played.engine.state["contacts"][0] if contact["gesture"]]


def test_object_that_strikes_gives_its_mass_and_place_and_is_waited_for(played):
    say(played, "/object/pane/impact", 0.5, "by", "cup", "id", "x")
    played.engine.process(64)
    (contact,) = touching(played)
    cup = played.objects["cup"]
    assert contact["m"] == cup.mass and contact["point"][1]["slot"] == cup.handle.slot
    say(played, "/object/new", "later", "plastic-cup", time=played.engine.position + 4_800.0)
    before = played.engine.stats.impacts
    say(played, "/object/pane/impact", 0.5, "by", "later")
    seconds(played, 0.05)
    assert played.engine.stats.impacts == before
    seconds(played, 0.1)
    assert played.engine.stats.impacts > before


def test_a_rolling_body_loses_what_its_surface_takes(played):
    for name, *own in (("pane",), ("cup", "dissipation", 0.3)):
        say(played, f"/object/{name}/roll", 0.5, "striker", "steel", "surface", "glass", *own)
    played.engine.process(64)
    assert {contact["mu"] for contact in touching(played)} == {Presets().surface("glass").dissipation, 0.3}


def test_a_roll_that_goes_on_needs_no_ball_to_be_steered(played):
    assert say(played, "/object/pane/roll", 0.5, "striker", "steel") == []
    assert say(played, "/object/pane/roll", 0.7, "striker", "felt-hammer", "roughness", 100) == []
    assert "radius is missing" in refusal(played, "/object/cup/roll", 0.5, "striker", "felt-hammer")


@pytest.mark.slow
@pytest.mark.parametrize("striker", ["fingertip", "wood", "steel"])
def test_a_press_goes_on_until_it_is_stopped(played, striker):
    say(played, "/object/pane/press", 1.0, "striker", striker, "id", "hand")
    seconds(played, 1.0)
    assert list(played.take_ends()) == []
    say(played, "/gesture/hand/stop")
    seconds(played, 1.0)
    assert ends(played) == [("hand", None)]


def test_a_slide_feels_a_press_on_the_object(played):
    say(played, "/object/pane/press", 5.0, 0.2, "striker", "mute", "id", "hand")
    assert say(played, "/object/pane/slide", 0.1, "striker", "bow", "press", "hand", "id", "bow") == []
    seconds(played, 0.6)
    contacts, numbers = played.engine.state["contacts"][0], played.gestures.number_of
    (place,) = np.flatnonzero(contacts["gesture"] == numbers("bow"))
    slide = played.engine.state["slides"][0][contacts["roll"][place]]
    assert slide["press"] == numbers("hand") != 0
    assert slide["friction"]["normal"][1] == pytest.approx(5.0, rel=0.2)


@pytest.mark.slow
def test_a_heavy_striker_is_let_go_of(played):
    say(played, "/object/new", "tom", "tom")
    say(played, "/object/tom/bounce", 0.01, "mass", 1e5, "striker", "steel", "id", "x")
    seconds(played, 0.5)
    assert say(played, "/gesture/x/stop") == []
    seconds(played, 1.0)
    assert ends(played) == [("x", None)] and played.engine.stats.contacts_active == 0
    say(played, "/object/tom/impact", 0.01, "mass", 1e5, "id", "y")
    seconds(played, 3.0)
    assert ends(played) == [("y", None)]


def test_only_what_falls_feels_gravity_and_only_a_hand_a_force(played):
    say(played, "/object/pane/impact", 0.3, "striker", "felt", "id", "i")
    seconds(played, 0.003)
    for key, value in (("gravity", 9.81), ("force", 1000)):
        (warned,) = say(played, f"/gesture/*/{key}", value)
        assert warned.address == "/warning" and f"(impact) has no {key}" in warned.args[0]
    seconds(played, 3.0)
    assert ends(played) == [("i", None)]


@pytest.mark.slow
@pytest.mark.parametrize("words", [("glass",), ("pane", "by", "glass")])
def test_bend_of_a_pressed_glass_is_not_heard(played, words):
    """A hand of 10 N on a thin glass, or the glass on a pane: no direct current, and no thump of its coming."""
    name, *by = words
    say(played, "/object/new", "glass", "wine-glass")
    say(played, f"/object/{name}/press", 10, *by, "striker", "fingertip", "id", "hand")
    sound = played.engine.process(96_000)
    assert abs(sound).max() < 0.2 and abs(sound[-4_800:].mean(axis=0)).max() < 1e-3
    say(played, "/gesture/hand/stop")
    seconds(played, 2.0)
    assert ends(played) == [("hand", None)]


@pytest.mark.parametrize(("quality", "sounding"), [(3, 1), (4, 0)])
def test_bounce_goes_on_when_the_object_is_left_out(played, quality, sounding):
    say(played, "/quality", quality)
    say(played, "/object/new", "bowl", "singing-bowl")
    say(played, "/object/bowl/bounce", 3.0, "striker", "ping-pong", "dissipation", 0.13, "id", "x")
    seconds(played, 1.5)
    assert played.engine.stats.impacts == 1 and played.engine.stats.sounding == sounding  # it is in the air
    seconds(played, 2.0)
    assert played.engine.stats.impacts > 3 and played.engine.stats.sounding == 1


def peak(played, t):
    return np.abs(played.engine.process(round(t * played.engine.rate))).max()


@pytest.mark.slow
def test_a_panic_leaves_nothing_of_what_was_bent(played):
    say(played, "/object/pane/press", 100.0, "striker", "rubber")
    seconds(played, 3.0)  # what its coming sounded has faded
    assert np.abs(played.engine.state["bank"]["y1"]).max() > 0.1  # its modes, and as much of their reliefs
    played.perform([Message("/panic"), Message("/object/pane/impact", (1e-6,))], NOW)
    assert 0 < peak(played, 0.01) < 1e-4


@pytest.mark.slow
def test_an_object_that_presses_and_goes_leaves_its_mass(played):
    """An object in the place of one that was bent is at rest, and what it pressed on comes to rest."""
    say(played, "/object/new", "bell", "church-bell")
    say(played, "/object/new", "lid", "tin-lid")
    say(played, "/object/bell/press", 50.0, "by", "lid", "id", "hand")
    seconds(played, 2.0)
    say(played, "/object/lid/free", 1)
    seconds(played, 1.0)
    assert peak(played, 0.1) < 1e-6 and played.engine.stats.contacts_active == 1
    say(played, "/object/new", "other", "tin-lid")
    say(played, "/object/other/impact", 1e-6)
    assert peak(played, 0.01) < 1e-5


def test_a_hand_that_does_not_press_hovers(played):
    def ringing():
        say(played, "/object/bar/impact", 1.0)
        seconds(played, 0.3)
        return peak(played, 0.05)

    say(played, "/object/new", "bar", "triangle", "split", 0)
    say(played, "/object/bar/press", 0, "id", "hand", "striker", "hand")
    seconds(played, 3.0)
    free = ringing()
    say(played, "/gesture/hand/force", 10.0)
    seconds(played, 1.0)
    muted = ringing()
    say(played, "/gesture/hand/force", 0)
    seconds(played, 5.0)
    assert list(played.take_ends()) == [] and ringing() > 30 * muted and free > 30 * muted


def test_bend_of_silent_modes_is_not_heard(played):
    say(played, "/object/new", "bar", "marimba-bar", "tune", 60)
    say(played, "/object/bar/press", 100.0)
    seconds(played, 1.0)
    assert peak(played, 0.1) < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("rate", [8_000, 48_000, 192_000])
def test_the_heaviest_damping_is_silence_and_no_fault(rate):
    played = Session(Engine(rate), Presets())
    for name, preset, *keys in (
        ("cup", "plastic-cup", "decay", 0.001),
        ("block", "wood-block", "beta", 1e-3, "decay", 0.001),
        ("tile", "ceramic-tile", "alpha", 1e4, "decay", 0.001, "damp", 1),
        ("bell", "church-bell"),
    ):
        assert say(played, "/object/new", name, preset, *keys)[0].address == "/done"
    say(played, "/object/*/impact", 1.0)
    say(played, "/object/bell/impact", 1.0, "by", "cup")
    seconds(played, 0.2)
    assert played.engine.stats.faults == 0 and peak(played, 0.1) > 1e-3
