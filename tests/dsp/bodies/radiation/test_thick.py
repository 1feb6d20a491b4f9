"""Thick bars: the tables against boundary elements of a section, and a bar against the mesh that it is."""

import numpy as np
import pytest

from carom.dsp.bodies.radiation import line, thick, twist
from carom.dsp.bodies.radiation.closed import cylinder_efficiency
from tests.dsp.bodies.radiation import section

GRID = np.geomspace(*thick.REACH, thick.STEPS)


@pytest.mark.slow
@pytest.mark.parametrize("aspect, at", [(0.2, 11), (0.5, 6), (1.0, 14), (3.0, 9)])
def test_a_sections_excess_is_as_the_table_has_it(aspect, at):
    """Twice as many elements give the same within 0.05 dB."""
    row = thick.ASPECTS.index(aspect)
    fine = section.resistance(float(GRID[at]), aspect, count=36)
    known = line._strip_resistance(GRID[[at]])[0]
    dipole = 1 + (line.dipole_of(aspect) ** 2 - 1) / (1 + GRID[at] ** 2) ** 2
    assert 10 * np.log10(fine / known / dipole) == pytest.approx(thick.SWAYS[row][at], abs=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("aspect, at", [(0.2, 14), (0.5, 12), (0.7, 5)])
def test_a_twists_excess_is_as_the_table_has_it(aspect, at):
    row = thick.TURNED.index(aspect)
    fine = section.resistance(float(GRID[at]), aspect, turns=True, count=36)
    known = twist.strip(GRID[[at]])[0]
    strength = np.interp(aspect, twist.THICKNESS, twist.FLATNESS)
    quadrupole = 1 + (strength**2 - 1) / (1 + GRID[at] ** 2) ** 2
    assert 10 * np.log10(fine / known / quadrupole) == pytest.approx(thick.TURNS[row][at], abs=0.08)


def test_the_elements_have_the_flat_strip_and_a_square_that_is_nearly_round():
    """A thin section is the strip of the exact tables; a square lies between the cylinders inside and around it."""
    assert section.resistance(0.5, 0.05) == pytest.approx(line._strip_resistance(np.array([0.5]))[0], rel=0.4)
    inside, around = (np.pi * r * cylinder_efficiency(1, np.array([0.2 * r]))[0] for r in (1.0, 2**0.5))
    assert inside < section.resistance(0.2, 1.0) < around


def test_between_its_places_the_table_is_even():
    """A flat strip has no excess; beyond the last aspect it falls off at smaller x."""
    x = np.array([0.3, 1.0, 3.0])
    assert thick.swaying(x, 0.0) == pytest.approx(1.0)
    assert thick.turning(x, 0.0) == pytest.approx(1.0)
    assert thick.swaying(GRID[[9]], 3.0) == pytest.approx(10 ** (thick.SWAYS[9][9] / 10))
    middle = thick.swaying(GRID[[9]], 2.5)[0]
    assert thick.swaying(GRID[[9]], 3.0)[0] < middle < thick.swaying(GRID[[9]], 2.0)[0]
    assert thick.swaying(x[:1], 20.0) == pytest.approx(thick.swaying(2 * x[:1], 10.0))
