"""Sensors' own resonance: the filter against the mass on a spring that it stands for."""

import numpy as np
import pytest
from scipy.signal import freqz

from carom.dsp.bodies.sensor import Sensor

CASES = [(2_800, 0.1), (4_600, 0.02), (11_000, 0.05), (21_000, 0.03), (25_000, 0.02), (50_000, 0.02), (30_000, 0.7),
         (4_000, 1.5), (200, 0.5), (1e6, 0.05)]  # fmt: skip


@pytest.mark.parametrize(("resonance", "damping"), CASES)
@pytest.mark.parametrize("rate", [44_100.0, 48_000.0, 96_000.0])
def test_a_filter_does_as_a_mass_on_a_spring(rate, resonance, damping):
    sensor = Sensor("acceleration", resonance, damping)
    b0, b1, b2, a1, a2 = sensor.filter(rate)
    assert np.abs(np.roots([1.0, a1, a2])).max() < 1.0
    frequency = np.linspace(10.0, 20_000.0 * min(rate / 48_000.0, 1.0), 500)
    s = 2j * np.pi * frequency
    omega = 2 * np.pi * resonance
    wanted = np.abs(omega**2 / (s**2 + 2 * damping * omega * s + omega**2))
    found = np.abs(freqz([b0, b1, b2], [1.0, a1, a2], worN=frequency, fs=rate)[1])
    assert np.abs(20 * np.log10(found / wanted)).max() < 0.3


def test_a_sensor_without_resonance_changes_nothing():
    assert Sensor().filter(48_000.0) == (1.0, 0.0, 0.0, 0.0, 0.0)
