"""The level meter, against ITU-R BS.1770-5 as it is printed, and filters that are not ours."""

import math

import numpy as np
import pytest
from scipy.signal import freqz, lfilter

from carom.dsp.bodies.modes import Modes
from carom.dsp.engine.memory.meter_record import k_weighting
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import Engine
from carom.dsp.runtime.meter import SILENCE
from tests.dsp.engine.support import strike

SHELF = (1.53512485958697, -2.69169618940638, 1.19839281085285, -1.69065929318241, 0.73248077421585)
HIGH_PASS = (1.0, -2.0, 1.0, -1.99004745483398, 0.99007225036621)


def response(rate, frequency):
    """Return the K-weighting's gain (dB) at a frequency."""
    parts = [freqz(c[:3], [1.0, *c[3:]], [frequency], fs=rate)[1][0] for c in k_weighting(rate)]
    return 20 * math.log10(abs(np.prod(parts)))


def test_filters_are_those_that_are_printed():
    np.testing.assert_allclose(k_weighting(48_000.0), (SHELF, HIGH_PASS), atol=1e-11)


@pytest.mark.parametrize("rate", [32_000.0, 44_100.0, 96_000.0, 192_000.0])
@pytest.mark.parametrize("frequency", [30.0, 100.0, 997.0, 3_000.0])
def test_another_rate_weighs_alike(rate, frequency):
    assert response(rate, frequency) == pytest.approx(response(48_000.0, frequency), abs=0.1)
    assert response(48_000.0, 997.0) == pytest.approx(0.691, abs=0.005)  # so that a full-scale sine there is -3.01 LUFS


def playing(rate=48_000.0, channels=2):
    """Return an engine whose meter is on, and what it plays: a bell, and after a second another one."""
    engine = Engine(rate, channels)
    engine.meter.start()
    modes = Modes(np.array([150.0, 1_100.0, 6_000.0]), np.full(3, 3.0), np.full((4, 3), 1.0), np.ones((2, 3)), 1.0)
    handle = engine.add(modes, 1e-3, pan=0.4)
    strike(engine, handle)
    strike(engine, handle, time=rate)
    return engine, np.concatenate([engine.process(frames) for frames in (100, int(rate), int(0.3 * rate))])


@pytest.mark.parametrize(("rate", "channels"), [(48_000.0, 2), (48_000.0, 5), (44_100.0, 1), (192_000.0, 2)])
def test_loudness_is_the_standards_of_the_last_400_ms(rate, channels):
    engine, sound = playing(rate, channels)
    sound = sound[: engine.position].astype(float)
    extra = engine.position - len(sound)  # the quantum that was computed and not all given out
    sound = np.concatenate([sound, engine.process(extra)]) if extra else sound
    for c in (SHELF, HIGH_PASS) if rate == 48_000.0 else k_weighting(rate):
        sound = lfilter(c[:3], [1.0, *c[3:]], sound, axis=0)
    recent = sound[-round(0.4 * rate / QUANTUM) * QUANTUM :]
    assert len(recent) == pytest.approx(0.4 * rate, abs=QUANTUM)
    assert engine.meter.loudness == pytest.approx(-0.691 + 10 * math.log10((recent**2).mean(axis=0).sum()), abs=1e-4)


def test_peaks_are_those_of_each_channel_in_the_last_400_ms_or_since_a_sample():
    engine, sound = playing()
    sound = np.concatenate([sound, engine.process(-len(sound) % QUANTUM)])

    def highest(first):
        return pytest.approx(20 * np.log10(np.abs(sound[first:]).max(axis=0).astype(float)), abs=1e-5)

    assert engine.meter.peaks() == highest(-19_200)
    assert engine.meter.peaks(engine.position - 640) == highest(-640) != engine.meter.peaks()
    assert engine.meter.peaks(engine.position) == [SILENCE, SILENCE]


def test_silence_is_200_db_below_full_scale_and_a_meter_that_was_not_started_shows_it():
    engine, _ = playing()
    engine.process(48_000 * 20)
    assert engine.meter.loudness < -100 and max(engine.meter.peaks()) < -100
    other = Engine(48_000.0)
    strike(other, other.add(Modes(np.array([500.0]), np.ones(1), np.ones((4, 1)), np.ones((2, 1)), 1.0)))
    other.process(4_800)
    assert other.meter.loudness == pytest.approx(SILENCE - 0.691) and other.meter.peaks() == [SILENCE] * 2
