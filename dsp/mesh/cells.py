"""Finite cells: the modes of a solid, or of a thick sheet, on a grid of cubes that needs no mesh of its own.

The displacement is a polynomial in each cube; the body is met by the quadrature alone (J. Parvizian, A. Duester,
E. Rank, Comput. Mech. 41, 2007). Outside, a stiffness of at most 1e-6 of the body's and no mass keep the system
definite. The body is turned against the grid, so that its flat faces don't lie along the rays.
"""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array, Material
from .forms import together
from .fronts import Elements, Factor
from .lanczos import lowest
from .parts import Parts
from .polynomials import gauss, integrals, moments, products
from .rays import Grid, Quadrature, grid_about, quadrature
from .sheets import of_sheet
from .surface import Indices, MeshError, Surface, faces_of, rotation, volume_of

TILT = rotation((0.11, 0.13, 0.17))
"""The turn of the body against the grid: of angles that no body has."""

_VOID = 1e-6  # of the stiffness: outside of the body
_SLIVER = 1e-2  # of the stiffness, times the cube of the filling: of cells that hold little
_LEAST_FILLED = 1e-3  # of a cell
_THIN = 0.3  # of a cell's side: sheets are thinner
_BENT = 0.01  # of a cell's volume, with normals over 45 degrees from the first direction: where sheets meet
_LEFT = 0.4  # share of the stiffness along a sheet's normal that stays, over (thickness/side of a cell)^2
_AGREED = 0.02  # of the volume, by triangles and by rays: within that the triangles' counts
_SHIFT = 0.02  # of a wave's frequency along the body
_SIZES = 24  # halvings
_SAMPLES = 30_000
_RAYS = (24, 40)  # of a cell: the fewest, the most
_THROUGH = 4  # rays through a wall


class Mesh(NamedTuple):
    """The cells in use: their numbers, indices (e, 3), nodes (e, m) and how many nodes there are."""

    grid: Grid
    degree: int
    cells: Indices
    at: Indices
    nodes: Indices
    size: int


class Points(NamedTuple):
    """Points of a quadrature: places and normals (n, 3), weights (n,) in m^3, numbers of cells and materials (n,), how
    far (m) the body reaches along the normals there."""

    places: Array
    weights: Array
    cells: Indices
    of: Indices
    normals: Array
    through: Array

    def part(self, begin: int, end: int) -> "Points":
        """Return some that follow each other."""
        return Points(
            self.places[begin:end],
            self.weights[begin:end],
            self.cells[begin:end],
            self.of[begin:end],
            self.normals[begin:end],
            self.through[begin:end],
        )


class _Piece(NamedTuple):
    """The share of one material in a cell: the cell's place among those in use, the material's number, stiffness."""

    number: int
    of: int
    stiffness: Array


class Solution(NamedTuple):
    """Modes on cells: frequencies (n,) in Hz and displacements (nodes, 3, n) of unit modal mass, the cells, the body's
    mass (kg) and volume (m^3), the share of rays that met a gap, and the share (materials, n) of each material in the
    energy that bends the body."""

    frequency: Array
    displacement: Array
    mesh: Mesh
    mass: float
    volume: float
    leaks: float
    energy: Array

    def at(self, points: Array) -> Array:
        """Return the shapes (points, 3, n) in kg^-1/2 at points of the body (points, 3)."""
        from scipy.sparse import csr_array
        from scipy.spatial import cKDTree

        mesh, grid = self.mesh, self.mesh.grid
        places = points @ TILT.T
        numbers = grid.number(places)
        element = np.clip(np.searchsorted(mesh.cells, numbers), 0, len(mesh.cells) - 1)
        outside = mesh.cells[element] != numbers
        if outside.any():
            middles = grid.corner + grid.side * (mesh.at + 0.5)
            element[outside] = cKDTree(middles).query(places[outside])[1]
        values = products((places - grid.corner) / grid.side - mesh.at[element], mesh.degree)[0]
        rows = np.arange(0, values.size + 1, values.shape[1])
        weights = csr_array((values.ravel(), mesh.nodes[element].ravel(), rows), shape=(len(points), mesh.size))
        found: Array = (weights @ self.displacement.reshape(mesh.size, -1)).reshape(len(points), 3, -1)
        return found


class Sizes(NamedTuple):
    """The side of cells (m), rays through each, and the body's thickness (m): twice its volume over its area."""

    side: float
    rays: int
    thickness: float


def sizes(surface: Surface, cells: int, wall: float | None = None) -> Sizes:
    """Return sizes for about so many cells."""
    turned = Surface(surface.points @ TILT.T, surface.faces)
    areas = faces_of(turned).areas
    total = float(areas.sum())
    volume = volume_of(turned) if wall is None else wall * total
    rng = np.random.default_rng(0)
    face = rng.choice(len(areas), _SAMPLES, p=areas / total)
    places = np.einsum("ij,ijk->ik", rng.dirichlet((1, 1, 1), _SAMPLES), turned.points[turned.faces[face]])
    low, high = 1e-3 * float(np.ptp(turned.points)), float(np.ptp(turned.points))
    for _ in range(_SIZES):
        side = np.sqrt(low * high)
        grid = grid_about(turned, side, 1)
        crossed = len(np.unique(grid.number(places)))
        if crossed + (max(0.0, volume / side**3 - crossed / 2) if wall is None else 0) > cells:
            low = side
        else:
            high = side
    thickness = 2 * volume / total
    return Sizes(high, int(np.clip(np.ceil(high * _THROUGH / thickness), *_RAYS)), thickness)


def solve(parts: Parts, size: Sizes, degree: int, count: int) -> Solution:
    """Return a solid's `count` lowest modes, rigid motions among them."""
    turned = [Surface(each.points @ TILT.T, each.faces) for each in parts.surfaces]
    grid = grid_about(together(*turned), size.side, size.rays)
    inside = []
    for number, own in enumerate(turned):
        found = quadrature(own, grid, degree, together(*turned[:number]) if number else None)
        true, weight = volume_of(own), float(found.weights.sum())
        got = weight + len(found.full) * grid.side**3
        if abs(got / true - 1) < _AGREED:
            found = found._replace(weights=found.weights * (1 + (true - got) / max(weight, 1e-300)))
        inside.append(found)
    if not any(len(each.weights) or len(each.full) for each in inside):
        raise MeshError("no ray meets the inside: expected a closed surface with a thickness")
    return of_points(inside, grid, parts.materials, degree, count)


def solve_sheet(parts: Parts, wall: float, size: Sizes, degree: int, count: int) -> Solution:
    """Return the lowest modes of a sheet of a wall (m) about surfaces."""
    turned = [Surface(each.points @ TILT.T, each.faces) for each in parts.surfaces]
    grid = grid_about(together(*turned), size.side, size.rays, wall)
    return of_points([of_sheet(each, wall, grid, degree) for each in turned], grid, parts.materials, degree, count)


def of_points(
    inside: list[Quadrature], grid: Grid, materials: tuple[Material, ...], degree: int, count: int
) -> Solution:
    """Return the modes of a body that quadratures stand for, one for each of its materials."""
    of = np.repeat(np.arange(len(inside)), [len(each.cells) for each in inside])
    places, weights, cells, normals, through = (
        np.concatenate([getattr(each, name) for each in inside])
        for name in ("places", "weights", "cells", "normals", "through")
    )
    order = np.argsort(cells * len(inside) + of, kind="stable")
    volumes = np.bincount(cells, weights, int(grid.counts.prod()))
    full = np.concatenate([each.full for each in inside])
    numbers = np.sort(np.r_[np.flatnonzero(volumes > _LEAST_FILLED * grid.side**3), full])
    mesh = _mesh(grid, degree, numbers)
    points = Points(places[order], weights[order], cells[order], of[order], normals[order], through[order])
    stiffness, mass, pieces = _matrices(mesh, points, [each.full for each in inside], materials)
    elements = Elements(mesh.nodes, grid.corner + grid.side * (mesh.at + 0.5), 3, mesh.size)
    length = float((mesh.at.max(axis=0) - mesh.at.min(axis=0) + 1).max()) * grid.side
    speed = max(np.sqrt(each.youngs_modulus / each.density) for each in materials)
    shift = (2 * np.pi * _SHIFT * speed / length) ** 2
    values, vectors = _modes(elements, stiffness, mass, shift, count)
    displacement = np.einsum("ij,aim->ajm", TILT, vectors.reshape(mesh.size, 3, -1))
    kept = np.isin(points.cells, mesh.cells)
    cubes = np.array([len(each.full) for each in inside]) * grid.side**3
    volume = np.bincount(points.of[kept], points.weights[kept], len(inside)) + cubes
    total = sum(each.density * float(own) for each, own in zip(materials, volume, strict=True))
    energy = np.ones((1, len(values)))
    if len(materials) > 1:
        energy = _energies(mesh, pieces, vectors, len(materials))
    leaks = max(each.leaks for each in inside)
    frequency = np.sqrt(np.maximum(values, 0)) / (2 * np.pi)
    return Solution(frequency, displacement, mesh, total, float(volume.sum()), leaks, energy)


def _mesh(grid: Grid, degree: int, numbers: Indices) -> Mesh:
    """Return the cells with their nodes numbered."""
    at = grid.cell(numbers)
    steps = np.arange(degree + 1)
    local = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    nodes = at[:, None] * degree + local
    most = grid.counts * degree + 1
    keys = (nodes[..., 0] * most[1] + nodes[..., 1]) * most[2] + nodes[..., 2]
    names, numbered = np.unique(keys, return_inverse=True)
    return Mesh(grid, degree, numbers, at, numbered.reshape(keys.shape).astype(np.int64), len(names))


def _matrices(
    mesh: Mesh, points: Points, full: list[Indices], materials: tuple[Material, ...]
) -> tuple[Array, Array, list[_Piece]]:
    """Return the stiffness (e, 3 m, 3 m) and the mass (e, m, m) of each cell, and the pieces of cells that hold several
    materials. full: numbers of the cells that are full of each material."""
    side, degree = mesh.grid.side, mesh.degree
    nodes, weights = gauss(degree + 1)
    at = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 3)
    cube = (weights[:, None, None] * weights[:, None] * weights).ravel() * side**3
    whole = [_of_cell(at, cube, mesh, material) for material in materials]
    stiffness = np.zeros((len(mesh.cells), *whole[0][0].shape))
    mass = np.zeros((len(mesh.cells), *whole[0][1].shape))
    filled, last = np.zeros(len(mesh.cells)), np.zeros(len(mesh.cells), np.int64)
    pieces = []
    for begin, end in _spans(mesh, points):
        own = points.part(begin, end)
        number, of = int(np.searchsorted(mesh.cells, own.cells[0])), int(own.of[0])
        stiff, heavy = _of_piece(own, mesh, number, materials[of])
        stiffness[number] += stiff
        mass[number] += heavy
        filled[number] += float(own.weights.sum()) / side**3
        last[number] = of
        if len(materials) > 1:
            pieces.append(_Piece(number, of, stiff))
    for number, share in enumerate(filled):
        stiffness[number] += min(_VOID, _SLIVER * share**3) * whole[last[number]][0]
    for of, cells in enumerate(full):
        for number in np.searchsorted(mesh.cells, cells):
            stiffness[number], mass[number] = whole[of]
            if len(materials) > 1:
                pieces.append(_Piece(int(number), of, whole[of][0]))
    return stiffness, mass, pieces


def _spans(mesh: Mesh, points: Points) -> list[tuple[int, int]]:
    """Return where the points of each cell that is in use and of each of its materials begin and end."""
    change = (np.diff(points.cells) != 0) | (np.diff(points.of) != 0)
    begin = np.r_[0, np.flatnonzero(change) + 1][: len(points.cells)]
    end = np.r_[begin[1:], len(points.cells)][: len(begin)]
    used = np.isin(points.cells[begin], mesh.cells)
    return list(zip(begin[used].tolist(), end[used].tolist(), strict=True))


def _of_piece(own: Points, mesh: Mesh, number: int, material: Material) -> tuple[Array, Array]:
    """Return the stiffness and the mass of a cell's points of one material."""
    grid = mesh.grid
    places = (own.places - grid.corner) / grid.side - mesh.at[number]
    stiffness, mass = _of_cell(places, own.weights, mesh, material)
    thickness = float(np.median(own.through)) / grid.side
    if thickness < _THIN and _is_bent(own.weights, own.normals):
        share = 1 - _LEFT * thickness**2
        stiffness -= share * _held_across(places, own.weights, own.normals, mesh, material)
    return stiffness, mass


def _energies(mesh: Mesh, pieces: list[_Piece], vectors: Array, count: int) -> Array:
    """Return the share (count, n) of each material in the energy that bends the body, of each mode."""
    shapes = vectors.reshape(mesh.size, 3, -1)
    found = np.zeros((count, shapes.shape[2]))
    for piece in pieces:
        moved = shapes[mesh.nodes[piece.number]].reshape(-1, shapes.shape[2])
        found[piece.of] += np.einsum("an,an->n", moved, piece.stiffness @ moved)
    return np.asarray(found / np.maximum(found.sum(axis=0), 1e-300))


def _of_cell(places: Array, weights: Array, mesh: Mesh, material: Material) -> tuple[Array, Array]:
    """Return the stiffness and the mass of a cell that is met at places (n, 3) of it, 0 to 1, with weights in m^3."""
    degree = mesh.degree
    of, count = moments(places, weights, degree), (degree + 1) ** 3
    nu = material.poisson_ratio
    mu = material.youngs_modulus / (2 * (1 + nu)) / mesh.grid.side**2
    lame = 2 * mu * nu / (1 - 2 * nu)
    stiffness, trace = np.empty((count, 3, count, 3)), np.zeros((count, count))
    for i in range(3):
        for j in range(i, 3):
            pair = integrals(of, degree, (i, j))
            stiffness[:, i, :, j] = lame * pair + mu * pair.T
            if i != j:
                stiffness[:, j, :, i] = stiffness[:, i, :, j].T
            else:
                trace += pair
    for axis in range(3):
        stiffness[:, axis, :, axis] += mu * trace
    return stiffness.reshape(3 * count, 3 * count), material.density * integrals(of, degree)


def _is_bent(weights: Array, normals: Array) -> bool:
    """Return whether sheets meet at an angle in a cell, by the normals (n, 3) at its points."""
    first = np.linalg.eigh(np.einsum("p,pi,pj->ij", weights, normals, normals))[1][:, 2]
    return bool(weights[(normals @ first) ** 2 < 0.5].sum() > _BENT * weights.sum())


def _held_across(places: Array, weights: Array, normals: Array, mesh: Mesh, material: Material) -> Array:
    """Return the stiffness (3 m, 3 m) by which a cell's polynomials resist where sheets may yield: that of the stress
    along their normals (n, 3), which is none in a thin sheet.

    Where it is left, sheets that meet don't bend near their edge: the curvature of each would stretch the other across.
    """
    nu = material.poisson_ratio
    mu = material.youngs_modulus / (2 * (1 + nu))
    lame = 2 * mu * nu / (1 - 2 * nu)
    slopes = products(places, mesh.degree)[1] / mesh.grid.side
    along = np.einsum("inm,ni->nm", slopes, normals)
    stress = lame * slopes.transpose(1, 2, 0) + 2 * mu * along[:, :, None] * normals[:, None, :]
    share = np.sqrt(weights / (lame + 2 * mu))
    scaled = share[:, None] * stress.reshape(len(normals), -1)
    held: Array = scaled.T @ scaled
    return held


def _modes(elements: Elements, stiffness: Array, mass: Array, shift: float, count: int) -> tuple[Array, Array]:
    """Return eigenvalues and vectors of elements whose mass is the same for all three directions."""
    from scipy.sparse import csr_array

    nodes, size = elements.nodes, elements.size
    gather = csr_array((np.ones(nodes.size), (nodes.ravel(), np.arange(nodes.size))), shape=(size, nodes.size))
    cells, m = nodes.shape
    blocks = stiffness.reshape(cells, m, 3, m, 3)
    for axis in range(3):
        blocks[:, :, axis, :, axis] += shift * mass
    factor = Factor(elements, stiffness, max(1, 64 // m * 4))

    def weigh(x: Array) -> Array:
        each = np.matmul(mass, x.reshape(size, -1)[nodes])
        weighed: Array = (gather @ each.reshape(nodes.size, -1)).reshape(3 * size, -1)
        return weighed

    return lowest(factor.solve, weigh, 3 * size, shift, count)
