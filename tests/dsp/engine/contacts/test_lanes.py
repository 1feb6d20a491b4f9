"""Bodies that roll on objects of their own, and objects that rest, solved in the lanes of registers."""

import math

import numpy as np
import pytest

from carom.dsp.bodies.modes import Modes
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.contact.block_records import LANES
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine

from ..support import RATE, gesture, steer, stop

QUANTA = 60
MASS = 0.005  # kg
LAW = (MASS, 2e8, 0.4, 1.5)
UNLIKE = (MASS, 2e8, 0.4, 1.6)  # by an exponent that lanes don't take
LINEAR, CUBIC = (MASS, 5e4, 0.4, 1.0), (MASS, 1e16, 0.4, 3.0)
GLASS, ROUGH = (2e-7, 1e-3, 2.0, 0.0, 1.0, 0.0, 1.0), (2e-6, 1e-3, 2.0, 0.0, 1.0, 0.0, 1.0)  # bodies hop on that one
ROLLS = [
    (GLASS, LAW, 3.25, 0.4),
    (ROUGH, LAW, 0.0, 0.5),
    (ROUGH, LAW, 700.5, 0.9),  # begins later, within a quantum
    (GLASS, UNLIKE, 0.0, 0.4),
    (GLASS, LAW, 0.0, 3.0),
    (ROUGH, LAW, 10.0, 0.2),
    (GLASS, LINEAR, 0.0, 1.3),
    (ROUGH, LAW, 0.0, 0.6),
    (GLASS, CUBIC, 0.0, 0.7),
    (ROUGH, LAW, 0.0, 0.8),
    (GLASS, LAW, 0.0, 0.3),
    (ROUGH, LAW, 0.0, 1.1),
    (ROUGH, LAW, 30.0, 1.0),
]
STEERED, STOPPED = 4, 6


def light(n):
    """Return an object about as light as the bodies, of its own modes."""
    count, random = 24 + 2 * n, np.random.default_rng(n)
    return Modes(
        frequency=np.geomspace(150.0 + n, 20_000.0, count),
        decay=np.full(count, 0.5),
        strike=random.normal(size=(4, count)) * math.sqrt(1.0 / (MASS * count)),
        pressure=np.full((2, count), 1e-3),
        mass=1.0,
    )


def rolled(numbers, level):
    """Return the states of each object's modes after each quantum, with those bodies at once, and the lanes that were
    taken to the end of the last one."""
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(level))])
    handles = [engine.add(light(n), 0.05) for n in numbers]
    for n, handle in zip(numbers, handles, strict=True):
        surface, law, begin, speed = ROLLS[n]
        command = gesture("roll", handle, law, begin, 1 + n, speed=speed, radius=0.01, seed=1 + n, position=0.0)
        engine.send([command._replace(surface=surface)])
    if STEERED in numbers:
        engine.send([steer(1 + STEERED, "speed", 0.5, 30.5 * QUANTUM)])
    if STOPPED in numbers:
        engine.send([stop(1 + STOPPED, 40.5 * QUANTUM)])
    states = {n: [] for n in numbers}
    for _ in range(QUANTA):
        engine.process(QUANTUM)
        for n, handle in zip(numbers, handles, strict=True):
            obj, bank = engine.state[0]["objects"][handle.slot], engine.state[0]["bank"]
            modes = slice(obj["first"], obj["first"] + obj["size"])
            states[n].append(np.concatenate([bank["y1"][modes], bank["y2"][modes]]))
    lanes = engine.state[0]["scratch"]["lanes"]
    return {n: np.array(each) for n, each in states.items()}, int((lanes["ended"] == QUANTUM).sum())


@pytest.mark.parametrize("level", ["-50", "-60"])
def test_bodies_roll_as_they_do_alone_whoever_else_rolls(level):
    """Bodies that hop, begin late, are steered, stop, or have a law that lanes don't take: the same bits."""
    together, in_lanes = rolled(range(len(ROLLS)), level)
    assert LANES >= in_lanes > 1
    few, _ = rolled([5, 1, 8, 9], level)
    for n in range(len(ROLLS)):
        states, in_lanes = rolled([n], level)
        assert in_lanes == (ROLLS[n][1] != UNLIKE) or n == STOPPED
        assert np.abs(states[n][-1]).max() > 0.0
        np.testing.assert_array_equal(together[n], states[n], err_msg=f"body {n}")
    for n, states in few.items():
        np.testing.assert_array_equal(states, together[n], err_msg=f"body {n} of few")


@pytest.mark.parametrize("number", [0, 8, 10])
def test_three_terms_roll_a_body_that_does_not_hop_within_60_db(number):
    found, in_lanes = rolled([number], "-60")
    expected, by_steps = rolled([number], "exact")
    assert in_lanes == 1 and by_steps == 0
    found, expected = (each[number][:15] for each in (found, expected))
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()
