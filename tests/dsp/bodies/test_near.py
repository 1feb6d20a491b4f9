"""Radiation of a thin body from about the point that is struck."""

import math

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.special import hankel1, kv

from carom.dsp import bodies
from carom.dsp.bodies import acceleration
from carom.dsp.bodies.air import DENSITY, SPEED
from carom.dsp.bodies.near import critical_frequency, near_field
from carom.presets import Presets

AREAL, RIGIDITY = 9.0, 13.0  # kg/m^2, N m: about a cymbal's
FLAT = DENSITY / (2 * math.pi * AREAL)  # Pa/N


def response(clicks, frequency):
    """Return |p/F| (Pa/N) at frequencies (Hz)."""
    s = 2j * math.pi * np.asarray(frequency)
    each = [c.strength * s / ((s + c.decay) ** 2 + (2 * math.pi * c.frequency) ** 2) for c in clicks]
    return np.abs(sum(each))


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


def test_a_stiff_or_small_plate_is_heard_as_a_whole():
    whole = acceleration.disc(0.1, 0.03, 0.01)
    assert near_field(78.0, whole, 1200.0) == (whole,)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cymbal", "tom", "polycarbonate-sheet"])
def test_thin_presets_have_it(name):
    preset = Presets().object(name)
    areal = preset.material.density * preset.geometry["thickness"]
    for top in (5_000, 20_000):
        found = response(preset.modes(top).clicks, [2_000.0])
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
