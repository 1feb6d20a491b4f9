"""Radiation of a thin body from about the point that is struck."""

import math

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.integrate import trapezoid
from scipy.special import eval_jacobi, gammaln, hankel1, kv, spherical_jn

from carom.dsp import bodies
from carom.dsp.bodies import acceleration
from carom.dsp.bodies.air import DENSITY, SPEED
from carom.dsp.bodies.near import critical_frequency, near_field, round_field
from carom.dsp.bodies.radiation.quadrature import segment
from carom.presets import Presets

AREAL, RIGIDITY = 9.0, 13.0  # kg/m^2, N m: about a cymbal's
FLAT = DENSITY / (2 * math.pi * AREAL)  # Pa/N


def response(clicks, frequency, position=0.0):
    """Return |p/F| (Pa/N) at frequencies (Hz), struck at a position."""
    s = 2j * math.pi * np.asarray(frequency)
    shares = [np.interp(position, np.linspace(0, 1, len(c.along)), c.along) if len(c.along) > 1 else 1 for c in clicks]
    each = [c.strength * s / ((s + c.decay) ** 2 + (2 * math.pi * c.frequency) ** 2) for c in clicks]
    return np.abs(sum(share * one for share, one in zip(shares, each, strict=True)))


def edge_of(order, n, r):
    """Return what of a unit flow at a radius r the function has whose Hankel transform is j_(m + 2 n + 1)(s)/s."""
    scale = math.exp(gammaln(n + 1) - gammaln(n + 1.5)) * math.sqrt(math.pi) / 2
    return scale * r**order * math.sqrt(1 - r * r) * eval_jacobi(n, order, 0.5, 1 - 2 * r * r)


def diffracted(x, r):
    """Return how much a source on one face of a rigid disc of radius 1, and a sink on the other, at a radius r, radiate
    at k = x, rms over directions, over the same in front of a wall: by Galerkin's method, as the disc's impedances."""
    nodes, weights = leggauss(24)
    cosine, total = 0.5 * (nodes + 1), 0.0
    s = x * np.sqrt(1 - cosine**2)
    for order in range(int(x + 6 + 2 * x**0.4) + 1):
        degree = order + 2 * np.arange(max(6, int((x - order) / 2) + 8)) + 1
        t, w = segment(0, math.pi / 2, 16 + 0.6 * x)
        span = degree[-1] + 12.0
        y, wy = segment(0, math.sqrt(span), 16 + 0.6 * span)
        low, high = x * np.sin(t), x + y**2
        still = np.append(-x * np.cos(t) * w, -(x**2) / (np.sqrt(high**2 - x**2) + high) / high * 2 * y * wy)
        j = np.array([spherical_jn(each, np.append(low, high)) for each in degree])
        matrix = 1j * (j * still) @ j.T + (j[:, : t.size] * (x * np.cos(t)) ** 2 * w / low) @ j[:, : t.size].T
        matrix += np.diag(1j * math.pi / (2 * (2 * degree + 1)))
        flow = [(2 if order else 1) / (2 * math.pi) * edge_of(order, n, r) for n in range(degree.size)]
        far = np.array([spherical_jn(each, s) / s for each in degree])
        pressure = 2 * math.pi * x * cosine * np.abs(np.linalg.solve(matrix, np.array(flow) + 0j) @ far)
        total += 0.5 * weights @ pressure**2 * (0.5 if order else 1.0)
    return math.sqrt(total)


def decibels(ratio):
    return 20 * np.log10(ratio)


@pytest.mark.slow
@pytest.mark.parametrize("frequency", [200.0, 1000.0, 5000.0])
def test_an_endless_plate_radiates_by_its_mass_alone(frequency):
    """Rayleigh's integral, straight ahead, over the velocity about a force of 1 N; the plate loses a little."""
    omega, rigidity = 2 * math.pi * frequency, RIGIDITY * (1 - 0.05j)
    k = (AREAL * omega**2 / rigidity) ** 0.25
    r = np.linspace(1e-6, 600 / abs(k), 400_000)
    velocity = omega / (8 * rigidity * k**2) * (hankel1(0, k * r) + 2j / math.pi * kv(0, k * r))
    flow = trapezoid(velocity * 2 * math.pi * r, r)
    assert DENSITY * omega / (2 * math.pi) * abs(flow) == pytest.approx(FLAT, rel=0.01)


def test_the_band_is_flat_from_the_bodys_size_to_the_critical_frequency():
    radius, critical = 0.2, critical_frequency(AREAL, RIGIDITY)
    assert critical == pytest.approx(SPEED**2 / (2 * math.pi) * math.sqrt(AREAL / RIGIDITY))
    whole = acceleration.disc(AREAL * math.pi * radius**2, radius)
    clicks = near_field(AREAL, whole, critical)
    inside = np.geomspace(2.5 * SPEED / radius / math.pi, 0.6 * critical, 50)
    assert np.abs(decibels(response(clicks, inside) / FLAT)).max() < 2
    low = np.array([5.0, 20.0])  # the dipole of a disc that moves as a whole
    assert decibels(response(clicks, low) / response([whole], low)) == pytest.approx([0, 0], abs=0.1)
    assert response(clicks, 8 * critical) < 0.2 * FLAT


@pytest.mark.slow
@pytest.mark.parametrize("radius", [0.08, 0.203])
@pytest.mark.parametrize("place", [0.0, 0.5, 0.8, 0.94, 0.97])
def test_an_edge_lets_sound_round_as_it_does_about_a_rigid_disc(radius, place):
    """Within 3 dB in each octave, at five places from the centre to near the edge."""
    critical = critical_frequency(AREAL, RIGIDITY)
    clicks = round_field(AREAL, radius, acceleration.disc(AREAL * math.pi * radius**2, radius), critical)
    octaves = [each for each in 125.0 * 2.0 ** np.arange(7) if each < 0.5 * critical]
    for octave in octaves:
        inside = octave * 2.0 ** np.linspace(-0.5, 0.5, 7)
        exact = [diffracted(2 * math.pi * each * radius / SPEED, place) for each in inside]
        found = response(clicks, inside, 0.5 + 0.5 * place) / FLAT
        assert abs(decibels(np.sqrt(np.mean(found**2) / np.mean(np.square(exact))))) < 3.0, octave
    assert response(clicks, [250.0], 0.5 + 0.5 * 0.97) < 0.3 * response(clicks, [250.0], 0.5)


def test_a_rigid_discs_edge_diffracts_as_flow_and_as_a_straight_one_do():
    """At low frequencies a disc's dipole moment goes with sqrt(1 - r^2); at high ones it is a wall, but by its edge."""
    for r in (0.0, 0.6, 0.9):
        dipole = 2 * 0.1 / (math.pi * math.sqrt(3)) * math.sqrt(1 - r * r)
        assert diffracted(0.1, r) == pytest.approx(dipole, rel=0.01)
    assert diffracted(16.0, 0.3) == pytest.approx(1.0, rel=0.02)
    for x, r in ((12.0, 0.97), (8.0, 0.95), (16.0, 0.97)):
        assert abs(decibels(diffracted(x, r) / math.sqrt(math.tanh(x * (1 - r))))) < 0.5


def test_a_stiff_or_small_plate_is_heard_as_a_whole():
    whole = acceleration.disc(0.1, 0.03, 0.01)
    assert near_field(78.0, whole, 1200.0) == (whole,)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cymbal", "tom", "polycarbonate-sheet"])
def test_thin_presets_have_it(name):
    preset = Presets().object(name)
    areal = preset.material.density * preset.geometry["thickness"]
    for top in (5_000, 20_000):
        found = response(preset.modes(top).clicks, [2_000.0], 0.6)
        assert decibels(found * 2 * math.pi * areal / DENSITY) == pytest.approx([0], abs=3)


def test_a_head_in_a_wall_has_none():
    film = Presets().material("mylar")
    given = {"radius": 0.165, "thickness": 0.00025, "fundamental": 103.0, "top": 400}
    assert bodies.membrane(film, **given).clicks and not bodies.membrane(film, baffle="wall", **given).clicks


@pytest.mark.parametrize("radius", [0.035, 0.2])
def test_a_wall_that_bends_round_a_cup_radiates_about_the_blow_as_a_plate_does(radius):
    """The wall does so where sound is shorter than its radius, also that of a cup that is held; its band is narrow, and
    errs to the quiet side."""
    plastic = Presets().material("plastic")
    cup = bodies.glass(plastic, radius=radius, height=0.09, thickness=0.0015, top=20_000)
    flat = DENSITY / (2 * math.pi * plastic.density * 0.0015)
    middle = np.geomspace(2 * SPEED / (2 * math.pi * radius), 15_000, 20)
    level = decibels(response(cup.clicks, middle) / flat)
    assert -7.0 < level.max() < 1.0
    low = 0.1 * SPEED / (2 * math.pi * radius)
    assert decibels(response(cup.clicks, [low])[0] / flat) < -12.0
