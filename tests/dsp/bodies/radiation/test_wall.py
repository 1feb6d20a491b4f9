"""The air's load on long tubes, against sums over all of their length."""

import math

import numpy as np
import pytest

from carom.dsp.bodies.air import IMPEDANCE, wavenumber
from carom.dsp.bodies.radiation.closed import radial_function
from carom.dsp.bodies.radiation.wall import load_of

PROFILES = {
    "uniform": np.ones_like,
    "tilted": lambda z: (1 + z) / 2,
    "cantilever": lambda z: np.cosh(3.9 * z) / np.cosh(3.9) + 0.3 * np.sin(3.9 * z),
}


@pytest.mark.slow
@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
@pytest.mark.parametrize(("radius", "half", "frequency"), [(0.02, 0.3, 900.0), (0.02, 0.3, 15_000.0), (1.0, 5.0, 4e3)])
def test_a_long_tube_radiates_as_a_sum_over_its_length_says(profile, radius, half, frequency):
    """R = 2 rho c eps/pi^2 int_0^(pi/2) |V(k cos t)|^2/(sin t |H_m'(k a sin t)|^2) dt, by one rule of 1,000 angles."""
    k = float(wavenumber(np.array([frequency]))[0])
    (t, shares), (z, weights) = (np.polynomial.legendre.leggauss(points) for points in (1_000, 400))
    t, shares = (1 + t) * math.pi / 4, shares * math.pi / 4
    wave = np.exp(1j * k * half * np.outer(np.cos(t), z)) @ (profile(z) * weights)
    for order in (2.0, 5.0):
        outward = radial_function(int(order), k * radius * np.sin(t)) * np.sin(t)
        power = (half**2 * np.abs(wave) ** 2 / outward * shares).sum()
        load = load_of(np.array([order]), radius, half, profile, np.array([frequency]))
        assert load.resistance[0] == pytest.approx(2 * IMPEDANCE * math.pi / math.pi**2 * power, rel=0.01)
