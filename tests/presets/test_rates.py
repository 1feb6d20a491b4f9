"""A strike has the same sound at the same times at any sampling rate."""

import numpy as np
import pytest

import carom
from tests.accuracy import RATES

BASE, TOP = 48_000, 12_000.0
"""Hz: below it sounds are compared."""


def sound(name: str, rate: int, seconds: float = 0.05, **keys: str) -> np.ndarray:
    """Return the spectrum below TOP of the beginning of a preset's strike, at the times of samples at 48 kHz."""
    with carom.Scene(rate, limiter=False) as scene:
        scene.send("/accuracy", "exact")
        scene.new("a", name).impact(1.0, at=0.001, **keys)
        left = scene.render(seconds).samples[:: rate // BASE, 0].astype(float)
    spectrum = np.fft.rfft(left)
    return spectrum[np.fft.rfftfreq(len(left), 1 / BASE) < TOP]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "within"), [(name, RATES[names].bound) for names in RATES for name in names])
def test_a_strike_is_alike_at_48_and_192_khz(name, within):
    assert apart(sound(name, BASE), sound(name, 4 * BASE)) < within


@pytest.mark.slow
def test_felt_on_a_bell_sounds_the_same_at_four_times_the_rate():
    """Felt on a bell is so quiet that the end of its higher modes is a part of the sound."""
    coarse, fine = (sound("church-bell", rate, 0.1, striker="felt") for rate in (BASE, 4 * BASE))
    assert apart(coarse, fine) < -100


def apart(coarse: np.ndarray, fine: np.ndarray) -> float:
    """Return the energy of the difference of two spectra over that of the second, dB."""
    return float(10 * np.log10(np.sum(np.abs(coarse - fine) ** 2) / np.sum(np.abs(fine) ** 2)))
