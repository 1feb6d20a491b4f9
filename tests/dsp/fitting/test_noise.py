"""Bands of noise of known levels and decays, with and without a floor; distances that are known."""

import numpy as np
import pytest

from carom.dsp.fitting.distance import decay, distance, log_spectral
from carom.dsp.fitting.noise import Bands, band_edges, noise_bands, without_tones

from .synthetic import modes

RATE = 48_000.0
EDGES = band_edges(RATE)
COUNT = len(EDGES) - 1
KNOWN = Bands(EDGES, np.geomspace(0.02, 0.002, COUNT), np.geomspace(5, 60, COUNT), np.zeros(COUNT))
MIDDLE = slice(9, COUNT - 1)  # bands that are broad enough for their power to be known


def noise(count: int, size: float, seed: int = 2) -> np.ndarray:
    return size * np.random.default_rng(seed).standard_normal(count)


@pytest.mark.slow
@pytest.mark.parametrize("floor", [0.0, 3e-4])
def test_levels_and_decays_are_found_with_the_floor_in_the_model(floor):
    rest = KNOWN.sound(round(1.5 * RATE), RATE, seed=3) + noise(round(1.5 * RATE), floor)
    found = noise_bands([rest], [noise(round(0.5 * RATE), floor, 9)], RATE)
    louder = 20 * np.log10(found.rms / KNOWN.rms)[MIDDLE]
    faster = np.log(found.decay / KNOWN.decay)[MIDDLE]
    # A burst of noise has few degrees of freedom, so that its level itself scatters by 1 to 2 dB.
    assert np.sqrt(np.mean(louder**2)) < 2 and abs(np.mean(louder)) < 1
    assert np.sqrt(np.mean(faster**2)) < 0.25 and abs(np.mean(faster)) < 0.1


def test_noise_is_left_where_a_tone_is_taken_out():
    t = np.arange(round(RATE)) / RATE
    tone = 0.01 * np.sin(2 * np.pi * 1003 * t) * np.exp(-3 * t)
    hiss = noise(len(t), 0.001)
    left = without_tones(tone + hiss, np.array([1000.0]), np.array([3.0]), RATE)
    assert np.sum((left - hiss) ** 2) < 0.02 * np.sum(tone**2)


BELL = modes(10, 1, apart=300.0).sound(1.0, RATE)


def test_a_sound_is_no_distance_from_itself_later_and_louder():
    found = distance(BELL, 0.3 * np.concatenate([np.zeros(777), BELL]), RATE)
    assert found.residual < -60 and found.spectral < 0.05
    assert found.gain == pytest.approx(-20 * np.log10(0.3), abs=0.01) and found.shift == pytest.approx(-777 / RATE)
    assert found.thirds[:, 1] == pytest.approx(found.thirds[:, 2], abs=0.1)


def test_a_sound_at_another_rate_is_the_same():
    slow = modes(10, 1, apart=300.0).sound(1.0, 32_000)
    assert distance(BELL, slow, RATE, 32_000).spectral < 0.5


def test_a_quiet_band_and_a_gain_are_heard():
    assert log_spectral(BELL, BELL, RATE) == 0
    assert log_spectral(BELL, 2 * BELL, RATE) == pytest.approx(20 * np.log10(2), abs=0.3)


@pytest.mark.parametrize("t60", [0.1, 0.5, 2.0])
def test_decays_are_read_off(t60):
    t = np.arange(round(1.5 * RATE)) / RATE
    rings = np.exp(-np.log(1000) / t60 * t)
    assert decay(rings * noise(len(t), 1.0), RATE, 1000.0) == pytest.approx(t60, rel=0.15)
    assert np.isnan(decay(rings * np.sin(2 * np.pi * 8000 * t) * np.minimum(1, t / 0.01), RATE, 125.0))
