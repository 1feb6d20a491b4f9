"""Headroom: what goes on being too loud is turned down slowly, and all else is left as it is."""

import numpy as np
import pytest

from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.engine.support import RATE, bell, strike

PERIOD = round(0.25 * RATE)


def struck(on: bool, level: float, blows: int, limited: bool = True, block: int = PERIOD) -> tuple[Engine, np.ndarray]:
    """Return an engine, and its sound, of a bell that is struck four times a second."""
    engine = Engine(RATE, limited=limited)
    engine.send([Command(NOW, Kind.HEADROOM, value=float(on))])
    handle = engine.add(bell(8, t60=0.1), level)
    for n in range(blows):
        strike(engine, handle, time=n * PERIOD + 300.5)
    sizes = [min(block, blows * PERIOD - first) for first in range(0, blows * PERIOD, block)]
    return engine, np.concatenate([engine.process(size) for size in sizes])


def loud() -> float:
    """Return the level at which a blow is four times over full scale."""
    return 4.0 / float(np.abs(struck(False, 1.0, 1, limited=False)[1]).max())


def test_soft_sound_keeps_its_bits():
    level = 0.1 * loud()
    np.testing.assert_array_equal(struck(True, level, 8)[1], struck(False, level, 8)[1])


def test_after_some_blows_the_limiter_rests():
    """The limiter takes a tenth of the frames, at most, that it takes without, once the level is down."""
    counts = []
    for on in (False, True):
        first = struck(on, loud(), 24)[0].stats.limited
        counts.append(struck(on, loud(), 36)[0].stats.limited - first)
    assert counts[0] > 100_000 and counts[1] < 0.1 * counts[0]


def test_the_level_glides_and_says_so():
    engine, sound = struck(True, loud(), 12)
    assert engine.headroom and 0.1 < engine.stats.headroom < 0.5
    plain = struck(False, loud(), 12, limited=False)[1]
    gain = sound[64:, 0] / np.where(np.abs(plain[:-64, 0]) > 0.1, plain[:-64, 0], np.nan)
    assert np.nanmax(gain[-PERIOD:]) < 0.5
    engine.process(round(20 * RATE))
    assert engine.stats.headroom > 0.8


@pytest.mark.parametrize("block", [1, 64, 1_000])
def test_blocks_do_not_matter(block):
    frames = struck(True, loud(), 2, block=block)[1]
    np.testing.assert_array_equal(frames, struck(True, loud(), 2)[1])


def test_without_a_limiter_there_is_none():
    sounds = [struck(on, loud(), 6, limited=False)[1] for on in (False, True)]
    np.testing.assert_array_equal(*sounds)
