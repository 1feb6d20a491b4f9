"""Bodies that rest on objects push with their weight alone."""

from itertools import cycle

import numpy as np
import pytest

import carom
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.runtime.engine import NOW, Engine
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.bench.rest_errors import sound

PRESETS = carom.Presets()
RATE = 48_000
BALLS = ("bowling-ball", "glass-marble")
LIGHT = ("polycarbonate-sheet", "glass-plate", "tin-lid")


def excess(name, accuracy, *balls):
    """Return the force of any ball beyond its weight, of those that roll over an object on a flat path, as a share of
    all weights (100 ms)."""
    with carom.Scene(channels=1, calibrated=True, contacts=True) as scene:
        scene.accuracy(accuracy)
        body = scene.new("a", name, **({"rest": "none"} if PRESETS.object(name).standing else {}))
        for ball in balls:
            body.roll(0.1, 0.4, striker=ball, roughness=0.0, id=ball)
        told = scene.render(0.1).contacts
    assert len(told) == len(balls)
    weight = sum(PRESETS.striker(ball).mass for ball in balls) * STANDARD_GRAVITY
    return max(np.abs(each.force).max() for each in told) / weight


@pytest.mark.slow
@pytest.mark.parametrize(("name", "ball"), [*zip(PRESETS.names("objects"), cycle(BALLS), strict=False)])
def test_a_ball_at_rest_pushes_with_its_weight(name, ball):
    assert excess(name, "-60", ball) < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("accuracy", LEVELS)
@pytest.mark.parametrize("name", LIGHT)
def test_a_ball_at_rest_on_a_light_object_pushes_with_its_weight(name, accuracy):
    for ball in BALLS:
        assert excess(name, accuracy, ball) < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("accuracy", LEVELS)
def test_balls_at_rest_together_push_with_their_weights(accuracy):
    assert excess("polycarbonate-sheet", accuracy, *BALLS) < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("accuracy", ("-50", "-60", "-80"))
@pytest.mark.parametrize("held", ({}, {"by": "b"}), ids=("a hand", "another object"))
@pytest.mark.parametrize("name", ("wood-block", "plastic-cup", "steel-plate"))
def test_a_press_that_rests_takes_one_step_a_sample(name, held, accuracy):
    engine = Engine(RATE)
    session = Session(engine, PRESETS)
    made = [Message("/object/new", ("a", name)), Message("/object/new", ("b", "wood-block"))]
    keys = tuple(word for pair in held.items() for word in pair)
    pressed = Message("/object/a/press", (20.0, *keys))
    session.perform([Message("/accuracy", (accuracy,)), *made, pressed], NOW)
    engine.process(RATE)
    every = engine.state["contacts"][0]["coupled"]
    contact = every[every["steps"].argmax()]
    before = contact["steps"]
    engine.process(RATE // 20)
    assert RATE // 20 <= contact["steps"] - before < 1.1 * RATE // 20
    assert contact["force"] == pytest.approx([20.0] * 3, rel=0.05)


def test_feet_that_an_object_stands_on_are_told_as_rests():
    with carom.Scene(contacts=True) as scene:
        scene.new("a", "tumbler").impact(1.0)
        told = scene.render(0.05).contacts
    assert sorted((each.object, each.gesture) for each in told) == [("a", "impact"), *[("a", "rest")] * 3]


@pytest.mark.slow
@pytest.mark.parametrize("level", ["-50", "-60"])
@pytest.mark.parametrize("name", ["glockenspiel-bar", "triangle"])
def test_hard_objects_that_swing_on_each_other_for_long_stay_in_step(name, level):
    """The contact loses next to nothing: what errs in each of its swings would add up, to -45 and -25 dB."""
    right = sound(name, "other", "exact", 0.001)
    assert np.linalg.norm(sound(name, "other", level, 0.001) - right) < 1e-3 * np.linalg.norm(right)
