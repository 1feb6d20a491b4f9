"""The limiter: no true peak leaves above -1 dB of full scale, its gain comes down ahead of a peak, and its delay is
constant."""

import numpy as np
import pytest

from carom.dsp.bodies.modes import Modes
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.engine.output.limiter import CEILING
from carom.dsp.runtime.engine import Engine
from carom.dsp.runtime.loudness import true_peak
from tests.dsp.engine.support import RATE, bell, panic, set_limiter, strike

FRAMES = 9_600


def struck(limited: bool, level: float, on: bool = True, block: int = FRAMES) -> tuple[Engine, np.ndarray]:
    """Return an engine, and its sound in blocks, of a bell that is struck within its tenth quantum."""
    engine = Engine(RATE, limited=limited)
    set_limiter(engine, on)
    strike(engine, engine.add(bell(), level), time=600.4)
    sizes = [min(block, FRAMES - first) for first in range(0, FRAMES, block)]
    return engine, np.concatenate([engine.process(size) for size in sizes])


@pytest.mark.parametrize("on", [True, False])
def test_the_delay_is_a_quantum_whether_it_is_on_or_off(on):
    plain = struck(False, 1e-2)[1]
    engine, sound = struck(True, 1e-2, on)
    assert engine.delay == QUANTUM and engine.left == engine.position - QUANTUM and engine.stats.limited == 0
    assert not sound[:QUANTUM].any()
    np.testing.assert_array_equal(sound[QUANTUM:], plain[:-QUANTUM])
    assert plain.any() and Engine(RATE).delay == 0


def test_sound_stays_within_full_scale_and_limited_frames_are_counted():
    engine, sound = struck(True, 1e4)
    assert 0.8 * CEILING < np.abs(sound).max() <= CEILING + 1e-6
    assert engine.stats.limited > 100 and engine.stats.limit_lowest < 0.1


@pytest.mark.parametrize("frequency", [RATE / 4.0, RATE / 6.0, RATE / 3.0, 0.2371 * RATE])
def test_peaks_between_samples_stay_below_the_ceiling(frequency):
    """Of a sine at a quarter of the rate samples may lie 3 dB below the peaks."""
    tone = Modes(np.array([frequency]), np.array([20.0]), np.full((1, 1), 1.0), np.full((2, 1), 1.0), 1.0)
    for phase in (0.0, 0.25, 0.5, 0.75):
        plain, engine = Engine(RATE), Engine(RATE, limited=True)
        strike(plain, plain.add(tone, 1.0), time=600.0 + phase)
        strike(engine, engine.add(tone, 1.3 / true_peak(plain.process(FRAMES))), time=600.0 + phase)
        sound = engine.process(FRAMES)
        assert engine.stats.limited > 100
        assert -1.5 < 20.0 * np.log10(true_peak(sound)) < -0.95


def test_after_silence_it_has_let_go():
    """A blow soon after a loud one that was silenced sounds as it does alone."""
    sounds = []
    for loud in (True, False):
        engine = Engine(RATE, limited=True)
        first, second = engine.add(bell(), 1e4), engine.add(bell(), 1e-2)
        if loud:
            strike(engine, first, time=600.4)
        engine.send([panic(2_400.0)])
        engine.process(4_800)
        assert (engine.stats.limited > 100) == loud
        strike(engine, second, time=5_000.4)
        sounds.append(engine.process(FRAMES))
    assert sounds[0].any()
    np.testing.assert_array_equal(*sounds)


def test_an_engine_without_a_limiter_leaves_the_sound_as_it_is():
    engine, sound = struck(False, 1e4)
    assert np.abs(sound).max() > 10.0 and engine.stats.limited == 0
    np.testing.assert_array_equal(struck(True, 1e4, on=False)[1][QUANTUM:], sound[:-QUANTUM])


@pytest.mark.parametrize("level", [5e2, 1e4])
def test_the_gain_comes_down_along_a_line_ahead_of_a_peak(level):
    """Frame by frame the gain falls by 1/64 at most; before the bell is struck there is nothing to hear it by."""
    plain = struck(False, level)[1][:-QUANTUM, 0].astype(float)
    limited = struck(True, level)[1][QUANTUM:, 0].astype(float)
    heard = np.flatnonzero(np.abs(plain) > 1e-3)
    gain = limited[heard] / plain[heard]
    assert gain.min() < 0.5 and gain.max() <= 1.0 + 1e-6
    assert (np.diff(gain) / np.diff(heard)).min() > -1.0 / QUANTUM - 1e-6


def test_a_recording_begins_with_the_sound():
    """The silence of the delay is not recorded: the frame of an event in the engine is its frame in the file."""
    engine = Engine(RATE, limited=True)
    engine.record()
    strike(engine, engine.add(bell(), 1e-2), time=600.4)
    heard = engine.process(4_800)
    np.testing.assert_array_equal(engine.recorded(), heard[QUANTUM:])


def test_stems_are_those_of_the_sound_that_leaves():
    engine = Engine(RATE, limited=True)
    engine.stems.keep(True)
    for level in (1e-2, 2e-2):
        strike(engine, engine.add(bell(), level), time=10.0)
    for _ in range(30):
        sound = engine.process(QUANTUM)
        np.testing.assert_allclose(engine.stems.shares().sum(axis=0).T, sound, rtol=1e-6, atol=1e-9)
    assert len(engine.stems.sounding()) == 2


def test_a_limited_sound_recovers():
    engine = Engine(RATE, limited=True)
    handle = engine.add(bell(8, t60=0.05), 1e3)
    strike(engine, handle)
    engine.process(96_000)
    soft = strike(engine, handle, velocity=1e-4) or engine.process(4800)
    reference = Engine(RATE)
    strike(reference, reference.add(bell(8, t60=0.05), 1e3), velocity=1e-4)
    np.testing.assert_allclose(np.abs(soft).max(), np.abs(reference.process(4800)).max(), rtol=1e-3)


def test_the_limiter_lets_go_within_half_a_second():
    engine = Engine(RATE, limited=True)
    strike(engine, engine.add(bell(8, t60=0.02), 1e4))
    engine.process(2400)
    assert engine.state["output"]["limit"][0] < 0.5
    engine.process(24_000)
    assert engine.state["output"]["limit"][0] > 0.95
