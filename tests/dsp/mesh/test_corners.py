"""Corners of walls in finite cells: they bend there as the solid does."""

from functools import partial

import numpy as np
import pytest

from carom.dsp.mesh import cells
from carom.dsp.mesh.parts import Parts
from tests.bench import elastic, meshes

WALL = 0.004


@pytest.mark.slow
def test_the_bottom_of_a_cup_of_thick_walls_rings_as_polynomials_of_high_degree_do():
    place = partial(meshes.can, WALL)
    known = elastic.revolved(
        meshes.METAL, lambda at: place(np.stack([*at, np.zeros(at.shape[1])]))[[0, 2]], (3, 6), 9, 5, 14
    )
    body = meshes.skin((2, 36, 96), place)
    size = cells.graded_sizes(body, 80, fine=False)
    found = np.sort(cells.solve(Parts((body,), (meshes.METAL,)), size, 4, 26).frequency)[6:20]
    assert found == pytest.approx(known, rel=0.015)
