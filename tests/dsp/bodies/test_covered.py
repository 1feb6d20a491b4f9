"""Mean squares of modes over a pad, against means of exact shapes over its area."""

import math

import numpy as np
import pytest

from carom.dsp.bodies.covered import mean_squares
from carom.dsp.bodies.plate import plate
from carom.presets import Presets

AREA = 8e-3
TOP = 4_000.0


def test_a_plates_modes_are_known_over_a_palm():
    """Within 3 dB at 80 of 100 places, where single points err by 17."""
    preset = Presets().object("steel-plate")
    sides = np.array([preset.geometry["length"], preset.geometry["width"]])
    body = {name: preset.geometry[name] for name in ("length", "width", "thickness")}
    ends = [np.array(preset.geometry[name]) * sides for name in ("path_from", "path_to")]
    along = (ends[1] - ends[0]) / math.dist(*ends)
    across, radius = np.array([-along[1], along[0]]), math.sqrt(AREA / math.pi)
    made = preset.modes(TOP)
    places = np.linspace(0.0, math.dist(*ends), len(made.strike))
    total, count = np.zeros_like(made.strike), np.zeros((len(places), 1))
    for aside in np.linspace(-0.9, 0.9, 9) * radius:
        first, last = ends[0] + aside * across - radius * along, ends[1] + aside * across + radius * along
        line = plate(preset.material, top=TOP, path_from=tuple(first / sides), path_to=tuple(last / sides), **body)
        points = np.linspace(first, last, len(line.strike))
        inside = ((points >= 0.0) & (points <= sides)).all(axis=1)
        apart = np.subtract.outer(places, np.linspace(-radius, places[-1] + radius, len(points)))
        under = (np.hypot(apart, aside) <= radius) & inside
        total += under @ line.strike**2
        count += under.sum(axis=1, keepdims=True)
    exact = total / count
    found = mean_squares(made, "plate", preset.geometry, preset.material, AREA)
    assert np.mean(np.abs(10 * np.log10(found / exact)) < 3.0) > 0.8
    assert np.mean(np.abs(10 * np.log10(made.strike**2 / exact)) < 3.0) < 0.5
    assert abs(10 * np.log10(found.mean() / exact.mean())) < 0.5


@pytest.mark.parametrize("name", ["crash-cymbal", "iron-pan", "tom"])
def test_a_discs_modes_move_its_mass_on_the_whole(name):
    """The mean of the squares over the disc is 1/M, and no mode is spared anywhere."""
    preset = Presets().object(name)
    made = preset.modes(TOP)
    found = mean_squares(made, preset.shape, preset.geometry, preset.material, AREA)
    mean = made.mass * np.average(found, axis=0, weights=np.abs(np.linspace(-1.0, 1.0, len(found))))
    assert np.median(mean) == pytest.approx(1.0, abs=0.1)
    assert mean.min() > 0.2 and mean.max() < 2.5
    assert found.min() > 0.01 / made.mass


@pytest.mark.parametrize("name", ["church-bell", "wine-glass", "water-basin"])
def test_bodies_without_known_shapes_have_one_over_their_mass(name):
    preset = Presets().object(name)
    made = preset.modes(TOP)
    found = mean_squares(made, preset.shape, preset.geometry, preset.material, AREA)
    assert found.shape == (max(len(made.strike), 4), made.frequency.size)
    assert np.allclose(found, 1.0 / made.mass)


@pytest.mark.parametrize("name", ["marimba-bar", "piano-string"])
def test_body_narrower_than_a_palm_has_one_over_its_mass_as_mean_square(name):
    preset = Presets().object(name)
    made = preset.modes(TOP)
    found = mean_squares(made, preset.shape, preset.geometry, preset.material, AREA)
    assert np.allclose(made.mass * found.mean(axis=0), 1.0)


def test_a_palm_on_a_surface_finds_the_triangles_under_it():
    """On the body of a spoon it covers all of the bowl, at a point of the handle a part of that."""
    preset = Presets().object("spoon")
    made = preset.modes(TOP)
    faces = made.faces
    whole = mean_squares(made, "mesh", preset.geometry, preset.material, 10.0)
    corners = np.mean([made.strike[faces.rows + corner] ** 2 for corner in range(3)], axis=0)
    sides = faces.corners[:, 1:] - faces.corners[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    assert np.allclose(whole, np.average(corners, axis=0, weights=areas))
    least = mean_squares(made, "mesh", preset.geometry, preset.material, 1e-12, tuple(faces.corners[7].mean(axis=0)))
    assert np.allclose(least, corners[7])
