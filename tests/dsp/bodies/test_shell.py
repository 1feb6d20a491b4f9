"""Walls of cylinders against their limits: rings, plates, and shallow shells."""

import math

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies.shell import wall_modes

STUFF = bodies.Material("stuff", 2700.0, 72e9, 0.34, alpha=1.0, beta=0.0)
BENDING = math.sqrt(72e9 / (12 * 2700.0 * (1 - 0.34**2))) / (2 * math.pi)


def test_a_long_cylinder_is_a_ring():
    order = np.arange(2.0, 9.0)
    frequency, heavier = wall_modes(STUFF, 0.05, 0.001, 50.0, order, 1)
    hoppe = BENDING * order * (order**2 - 1) / np.sqrt(order**2 + 1) * 0.001 / 0.05**2
    assert frequency == pytest.approx(hoppe, rel=2e-4)
    assert heavier == pytest.approx(1 + 1 / order**2, rel=1e-3)


def test_a_wide_cylinder_is_a_plate():
    """A cylinder of 100 m radius, between two nodal lines 0.5 m apart and two ends 0.4 m apart."""
    order = math.pi * 100.0 / 0.5
    frequency, heavier = wall_modes(STUFF, 100.0, 0.02, 0.4, np.array([order]), 3)
    waves = (math.pi / 0.5) ** 2 + (3 * math.pi / 0.4) ** 2
    assert frequency[0] == pytest.approx(BENDING * 0.02 * waves, rel=1e-3)
    assert heavier[0] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("row", [1, 3, 8])
def test_waves_that_are_short_go_as_on_a_shallow_shell(row):
    """Donnell's formula: stretching by the curvature, and bending; it holds for n of 6 and more within some percent."""
    order, radius, thickness, height = np.arange(6.0, 25.0), 0.033, 1e-4, 0.105
    waves = row * math.pi * radius / height
    square = order**2 + waves**2
    stretched = math.sqrt(72e9 / 2700.0) / (2 * math.pi * radius) * waves**2 / square
    shallow = np.hypot(stretched, BENDING * thickness / radius**2 * square)
    assert wall_modes(STUFF, radius, thickness, height, order, row)[0] == pytest.approx(shallow, rel=0.04)


@pytest.mark.slow
def test_a_can_rings_by_its_wall_between_its_ends():
    can = bodies.can(STUFF, radius=0.033, height=0.105, thickness=1e-4, top=20_000)
    assert can.mass == pytest.approx(2 * math.pi * 0.033 * 0.105 * 1e-4 * 2700.0)
    families = [wall_modes(STUFF, 0.033, 1e-4, 0.105, np.arange(2.0, 60.0), row)[0] for row in range(1, 30)]
    alone = np.sort(np.concatenate(families))
    assert can.frequency.size == pytest.approx(np.count_nonzero(alone < 20_000), rel=0.05)
    assert 0.9 * alone[0] < can.frequency[0] < alone[0]  # by the air's mass
    # A quarter of the mass swings, where the sine up the wall and the cosine around it have their peaks, and the air's.
    assert 0.8 * 4 / can.mass < (can.strike**2).max() < 4 / can.mass
