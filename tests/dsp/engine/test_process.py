"""Sound in blocks of any size, and what is kept of it for a recorder."""

import math

import numpy as np
import pytest

from carom.dsp.engine.memory.state import QUANTUM, TAP
from carom.dsp.runtime.engine import Engine
from tests.dsp.engine.support import RATE, bell, free, setting, strike


@pytest.mark.parametrize("block", [1, 37, 480, 4096])
def test_block_size_changes_no_bit(block):
    def run(size):
        engine = Engine(RATE)
        handles = [engine.add(bell(n), 0.05, pan=p) for n, p in ((5, -1.0), (24, 0.0), (40, 0.7))]
        for i in range(30):
            law = (0.01, 10.0 ** (4 + i % 7), 0.5, 1.5)
            strike(engine, handles[i % 3], time=97.31 * i, velocity=0.1 + 0.1 * i, law=law)
        engine.send([setting(handles[0], "tune", 1.5, 1500.0), setting(handles[1], "gain", 0.2, 1600.0)])
        engine.send([free(handles[2], at_once=True, time=2000.0), setting(handles[1], "damp", 0.7, 2500.0)])
        return np.concatenate([engine.process(size) for _ in range(math.ceil(8192 / size))])[:8192]

    np.testing.assert_array_equal(run(block), run(64))


def test_a_recorder_gets_what_was_heard_and_is_told_what_is_missing():
    engine = Engine(RATE)
    strike(engine, engine.add(bell(), 0.05))
    engine.process(10 * QUANTUM)
    engine.record()
    heard = engine.process(10 * QUANTUM)
    np.testing.assert_array_equal(engine.recorded(), heard)
    heard = engine.process(TAP + 3 * QUANTUM)
    np.testing.assert_array_equal(engine.recorded(), heard[:TAP])
    assert engine.stats.tap_lost == 3 * QUANTUM
    np.testing.assert_array_equal(engine.process(QUANTUM), engine.recorded())


@pytest.mark.parametrize("limited", [False, True])
def test_recorded_parts_say_where_sound_is_missing(limited):
    """Sound that was lost lies after what waited for the recorder, and before what came once that had taken it."""
    engine = Engine(RATE, limited=limited)
    strike(engine, engine.add(bell(), 0.05))
    engine.record()
    heard = [engine.process(10 * QUANTUM)]
    (one,) = engine.recorded_parts()
    heard.append(engine.process(TAP + 3 * QUANTUM))
    (two,) = engine.recorded_parts()
    heard.append(engine.process(2 * QUANTUM))
    heard.append(engine.process(5 * QUANTUM))
    (three,) = engine.recorded_parts()
    engine._record["tap"]["read"] -= 9 * QUANTUM  # as if it had copied while a quantum was lost
    joined = engine.recorded_parts()
    whole = np.concatenate(heard)[engine.delay :]
    for first, sound in (one, two, three, *joined):
        np.testing.assert_array_equal(sound, whole[first : first + len(sound)])
    assert [first for first, _ in (one, two, three)] == [0, len(one[1]), len(one[1]) + TAP + 3 * QUANTUM]
    assert [len(sound) for _, sound in joined] == [2 * QUANTUM, 7 * QUANTUM]
