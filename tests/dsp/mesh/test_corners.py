"""Corners of walls in finite cells: they bend there as the solid does, and nothing yields where no walls meet."""

from functools import partial

import numpy as np
import pytest

from carom.dsp.mesh import cells, sizing
from carom.dsp.mesh.parts import Parts
from tests.bench import elastic, hexahedra, meshes

WALL = 0.004


def rung(surface, size, count):
    """Return the lowest frequencies (Hz) of a body of cells."""
    solved = cells.solve(Parts((surface,), (meshes.METAL,)), size, 4, count + 6)
    return np.sort(solved.frequency)[6 : count + 6]


def turned(place, degrees, pieces, count):
    """Return the known ones of what a section makes as it turns."""
    return elastic.revolved(
        meshes.METAL, lambda at: place(np.stack([*at, np.zeros(at.shape[1])]))[[0, 2]], degrees, pieces, 5, count
    )


@pytest.mark.slow
def test_the_bottom_of_a_cup_of_thick_walls_rings_as_polynomials_of_high_degree_do():
    place = partial(meshes.can, WALL)
    body = meshes.skin((2, 36, 48), place)
    found = rung(body, sizing.graded_sizes(body, 50, fine=False), 14)
    assert found == pytest.approx(turned(place, (3, 6), 9, 14), rel=0.015)


@pytest.mark.slow
def test_panels_at_right_angles_bend_at_their_edge_in_cells_of_two_walls():
    beside, along, thick = (WALL, 1.06 * WALL, 1.3 * WALL, 0.02, 0.04), (0.0, 0.01, 0.02), (0.0, 0.7 * WALL, WALL)
    panels = [
        hexahedra.box(x, along, z, (len(x) - 1, 2, len(z) - 1))
        for x, z in ((thick, thick), (beside, thick), (thick, beside))
    ]
    found = rung(hexahedra.skin(panels), sizing.Sizes(2.2 * WALL, 24, WALL, edges=True), 6)
    assert found == pytest.approx(hexahedra.known(panels, meshes.METAL, 6, 1), rel=0.01)


@pytest.mark.slow
def test_a_curved_wall_is_as_stiff_beside_its_rim_as_elsewhere():
    def tube(at):
        radius, turn = 0.038 + WALL * at[0], 2 * np.pi * at[2]
        return np.stack([radius * np.cos(turn), radius * np.sin(turn), 0.03 * at[1]])

    found = rung(meshes.skin((2, 6, 96), tube), sizing.Sizes(6 * WALL, 24, WALL, edges=True), 6)
    assert found == pytest.approx(turned(tube, (3, 6), 2, 6), rel=0.01)
