"""Compliance of modes that are felt and not heard: against static deflections in closed form, and sums over modes."""

import math

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies.shearing import rectangles_shear
from carom.dsp.bodies.string import _Sines
from carom.dsp.bodies.unheard import Felt, completed, with_unheard
from carom.presets import Presets

STEEL = Presets().material("steel")
TOP = 8_000.0


def flexibility(felt, power=2):
    """Return sum phi^2/omega^power along the path."""
    return (felt.strike**2 / (2 * np.pi * felt.frequency) ** power).sum(axis=1)


def at(values, position):
    return np.interp(position, np.linspace(0, 1, len(values)), values)


def rigidity(thickness):
    return STEEL.contact_modulus * thickness**3 / 12


def cantilever():
    length, width, thickness = 0.12, 0.008, 0.004  # so narrow that it bends as a bar does
    modes = bodies.bar(
        STEEL, length=length, width=width, thickness=thickness, ends="cantilever", top=TOP, across=0.0, tilt=0.0
    )
    coefficient = float(rectangles_shear(STEEL, np.array([width / thickness]))[0])
    shear = length / (coefficient * STEEL.shear_modulus * width * thickness)
    return modes, 1.0, length**3 / (3 * STEEL.youngs_modulus * width * thickness**3 / 12) + shear


def clamped_disc():
    radius, thickness = 0.15, 0.003
    modes = bodies.disc(STEEL, radius=radius, thickness=thickness, edge="clamped", top=TOP)
    return modes, 0.5, radius**2 / (16 * math.pi * rigidity(thickness))


def supported_disc():
    radius, thickness, nu = 0.15, 0.003, STEEL.poisson_ratio
    modes = bodies.disc(STEEL, radius=radius, thickness=thickness, edge="supported", top=TOP)
    return modes, 0.5, (3 + nu) / (1 + nu) * radius**2 / (16 * math.pi * rigidity(thickness))


def supported_plate():
    length, width, thickness = 0.5, 0.4, 0.003
    edges = ("supported",) * 4
    modes = bodies.plate(STEEL, length=length, width=width, thickness=thickness, edges=edges, top=TOP)
    # By Levy's series, one sum of Navier's two being in closed form (Timoshenko and Woinowsky-Krieger, art. 34).
    m = np.arange(1, 2001, 2)
    alpha = m * np.pi * width / (2 * length)
    within = np.tanh(alpha) - alpha / np.cosh(np.minimum(alpha, 300.0)) ** 2
    return modes, 0.5, length**2 / (2 * math.pi**3 * rigidity(thickness)) * (within / m**3).sum()


def string():
    length, diameter, tension = 0.6, 0.001, 700.0
    modes = bodies.string(STEEL, length=length, diameter=diameter, tension=tension, top=TOP)
    density, stiffness = STEEL.density * math.pi * diameter**2 / 4, STEEL.youngs_modulus * math.pi * diameter**4 / 64
    # A stiff string under tension, pinned: each half bends by T w - E I w'' = x F/2.
    wave = math.sqrt(tension / stiffness) * length / 2
    assert modes.mass == pytest.approx(density * length)
    return modes, 0.5, length / (4 * tension) * (1 - math.tanh(wave) / wave)


@pytest.mark.parametrize(
    ("made", "tolerance"),
    [(cantilever, 0.04), (clamped_disc, 0.1), (supported_disc, 0.1), (supported_plate, 0.04), (string, 0.04)],
)
def test_heard_and_unheard_modes_yield_together_as_the_body_does(made, tolerance):
    modes, position, whole = made()
    heard, unheard = (at(flexibility(each), position) for each in (modes, modes.unheard))
    assert unheard == pytest.approx(whole - heard, rel=tolerance)
    assert whole - heard > 1e-4 * whole


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["tin-lid", "steel-plate", "wood-board", "wine-glass", "piano-string", "glockenspiel-bar", "steel-ring"]
)
def test_a_body_yields_as_far_whatever_it_is_made_up_to(name):
    preset = Presets().object(name)
    parts = []
    for top in (20_000.0, 60_000.0):
        modes = preset.modes(top)
        low = modes.frequency <= 20_000.0
        cut = (modes.strike[:, ~low] ** 2 / (2 * np.pi * modes.frequency[~low]) ** 2).sum(axis=1)
        parts.append(at(cut + flexibility(modes.unheard), preset.position))
    assert parts[0] == pytest.approx(parts[1], rel=0.06)


def test_gathered_modes_keep_both_sums_and_all_are_positive():
    random = np.random.default_rng(0)
    frequency, strike = np.sort(random.uniform(8_100.0, 18_000.0, 400)), random.normal(size=(5, 400))
    heard = bodies.listed(frequency=np.linspace(100, TOP, 60), t60=1.0, modal_mass=1.0, mass=1.0, top=TOP)
    felt = with_unheard(heard, Felt(frequency, strike), STEEL.decay, TOP).unheard
    assert felt.frequency.size < 60 and np.all(np.diff(felt.frequency) > 0)
    for power in (2, 4):
        np.testing.assert_allclose(flexibility(felt, power), flexibility(Felt(frequency, strike), power), rtol=1e-12)
    np.testing.assert_array_equal(felt.strike[:, :30], strike[:, :30])  # the lowest are as they were


def test_squares_of_sines_sum_as_those_of_a_table():
    """Orders go beyond the places' own period, as those of many modes do."""
    order, places = np.arange(20.0, 300.0), 121
    sines = _Sines(100.0 * order, order, places, 1.7)
    table = Felt(sines.frequency, 1.7 * np.sin(np.pi * np.outer(np.linspace(0, 1, places), order)))
    which = np.arange(5, order.size)
    u = 1 / (2 * np.pi * sines.frequency[which]) ** 2
    summed, expected = (each.squares(which, u, np.geomspace(u[0], u[-1] / 2, 8)) for each in (sines, table))
    np.testing.assert_allclose(summed, expected, rtol=1e-10, atol=1e-12 * expected.max())
    np.testing.assert_allclose(sines.shapes(which), table.shapes(which), atol=1e-12)


@pytest.mark.slow
def test_the_bands_of_a_tail_sum_to_the_integral():
    """Modes are of equal size, with a density that is even, or falls as the root of the frequency."""
    for growth in (0.0, -0.5):
        count = np.arange(1.0, 4_000.0)
        frequency = 10.0 * count ** (1 / (growth + 1))
        felt = Felt(frequency, np.ones((1, frequency.size)))
        last = float(frequency[799])
        heard, others = (Felt(frequency[part], felt.strike[:, part]) for part in (slice(400), slice(400, 800)))
        tail = completed(heard, others, last, 3 * last, growth)
        exact = 1 / (2 * np.pi * 10.0 * np.arange(401.0, 4e6) ** (1 / (growth + 1))) ** 2
        assert flexibility(tail)[0] == pytest.approx(exact.sum(), rel=5e-3)


def test_a_body_of_few_modes_keeps_all_that_are_known():
    heard = bodies.listed(frequency=[100.0, 200.0], t60=1.0, modal_mass=1.0, mass=1.0, top=TOP)
    felt = with_unheard(heard, Felt(np.array([9e3, 2e4]), np.ones((1, 2))), STEEL.decay, TOP).unheard
    np.testing.assert_array_equal(felt.frequency, [9e3, 2e4])
    assert with_unheard(heard, Felt(np.empty(0), np.empty((1, 0))), STEEL.decay, TOP) is heard
