"""Pieces of a body in cells: parts beside a gap move apart, and what holds them together is told."""

import numpy as np
import pytest

from carom.dsp.bodies.material import Material
from carom.dsp.mesh import cells, forms, sizing
from carom.dsp.mesh.grids import grid_about
from carom.dsp.mesh.model import Wanted, _held_gap, model_of
from carom.dsp.mesh.numbering import mesh_of
from carom.dsp.mesh.parts import Parts
from carom.dsp.mesh.pieces import _labels, divided
from carom.dsp.mesh.rays import quadrature
from carom.dsp.mesh.surface import MeshError, Surface, rotation
from tests.bench import hexahedra

STEEL = Material("steel", 7850.0, 200e9, 0.29, 1.0, 0.0)


def prongs(gap, length=0.08, width=0.006):
    """Return two prongs (m) beside a gap, that a block holds at one end."""
    prong = forms.moved(forms.box(length + 0.01, width, 0.006), (length / 2 - 0.005, (gap + width) / 2, 0.003))
    other = forms.moved(prong, (0, -gap - width, 0))
    block = forms.moved(forms.box(0.02, gap + 2 * width, 0.006), (-0.01, 0, 0.003))
    return forms.together(block, prong, other)


@pytest.mark.slow
@pytest.mark.parametrize(("gap", "angles"), [(0.0003, (0.11, 0.13, 0.17)), (0.002, (0.4, -0.7, 0.9))])
def test_cells_on_both_sides_of_a_gap_share_no_node(gap, angles):
    turn = rotation(angles)
    body = prongs(gap)
    turned = Surface(body.points @ turn.T, body.faces)
    grid = grid_about(turned, 0.012, 30)
    pieces, (points,) = divided(turned, grid, [quadrature(turned, grid, 3)], 1e-3)
    mesh = mesh_of(pieces, 3, np.unique(points.cells))
    at = points.places @ turn
    rows = np.searchsorted(mesh.cells, points.cells)
    root = np.zeros(len(mesh.cells), bool)
    root[rows[at[:, 0] < 0.001]] = True  # cells that the block is in may hold both
    side = np.bincount(rows, points.weights * np.sign(at[:, 1])) / np.bincount(rows, points.weights)
    far = ~root
    assert (np.abs(side[far]) > 0.99).all()
    upper, lower = (np.unique(mesh.nodes[far & (each * side > 0)]) for each in (1, -1))
    beside = np.unique(mesh.nodes[root])
    assert not len(np.setdiff1d(np.intersect1d(upper, lower), beside))
    assert len(upper) > 100
    # A place of the surface is that of the piece of its side.
    tip = np.array([[0.07, each * (gap / 2 + 1e-6), z] for each in (1, -1) for z in (0.001, 0.003, 0.005)])
    found = mesh.elements(tip @ turn.T)
    assert np.array_equal(np.sign(side[found]), [1, 1, 1, -1, -1, -1])


@pytest.mark.slow
def test_bodies_that_touch_nowhere_hold_each_other():
    box = forms.box(0.05, 0.01, 0.01)
    both = forms.together(box, forms.moved(box, (0, 0.0115, 0)))
    found = cells.solve(Parts((both,), (STEEL,)), sizing.sizes(both, 20), 3, 14)
    assert np.count_nonzero(found.frequency < 1e-3 * found.frequency[-1]) == 6


@pytest.mark.slow
def test_a_gap_that_ends_in_a_large_cell_is_told():
    fork = prongs(0.0005)
    held = cells.solve(Parts((fork,), (STEEL,)), sizing.sizes(fork, 30), 2, 14)
    (told,) = _held_gap(held, 0.1)
    assert told.startswith("a gap of 0.5 mm ends about (")
    box = forms.box(0.1, 0.01, 0.006)
    assert _held_gap(cells.solve(Parts((box,), (STEEL,)), sizing.sizes(box, 30), 2, 14), 0.1) == ()


FORK = 898.24, 1029.74, 2122.76, 2302.08, 5503.52, 5620.17, 5809.33, 7335.45
"""Hz: of a steel bar of 120 x 12 x 6 mm and a slot of 2 mm, 70 mm long, by tests.bench.hexahedra, degree 4."""


@pytest.mark.slow
def test_a_fork_of_narrow_tines_rings_as_hexahedra_do():
    body = hexahedra.skin(hexahedra.fork(0.002))
    turned = Surface(body.points @ rotation((0.3, -0.5, 0.8)).T, body.faces)
    size = sizing.graded_sizes(turned, 80, fine=False)
    found = cells.solve(Parts((turned,), (STEEL,)), size, 4, 18)
    assert np.sort(found.frequency)[6:14] == pytest.approx(FORK, rel=0.03)


@pytest.mark.parametrize("thickness", [1e-4, 3e-5, 1e-6])
def test_a_body_too_thin_for_any_voxel_is_refused(thickness):
    leaf = forms.box(0.2, 0.2, thickness)
    with pytest.raises(MeshError, match=r"expected (thicker ones|a body with a thickness), or"):
        model_of(leaf.points, leaf.faces, STEEL, Wanted(modes=5, points=60))


def test_cells_without_a_voxel_inside_hold_no_piece():
    nothing = np.full((2, 3, 3, 3), -1)
    assert (_labels([nothing, nothing, nothing]) == -1).all()
