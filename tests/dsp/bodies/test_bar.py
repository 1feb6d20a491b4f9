"""Bars against published figures and exact solutions."""

import math
import sys

import numpy as np
import pytest
from scipy.optimize import brentq

from carom.dsp import bodies
from tests.dsp.bodies.reference import FREE_ROOTS, STEEL, euler_bernoulli


@pytest.mark.parametrize(("ratio", "deviation"), [(40, {1: -0.2, 6: -4.0}), (10, {1: -3.4, 3: -15.0})])
def test_timoshenko_lowers_a_free_bar_as_published(ratio, deviation):
    modes = bodies.bar(STEEL, length=1, width=0.02, thickness=1 / ratio, top=20000)
    thin = euler_bernoulli(STEEL, FREE_ROOTS, 1, 1 / ratio)
    for n, percent in deviation.items():
        assert 100 * (modes.frequency[n - 1] / thin[n - 1] - 1) == pytest.approx(percent, abs=0.1)


def test_thin_cantilever_and_free_bar_are_euler_bernoullis():
    tine = bodies.bar(STEEL, length=0.3, width=0.02, thickness=0.0003, ends="cantilever", top=4000)
    assert tine.frequency[:3] == pytest.approx(
        euler_bernoulli(STEEL, [1.8751041, 4.6940911, 7.8547574], 0.3, 0.0003), rel=1e-4
    )
    free = bodies.bar(STEEL, length=0.3, width=0.02, thickness=0.0003, top=4000)
    assert free.frequency[:7] == pytest.approx(euler_bernoulli(STEEL, FREE_ROOTS, 0.3, 0.0003), rel=2e-4)


def test_the_ends_of_a_thin_bar_move_twice_the_rms():
    modes = bodies.bar(STEEL, length=0.3, width=0.02, thickness=0.0003, top=2000)
    assert np.abs(modes.strike[[0, -1]]) * math.sqrt(modes.mass) == pytest.approx(2, rel=1e-3)


def test_a_thick_free_bar_solves_timoshenkos_frequency_equation():
    # moment and shear of the four exponential solutions, at both ends: the determinant vanishes
    nu, e, rho, length, h = STEEL.poisson_ratio, STEEL.youngs_modulus, STEEL.density, 1.0, 0.1
    kappa = 10 * (1 + nu) / (12 + 11 * nu)
    g, moment, area = STEEL.shear_modulus, h**3 / 12, h

    def determinant(frequency):
        omega2 = (2 * math.pi * frequency) ** 2
        b = rho * moment * (1 + e / (kappa * g)) * omega2
        c = rho * area * omega2 - rho**2 * moment / (kappa * g) * omega2**2
        root = np.sqrt(b**2 + 4 * e * moment * c + 0j)
        rows = []
        for s in (
            *(sign * 1j * np.sqrt((b + root) / (2 * e * moment)) for sign in (1, -1)),
            *(sign * np.sqrt((root - b) / (2 * e * moment)) for sign in (1, -1)),
        ):
            turn = (s**2 + rho * omega2 / (kappa * g)) / s  # psi / w of exp(s x)
            rows.append([s * turn, s - turn, s * turn * np.exp(s * length), (s - turn) * np.exp(s * length)])
        value = np.linalg.det(np.array(rows))
        return value.real if abs(value.real) > abs(value.imag) else value.imag

    modes = bodies.bar(STEEL, length=length, width=0.02, thickness=h, top=6000)
    for frequency in modes.frequency[:6]:
        exact = brentq(determinant, frequency * 0.995, frequency * 1.005)
        assert frequency == pytest.approx(exact, rel=1e-8)


def test_the_ritz_series_of_a_bar_has_converged(monkeypatch):
    coarse = bodies.bar(STEEL, length=0.5, width=0.03, thickness=0.02, undercut=0.8, top=20000)
    module = sys.modules["carom.dsp.bodies.bar"]  # its name in the package is the function's
    wavenumber = module._wavenumber
    monkeypatch.setattr(module, "_wavenumber", lambda *arguments: 1.6 * wavenumber(*arguments))
    fine = bodies.bar(STEEL, length=0.5, width=0.03, thickness=0.02, undercut=0.8, top=20000)
    assert coarse.frequency == pytest.approx(fine.frequency, rel=1e-3)


def test_an_undercut_tunes_the_second_mode_up_to_two_octaves():
    def ratio(undercut):
        modes = bodies.bar(STEEL, length=0.35, width=0.05, thickness=0.02, undercut=undercut, top=20000)
        return modes.frequency[1] / modes.frequency[0]

    assert ratio(0.0) == pytest.approx(2.7, abs=0.06)
    assert ratio(brentq(lambda u: ratio(u) - 4, 0.1, 0.9)) == pytest.approx(4)


def test_a_tube_rings_between_a_rod_and_a_shell():
    rod, tube = (bodies.bar(STEEL, length=1.5, diameter=0.038, wall=wall, top=5000) for wall in (None, 0.0015))
    assert rod.mass == pytest.approx(STEEL.density * math.pi / 4 * 0.038**2 * 1.5)
    assert tube.mass == pytest.approx(STEEL.density * math.pi * 0.0365 * 0.0015 * 1.5)
    # radius of gyration: d/4 for a rod, sqrt(D^2 + d^2)/4 for a tube
    assert tube.frequency[0] / rod.frequency[0] == pytest.approx(math.hypot(0.038, 0.035) / 0.038, rel=0.02)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"width": 0.1}, "width and thickness, or diameter"),
        ({"width": 0.1, "thickness": 0.01, "diameter": 0.1}, "width and thickness, or diameter"),
        ({"diameter": 0.02, "wall": 0.011}, "wall = 0.011: expected at most half the diameter"),
        ({"diameter": -0.02}, "diameter = -0.02: expected a positive number"),
        ({"diameter": 0.02, "ends": "glued"}, "ends = glued: expected one of free, cantilever"),
        ({"width": 0.1, "thickness": 0.01, "undercut": 1.0}, "undercut = 1.0"),
    ],
)
def test_impossible_bars_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        bodies.bar(STEEL, length=1, top=20000, **arguments)
