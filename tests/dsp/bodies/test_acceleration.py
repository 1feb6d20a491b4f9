"""Clicks of bodies against exact solutions of the air around them."""

import itertools
import math

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.special import eval_jacobi, gammaln, h1vp, spherical_jn

from carom.dsp.bodies import acceleration, air, bar, disc, plate, ring
from carom.presets import Presets

RHO, C = air.DENSITY, air.SPEED
MATERIALS = Presets()


def response(click, frequency):
    """Return |p/A| of a body of 1 kg at frequencies (Hz): strength s/((s + decay)^2 + omega^2)."""
    s = 2j * np.pi * frequency
    return click.strength * np.abs(s / ((s + click.decay) ** 2 + (2 * np.pi * click.frequency) ** 2))


def heard(resistance, frequency):
    """Return |p/A| (Pa s^2/m) of a body whose radiation resistance (N s/m) at unit velocity is given."""
    return np.sqrt(RHO * C * resistance / (4 * np.pi)) / (2 * np.pi * frequency)


def gauss(low, high, n):
    x, w = leggauss(n)
    return low + (high - low) * (x + 1) / 2, w * (high - low) / 2


def decibels(click, frequency, exact):
    return 20 * np.log10(response(click, frequency) / exact)


def disc_resistance(K, terms):
    """Return the radiation resistance of a thin free disc of radius 1 that moves along its axis, over rho c: Galerkin's
    method on the pressure jump.

    The jump is sum c_n psi_n, psi_n = (sqrt(pi)/2) n!/Gamma(n + 3/2) sqrt(1 - r^2) P_n^(0,1/2)(1 - 2 r^2), whose Hankel
    transform is j_(2n+1)(x)/x; in the spectrum the velocity is sqrt(K^2 - x^2)/(rho c K) times half the jump.
    """
    n = np.arange(terms)[:, None]
    t, w = gauss(0, np.pi / 2, 2 * terms + 40)
    r = np.sin(t)
    norm = np.exp(gammaln(n + 1) - gammaln(n + 1.5)) * math.sqrt(math.pi) / 2
    b = (norm * np.cos(t) * eval_jacobi(n, 0, 0.5, 1 - 2 * r**2)) @ (r * np.cos(t) * w)
    matrix = np.diag(1j * np.pi / (2 * (4 * n[:, 0] + 3)))  # int_0^inf i x j j dx/x: the static part
    t, w = gauss(0, np.pi / 2, int(30 + K))
    x = K * np.sin(t)
    j = spherical_jn(2 * n + 1, x)
    matrix = matrix + (j * (K * np.cos(t) - 1j * x) * w * K * np.cos(t) / x) @ j.T
    reach = K + 2 * terms + 20
    y, w = gauss(0, math.sqrt(reach - K), int(40 + 1.2 * (reach - K)))
    x = K + y**2
    j = spherical_jn(2 * n + 1, x)
    matrix = matrix + (j * (1j * (np.sqrt(x**2 - K**2) - x) * w * 2 * y / x)) @ j.T
    return 4 * np.pi * np.real(b @ np.linalg.solve(matrix / K, b))


def test_a_sphere_is_that_of_koss_and_alfredson():
    radius, mass = 0.008, 0.0168
    click = acceleration.sphere(mass, radius)
    t = np.linspace(0, 2e-4, 200)
    b = C / radius
    exact = RHO * radius * C / (math.sqrt(3) * mass) * np.exp(-b * t) * (np.cos(b * t) - np.sin(b * t))
    omega = 2 * math.pi * click.frequency
    wave = np.cos(omega * t) - click.decay / omega * np.sin(omega * t)
    np.testing.assert_allclose(click.strength * np.exp(-click.decay * t) * wave, exact, rtol=1e-12, atol=1e-12)
    # The dipole around it, from its own equation: p = rho a A [a/(..)] h_1'(ka) ..., |x h_1'(x)|^2 = (4 + x^4)/x^4.
    x = np.geomspace(0.01, 30, 50)
    dipole = RHO * radius**2 / math.sqrt(3) * x / np.sqrt(4 + x**4)
    np.testing.assert_allclose(mass * response(click, x * C / radius / (2 * np.pi)), dipole, rtol=1e-12)


@pytest.mark.slow
def test_a_disc_is_the_exact_one_within_2_db():
    K = np.geomspace(0.03, 25, 50)
    exact = RHO * C * np.array([disc_resistance(k, 14 + int(k)) for k in K])
    frequency = K * C / (2 * np.pi)
    error = decibels(acceleration.disc(1.0, 1.0), frequency, heard(exact, frequency))
    assert np.abs(error).max() < 2.0 and np.sqrt((error**2).mean()) < 0.7
    # At low frequencies the dipole of the added mass 8/3 rho a^3, at high ones twice a piston.
    assert exact[0] == pytest.approx(RHO * C * (8 / 3) ** 2 * K[0] ** 4 / (12 * np.pi), rel=2e-3)
    assert np.abs(error[[0, -1]]).max() < 0.1
    equal = acceleration.sphere(1.0, (0.75 * 0.2) ** (1 / 3))  # a sphere of a coin's volume
    assert decibels(equal, frequency[:1], heard(exact, frequency)[:1]) < -6


def test_a_thick_disc_also_displaces_air():
    thin, thick = (acceleration.disc(1.0, 0.0116, h) for h in (0.0, 0.0023))
    ratio = response(thick, np.array([50.0])) / response(thin, np.array([50.0]))
    thicker = 1 + 0.45 * math.sqrt(0.0023 / 0.0232)
    assert ratio[0] == pytest.approx(thicker + math.pi * 0.0023 / (8 / 3 * 0.0116), rel=1e-3)


@pytest.mark.parametrize(
    ("sides", "added"),
    [((1, 1, 1), 0.68), ((1, 1, 2), 0.72), ((100, 1, 0.1), 89.5), ((100, 1, 0.5), 107), ((100, 1, 1), 119)],
)
def test_a_box_carries_the_air_that_is_known(sides, added):
    """Prisms of DNV-RP-C205, table D-2, and sections of table D-1 (1.14, 1.36 and 1.51 times pi/4 w^2)."""
    length, width, thickness = sides
    frequency, volume = np.array([0.1]), length * width * thickness
    click = acceleration.rectangle(1.0, length, width, volume)
    dipole = RHO * (added + volume) * 2 * math.pi * frequency / (4 * math.pi * math.sqrt(3) * C)
    assert np.abs(decibels(click, frequency, dipole)) < 0.25


def box_resistance(sides, k, cells=8):
    """Return the radiation resistance, over rho c, of a box that moves along its third side: monopoles on its surface,
    by collocation at the middles of rectangles, each seen as four points."""
    places, normals, halves = [], [], []
    steps = -0.5 * np.cos(np.linspace(0, np.pi, cells + 1))
    for axis, sign, i, j in itertools.product(range(3), (-1, 1), range(cells), range(cells)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        place, normal, half = np.zeros(3), np.zeros(3), np.zeros(3)
        place[[u, v, axis]] = (steps[i] + steps[i + 1]) / 2, (steps[j] + steps[j + 1]) / 2, sign / 2
        half[[u, v]] = (steps[i + 1] - steps[i]) / 2, (steps[j + 1] - steps[j]) / 2
        normal[axis] = sign
        places.append(place * sides), normals.append(normal), halves.append(half * sides)
    places, normals, halves = np.array(places), np.array(normals), np.array(halves)
    long, short = np.sort(halves, axis=1)[:, 2], np.sort(halves, axis=1)[:, 1]
    areas, leaving, above = 4 * long * short, 0.0, 0.0
    for signs in itertools.product((-1, 1), repeat=3):  # each point twice: one axis is normal
        away = places[:, None] - places - np.array(signs) / math.sqrt(3) * halves
        r = np.linalg.norm(away, axis=2)
        wave = areas / 8 * np.exp(1j * k * r) / (4 * np.pi * r)
        above = above + wave
        leaving = leaving + wave * (1j * k * r - 1) * (away * normals[:, None]).sum(axis=2) / r**2
    np.fill_diagonal(leaving, -0.5)
    own = (long * np.arcsinh(short / long) + short * np.arcsinh(long / short)) / np.pi
    np.fill_diagonal(above, own + 1j * k * areas / (4 * np.pi))
    pressure = k * (above @ np.linalg.solve(leaving, normals[:, 2] + 0j))
    return abs(np.sum(pressure * normals[:, 2] * areas).imag)


@pytest.mark.slow
@pytest.mark.parametrize(("sides", "error"), [((1, 1, 1), 0.8), ((2, 1, 1), 0.5), ((1, 1, 0.5), 0.8), ((1, 1, 2), 1.7)])
def test_a_box_is_that_of_boundary_elements(sides, error):
    """Frequencies go from sound much longer than the box to half its length."""
    length, width, thickness = sides
    k = np.geomspace(0.3, 4.0, 6) / math.sqrt(length * width)
    exact = RHO * C * np.array([box_resistance(sides, each) for each in k])
    click = acceleration.rectangle(1.0, length, width, length * width * thickness)
    assert np.abs(decibels(click, k * C / (2 * np.pi), heard(exact, k * C / (2 * np.pi)))).max() < error


@pytest.mark.slow
@pytest.mark.parametrize(("slenderness", "error"), [(2, 1), (5, 1), (10, 1), (20, 2.5), (40, 5)])
def test_a_rod_is_a_cylinder(slenderness, error):
    """Every part of a long cylinder radiates as cos theta of an infinite one."""
    length = 2.0 * slenderness
    k = np.geomspace(0.3 / length, 12, 40)
    exact = []
    for each in k:
        t, w = gauss(0, np.pi, int(30 + each * length))
        axial, radial = each * np.cos(t), each * np.sin(t)
        spectrum = length * np.sinc(axial * length / (2 * np.pi))
        exact.append(np.sum(w * spectrum**2 / (np.sin(t) * np.abs(h1vp(1, radial)) ** 2)) / np.pi)
    frequency = k * C / (2 * np.pi)
    click = acceleration.cylinder(1.0, length, 2.0)
    assert np.abs(decibels(click, frequency, heard(RHO * C * np.array(exact), frequency))).max() < error


@pytest.mark.parametrize(("ratio", "coefficient"), [(1, 0.579), (1.59, 0.704), (2, 0.757), (3.17, 0.840), (5, 0.897)])
def test_a_plate_carries_the_air_that_is_known(ratio, coefficient):
    """Added masses of thin rectangles, c pi/4 rho w^2 l (Meyerhoff 1970), and the dipole that they make."""
    frequency = np.array([1.0])
    click = acceleration.rectangle(1.0, ratio, 1.0, 0.0)
    dipole = RHO * coefficient * math.pi / 4 * ratio * 2 * math.pi * frequency / (4 * math.pi * math.sqrt(3) * C)
    assert np.abs(decibels(click, frequency, dipole)) < 0.1


def test_a_square_plate_is_about_a_disc():
    frequency = np.geomspace(30, 3000, 20)
    square = acceleration.rectangle(1.0, math.sqrt(math.pi), math.sqrt(math.pi), 0.0)
    assert np.abs(decibels(square, frequency, response(acceleration.disc(1.0, 1.0), frequency))).max() < 0.8


@pytest.mark.slow
def test_free_bodies_click_and_held_ones_do_not():
    steel = MATERIALS.material("steel")
    box = {"length": 0.3, "width": 0.2, "thickness": 0.01}
    assert plate(steel, **box, top=5000).clicks == (acceleration.rectangle(0.3 * 0.2 * 78.5, 0.3, 0.2, 6e-4),)
    assert plate(steel, **box, top=5000, edges=("free", "free", "clamped", "free")).clicks == ()
    made = disc(steel, radius=0.1, thickness=0.01, top=5000)
    assert made.clicks == (acceleration.disc(made.mass, 0.1, 0.01),)
    assert disc(steel, radius=0.1, thickness=0.01, top=5000, edge="clamped").clicks == ()
    rod = bar(steel, length=0.2, diameter=0.01, top=20_000)
    assert rod.clicks == (acceleration.cylinder(rod.mass, 0.2, 0.01),)
    assert bar(steel, length=0.2, diameter=0.01, top=20_000, ends="cantilever").clicks == ()
    carved = bar(steel, length=0.2, width=0.03, thickness=0.01, undercut=0.5, top=20_000)
    assert carved.clicks == (acceleration.rectangle(carved.mass, 0.2, 0.03, carved.mass / 7850),)
    hoop = ring(steel, radius=0.1, thickness=0.002, length=0.02, top=5000)
    assert hoop.clicks == (acceleration.ring(hoop.mass, 0.1, 0.02, hoop.mass / 7850),)
