"""Strips and open cylinders against limits, panels of another method, and closed bodies."""

import math

import numpy as np
import pytest
from scipy.special import hankel1, jvp

from carom.dsp.bodies.air import DENSITY, IMPEDANCE, SPEED
from carom.dsp.bodies.radiation import strip_table
from carom.dsp.bodies.radiation.closed import cylinder_efficiency
from carom.dsp.bodies.radiation.thin import open_cylinder, strip
from carom.dsp.bodies.radiation.wall import load_of
from tests.dsp.bodies.write_tables import FOLDER
from tests.dsp.bodies.write_tables import strip_table as written


def decibels(ratio):
    return 10 * np.log10(ratio)


def strip_by_panels(x, count):
    """Return the impedance per length over rho c b: the jump constant on panels, velocity met at their middles.

    v = 1/(i omega rho) d^2/dn^2 int p G with G = i/4 H_0; on the flat strip d^2/dn^2 = -(k^2 + d^2/dz^2), and the
    derivative is taken at the panels' ends.
    """
    edges = np.linspace(-1, 1, count + 1)
    middle = (edges[1:] + edges[:-1]) / 2
    nodes, weights = np.polynomial.legendre.leggauss(16)
    half = 1 / count

    def green(distance):
        return 0.25j * hankel1(0, x * np.abs(distance))

    def slope(distance):
        return -0.25j * x * hankel1(1, x * np.abs(distance)) * np.sign(distance)

    offset = middle[:, None] - middle
    whole = half * (weights * green(offset[..., None] - half * nodes)).sum(axis=2)
    near = np.arange(count)
    # the logarithm of the own panel is integrated by itself
    u = half * (nodes + 1) / 2
    smooth = green(u) + np.log(u) / (2 * math.pi)
    whole[near, near] = 2 * (half / 2 * (weights * smooth).sum() - half * (math.log(half) - 1) / (2 * math.pi))
    ends = slope(middle[:, None] - edges[1:]) - slope(middle[:, None] - edges[:-1])
    matrix = -(x**2 * whole - ends)
    jump = np.linalg.solve(matrix / (1j * x), np.ones(count))
    return complex((jump * 2 * half).sum())


@pytest.mark.slow
@pytest.mark.parametrize("x", [0.3, 1.0, 1.7, 4.0])
def test_a_strip_is_that_of_panels(x):
    coarse, fine = (strip_by_panels(x, count) for count in (100, 200))
    expected = 2 * fine - coarse  # it errs by the panel's width
    assert strip(x).real == pytest.approx(abs(expected.real), rel=0.01)
    assert abs(strip(x).imag) == pytest.approx(abs(expected.imag), rel=0.01)


def test_a_strip_of_long_and_of_short_waves():
    slow = strip(0.01)
    assert -slow.imag / 0.01 == pytest.approx(math.pi, rel=1e-3)  # rho pi b^2 of air moves along
    assert slow.real == pytest.approx(math.pi**2 * 0.01**3 / 8, rel=1e-3)
    assert strip(40.0).real == pytest.approx(4, rel=0.01)


def test_the_strips_table_is_the_solution():
    assert written() == (FOLDER / "strip_table.py").read_text(encoding="utf-8")
    assert len(strip_table.RESISTANCE) == len(strip_table.MASS) == 160


def cylinder(order, k, radius, half):
    """Return the impedance of an open cylinder that moves alike along its length."""
    (found,) = open_cylinder(np.array([order]), np.array([k]), radius, half, np.ones_like)
    return found


@pytest.mark.parametrize(("order", "x"), [(2, 0.7), (2, 1.5), (3, 2.0), (5, 3.0)])
def test_a_long_open_cylinder_radiates_as_a_closed_one(order, x):
    """Slower than its inside can carry sound along, the inside is silent."""
    radius, half = 0.05, 0.4
    k = x / radius
    found = cylinder(order, k, radius, half).real
    area = 2 * math.pi * radius * 2 * half
    endless = IMPEDANCE * area / 2 * cylinder_efficiency(order, np.array(x))
    assert decibels(found / endless) == pytest.approx(0, abs=1)  # of 16 radii
    by_line = load_of(np.array([float(order)]), radius, half, np.ones_like, np.array([k * SPEED / (2 * math.pi)]))
    assert decibels(found / by_line.resistance[0]) == pytest.approx(0, abs=0.25)


@pytest.mark.parametrize(("order", "x"), [(1, 0.5), (2, 0.5), (2, 1.0), (3, 1.0)])
def test_a_short_ring_is_a_ring_of_dipoles(order, x):
    radius, half = 0.05, 0.0025
    k = x / radius
    u, w = np.polynomial.legendre.leggauss(60)
    sine = np.sqrt(1 - u**2)
    force = SPEED * k * DENSITY * math.pi * half**2
    directions = (w * sine**2 * jvp(order, x * sine) ** 2).sum()
    dipoles = (k * force * radius / 2) ** 2 * math.pi / IMPEDANCE * directions
    assert decibels(cylinder(order, k, radius, half).real / dipoles) == pytest.approx(0, abs=0.5)


def test_more_terms_change_an_open_cylinder_little():
    for order, k, half in ((2, 20, 0.05), (3, 150, 0.05), (6, 300, 0.1)):
        found = cylinder(order, k, 0.05, half)
        assert np.isfinite(found) and found.real > 0
    slow = cylinder(2, 0.5, 0.05, 1.0)
    # both sides of a long wall that bends by cos(m theta) move rho a/m each
    mass = -slow.imag / (0.5 * SPEED)
    assert mass == pytest.approx(2 * DENSITY * 0.05 / 2 * math.pi * 0.05 * 2.0, rel=0.05)


@pytest.mark.parametrize(("order", "x"), [(31, 20.0), (31, 40.0), (45, 40.0), (45, 70.0)])
def test_debyes_terms_serve_for_high_orders(monkeypatch, order, x):
    by_debye = cylinder(order, x / 0.3, 0.3, 0.1)
    monkeypatch.setattr("carom.dsp.bodies.radiation.thin._UNIFORM", 1000)
    exact = cylinder(order, x / 0.3, 0.3, 0.1)
    assert decibels(by_debye.real / exact.real) == pytest.approx(0, abs=0.05)
    assert by_debye.imag == pytest.approx(exact.imag, rel=0.01)
