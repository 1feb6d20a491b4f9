"""A strike has the same sound at the same times at any sampling rate."""

import numpy as np
import pytest

import carom
from tests.accuracy import RATES

BASE, TOP = 48_000, 12_000.0
"""Hz: below it sounds are compared."""


def sound(name: str, rate: int) -> np.ndarray:
    """Return the spectrum below TOP of 50 ms of a preset's own strike, at the times of samples at 48 kHz."""
    with carom.Scene(rate, limiter=False) as scene:
        scene.send("/accuracy", "exact")
        scene.new("a", name).impact(1.0, at=0.001)
        left = scene.render(0.05).samples[:: rate // BASE, 0].astype(float)
    spectrum = np.fft.rfft(left)
    return spectrum[np.fft.rfftfreq(len(left), 1 / BASE) < TOP]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "within"), [(name, RATES[names].bound) for names in RATES for name in names])
def test_a_strike_is_alike_at_48_and_192_khz(name, within):
    coarse, fine = sound(name, BASE), sound(name, 4 * BASE)
    difference = float(np.sum(np.abs(coarse - fine) ** 2) / np.sum(np.abs(fine) ** 2))
    assert 10 * np.log10(difference) < within
