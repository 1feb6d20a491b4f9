"""Solid spheres against Ritz's method in powers of x, y and z, and against their equations in 30 digits."""

import math
import time
from itertools import product

import mpmath
import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.special import spherical_jn

from carom.dsp.bodies import Material, sphere
from carom.dsp.bodies.air import IMPEDANCE, SPEED
from carom.dsp.bodies.modes import MOST_MODES

GLASS = Material("glass", 2600.0, 62e9, 0.2, alpha=1.0, beta=0.0)
RADIUS = 0.15


def ball_integral(powers: tuple[int, ...]) -> float:
    """Return the integral of x^a y^b z^c over the unit ball."""
    if any(power % 2 for power in powers):
        return 0.0

    def odd(n: int) -> int:
        return math.prod(range(n, 0, -2))

    return 4 * math.pi * math.prod(odd(p - 1) for p in powers) / odd(sum(powers) + 1) / (sum(powers) + 3)


def ritz(nu: float, order: int = 7):
    """Return the free vibrations of the unit ball, rho = G = 1: omega, and the radial motion at a pole of shapes of
    unit mass (W. M. Visscher and others, J. Acoust. Soc. Am. 90, 1991)."""
    lam = 2 * nu / (1 - 2 * nu)
    stiff = np.zeros((3, 3, 3, 3))
    for i, j, k, m in product(range(3), repeat=4):
        stiff[i, j, k, m] = lam * (i == j) * (k == m) + (i == k) * (j == m) + (i == m) * (j == k)
    powers = [p for p in product(range(order + 1), repeat=3) if sum(p) <= order]
    count = len(powers)
    mass = np.array([[ball_integral(tuple(np.add(p, q))) for q in powers] for p in powers])
    slope = np.zeros((3, 3, count, count))
    for (n, p), (m, q) in product(enumerate(powers), repeat=2):
        for j, k in product(range(3), repeat=2):
            if p[j] and q[k]:
                whole = list(np.add(p, q))
                whole[j] -= 1
                whole[k] -= 1
                slope[j, k, n, m] = p[j] * q[k] * ball_integral(tuple(whole))
    energy = np.einsum("ijkl,jlnm->inkm", stiff, slope).reshape(3 * count, 3 * count)
    square, vectors = eigh(energy, np.kron(np.eye(3), mass))
    at_pole = np.array([p[0] == p[1] == 0 for p in powers], float)
    return np.sqrt(np.maximum(square, 0)), at_pole @ vectors[2 * count :]


@pytest.mark.slow
def test_frequencies_and_motion_where_it_is_struck_are_ritzs():
    top = 22_000.0
    made = sphere(GLASS, radius=RADIUS, top=top)
    unit = math.sqrt(GLASS.shear_modulus / GLASS.density) / (2 * math.pi * RADIUS)
    omega, pole = ritz(GLASS.poisson_ratio)
    for frequency, phi in zip(made.frequency[:6], made.strike[0, :6], strict=True):
        same = np.abs(omega - frequency / unit) < 2e-3 * frequency / unit
        assert same.any(), frequency
        # Of the 2 n + 1 modes of a frequency a blow at the pole moves one, whose motion there is all of theirs.
        expected = np.sqrt((pole[same] ** 2).sum() / (GLASS.density * RADIUS**3))
        assert abs(phi) == pytest.approx(expected, rel=2e-3)


def surface(n, ratio, y, bessel=spherical_jn):
    """Return the stresses at the surface of the waves of pressure and of shear: T11, T13, T41 and T43."""
    x = ratio * y
    j, above, s, s_above = bessel(n, x), bessel(n + 1, x), bessel(n, y), bessel(n + 1, y)
    t11, t13 = (n * n - n - y * y / 2) * j + 2 * x * above, n * (n + 1) * ((n - 1) * s - y * s_above)
    return t11, t13, (n - 1) * j - x * above, (n * n - 1 - y * y / 2) * s + y * s_above


def determinant(n, ratio, y, bessel=spherical_jn):
    t11, t13, t41, t43 = surface(n, ratio, y, bessel)
    return t11 * t43 - t13 * t41 if n else t11


def exact_bessel(n, z):
    return mpmath.sqrt(mpmath.pi / (2 * z)) * mpmath.besselj(n + mpmath.mpf(1) / 2, z)


def made_of(nu, top=1e6):
    """Return a sphere whose frequencies are y: waves of shear go at 1 m/s around a circumference of 1 m."""
    material = Material("nu", 1000.0, 2.0 * (1 + nu) * 1e3, nu, alpha=1.0, beta=0.0)
    return sphere(material, radius=0.5 / math.pi, top=top), math.sqrt((1 - 2 * nu) / (2 - 2 * nu))


@pytest.mark.slow
@pytest.mark.parametrize("nu", [0.0, 0.225, 0.4999])
def test_frequencies_are_those_of_the_equation_in_30_digits(nu):
    made, ratio = made_of(nu)
    with mpmath.workdps(30):
        for place, orders in ((0, range(3)), (5, range(6)), (MOST_MODES - 1, range(110))):
            y = mpmath.mpf(made.frequency[place])
            low, high = ([determinant(n, ratio, y * (1 + e), exact_bessel) for n in orders] for e in (-1e-13, 1e-13))
            assert any(a * b < 0 for a, b in zip(low, high, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("nu", [0.0, 0.225, 0.49])
def test_the_motion_at_the_pole_is_that_of_a_quadrature_along_the_radius(nu):
    made, ratio = made_of(nu)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    r = np.append(0.5 * (nodes + 1), 1.0)
    for place in (0, 1, 2, 3, 50, 100, 400):
        y = made.frequency[place]
        n = int(
            np.argmax(
                [determinant(n, ratio, y * (1 - 1e-9)) * determinant(n, ratio, y * (1 + 1e-9)) < 0 for n in range(80)]
            )
        )
        t11, t13, t41, t43 = surface(n, ratio, y)
        share = 0.0 if n == 0 else -t11 / t13 if abs(t13) > abs(t43) else -t41 / t43
        x, z = ratio * y * r, y * r
        j, above, s, s_above = (spherical_jn(m, each) for each in (x, z) for m in (n, n + 1))
        radial, along = (n * j - x * above + share * n * (n + 1) * s) / r, (j + share * ((n + 1) * s - z * s_above)) / r
        square = (radial**2 + n * (n + 1) * along**2)[:-1] @ (0.5 * weights * r[:-1] ** 2)
        expected = radial[-1] / math.sqrt(3 * square / (2 * n + 1) * made.mass)
        assert abs(made.strike[0, place]) == pytest.approx(abs(expected), rel=1e-9)


@pytest.mark.parametrize("material", [GLASS, Material("rubber", 1100.0, 2e6, 0.4999, alpha=1.0, beta=1e-5)])
def test_the_largest_sphere_takes_a_tenth_of_a_second(material):
    sphere(material, radius=0.1, top=20_000.0)  # scipy is loaded
    begun = time.process_time()
    assert sphere(material, radius=20.0, top=96_000.0).frequency.size == MOST_MODES
    assert time.process_time() - begun < 0.5  # 0.08 s on an idle machine


@pytest.mark.slow
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.4999])
def test_no_mode_is_missed_however_close_two_are(nu):
    made, ratio = made_of(nu, top=25.0)
    y = np.arange(0.5, 25.0, 0.01)
    found = [determinant(n, ratio, y) for n in range(30)]
    assert made.frequency.size == sum(np.count_nonzero(each[1:] * each[:-1] < 0) for each in found) > 75


def test_every_mode_is_found_and_grows_with_the_size():
    small, large = sphere(GLASS, radius=RADIUS, top=20_000.0), sphere(GLASS, radius=2 * RADIUS, top=10_000.0)
    assert small.frequency.size == large.frequency.size > 4
    np.testing.assert_allclose(small.frequency, 2 * large.frequency, rtol=1e-9)


@pytest.mark.slow
def test_a_breathing_ball_radiates_as_a_pulsating_sphere():
    soft = Material("soft", 1000.0, 1e8, 0.3, alpha=1.0, beta=0.0)
    made = sphere(soft, radius=0.1, top=8_000.0)
    x = 2 * math.pi * made.frequency * 0.1 / SPEED
    pulsating = IMPEDANCE * 4 * math.pi * 0.1**2 * x**2 / (1 + x**2) * made.strike[0] ** 2
    resistance = 4 * math.pi * made.pressure[0] ** 2 / IMPEDANCE
    assert np.min(np.abs(resistance / pulsating - 1)) < 1e-9  # one of them breathes


def test_a_small_ball_has_no_mode_but_a_click():
    made = sphere(GLASS, radius=0.008, top=20_000.0)
    assert made.frequency.size == 0 and made.strike.shape == (1, 0) and len(made.clicks) == 1
    assert made.mass == pytest.approx(GLASS.density * 4 / 3 * math.pi * 0.008**3)


def test_a_radius_that_cannot_be_is_named():
    with pytest.raises(ValueError, match="radius = -1"):
        sphere(GLASS, radius=-1.0, top=20_000.0)
