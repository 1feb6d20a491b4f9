"""Boxes and cylinders by polynomials: closed forms of modes, rigid motions, other solutions of the same bodies."""

import itertools

import numpy as np
import pytest

from carom.dsp.bodies.material import Material
from carom.dsp.bodies.mesh import Table, mesh
from carom.dsp.mesh import cells, sizing
from carom.dsp.mesh.blocks import BOX, CYLINDER, Block, degrees_of, solve
from carom.dsp.mesh.model import Wanted, model_of_block
from carom.dsp.mesh.parts import Parts
from carom.dsp.mesh.polynomials import gauss
from carom.dsp.mesh.surface import MeshError
from tests.bench import elastic

STEEL = Material("steel", 7850.0, 200e9, 0.29, 1.0, 0.0)
RIGID = 6


def inside(block, count=24):
    """Return points (n, 3) of a block and their weights (n,) in m^3, exact for polynomials of the shapes' squares."""
    nodes, weights = gauss(count)
    z, along = (2 * nodes - 1) * block.edges[2] / 2, weights * block.edges[2]
    if block.kind == BOX:
        x, y = (2 * nodes - 1) * block.edges[0] / 2, (2 * nodes - 1) * block.edges[1] / 2
        at = np.array(list(itertools.product(x, y)))
        across = np.outer(weights, weights).ravel() * block.edges[0] * block.edges[1]
    else:
        radius, angle = block.size[0] * np.sqrt(nodes), np.arange(60) * 2 * np.pi / 60
        at = np.stack([np.outer(radius, np.cos(angle)).ravel(), np.outer(radius, np.sin(angle)).ravel()], axis=1)
        across = np.repeat(weights * np.pi * block.size[0] ** 2 / 60, 60)
    points = np.hstack([np.repeat(at, count, axis=0), np.tile(z, len(at))[:, None]])
    return points, np.outer(across, along).ravel()


def nearest(frequencies, wanted):
    return np.abs(np.asarray(frequencies)[:, None] / wanted - 1).min(axis=0)


def test_a_cube_has_the_modes_of_lame():
    """Equivoluminal motion that leaves all faces free of stress: f = sqrt(2) c_s m/(2 a)."""
    shear = np.sqrt(STEEL.shear_modulus / STEEL.density)
    found = solve(Block(BOX, (0.05, 0.05, 0.05)), STEEL, 40).frequency
    assert nearest(found, np.sqrt(2) * shear / (2 * 0.05)) < 1e-5


def test_a_cylinder_twists_as_a_shaft():
    """Circles that turn as they are: f = n c_s/(2 L), whatever the radius."""
    shear, order = np.sqrt(STEEL.shear_modulus / STEEL.density), np.arange(1, 5)
    found = solve(Block(CYLINDER, (0.02, 0.1)), STEEL, 60).frequency
    assert (nearest(found, order * shear / (2 * 0.1)) < 1e-7).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    "size", [(0.1, 0.08, 0.06), (0.24, 0.03, 0.01), (0.01, 0.24, 0.03), (0.2, 0.2, 0.006), (0.12, 0.1, 0.01)]
)
def test_frequencies_of_boxes_are_those_of_polynomials_of_higher_degree(size):
    highest = 20 if max(size) > 5 * min(size) else 14
    degrees = tuple(int(each) for each in np.clip(np.ceil(np.array(size) / max(size) * highest), 5, highest))
    known = elastic.box(STEEL, size, degrees, 20)
    found = solve(Block(BOX, size), STEEL, 30).frequency[RIGID:]
    assert np.abs(found[:20] / known - 1).max() < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "degrees"), [((0.02, 0.1), (10, 14)), ((0.05, 0.01), (10, 14)), ((0.01, 0.2), (8, 20))]
)
def test_frequencies_of_cylinders_are_those_of_waves_round_the_axis(size, degrees):
    def section(at):
        return np.stack([1e-6 + (size[0] - 1e-6) * at[0], size[1] * at[1]])

    known = elastic.revolved(STEEL, section, degrees, 1, 8, 20)
    found = solve(Block(CYLINDER, size), STEEL, 30).frequency[RIGID:]
    assert np.abs(found[:20] / known - 1).max() < 6e-4


@pytest.mark.slow
@pytest.mark.parametrize("block", [Block(BOX, (0.1, 0.08, 0.06)), Block(CYLINDER, (0.02, 0.1))])
def test_shapes_are_of_unit_mass_and_move_the_body_as_a_whole_in_no_way(block):
    solution = solve(block, STEEL, 40)
    points, weights = inside(block)
    shapes = solution.at(points)[:, :, RIGID:]
    masses = weights * STEEL.density
    assert masses.sum() == pytest.approx(solution.mass, rel=1e-12)
    product = np.einsum("p,pcn,pcm->nm", masses, shapes, shapes)
    assert product == pytest.approx(np.eye(shapes.shape[2]), abs=1e-6)
    momentum = np.einsum("p,pcn->cn", masses, shapes)
    spin = np.einsum("p,pcn->cn", masses, np.cross(points[:, :, None], shapes, axisa=1, axisb=1, axisc=1))
    assert np.abs(momentum).max() < 1e-7 * np.sqrt(solution.mass)
    assert np.abs(spin).max() < 1e-7 * np.sqrt(solution.mass) * max(block.edges)


@pytest.mark.slow
@pytest.mark.parametrize("block", [Block(BOX, (0.1, 0.08, 0.03)), Block(CYLINDER, (0.03, 0.04))])
def test_shapes_at_faces_and_edges_are_those_of_finite_cells(block):
    """All of one frequency together: a pair's shapes may be turned, and their span may not. The cells' frequencies are
    off by less than 0.8 %: other tests tell how far ours are."""
    own = solve(block, STEEL, 18)
    parts = Parts((block.surface,), (STEEL,))
    other = cells.solve(parts, sizing.sizes(block.surface, 60), 3, 18)
    half = np.array(block.edges) / 2
    if block.kind == BOX:
        points = np.array([*itertools.product(*([-0.99, 0.3, 0.99],) * 3)]) * half
    else:
        angle = np.arange(0, 6.2, 0.7)
        round_ = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1) * 0.99 * half
        points = np.vstack([round_ + np.array([0, 0, z * half[2]]) for z in (-0.99, 0.2, 0.99)])
    mine, theirs = (each.at(points).reshape(-1, 18) for each in (own, other))
    begin = RIGID
    while begin < 14:
        end = begin + 1
        while own.frequency[end] < 1.003 * own.frequency[end - 1]:
            end += 1
        assert np.abs(other.frequency[begin:end] / own.frequency[begin:end] - 1).max() < 8e-3
        basis = np.linalg.qr(theirs[:, begin:end])[0]
        left = mine[:, begin:end] - basis @ (basis.T @ mine[:, begin:end])
        assert np.linalg.norm(left) < 0.07 * np.linalg.norm(mine[:, begin:end])
        size = np.linalg.norm(mine[:, begin:end]) / np.linalg.norm(theirs[:, begin:end])
        assert size == pytest.approx(1.0, abs=0.02)
        begin = end


@pytest.mark.slow
def test_a_box_rings_on_its_edge_less_than_on_its_face_and_more_than_on_its_end():
    """A blow on a bar's face in the middle, on the edge beside it, on its end along it: the lowest mode bends the bar
    upward; the contact on the edge is softer."""
    block = Block(BOX, (0.24, 0.03, 0.01))
    model = model_of_block(block, STEEL, Wanted(modes=20, errors=True))
    assert np.nanmax(model.error[:10]) < 2e-3
    values = {**vars(model), "density": 7850.0, "youngs_modulus": 200e9, "poisson_ratio": 0.29}
    table = Table(digest="", **values)
    places = np.array([[0, 0, 0.005], [0, 0.015, 0.005], [0.12, 0, 0]])
    _, _, shapes = table.near(places)
    up = np.abs(shapes[:, 2, 0])
    assert up[1] == pytest.approx(up[0], rel=0.02)
    assert np.abs(shapes[2, 0, 0]) < 0.02 * up[0]
    faces = mesh(STEEL, table=table, top=20e3).faces
    assert faces is not None and faces.edges.any() and np.abs(faces.curvature).max() < 1.0
    assert model.volume == pytest.approx(block.volume)


@pytest.mark.slow
def test_another_size_of_the_same_proportions_is_the_same_body(monkeypatch):
    """Twice as large it rings an octave lower, and all shapes are of unit mass; nothing is computed again."""
    wanted, size = Wanted(modes=5, points=60), (0.06, 0.05, 0.04)
    small = model_of_block(Block(BOX, size), STEEL, wanted)
    alone = solve(Block(BOX, size), STEEL, 5 + RIGID + 4)
    np.testing.assert_allclose(small.frequency, alone.frequency[RIGID : RIGID + 5], rtol=1e-9)
    shapes = np.abs(alone.at(small.points)[:, :, RIGID : RIGID + 5])
    np.testing.assert_allclose(np.abs(small.shapes), shapes, atol=1e-6 * shapes.max())
    monkeypatch.setattr("carom.dsp.mesh.blocks.solve", None)
    large = model_of_block(Block(BOX, tuple(2 * each for each in size)), STEEL, wanted)
    np.testing.assert_allclose(large.frequency, small.frequency / 2)
    np.testing.assert_allclose(large.resistance, small.resistance / 2)
    np.testing.assert_allclose(large.shapes * 8**0.5, small.shapes)
    assert large.mass == pytest.approx(8 * small.mass) and large.points.max() == pytest.approx(0.06)
    with pytest.raises(MeshError, match="a box of 500 x 10 x 10 mm: expected edges"):
        model_of_block(Block(BOX, (0.5, 0.01, 0.01)), STEEL, wanted)


def test_block_that_is_too_slender_is_refused():
    with pytest.raises(MeshError, match="a box of 500 x 10 x 10 mm: expected edges"):
        degrees_of(Block(BOX, (0.5, 0.01, 0.01)), 700)
