"""Finite cells against closed forms: integrals over bodies, a sphere's modes, a bar's."""

import numpy as np
import pytest

from carom.dsp.bodies import bar, sphere
from carom.dsp.bodies.material import Material
from carom.dsp.mesh import cells, forms, sizing
from carom.dsp.mesh.fronts import Elements, Factor
from carom.dsp.mesh.grids import TILT, grid_about
from carom.dsp.mesh.lanczos import lowest
from carom.dsp.mesh.parts import Parts
from carom.dsp.mesh.rays import quadrature
from carom.dsp.mesh.surface import Surface, volume_of
from tests.bench.hexahedra import gradients

STEEL = Material("steel", 7850.0, 200e9, 0.29, 1.0, 0.0)


def turned(surface):
    return Surface(surface.points @ TILT.T, surface.faces)


def integrals(body, side, degree=3):
    """Return the volume of a body, and its integral of x^2, by the quadrature."""
    grid = grid_about(body, side, 12)
    found = quadrature(body, grid, degree)
    from carom.dsp.mesh.polynomials import gauss

    nodes, weights = gauss(2)
    inner = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), -1).reshape(-1, 3)
    share = (weights[:, None, None] * weights[:, None] * weights).ravel()
    at = (grid.corners[found.full][:, None] + grid.side * inner).reshape(-1, 3)
    places = np.vstack([found.places, at])
    every = np.r_[found.weights, np.tile(share, len(found.full)) * grid.side**3]
    return every.sum(), (every * places[:, 0] ** 2).sum()


def test_cells_beside_a_body_have_no_points_though_they_alone_are_halved():
    body = turned(forms.box(0.1, 0.06, 0.004))
    grid = grid_about(body, 0.015, 12)
    found = quadrature(body, grid, 3)
    beside = np.setdiff1d(grid.leaves, [*found.cells, *found.full])
    again = quadrature(body, grid.halved(beside[:1]), 3)
    assert np.array_equal(again.places, found.places) and np.array_equal(again.weights, found.weights)


@pytest.mark.slow
def test_the_quadrature_measures_bodies():
    box = turned(forms.box(0.1, 0.06, 0.004))
    inertia = TILT @ np.diag(np.array([0.1, 0.06, 0.004]) ** 2 / 12) @ TILT.T * 0.1 * 0.06 * 0.004
    volume, square = integrals(box, 0.015)
    assert volume == pytest.approx(0.1 * 0.06 * 0.004, rel=2e-3)
    assert square == pytest.approx(inertia[0, 0], rel=4e-3)
    ball = forms.ball(0.05, 3)
    volume, _ = integrals(ball, 0.02)
    assert volume == pytest.approx(volume_of(ball), rel=2e-3)


def test_moments_give_the_integrals_of_products():
    from carom.dsp.mesh.polynomials import integrals, moments, products

    rng = np.random.default_rng(3)
    places, weights = rng.random((40, 3)), rng.random(40)
    of = moments(places, weights, 2)
    values, slopes = products(places, 2), gradients(places, 2)
    assert np.allclose(integrals(of, 2), (values * weights[:, None]).T @ values, atol=1e-12)
    for i, j in ((0, 0), (0, 1), (2, 1)):
        assert np.allclose(integrals(of, 2, (i, j)), (slopes[i] * weights[:, None]).T @ slopes[j], atol=1e-10)


def test_stress_across_sheets_is_that_of_its_square_point_by_point():
    """By the strain of a random motion at each place, and the stress along the normal there."""
    from carom.dsp.mesh.corners import held_across
    from carom.dsp.mesh.rays import Points

    rng, side, degree = np.random.default_rng(4), 0.02, 3
    places, weights, normals = rng.random((50, 3)), rng.random(50), rng.standard_normal((50, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    zeros = np.zeros(50, np.int64)
    held = held_across(Points(places, weights, zeros, zeros, normals, np.ones(50)), side, degree, STEEL)
    motion = rng.standard_normal(((degree + 1) ** 3, 3))
    gradient = np.einsum("ipm,mj->ipj", gradients(places, degree), motion) / side
    mu = STEEL.youngs_modulus / (2 * (1 + STEEL.poisson_ratio))
    lame = 2 * mu * STEEL.poisson_ratio / (1 - 2 * STEEL.poisson_ratio)
    stress = lame * np.einsum("ipi->p", gradient) + 2 * mu * np.einsum("ipj,pi,pj->p", gradient, normals, normals)
    energy = (weights * stress**2).sum() / (lame + 2 * mu)
    assert motion.ravel() @ held @ motion.ravel() == pytest.approx(energy, rel=1e-12)


@pytest.mark.slow
def test_parts_that_overlap_count_once():
    half = forms.box(0.1, 0.05, 0.05)
    body = turned(forms.together(half, forms.moved(half, (0.04, 0, 0))))
    assert integrals(body, 0.02)[0] == pytest.approx(0.14 * 0.05 * 0.05, rel=3e-3)


def test_the_factor_solves_as_a_dense_matrix_does_and_modes_are_those_of_scipy():
    from scipy.linalg import eigh

    rng = np.random.default_rng(1)
    nodes = np.array([[i, i + 1, i + 2] for i in range(30)])
    parts = rng.standard_normal((30, 6, 6))
    parts = parts @ parts.transpose(0, 2, 1)
    whole, mass = np.zeros((64, 64)), np.diag(rng.uniform(1, 2, 64))
    for at, part in zip(nodes, parts, strict=True):
        rows = (at[:, None] * 2 + [0, 1]).ravel()
        whole[np.ix_(rows, rows)] += part
    factor = Factor(Elements(nodes, np.c_[np.arange(30.0), np.zeros((30, 2))], 2, 32), parts, 4)
    right = rng.standard_normal((64, 3))
    assert np.allclose(whole @ factor.solve(right), right, atol=1e-8)
    values, vectors = lowest(factor.solve, lambda x: mass @ x, 64, 0.0, 8)
    assert np.allclose(values, eigh(whole, mass, eigvals_only=True)[:8], rtol=1e-8)
    assert np.allclose(vectors.T @ mass @ vectors, np.eye(8), atol=1e-8)


@pytest.mark.slow
def test_a_ball_rings_as_lambs_sphere_does():
    """The lowest spheroidal modes with motion along the normal: five of order 2, three of 1, ... at Lamb's roots."""
    ball = forms.ball(0.05, 4)
    own = cells.solve(Parts((ball,), (STEEL,)), sizing.sizes(ball, 30), 4, 40)
    closed = sphere(STEEL, radius=0.05, top=70_000.0).frequency
    scale = (volume_of(ball) / (4 / 3 * np.pi * 0.05**3)) ** (1 / 3)
    for frequency in closed[:3]:
        assert np.abs(own.frequency * scale / frequency - 1).min() < 4e-3
    fives = own.frequency[(np.abs(own.frequency * scale / closed[0] - 1) < 5e-3)]
    assert len(fives) == 5
    assert own.frequency[:6].max() < 1e-3 * closed[0]


@pytest.mark.slow
def test_a_bar_rings_as_caroms_own_bar_does():
    """Bending in both planes is Timoshenko's; the 4th and the 7th mode twist."""
    size = {"length": 0.24, "width": 0.03, "thickness": 0.01}
    block = forms.box(*size.values())
    found = cells.solve(Parts((block,), (STEEL,)), sizing.sizes(block, 78), 4, 17)
    closed = bar(STEEL, top=9000.0, **size)
    own = found.frequency[6:13]
    apart = np.abs(own / closed.frequency[: len(own)] - 1)
    assert apart.max() < 6e-3
    assert found.mass == pytest.approx(closed.mass, rel=2e-3)
    # At an end, in the middle of the face: the first mode's shape is a free bar's, 2/sqrt(m).
    tip = found.at(np.array([[0.12, 0.0, 0.0]]))[0, :, 6]
    assert np.linalg.norm(tip) == pytest.approx(2 / np.sqrt(closed.mass), rel=0.01)


def square_tube(side, wall, length):
    """Return the surface of a tube of four panels, each `side` (m) wide between the middles of its neighbours."""
    corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
    rings = [(side + wall, 0.0), (side + wall, length), (side - wall, 0.0), (side - wall, length)]
    points = np.vstack([np.c_[size * corner, np.full(4, height)] for size, height in rings])
    faces = []
    for k in range(4):
        n = (k + 1) % 4
        sides = (k, n, n + 4, k + 4), (n + 8, k + 8, k + 12, n + 12)
        for quad in (*sides, (n, k, k + 8, n + 8), (k + 4, n + 4, n + 12, k + 12)):
            faces += [quad[:3], (quad[0], *quad[2:])]
    return Surface(points, np.array(faces))


@pytest.mark.slow
def test_panels_of_a_square_tube_bend_as_clamped_and_supported_plates_do():
    # The panels' centres move outward together: by symmetry no corner turns. In and out by turns: no corner holds.
    side, wall = 0.06, 0.002
    material = Material("steel", 7850.0, 200e9, 0.3, 1.0, 0.0)
    body = square_tube(side, wall, side)
    found = cells.solve(Parts((body,), (material,)), sizing.sizes(body, 50), 4, 16)
    out = np.array([[0, -1, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0]])
    moves = np.einsum("pin,pi->np", found.at(out * (side + wall) / 2 + [0, 0, side / 2]), out)
    moves /= np.abs(moves).max(axis=1)[:, None]
    stiff = 200e9 * wall**3 / 12 / (1 - 0.3**2)
    unit = np.sqrt(stiff / (7850 * wall)) / (2 * np.pi * side**2)
    # A. Leissa, Vibration of Plates, NASA SP-160, 1969: squares, two sides free, two clamped or supported.
    for signs, factor in (([1, 1, 1, 1], 22.272), ([1, -1, 1, -1], 9.6314)):
        first = np.flatnonzero((found.frequency > 1.0) & (np.abs(moves @ signs) > 3.5))[0]
        assert found.frequency[first] == pytest.approx(factor * unit, rel=0.04), signs
