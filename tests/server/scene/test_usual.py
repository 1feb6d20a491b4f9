"""Values that a gesture's message leaves out, as the object's preset has them."""

import pytest

from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.presets import Presets
from tests.server.scene.support import refusal, say

PLATE = Presets().object("steel-plate")


@pytest.fixture
def sent(session, monkeypatch):
    """A session with a steel plate, a board and a bell, and the commands that it sends."""
    for name, preset in (("plate", "steel-plate"), ("board", "wood-board"), ("bell", "church-bell")):
        say(session, "/object/new", name, preset)
    commands = []
    send = session.engine.send
    monkeypatch.setattr(session.engine, "send", lambda each: (commands.extend(each), send(each))[1])
    return session, commands


def values(sent, *message):
    session, commands = sent
    say(session, *message)
    return commands[-1]


def law(striker, surface=None):
    presets = Presets()
    mass, stiffness, dissipation, exponent = presets.striker(striker).contact(PLATE.material)
    lost = dissipation if surface is None else presets.surface(surface).dissipation
    return {"mass": mass, "stiffness": stiffness, "dissipation": lost, "exponent": exponent}


def test_a_strike_without_a_velocity_is_the_presets(sent):
    command = values(sent, "/object/plate/impact")
    assert command.kind == "impact" and command.values["velocity"] == PLATE.velocity


@pytest.mark.parametrize("kind", ["bounce", "roll", "slide", "spin"])
def test_a_gesture_that_suits_goes_as_the_preset_says(sent, kind):
    usual = PLATE.gestures[kind]
    command = values(sent, f"/object/plate/{kind}")
    assert command.kind == kind
    expected = law(usual.striker, usual.surface or None)
    if kind != "bounce":
        expected |= usual.numbers
    assert {key: command.values[key] for key in expected} == pytest.approx(expected)
    if usual.surface:
        assert command.surface == Presets().surface(usual.surface).profile


def test_values_in_a_message_come_before_those_of_the_preset(sent):
    slide = PLATE.gestures["slide"]
    command = values(sent, "/object/plate/slide", 0.05, 0.25, "surface", "glass", "force", 1)
    assert command.values["speed"] == 0.05 and command.values["position"] == 0.25 and command.values["force"] == 1.0
    assert command.values["mass"] == Presets().striker(slide.striker).mass
    assert command.surface == Presets().surface("glass").profile


def test_a_striker_that_is_named_brings_its_own_numbers_and_meets_the_objects_surface(sent):
    command = values(sent, "/object/plate/slide", "striker", "knife")
    knife = Presets().striker("knife")
    assert command.values["radius"] == knife.sliding["radius"]
    assert command.values["force"] == pytest.approx(knife.mass * STANDARD_GRAVITY)
    assert command.values["speed"] == PLATE.gestures["slide"].numbers["speed"]
    assert command.surface == Presets().surface(PLATE.gestures["slide"].surface).profile
    point = values(sent, "/object/plate/bounce", "mass", 0.01, "stiffness", 1e6)
    assert point.values["mass"] == 0.01 and "sound_serial" not in point.values


def test_a_roll_that_goes_on_is_steered_by_what_is_said_alone(sent):
    values(sent, "/object/board/roll", 0.4, "id", "ball")
    command = values(sent, "/object/board/roll", 0.9, "id", "ball")
    assert command.given == ["speed"]


def test_a_gesture_that_does_not_suit_is_played_if_the_message_says_how(sent):
    assert "speed is missing, and church-bell has none" in refusal(sent[0], "/object/bell/roll")
    command = values(sent, "/object/bell/roll", 0.5, "striker", "glass-marble")
    assert command.surface == Presets().surface("wood").profile


def test_held_striker_clicks_and_does_not_ring(sent):
    """A coin that is drawn over a plate is not a line at 14.7 kHz."""
    session, _ = sent
    laws = session.laws if hasattr(session, "laws") else session._laws
    assert laws.sound_of("coin").ringing is not None
    assert laws.sound_of("coin", held=True).ringing is None and laws.sound_of("coin", held=True).click is not None
