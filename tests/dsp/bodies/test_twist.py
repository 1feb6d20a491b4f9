"""Radiation of a twisting bar, against the exact strip, potential flow, and far fields of the jump of the pressure."""

import math

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.special import jv

from carom.dsp.bodies.air import DENSITY, SPEED
from carom.dsp.bodies.radiation import twist
from carom.dsp.bodies.radiation.twist import FLATNESS, THICKNESS, Twist, strip


def galerkin(x, terms=24):
    """Return S of a strip whose velocity is y: U_n on the jump of the pressure, in the spectrum ."""

    def segment(low, high, points):
        nodes, weights = legendre.leggauss(points)
        return low + (high - low) * (nodes + 1) / 2, weights * (high - low) / 2

    n = np.arange(terms)[:, None]
    t, weights = segment(0, math.pi, 4 * terms + 40)
    b = (np.sin((n + 1) * t) * np.sin(t) * weights) @ np.cos(t)
    matrix = np.diag(1j * math.pi * (n[:, 0] + 1) / 2 / x).astype(complex)
    even = (n + n.T) % 2 == 0
    sign = math.pi * np.outer(n + 1, n + 1) / x * np.where(even, np.real(1j ** (n - n.T)), 0)
    t, weights = segment(0, math.pi / 2, int(40 + x))
    kappa = x * np.sin(t)
    bessel = jv(n + 1, kappa) / kappa
    matrix += sign * ((bessel * ((x * np.cos(t) - 1j * kappa) * weights * x * np.cos(t))) @ bessel.T)
    end = x + terms + 60
    y, weights = segment(0, math.sqrt(end - x), int(120 + 0.6 * (end - x)))
    kappa = x + y**2
    bessel = jv(n + 1, kappa) / kappa
    matrix += sign * ((bessel * (1j * (np.sqrt(kappa**2 - x**2) - kappa) * weights * 2 * y)) @ bessel.T)
    return np.real(np.linalg.solve(matrix / 2, b) @ b)


@pytest.mark.parametrize("x", [0.03, 0.11, 0.47, 1.3, 2.9, 5.2, 9.0, 30.0])
def test_the_table_is_the_exact_strip(x):
    assert float(strip(np.array([x]))[0]) == pytest.approx(galerkin(x), rel=0.025)


def source_panels(thickness, count=60):
    """Return the quadrupole of a rectangle of half sides 1 and `thickness` that turns, by sources on its sides."""
    graded = (np.arange(count + 1) / count) ** 3 / 2
    along = 2 * np.concatenate([graded[:-1], 1 - graded[::-1]]) - 1
    top, right = np.stack([along, np.full_like(along, thickness)], 1), np.stack([0 * along + 1, -thickness * along], 1)
    first = np.concatenate([side[:-1] for side in (top, right, -top, -right)])
    second = np.concatenate([side[1:] for side in (top, right, -top, -right)])
    middle, across = (first + second) / 2, second - first
    length = np.hypot(*across.T)
    tangent = across / length[:, None]
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], 1)
    velocity = middle[:, 0] * normal[:, 1] - middle[:, 1] * normal[:, 0]
    apart = middle[:, None] - middle
    x, y, h = (apart * tangent).sum(-1), (apart * normal).sum(-1), length / 2
    u = np.log(((x + h) ** 2 + y**2) / ((x - h) ** 2 + y**2)) / (4 * math.pi)
    v = np.arctan2(2 * y * h, x**2 + y**2 - h**2) / (2 * math.pi)
    field = u[..., None] * tangent + v[..., None] * normal
    matrix = (field * normal[:, None]).sum(-1)
    np.fill_diagonal(matrix, 0.5)
    source = np.linalg.lstsq(matrix, velocity, rcond=None)[0]
    return abs((source * length * middle[:, 0] * middle[:, 1]).sum()) / (math.pi / 8)


@pytest.mark.slow
@pytest.mark.parametrize(("thickness", "flatness"), list(zip(THICKNESS, FLATNESS, strict=True))[1:])
def test_a_turning_rectangles_quadrupole_is_that_of_potential_flow(thickness, flatness):
    assert source_panels(thickness) == pytest.approx(flatness, rel=3e-3, abs=1e-9)


NODES, WEIGHTS = legendre.leggauss(120)


def flat(half, b, twist, thickness=1e-9):
    return Twist((half, b), NODES, WEIGHTS, twist(NODES)[:, None], np.full_like(NODES, thickness))


def test_a_slow_flat_bar_radiates_as_the_far_field_of_its_jump():
    """The jump of the velocity potential across a turning strip is its twist times y sqrt(b^2 - y^2), Lamb's."""
    half, b, frequency = 0.2, 0.01, 600.0
    k = 2 * math.pi * frequency / SPEED

    def twist(x):
        return np.sin(2.7 * x)

    x, wx = legendre.leggauss(60)
    u, wu = legendre.leggauss(40)
    y, wy = b * np.sin(math.pi / 2 * u), wu * b * math.pi / 2 * np.cos(math.pi / 2 * u)
    jump = y * np.sqrt(b**2 - y**2) * wy
    cosine, wc = legendre.leggauss(40)
    turn = np.arange(80) * 2 * math.pi / 80
    power = 0.0
    for c, w in zip(cosine, wc, strict=True):
        s = math.sqrt(1 - c**2)
        along = (twist(x) * wx * half) @ np.exp(-1j * k * c * half * x)
        across = np.exp(-1j * k * s * np.outer(np.cos(turn), y)) @ jump
        # p r = omega rho k sin t sin(turn)/(4 pi) int int jump exp(-i k.x)
        pressure = 2 * math.pi * frequency * DENSITY * k * s * np.sin(turn) / (4 * math.pi) * along * across
        power += w * np.mean(np.abs(pressure) ** 2) * 2 * math.pi / (2 * DENSITY * SPEED)
    found = flat(half, b, twist).resistance(np.array([frequency]))[0]
    assert found / 2 == pytest.approx(power, rel=3e-3)


def test_a_fast_bar_radiates_from_both_sides_as_plane_waves():
    half, b = 0.1, 0.05
    found = flat(half, b, lambda x: np.cos(1.2 * x)).resistance(np.array([40000.0]))[0]
    squared = WEIGHTS @ np.cos(1.2 * NODES) ** 2 * half * 2 * b**3 / 3
    assert found == pytest.approx(2 * DENSITY * SPEED * squared, rel=0.05)


def test_thickness_counts_at_low_frequencies_only_and_a_square_bar_has_no_quadrupole():
    bars = [flat(0.02, 0.01, np.sin, each) for each in (1e-9, 0.01, 0.02)]
    thin, thick, square = ([bar.resistance(np.array([each]))[0] for each in (300.0, 120000.0)] for bar in bars)
    assert thick[0] / thin[0] == pytest.approx(2.48**2, rel=0.01)
    # The narrow sides move too: by (h/w)^3 of what the wide ones do.
    assert thick[1] / thin[1] == pytest.approx(1 + 0.5**3, rel=0.06)
    assert square[0] < 1e-3 * thin[0]


def test_a_carved_bar_radiates_less_from_where_it_is_thin():
    def carved(thickness):
        return Twist((0.1, 0.02), NODES, WEIGHTS, np.ones((120, 1)), thickness).resistance(np.array([200.0]))[0]

    even, carve = np.full_like(NODES, 0.012), 0.012 * (0.3 + 0.7 * NODES**2)
    strengths = [np.interp(each / 0.04, THICKNESS, FLATNESS) for each in (even, carve)]
    mean = [WEIGHTS @ strength / 2 for strength in strengths]
    assert carved(carve) / carved(even) == pytest.approx((mean[1] / mean[0]) ** 2, rel=0.01)


def test_a_bar_that_stands_on_its_edge_is_one_that_lies():
    """Width and thickness exchanged turn the section by a right angle, which no listener around it hears."""
    lying, upright = (
        Twist((0.1, width / 2), NODES, WEIGHTS, np.sin(NODES)[:, None], np.full_like(NODES, thickness))
        for width, thickness in ((0.02, 0.012), (0.012, 0.02))
    )
    assert upright.resistance(np.array([150.0])) == pytest.approx(lying.resistance(np.array([150.0])), rel=5e-3)
    assert twist.strip(np.array([100.0])) == pytest.approx(4 / 3)
