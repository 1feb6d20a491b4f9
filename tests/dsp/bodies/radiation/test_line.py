"""Bars, rods and tubes against other solutions of the same bodies."""

import math

import numpy as np
import pytest
from scipy.integrate import trapezoid

from carom.dsp import bodies
from carom.dsp.bodies.air import DENSITY, IMPEDANCE, SPEED, wavenumber
from carom.dsp.bodies.radiation import line
from carom.dsp.bodies.radiation.closed import cylinder_efficiency
from carom.dsp.bodies.radiation.rectangle import free_rectangle, jump_terms, side
from tests.dsp.bodies.reference import HEAVY, STEEL


def decibels(ratio):
    return 10 * np.log10(ratio)


def moving(outline, length, shape, slope):
    """Return a bar of one kg whose one mode has a given shape of x in -1..1."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    values = [np.asarray(each(nodes), float)[:, None] for each in (shape, slope)]
    return line.Bar(nodes, weights, 120, *values, length / 2, outline(nodes))


def radiated(modes):
    return 4 * math.pi * (modes.pressure**2).mean(axis=0) / IMPEDANCE


@pytest.mark.parametrize("x", [0.3, 1.0, 4.0])
def test_a_long_rod_that_moves_as_a_whole_is_a_cylinder(x):
    radius, length = 0.01, 4.0
    bar = moving(lambda at: line.tubular(2 * radius, 0.0, at), length, np.ones_like, np.zeros_like)
    frequency = np.array([x / radius * SPEED / (2 * math.pi)])
    expected = IMPEDANCE * math.pi * radius * length * cylinder_efficiency(1, np.array([x]))
    assert decibels(line.load_of(bar, frequency).resistance / expected) == pytest.approx(0, abs=0.1)


@pytest.mark.slow
def test_a_slow_rod_is_a_line_of_dipoles():
    """p = k sin(t) cos(f)/(4 pi r) |int F' exp(-i k x cos t) dx|, F' of displaced and added mass, by brute force."""
    bar = bodies.bar(HEAVY, length=0.5, diameter=0.006, top=3000)
    x = np.linspace(0, 1, len(bar.strike))
    fine = np.linspace(0, 1, 4001)
    from scipy.interpolate import CubicSpline

    shapes = CubicSpline(x, bar.strike)(fine)
    angle, weights = np.polynomial.legendre.leggauss(200)
    for frequency, shape, found in zip(bar.frequency, shapes.T, radiated(bar), strict=True):
        k = float(wavenumber(frequency))
        force = 2 * k * SPEED * DENSITY * math.pi * 0.003**2 * shape
        phase = np.exp(-1j * k * 0.5 * np.outer(angle, fine))
        whole = np.abs(trapezoid(force * phase, fine * 0.5, axis=1))
        power = math.pi * (weights * (k / (4 * math.pi)) ** 2 * (1 - angle**2) * whole**2).sum() / IMPEDANCE
        assert decibels(found / power) == pytest.approx(0, abs=0.15)


@pytest.mark.parametrize("mode", [1, 2, 5])
@pytest.mark.parametrize("x", [0.2, 0.6, 1.5, 3.0])
def test_a_flat_bar_is_a_narrow_plate(mode, x):
    """A strip's line integral against the exact jump across the same rectangle, moving as sin or cos of its length."""
    length, width = 0.6, 0.04
    k = x / (width / 2)
    turn = mode * math.pi

    def shape(at):
        return np.cos(turn * (at + 1) / 2)

    def slope(at):
        return -turn / length * np.sin(turn * (at + 1) / 2)

    bar = moving(lambda at: line.rectangular(width, np.full_like(at, 1e-6)), length, shape, slope)
    by_line = line.load_of(bar, np.array([k * SPEED / (2 * math.pi)])).resistance[0]
    terms = (40 + 2 * mode, 14)
    sides = side(length / 2, terms[0]), side(width / 2, terms[1])
    along = jump_terms(terms[0], lambda at: np.cos(turn * at)[:, None], length / 2)
    across = jump_terms(terms[1], lambda at: np.ones_like(at)[:, None], width / 2)
    odd = mode % 2
    parts = {(odd, 0): along[odd::2, None] * across[None, 0::2]}
    exact = 2 * IMPEDANCE * k * free_rectangle(k, *sides, parts)[0].real
    assert decibels(by_line / exact) == pytest.approx(0, abs=0.6)


def test_the_air_lowers_a_light_broad_bar():
    given = {"length": 0.5, "width": 0.04, "thickness": 0.001, "top": 300}
    light = bodies.Material("light", 1000, 3e9, 0.3, 1, 0)
    alone = bodies.Material("light without air", 1000e9, 3e18, 0.3, 1, 0)
    ratio = (bodies.bar(alone, **given).frequency / bodies.bar(light, **given).frequency) ** 2 - 1
    flat = DENSITY * math.pi * 0.02**2 / (1000 * 0.04 * 0.001)  # rho pi b^2 of an endless strip, of long waves
    assert np.all(ratio < 1.01 * flat) and ratio[0] > 0.8 * flat and np.all(np.diff(ratio[:3]) < 0)


def test_a_bars_loss_is_what_it_radiates():
    modes = bodies.bar(STEEL, length=0.3, width=0.05, thickness=0.004, top=12000)
    assert modes.decay - STEEL.decay(modes.frequency) == pytest.approx(radiated(modes) / 2, rel=1e-6)
    assert radiated(modes).max() / 2 > STEEL.decay(0)
