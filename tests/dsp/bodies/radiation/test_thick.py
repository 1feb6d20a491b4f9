"""Thick bars: the tables against boundary elements of a section, and a bar against the mesh that it is."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from carom.dsp import bodies
from carom.dsp.bodies.air import IMPEDANCE, wavenumber
from carom.dsp.bodies.radiation import line, thick, twist
from carom.dsp.bodies.radiation.closed import cylinder_efficiency
from tests.dsp.bodies.radiation import box, section
from tests.dsp.bodies.reference import STEEL

GRID = np.geomspace(*thick.REACH, thick.STEPS)


@pytest.mark.slow
@pytest.mark.parametrize("aspect, at", [(0.2, 11), (0.5, 6), (1.0, 14), (3.0, 9)])
def test_a_sections_excess_is_as_the_table_has_it(aspect, at):
    """Twice as many elements give the same within 0.05 dB."""
    row = thick.ASPECTS.index(aspect)
    fine = section.resistance(float(GRID[at]), aspect, count=36)
    known = line._strip_resistance(GRID[[at]])[0]
    dipole = 1 + (section.dipole_of(aspect) ** 2 - 1) / (1 + GRID[at] ** 2) ** 2
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


WOOD = bodies.Material("wood", 900, 18e9, 0.3, 1, 0)
SOFT = bodies.Material("soft", 1400, 3e9, 0.3, 1, 0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "material, sides",
    [
        (STEEL, (0.24, 0.03, 0.01)),
        (STEEL, (0.24, 0.03, 0.004)),
        (STEEL, (0.24, 0.01, 0.03)),
        (STEEL, (0.5, 0.02, 0.02)),
        (WOOD, (0.4, 0.06, 0.02)),
        (SOFT, (0.24, 0.03, 0.01)),
    ],
)
def test_a_bar_radiates_as_its_box_does(material, sides):
    """The six lowest bending modes do, those that radiate over 3e-5 of what a large plane does. The boundary elements
    are within some 0.1 dB here of those half as long."""
    length, width, thickness = sides
    size = {"length": length, "width": width, "thickness": thickness}
    own = bodies.bar(material, **size, top=16000, across=0.0, tilt=0.0)
    shapes = CubicSpline(np.linspace(0, 1, len(own.strike)), own.strike)
    found = 4 * np.pi * (own.pressure**2).mean(axis=0) / IMPEDANCE
    flat = IMPEDANCE * 2 * width * length / own.mass
    apart = []
    for mode, frequency in enumerate(own.frequency[:6]):
        k, bend = float(wavenumber(frequency)), (mode + 1.5) * np.pi / length

        def moving(at, axes, mode=mode):
            place = at[:, 0] / length + 0.5
            turned = -at[:, 2] * shapes(place, 1)[:, mode] / length
            return np.where(axes == 2, shapes(place)[:, mode], np.where(axes == 0, turned, 0.0))

        panels = min(2 * np.pi / max(k, bend) / 10, length / 30), width / 10, max(thickness / 6, width / 12)
        body = box.panels((length / 2, width / 2, thickness / 2), panels)
        known = box.resistance(body, k, moving, (1 - mode % 2 * 2, 1, -1))
        if known > 3e-5 * flat:
            apart.append(10 * np.log10(found[mode] / known))
    assert len(apart) > 1 and np.abs(apart).max() < 0.5, apart
