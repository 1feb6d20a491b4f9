"""Samples at another rate, against scipy's polyphase filter and against sines."""

import numpy as np
import pytest
from scipy.signal import resample_poly

from carom.dsp.numerics.resampling import resampled


@pytest.mark.parametrize(("up", "down"), [(1, 1), (2, 1), (4, 1), (1, 2), (160, 147), (147, 160), (1, 24), (80, 441)])
@pytest.mark.parametrize("count", [0, 1, 5, 1000])
def test_samples_at_another_rate_agree_with_those_of_scipy(up, down, count):
    samples = np.random.default_rng(1).normal(size=(count, 2))
    expected = resample_poly(samples, up, down, axis=0) if count else np.zeros((0, 2))
    assert resampled(samples, up, down) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize(("rate", "other"), [(48_000, 44_100), (44_100, 48_000), (96_000, 48_000), (48_000, 192_000)])
def test_a_sine_stays_one(rate, other):
    common = np.gcd(rate, other)
    sine = np.sin(2 * np.pi * 1000 * np.arange(rate // 10) / rate)[:, None]
    found = resampled(sine, other // common, rate // common)[:, 0]
    expected = np.sin(2 * np.pi * 1000 * np.arange(len(found)) / other)
    inner = slice(other // 100, -other // 100)
    assert found[inner] == pytest.approx(expected[inner], abs=2e-3)
