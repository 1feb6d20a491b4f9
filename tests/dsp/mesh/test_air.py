"""Radiated power against closed forms: a sphere, a disc, dipoles inside of bars, a plate; a bowl by two routes."""

import itertools

import numpy as np
import pytest
from scipy.special import eval_legendre, spherical_jn, spherical_yn

from carom.dsp.bodies.air import DENSITY, IMPEDANCE, SPEED
from carom.dsp.bodies.material import Material
from carom.dsp.bodies.plate import plate
from carom.dsp.mesh import forms, shells
from carom.dsp.mesh.air import layer_of, radiation, velocities
from carom.dsp.mesh.surface import Surface

STEEL = Material("steel", 7850.0, 200e9, 0.29, 1.0, 0.0)


def decibels(a, b):
    return 10 * np.log10(a / b)


def hankel(n, z, derivative=False):
    return spherical_jn(n, z, derivative) + 1j * spherical_yn(n, z, derivative)


@pytest.mark.slow
def test_a_spheres_modes_radiate_as_they_do_at_resonances_of_the_inside_too():
    radius = 0.1
    layer, _ = layer_of(forms.ball(radius, 4), "solid", 300)
    cosine = layer.places[:, 2] / np.linalg.norm(layer.places, axis=1)
    tried = np.array([*itertools.product((0.1, 1.0, 3.14159, 4.4934, 10.0, 20.0), range(5))])
    z = np.array([(1j * hankel(int(order), ka) / hankel(int(order), ka, True)).real for ka, order in tried])
    ka, order = tried[z > 1e-4].T
    known = IMPEDANCE * z[z > 1e-4] * 4 * np.pi * radius**2 / (2 * order + 1)
    motion = eval_legendre(order, cosine[:, None])
    found = radiation(layer, motion, ka * SPEED / (2 * np.pi * radius)).resistance
    assert np.abs(decibels(found, known)).max() < 0.6


def test_a_mode_radiates_alike_beside_one_that_is_too_high_to_be_solved_for():
    """Modes are solved for in groups, whose middle may lie above 2.5 points a wavelength, and the lowest below."""
    layer, _ = layer_of(forms.ball(0.1, 3), "solid", 100)
    limit = SPEED / (2.5 * np.sqrt(np.median(layer.areas)))
    motion = np.stack([layer.normals[:, 2], layer.normals[:, 0]], axis=1)
    alone = radiation(layer, motion[:, :1], np.array([0.985 * limit])).resistance
    pair = radiation(layer, motion, np.array([0.985, 1.03]) * limit).resistance
    assert pair[0] == pytest.approx(alone[0], rel=0.01)


def test_a_disc_moves_its_air():
    """A thin disc that moves along its axis: a mass of 8/3 rho a^3, and the power of the dipole that this is."""
    radius = 0.1
    disc = forms.lathe(np.c_[np.linspace(0, radius, 12), np.zeros(12)], 48, closed=False)
    layer, _ = layer_of(disc, "sheet", 250)
    frequency = 0.1 * SPEED / (2 * np.pi * radius)
    found = radiation(layer, layer.normals[:, 2:], np.array([frequency]))
    mass = 8 / 3 * DENSITY * radius**3
    known = (2 * np.pi * frequency) ** 4 * mass**2 / (12 * np.pi * DENSITY * SPEED**3)
    assert found.mass[0] == pytest.approx(mass, rel=0.04)
    assert abs(decibels(found.resistance[0], known)) < 0.4


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sheet", "solid"])
def test_a_plate_radiates_as_caroms_own_plate_does(kind):
    """The plate is below its critical frequency, where all sound comes from the rim."""
    size, steps = (0.3, 0.2, 0.002), (36, 24)
    own = plate(STEEL, length=size[0], width=size[1], thickness=size[2], top=2000.0)
    known = 2 * (own.decay - STEEL.decay(own.frequency))
    middle = sheet(size[:2], steps)
    modes = shells.solve(middle, size[2], STEEL, 6 + len(known))
    layer, places = layer_of(middle if kind == "sheet" else forms.box(*size), kind, 400)
    motion = velocities(layer, modes.at(places)[:, :, 6:])
    found = radiation(layer, motion, modes.frequency[6:]).resistance
    apart = decibels(found, known)[known * own.mass > 2e-4 * IMPEDANCE * 2 * size[0] * size[1]]
    assert len(apart) > 15
    assert np.abs(apart).max() < 1.4
    assert np.sqrt((apart**2).mean()) < 0.7


def test_a_body_radiates_alike_wherever_it_lies():
    """Distances follow from products, and phases have seven digits: those of places 100 km off would have none left."""
    disc = forms.lathe(np.c_[np.linspace(0, 0.1, 12), np.zeros(12)], 48, closed=False)
    frequency = np.array([800.0, 5000.0])
    found = []
    for offset in (0.0, 1e5):
        layer, _ = layer_of(Surface(disc.points + offset, disc.faces), "sheet", 100)
        motion = layer.normals[:, 2:] * np.ones(2)
        found.append(radiation(layer, motion, frequency).resistance)
    assert np.abs(decibels(*found)).max() < 0.01


def sheet(sides, steps):
    """Return an open rectangle of triangles about the origin."""
    x, y = np.meshgrid(*(np.linspace(-a / 2, a / 2, n + 1) for a, n in zip(sides, steps, strict=True)), indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Surface(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), faces)


@pytest.mark.slow
def test_a_bowl_radiates_as_much_by_both_routes():
    """The bowl is a solid of two skins that become one layer, and the sheet in its middle."""
    angle = np.radians(np.linspace(0, 90, 40))
    arc = np.c_[np.sin(angle), -np.cos(angle)]
    ways = {
        "solid": forms.lathe(np.vstack([0.08 * arc, 0.076 * arc[::-1]]), 96),
        "sheet": forms.lathe(0.078 * arc, 96, closed=False),
    }
    frequency = np.array([650.0, 1700.0, 3100.0, 4700.0, 9000.0])
    found = []
    for kind, surface in ways.items():
        layer, places = layer_of(surface, kind, 300)
        along = places / np.linalg.norm(places, axis=1)[:, None]
        across, around = np.hypot(along[:, 0], along[:, 1]), np.arctan2(along[:, 1], along[:, 0])
        shapes = np.stack([along * (across**n * np.cos(n * around))[:, None] for n in range(2, 7)], axis=2)
        found.append(radiation(layer, velocities(layer, shapes), frequency).resistance)
    assert np.abs(decibels(*found)).max() < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("size", [(0.24, 0.03, 0.01), (0.24, 0.03, 0.004), (0.24, 0.01, 0.004)])
def test_dipoles_inside_of_a_bar_have_the_power_that_they_have(size):
    """The motion of a bar's surface by a sheet of dipoles inside of it, whose far field is known exactly."""
    length, width, _ = size
    layer, places = layer_of(forms.box(*size), "solid", 400)
    margin = min(0.004, width / 4)
    x = np.arange(-length / 2 + margin, length / 2 - margin + 1e-9, 0.004)
    y = np.arange(-width / 2 + margin, width / 2 - margin + 1e-9, 0.004)
    sources = np.stack([*(each.ravel() for each in np.meshgrid(x, y)), np.zeros(len(x) * len(y))], axis=1)
    strength = np.sin(sources[:, 0] / length * 7.8)
    frequency = 2441.0
    k, normals = 2 * np.pi * frequency / SPEED, layer.samples.normals
    across = places[:, None] - sources
    r = np.linalg.norm(across, axis=2)
    ikr = 1j * k * r
    both = np.einsum("ijk,ik->ij", across, normals) * across[..., 2] / r**2
    wave = np.exp(ikr) / (4 * np.pi * r**3)
    motion = (wave * ((ikr - 1) * normals[:, 2:] + (ikr**2 - 3 * ikr + 3) * both)) @ strength
    motion = motion / (1j * 2 * np.pi * frequency * DENSITY)
    side = np.sign(np.einsum("ij,ij->i", normals, layer.normals[layer.own]))
    count = np.bincount(layer.own)
    mean = [np.bincount(layer.own, part * side) / count for part in (motion.real, motion.imag)]
    found = radiation(layer, np.stack(mean, axis=1), np.array([frequency, frequency])).resistance.sum()
    angle = np.arccos(1 - 2 * (np.arange(600) + 0.5) / 600)
    turn = np.pi * (1 + 5**0.5) * np.arange(600)
    ways = np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], axis=1)
    far = (np.exp(-1j * k * ways @ sources.T) @ strength) * (-1j * k * ways[:, 2]) / (4 * np.pi)
    known = (np.abs(far) ** 2).mean() * 4 * np.pi / IMPEDANCE
    assert abs(decibels(found, known)) < 1.0
