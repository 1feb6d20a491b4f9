"""Cells that are halved at inner edges: where they are, that they fit together, and what they leave of the error."""

import numpy as np
import pytest

from carom.dsp.bodies.material import Material
from carom.dsp.mesh import cells, forms, sizing
from carom.dsp.mesh.grading import extrapolated, graded
from carom.dsp.mesh.grids import TILT, grid_about
from carom.dsp.mesh.numbering import mesh_of
from carom.dsp.mesh.parts import Parts
from carom.dsp.mesh.pieces import undivided
from carom.dsp.mesh.polynomials import products
from carom.dsp.mesh.surface import Surface, rotation
from tests.bench import hexahedra

STEEL = Material("steel", 7850.0, 200e9, 0.29, 1.0, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("degree", [2, 4])
def test_polynomials_of_cells_of_all_sizes_meet_at_their_faces(degree):
    rng = np.random.default_rng(0)
    grid = grid_about(forms.box(1, 1, 1), 0.4, 12)
    for _ in range(3):
        smallest = grid.leaves[grid.levels[grid.leaves] == grid.levels.max()]
        grid = grid.halved(np.sort(rng.choice(smallest, len(smallest) // 8, replace=False)))
    used = np.sort(rng.choice(grid.leaves, int(0.8 * len(grid.leaves)), replace=False))
    mesh = mesh_of(undivided(grid), degree, used)
    at_nodes = rng.standard_normal(mesh.size)

    def value(row, place):
        values = products(((place - mesh.corners[row]) / mesh.sides[row])[None], degree)[0]
        return values @ mesh.ties.get(row, np.eye(len(values))) @ at_nodes[mesh.nodes[row]]

    met = 0
    for row in range(len(used)):
        place, axis, end = mesh.corners[row] + mesh.sides[row] * rng.random(3), rng.integers(3), rng.integers(2)
        place[axis] = mesh.corners[row, axis] + end * mesh.sides[row]
        beyond = place.copy()
        beyond[axis] += (2 * end - 1) * 1e-9
        beside = np.flatnonzero(used == grid.number(beyond[None])[0])
        if len(beside) and ((beyond > grid.corner) & (beyond < grid.corner + grid.side * grid.counts)).all():
            assert value(int(beside[0]), place) == pytest.approx(value(row, place), abs=1e-9)
            met += 1
    assert met > 100


@pytest.mark.slow
def test_cells_are_halved_at_inner_edges_alone():
    wrench = hexahedra.skin(hexahedra.wrench())
    halved = graded(grid_about(wrench, 0.01, 24), wrench, 2)[-1]
    small = halved.leaves[halved.levels[halved.leaves] == 2]
    edges = np.array([[0.0, -0.006], [0.0, 0.006], [0.014, -0.006], [0.014, 0.006]])
    middles = halved.corners[small, :2] + halved.sides[small, None] / 2
    assert (np.abs(middles[:, None] - edges).max(axis=2).min(axis=1) < 0.0051).all()
    box = forms.box(0.1, 0.06, 0.004)
    assert len(graded(grid_about(box, 0.02, 24), box, 2)) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("gap", "seed"), [(0.001, 1), (0.002, 1), (0.001, 4)])
def test_cells_are_halved_where_a_narrow_gap_ends(gap, seed):
    turn = rotation(np.random.default_rng(seed).uniform(-3, 3, 3)).T @ TILT.T
    skin = hexahedra.skin(hexahedra.fork(gap))
    fork = Surface(skin.points @ turn, skin.faces)
    grid = graded(grid_about(fork, 0.013, 24), fork, 2)[-1]
    edges = np.array([(0, side * gap / 2, z) for side in (-1, 1) for z in np.linspace(0.0003, 0.0057, 40)])
    assert (grid.levels[grid.number(edges @ turn)] == 2).all()


def test_frequencies_are_extrapolated_from_what_a_halving_changes():
    # Errors that fall as the side to the power of 1.09; the second and the third mode have changed places.
    known, wrong = np.array([100.0, 202.0, 200.0]), np.array([1e-4, 1e-2, 2e-2])
    before, after = (known * (1 + wrong * side**1.0888) for side in (1.0, 0.5))
    shares = np.eye(3)[[0, 2, 1]]
    assert extrapolated(before[[0, 2, 1]], after, shares) == pytest.approx(known, rel=3e-5)


@pytest.mark.slow
def test_a_wrench_rings_as_hexahedra_that_are_short_at_its_inner_edges_do():
    blocks = hexahedra.wrench()
    known = hexahedra.known(blocks, STEEL, 14, 0)[:14]
    body = hexahedra.skin(blocks)
    size = sizing.graded_sizes(body, 80, fine=False)
    assert size.told
    found = cells.solve(Parts((body,), (STEEL,)), size, 4, 24)
    assert np.sort(found.frequency)[6:20] == pytest.approx(known, rel=0.006)
