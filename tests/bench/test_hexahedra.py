"""Blocks that are put together, against one box."""

import numpy as np
import pytest

from carom.dsp.mesh.surface import volume_of
from tests import needs
from tests.bench import elastic, hexahedra
from tests.bench.meshes import BODIES, METAL, blob, tetrahedral

SIDES = (0.1, 0.08, 0.06)
Y, Z = (0.0, SIDES[1]), (0.0, SIDES[2])
BLOCKS = [hexahedra.box((0.0, 0.06), Y, Z, (2, 2, 2)), hexahedra.box((0.06, SIDES[0]), Y, Z, (2, 2, 2))]


@pytest.mark.slow
def test_two_blocks_ring_as_the_box_that_they_are():
    known = elastic.box(METAL, SIDES, (6, 6, 6), 6)
    assert hexahedra.known(BLOCKS, METAL, 6, 1)[:6] == pytest.approx(known, rel=0.002)


@pytest.mark.slow
def test_half_a_box_rings_as_the_whole():
    half = [hexahedra.box((0.0, SIDES[0]), (0.0, SIDES[1] / 2), Z, (3, 2, 2))]
    known = elastic.box(METAL, SIDES, (6, 6, 6), 8)
    assert hexahedra.known_of_half(half, METAL, 8, 1) == pytest.approx(known, rel=0.002)


@pytest.mark.slow
def test_half_a_mug_reaches_half_as_far():
    whole, half = (np.ptp(hexahedra.skin(each).points, axis=0) for each in (hexahedra.mug(), hexahedra.half_mug()))
    assert whole == pytest.approx(half * [1, 2, 1], rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("blocks", "volume"), [(BLOCKS, np.prod(SIDES)), (hexahedra.wrench(), 11.088e-6)])
def test_a_skin_is_closed_and_turned_outward(blocks, volume):
    surface = hexahedra.skin(blocks)
    sides = np.sort(np.concatenate([surface.faces[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    assert (np.unique(sides, axis=0, return_counts=True)[1] == 2).all()
    assert volume_of(surface) == pytest.approx(volume)


@pytest.mark.slow
def test_a_lump_of_hexahedra_rings_as_one_of_tetrahedra():
    """The map is singular at the cube's edges: so the tetrahedra's error goes with the third power of their side."""
    needs.module("skfem")
    coarse, fine = (tetrahedral((count,) * 3, blob)[:6] for count in (4, 6))
    known = BODIES["lump of 60"].known(1)[:6]
    assert fine - (coarse - fine) / (1.5**3 - 1) == pytest.approx(known, rel=3e-4)
    assert (known < fine).all()
