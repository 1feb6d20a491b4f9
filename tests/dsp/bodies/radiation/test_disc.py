"""Discs in free air and in a wall against exact solutions of other kinds."""

import math

import numpy as np
import pytest
from scipy.special import iv, j1, jv, spherical_jn, struve

from carom.dsp.bodies.air import DENSITY, IMPEDANCE
from carom.dsp.bodies.radiation.disc import Waves, _jumps, baffled_disc, free_disc
from tests.dsp.bodies.radiation.spheroid import impedance

RADIUS = 0.2


def waves(order, root, growing=0.0):
    return Waves(order, *(np.atleast_1d(np.asarray(each, float)) for each in (root, growing, 1.0)))


def at(*x):
    return np.array(x, float)


def decibels(ratio):
    return 10 * np.log10(ratio)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "x", "growing"), [(0, 0.1, 0), (0, 1, 0.5), (0, 3, -0.4), (1, 2, 0), (2, 1, 0.7), (3, 4, 0.2)]
)
def test_a_free_disc_is_the_spheroid_of_no_thickness(order, x, growing):
    root = 5.3

    def profile(r):
        return jv(order, root * r) + growing * iv(order, root * r) / iv(order, root)

    expected = impedance(order, x, RADIUS, profile, 9)
    found = free_disc(waves(order, root, growing), at(x), RADIUS)[0, 0]
    assert found.real == pytest.approx(expected.real, rel=5e-3)  # 0.02 dB
    assert found.imag == pytest.approx(expected.imag, rel=2e-3)


def test_a_piston_in_free_air():
    """Slow: a dipole with the added mass 8/3 rho a^3. Fast: both sides as a wide source."""
    slow = free_disc(waves(0, 1e-6), at(0.05), RADIUS)[0, 0]
    omega = 0.05 * 343 / RADIUS
    mass = 8 / 3 * DENSITY * RADIUS**3
    assert -slow.imag / omega == pytest.approx(mass, rel=1e-3)
    # W = omega^2 F^2/(24 pi rho c^3) of a dipole of force F = omega m v, and W = R v^2/2
    assert slow.real == pytest.approx(omega**4 * mass**2 / (12 * math.pi * DENSITY * 343**3), rel=2e-3)
    fast = free_disc(waves(0, 1e-6), at(40.0), RADIUS)[0, 0]
    assert fast.real == pytest.approx(2 * IMPEDANCE * math.pi * RADIUS**2, rel=0.01)


@pytest.mark.parametrize("x", [0.05, 0.5, 2.0, 8.0, 30.0])
def test_a_piston_in_a_wall_is_rayleighs(x):
    found = baffled_disc(waves(0, 1e-6), at(x), RADIUS)[0, 0] / (IMPEDANCE * math.pi * RADIUS**2)
    assert found.real == pytest.approx(1 - j1(2 * x) / x, rel=1e-9)
    assert -found.imag == pytest.approx(struve(1, 2 * x) / x, rel=0.02)


@pytest.mark.parametrize("order", [0, 1, 2, 5, 12])
@pytest.mark.parametrize("x", [0.3, 2.0, 9.0, 20.0])
def test_near_field_and_far_field_agree(order, x):
    """The power at the disc, pressure times velocity, equals the power that its jump of pressure sends far away."""
    roots = order + np.array([3.0, 9.0, 16.0])
    b, (jump,), degrees = _jumps(Waves(order, roots, np.array([0.3, 0.0, -0.6]), np.ones(3)), at(x))
    turn = 2 * math.pi if order == 0 else math.pi
    near = 2 * IMPEDANCE * RADIUS**2 * turn * x * np.real((jump * b).sum(axis=0))
    # Far: |p| = k cos(t)/(2 r) |Dp^| cos(m f), Dp^ the Hankel transform of the jump, a dipole of it along the normal.
    angle, weights = np.polynomial.legendre.leggauss(400)
    angle, weights = (angle + 1) * math.pi / 4, weights * math.pi / 4
    s = x * np.sin(angle)
    transform = jump.T @ np.array([spherical_jn(int(degree), s) / s for degree in degrees])
    dipole = 2 * IMPEDANCE * x * np.abs(transform) * RADIUS**2 * x / RADIUS * np.cos(angle)
    far = 2 * turn / IMPEDANCE * (weights * np.sin(angle) * (dipole / 2) ** 2).sum(axis=1)
    assert near == pytest.approx(far, rel=1e-6, abs=1e-12 * near.max())


def test_places_and_modes_solved_together_are_those_solved_alone():
    roots, places = np.array([6.0, 9.5, 13.0]), at(0.1, 1.0, 7.0)
    for solve in (free_disc, baffled_disc):
        together = solve(Waves(3, roots, at(0.3, 0.0, -0.4), np.ones(3)), places, RADIUS)
        for p, x in enumerate(places):
            for k, (root, growing) in enumerate(zip(roots, (0.3, 0.0, -0.4), strict=True)):
                alone = solve(waves(3, root, growing), at(x), RADIUS)[0, 0]
                assert together[p, k] == pytest.approx(alone, rel=2e-3)


def test_terms_beyond_those_taken_change_nothing(monkeypatch):
    family = Waves(2, np.array([8.0, 14.0]), np.array([0.4, -0.3]), np.ones(2))
    few = free_disc(family, at(1.0, 6.0), RADIUS)
    monkeypatch.setattr("carom.dsp.bodies.radiation.disc._MARGIN", 12)
    assert decibels(few.real / free_disc(family, at(1.0, 6.0), RADIUS).real) == pytest.approx(0, abs=0.02)
