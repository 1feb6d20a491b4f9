"""Steering: each parameter changes what it says, in the time that it says, and nothing else."""

import math

import numpy as np
import pytest

from carom.dsp.bodies.modes import Faces, Modes
from carom.dsp.contact import contact_time
from carom.dsp.engine.memory.commands import Handle
from carom.dsp.engine.memory.state import QUANTUM, End
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.runtime.engine import Engine
from carom.dsp.schema import GESTURES, STEERABLE, gestures_steered_by
from tests.dsp.engine.support import RATE, gesture, numbered, steer, stop, strike

STEERED_AT = 20  # quanta after the beginning
SOFT = (0.05, 600.0, 0.3, 1.5)  # an impact that lasts some 50 ms
BALL = (0.005, 1e7, 0.1, 1.5)
GRAIN = (1e-6, 1e7, 0.1, 1.5)
HAND = (0.05, 1e5, 5.0, 1.5)
PAD = (0.3, 2e6, 1.0, 2.0)

SLIDE = {
    "speed": 0.4, "sweep": -1.0, "force": 2.0, "radius": 0.008, "patch": 0.0, "static": 0.5, "dynamic": 0.4,
    "stribeck": 0.1, "tangential": 0.0, "along": 0.5, "seed": 1,
}  # fmt: skip

SWARM = {
    "rain": {"rate": 2e4}, "shake": {"rate": 2e4, "excitation": 0.5}, "crumple": {"speed": 4.0}, "pour": {"rate": 2e4},
    "step": {"force": 700.0, "crackles": 10.0}, "shatter": {"velocity": 2.0, "whole": 0.1, "stage": 1.0},
}  # fmt: skip
EXPONENT = {"rain": 0.0}

NEW = {
    "x": 0.3, "y": 0.2, "z": 0.1,
    "position": 0.9, "gain": 0.25, "gravity": 30.0, "irregularity": 0.8, "speed": 0.9, "mass": 0.02,
    "radius": 0.02, "roughness": 0.3, "asymmetry": 0.4, "friction": 0.05, "force": 9.0, "flat": 0.6,
    "sweep": 0.7, "patch": 0.005, "static": 0.9, "dynamic": 0.2, "stribeck": 0.3, "tangential": 1e5,
    "along": 0.8, "rate": 4e4, "size": 1e-3, "variety": 0.5, "density": 5000.0, "energy": 1e-2, "steepness": 1.0,
    "decades": 2.0, "excitation": 0.9, "memory": 0.1, "load": 9.0, "by_position": 0.8, "height": 0.7, "crackles": 50.0,
    "evenness": 1.0, "stiffness": 4e6, "dissipation": 0.7, "exponent": 2.2, "by_x": 0.31, "by_y": 0.21, "by_z": 0.11,
}  # fmt: skip
"""New value of each parameter: nothing that it is by itself in `begin`."""

every_kind = pytest.mark.parametrize("kind", GESTURES)


def plate(mass):
    """Return a body with modes that differ along its strike path, so that it is heard where it is touched."""
    positions = np.linspace(0, 1, 17)[:, None] * np.arange(1, 9)
    shape = np.cos(np.pi * positions) / math.sqrt(mass)
    corners = np.array([[[0.0, 0.0, 0.0], [0.5, 0.0, 0.1], [0.0, 0.5, 0.2]]])
    faces = Faces(corners, np.array([17]), 17, np.zeros((17, 3)), np.zeros((1, 3, 2)), np.zeros((1, 3), int), 0)
    shape = np.concatenate([shape, shape[[0, 3, 7]], shape[:1] * 0])
    return Modes(np.linspace(200.0, 6_000.0, 8), np.full(8, 6.0), shape, np.full((2, 8), 1.0), 1.0, faces=faces)


def begin(kind):
    """Return an engine in which gesture 7 of a kind goes on: in the air, or on an object that rings."""
    engine = Engine(RATE)
    handle = engine.add(plate(1e3 if kind == "bounce" else 0.1), 1e-3)
    if kind != "bounce":
        strike(engine, handle, velocity=0.5)
    command = {
        "impact": lambda: gesture("impact", handle, SOFT, 1000.0, 7, velocity=1.0),
        "bounce": lambda: gesture("bounce", handle, BALL, 100.0, 7, velocity=0.2, seed=1),
        "roll": lambda: gesture("roll", handle, BALL, 100.0, 7, speed=0.4, radius=0.008, seed=1),
        "spin": lambda: gesture("spin", handle, BALL, 100.0, 7, duration=0.5, irregularity=0.1, seed=1),
        "slide": lambda: gesture("slide", handle, BALL, 100.0, 7, **SLIDE),
        "rest": lambda: gesture("rest", handle, PAD, 100.0, 7, engine.add(plate(0.1)), load=3.0, by_position=0.3),
        "press": lambda: gesture("press", handle, HAND, 100.0, 7, velocity=0.01, force=2.0),
        **dict.fromkeys(
            SWARM,
            lambda: gesture(
                kind,
                handle,
                GRAIN,
                100.0,
                7,
                seed=1,
                spread=0.5,
                **SWARM[kind],
                **engine.lay_out_pulses(EXPONENT.get(kind, 1.5)),
            ),
        ),
    }[kind]
    engine.send([command()])
    engine.process(STEERED_AT * QUANTUM)
    return engine


def steered(kind, name, quanta=1):
    """Return the same after so many quanta more, from which on a parameter is steered."""
    engine = begin(kind)
    engine.send([steer(7, name, NEW[name])])
    engine.process(quanta * QUANTUM)
    return engine


def steering_of(engine):
    """Return the only gesture's targets, and its values now."""
    (contact,) = numbered(engine)
    return {field: dict(zip(STEERABLE, contact[field].item(), strict=True)) for field in ("target", "now")}


@pytest.mark.slow
@every_kind
def test_a_parameter_steers_the_gestures_that_it_says_and_no_other_parameter(kind):
    before = steering_of(begin(kind))
    for name in STEERABLE:
        after = steering_of(steered(kind, name))
        expected = before["target"] | ({name: NEW[name]} if name in GESTURES[kind].steerable else {})
        assert before["target"][name] != NEW[name] and after["target"] == expected, name
        others = [other for other in STEERABLE if other != name]
        assert [after["now"][other] for other in others] == [before["now"][other] for other in others], name


@pytest.mark.slow
@every_kind
def test_steerable_parameters_are_heard_and_others_are_not(kind):
    def sound(*names):
        engine = begin(kind)
        engine.send([steer(7, name, NEW[name]) for name in names])
        return engine.process(9_600)

    unsteered = sound()
    assert np.array_equal(sound(*(set(STEERABLE) - set(GESTURES[kind].steerable))), unsteered)
    for name in GESTURES[kind].steerable:
        assert not np.array_equal(sound(name), unsteered), name


@pytest.mark.slow
@every_kind
def test_a_parameter_glides_as_declared(kind):
    starts = steering_of(begin(kind))["now"]
    for name in GESTURES[kind].steerable:
        glide, engine = gestures_steered_by(name)[kind].glide, steered(kind, name, 0)
        for before, quanta in ((0, 1), (1, 5), (5, 20)):
            engine.process((quanta - before) * QUANTUM)
            (contact,) = numbered(engine)
            left = math.exp(-quanta * QUANTUM / (glide * RATE)) if glide else 0.0
            expected = NEW[name] + (starts[name] - NEW[name]) * left
            assert contact["now"][name] == pytest.approx(expected, rel=1e-9), (name, quanta)


@pytest.mark.parametrize(("name", "field"), [("speed", "v"), ("mass", "m"), ("gravity", "g")])
def test_a_body_that_rolls_follows_its_target(name, field):
    """The body follows by events of half a millisecond at most, within a few percent of the way."""
    glide = gestures_steered_by(name)["roll"].glide
    start = steering_of(begin("roll"))["target"][name]
    for quanta in (8, 30):
        engine = steered("roll", name, quanta)
        (contact,) = numbered(engine)
        roll = engine.state["rolls"][0][contact["roll"]]
        left = (roll[field] - NEW[name]) / (start - NEW[name])
        assert left == pytest.approx(math.exp(-quanta * QUANTUM / (glide * RATE)), abs=0.04)


@pytest.mark.parametrize("name", ["radius", "roughness"])
def test_a_body_that_rolls_has_another_path_at_once(name):
    engine = steered("roll", name, 2)
    (contact,) = numbered(engine)
    assert engine.state["rolls"][0][contact["roll"]]["path"][name] == NEW[name]


def test_a_force_is_laid_on_as_declared():
    """The push glides to the force that is asked for, which itself glides to nothing else."""
    glide = gestures_steered_by("force")["press"].glide
    (before,), (after,) = numbered(begin("press")), numbered(steered("press", "force", 30))
    left = (after["push"] - NEW["force"]) / (before["push"] - NEW["force"])
    assert left == pytest.approx(math.exp(-30 * QUANTUM / (glide * RATE)), rel=1e-6)


def test_gravity_draws_a_bounce_down_from_its_next_flight_on():
    def flight(engine):
        """Return when (s) the flight that has begun ends, and how long the next one takes."""
        (contact,) = numbered(engine)
        landed = float(contact["elapsed"])
        touch = float(contact_time(contact["v_in"], *BALL))
        while contact["touching"] or contact["elapsed"] == landed:
            engine.process(QUANTUM)
        return landed, float(contact["elapsed"]) - landed - touch

    landed, long = flight(begin("bounce"))
    same, short = flight(steered("bounce", "gravity"))
    assert same == landed and short / long == pytest.approx(STANDARD_GRAVITY / NEW["gravity"], rel=1e-3)


@pytest.mark.parametrize("kind", GESTURES)
def test_a_gesture_that_is_stopped_ends_and_is_reported(kind):
    engine = begin(kind)
    engine.send([stop(7)])
    engine.process(48_000)
    assert [number for number, _ in engine.ended()] == [7] and engine.stats.contacts_active == 0


def test_a_roll_that_goes_on_takes_on_what_is_given_and_keeps_the_rest():
    engine = begin("roll")
    before = steering_of(engine)["target"]
    (contact,) = numbered(engine)
    there = Handle(contact["point"][0]["slot"], contact["point"][0]["serial"], 0, 0)
    again = gesture(
        "roll", there, BALL, number=7, given=("speed", "mass", "gain"),
        speed=0.9, radius=0.5, seed=9, mass=0.03, gain=0.5, friction=0.7,
    )  # fmt: skip
    engine.send([again])
    engine.process(QUANTUM)
    assert engine.ended() == [(7, End.JOINED)] and engine.stats.rolls_active == 1
    assert steering_of(engine)["target"] == before | {"speed": 0.9, "mass": 0.03, "gain": 0.5}
