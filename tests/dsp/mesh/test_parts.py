"""Bodies of several materials: a bar of two against transfer matrices, losses by energy, parts that don't touch."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from carom.dsp.bodies.material import Material
from carom.dsp.mesh import cells, forms, sizing
from carom.dsp.mesh.parts import Division, Parts, joined, outside
from carom.dsp.mesh.surface import MeshError, faces_of

STEEL = Material("steel", 7850.0, 200e9, 0.29, 1.0, 0.0)
WOOD = Material("wood", 750.0, 11e9, 0.25, 1.0, 0.0)
LENGTHS, WIDTH, THICKNESS = (0.16, 0.2), 0.02, 0.014
HALVES = tuple(
    forms.moved(forms.box(length, WIDTH, THICKNESS), (side * length / 2, 0, 0))
    for length, side in zip(LENGTHS, (-1, 1), strict=True)
)


def passed(material, length, omega, width, height):
    """Return how deflection, turn, moment and force at one end of Timoshenko's beam follow from those at the other."""
    nu, modulus = material.poisson_ratio, material.youngs_modulus
    section, inertia = width * height, width * height**3 / 12
    shear = 10 * (1 + nu) / (12 + 11 * nu) * modulus / (2 * (1 + nu)) * section
    rows = np.zeros((4, 4))
    rows[0, 1], rows[0, 3], rows[1, 2], rows[2, 3] = 1, 1 / shear, 1 / (modulus * inertia), -1
    rows[2, 1] = -material.density * inertia * omega**2
    rows[3, 0] = -material.density * section * omega**2
    return expm(rows * length)


def bending(width, height, top):
    """Return the frequencies (Hz) of the free bar of steel and wood that bends along its height."""

    def free(frequency):
        omega = 2 * np.pi * frequency
        both = passed(WOOD, LENGTHS[1], omega, width, height) @ passed(STEEL, LENGTHS[0], omega, width, height)
        return np.linalg.det(both[2:, :2])

    tried = np.arange(50.0, top, 20.0)
    return [brentq(free, *pair) for pair in pairwise(tried) if free(pair[0]) * free(pair[1]) < 0]


def solved(steel, wood, number, degree):
    size = sizing.sizes(forms.together(*HALVES), number)
    return cells.solve(Parts(HALVES, (steel, wood)), size, degree, 20)


@pytest.mark.slow
def test_a_bar_of_steel_and_wood_rings_as_transfer_matrices_say():
    found = solved(STEEL, WOOD, 80, 4)
    assert found.mass == pytest.approx(WIDTH * THICKNESS * (7850 * LENGTHS[0] + 750 * LENGTHS[1]), rel=2e-3)
    closed = sorted(bending(WIDTH, THICKNESS, 4000.0) + bending(THICKNESS, WIDTH, 4000.0))
    assert len(closed) == 7
    for frequency in closed:
        # Steel holds wood's end from growing across as it bends, which a beam leaves out: the body is a little stiffer.
        assert np.abs(found.frequency / frequency - 1).min() < 0.012, frequency


@pytest.mark.slow
def test_the_share_of_energy_is_by_how_much_a_material_raises_the_frequency():
    stiffer = Material("wood", 750.0, 1.01 * 11e9, 0.25, 1.0, 0.0)
    one, other = (solved(STEEL, each, 12, 2) for each in (WOOD, stiffer))
    raised = np.log(other.frequency[6:16] / one.frequency[6:16]) * 2 / np.log(1.01)
    assert np.allclose(raised, (one.energy + other.energy)[1, 6:16] / 2, atol=2e-3)
    assert np.allclose(one.energy[:, 6:].sum(axis=0), 1.0)
    assert one.energy[1, 6:16].min() < 0.5 < one.energy[1, 6:16].max()


@pytest.mark.slow
def test_overlap_of_parts_is_of_the_first_ones_material():
    both = HALVES[0], forms.moved(HALVES[1], (-0.04, 0, 0))
    size = sizing.sizes(forms.together(*both), 12)
    for materials, steel in (((STEEL, WOOD), 0.16), ((WOOD, STEEL), 0.16)):
        found = cells.solve(Parts(both, materials), size, 2, 8)
        kilograms = [each.density * (0.16, 0.16)[number] for number, each in enumerate(materials)]
        assert found.mass == pytest.approx(WIDTH * THICKNESS * sum(kilograms), rel=0.01), steel
        assert found.volume == pytest.approx(WIDTH * THICKNESS * 0.32, rel=0.01)


def division(*surfaces):
    of = np.repeat(np.arange(len(surfaces)), [len(each.faces) for each in surfaces])
    return Division(of, ("blade", "grip", "knob")[: len(surfaces)], (STEEL, WOOD, STEEL)[: len(surfaces)])


@pytest.mark.slow
def test_parts_that_do_not_touch_are_said():
    near, far = HALVES[1], forms.moved(HALVES[1], (0.0123, 0, 0))
    parts, notes = joined(*forms.together(HALVES[0], near), division(HALVES[0], near), False)
    assert parts.materials == (STEEL, WOOD) and notes == ("blade: of steel", "grip: of wood")
    with pytest.raises(MeshError, match=r"part grip does not touch blade: 12\.3 mm lie between them"):
        joined(*forms.together(HALVES[0], far), division(HALVES[0], far), False)
    inner = forms.moved(forms.box(0.01, 0.005, 0.005), (0.1, 0, 0))  # in the wood, and far from its surface
    parts, notes = joined(*forms.together(*HALVES, inner), division(*HALVES, inner), False)
    assert len(parts.surfaces) == 2 and len(parts.surfaces[0].faces) == len(HALVES[0].faces) + len(inner.faces)
    assert notes == ("blade, knob: of steel", "grip: of wood")


def test_a_part_that_is_open_is_named():
    cut = HALVES[1]._replace(faces=HALVES[1].faces[:-4])
    with pytest.raises(MeshError, match="part grip: open: 1 opening"):
        joined(*forms.together(HALVES[0], cut), division(HALVES[0], cut), False)


@pytest.mark.slow
def test_faces_on_and_inside_of_other_parts_are_not_the_bodys():
    thin = forms.moved(forms.box(0.2, WIDTH / 2, THICKNESS / 2), (0.1, 0, 0))
    sunk = forms.moved(thin, (-0.05, 0, 0))
    ends, side = WIDTH * THICKNESS, 2 * (WIDTH + THICKNESS)
    for part, sunk_by in ((thin, 0.0), (sunk, 0.05)):
        surface, of = outside(Parts((HALVES[0], part), (STEEL, WOOD)), 0.002)
        areas = np.bincount(of, faces_of(surface).areas)
        assert areas[1] == pytest.approx(ends / 4 + (0.2 - sunk_by) * side / 2, rel=0.01)
        assert areas[0] == pytest.approx(0.16 * side + 2 * ends - (ends / 4 if not sunk_by else 0), rel=0.01)
