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
from .grading import extrapolated, graded, hollow, places_on
from .grids import Grid, grid_about
from .lanczos import lowest
from .numbering import Mesh, mesh_of
from .parts import Parts
from .pieces import Pieces, divided, undivided
from .polynomials import cube_of, gauss, integrals, lobatto, moments, products
from .rays import Quadrature, quadrature
from .sheets import of_sheet
from .surface import Indices, MeshError, Surface, faces_of, rotation, volume_of

TILT = rotation((0.11, 0.13, 0.17))
"""The turn of the body against the grid: of angles that no body has."""

_VOID = 1e-6  # of the stiffness: outside of the body
_SLIVER = 1e-2  # of the stiffness, times the cube of the filling: of cells that hold little
_FAR = 1e-10  # of the stiffness: of nodes that hardly move a cell's part of the body
_LEAST_FILLED = 1e-3  # of a cell
_BENT = 0.01  # of a cell's volume, with normals over 45 degrees from the first direction: where sheets meet
_AGREED = 0.02  # of the volume, by triangles and by rays: within that the triangles' counts
_NOWHERE = np.zeros(0, np.int64)
_SHIFT = 0.02  # of a wave's frequency along the body
_AT_ONCE = 256  # points of a cell
_SIZES = 14  # halvings
_SAMPLES = 30_000
_SHARES, _FINE_SHARES = (0.8, 0.6), (1.0, 0.8, 0.6, 0.45)  # of cells that are all alike: before they are halved
_MORE = 2.4  # times as many cells as if all were alike, those of a second grid among them
_HALVINGS = 3
_RESOLVED = 0.2  # of the smallest cells' sides: the body is thicker
_RAYS = (24, 40)  # of a cell: the fewest, the most
_THROUGH = 4  # rays through a wall


class _Law(NamedTuple):
    """The share of the stiffness across walls that stays where they meet in a cell: a factor times a power of
    thickness/side, below a bound of it."""

    factor: float
    power: float
    most: float


_WHERE_BENT = _Law(3.0, 3, 0.3)
_AT_EDGES = _Law(0.4, 2, 1.0)
"""The laws of large cells, rims and outer edges among them, and of small ones at inner edges. At these a corner in
plane strain then yields as the solid does, in the mean over where it lies in its cell. At a rim nothing has to yield,
and a curved wall must not; but large cells are too stiff where it curves."""


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


class _Share(NamedTuple):
    """The share of one material in a cell: the cell's place among those in use, the material's number, stiffness."""

    number: int
    of: int
    stiffness: Array


class Solution(NamedTuple):
    """Modes on cells: frequencies (n,) in Hz and displacements (nodes, 3, n) of unit modal mass, the cells, the body's
    mass (kg) and volume (m^3), the share of rays that met a gap, the share (materials, n) of each material in the
    energy that bends the body, and the cells' masses (e, m, m). inside (e, 3): a place of the body in each."""

    frequency: Array
    displacement: Array
    mesh: Mesh
    mass: float
    volume: float
    leaks: float
    energy: Array
    masses: Array
    inside: Array

    def at(self, points: Array) -> Array:
        """Return the shapes (points, 3, n) in kg^-1/2 at points of the body (points, 3)."""
        from scipy.sparse import csr_array
        from scipy.spatial import cKDTree

        mesh = self.mesh
        places = points @ TILT.T
        element = mesh.elements(places)
        outside = element < 0
        if outside.any():
            middles = mesh.corners + mesh.sides[:, None] / 2
            element[outside] = cKDTree(middles).query(places[outside])[1]
        values = products((places - mesh.corners[element]) / mesh.sides[element, None], mesh.degree)[0]
        by_nodes = np.zeros((len(points), mesh.nodes.shape[1])) if mesh.ties else values
        for number, tie in mesh.ties.items():
            by_nodes[element == number] = values[element == number] @ tie
        values = by_nodes
        rows = np.arange(0, values.size + 1, values.shape[1])
        weights = csr_array((values.ravel(), mesh.nodes[element].ravel(), rows), shape=(len(points), mesh.size))
        found: Array = (weights @ self.displacement.reshape(mesh.size, -1)).reshape(len(points), 3, -1)
        return found


class Sizes(NamedTuple):
    """The side of cells (m), rays through each, and the body's thickness (m): twice its volume over its area. How often
    cells at inner edges are halved, and whether the last halving tells the error that is left; whether walls yield
    across at inner edges alone."""

    side: float
    rays: int
    thickness: float
    halvings: int = 0
    told: bool = False
    edges: bool = False


def sizes(surface: Surface, cells: int, wall: float | None = None) -> Sizes:
    """Return sizes for about so many cells, all alike."""
    turned = Surface(surface.points @ TILT.T, surface.faces)
    total = float(faces_of(turned).areas.sum())
    volume = volume_of(turned) if wall is None else wall * total
    places, _ = places_on(turned, _SAMPLES)
    low, high = 1e-3 * float(np.ptp(turned.points)), float(np.ptp(turned.points))
    for _ in range(_SIZES):
        side = np.sqrt(low * high)
        if _count(grid_about(turned, side, 1), places, volume if wall is None else 0.0) > cells:
            low = side
        else:
            high = side
    thickness = 2 * volume / total
    return Sizes(high, int(np.clip(np.ceil(high * _THROUGH / thickness), *_RAYS)), thickness)


def graded_sizes(surface: Surface, cells: int, fine: bool) -> Sizes:
    """Return sizes for a solid: where it has inner edges, of large cells that are halved there, as far as that takes no
    more time than some twice as many cells that are all alike."""
    turned = Surface(surface.points @ TILT.T, surface.faces)
    places, _ = places_on(turned, _SAMPLES)
    best = None
    for share in _FINE_SHARES if fine else _SHARES:
        size = sizes(surface, int(share * cells))
        grids = graded(grid_about(turned, size.side, size.rays), turned, _HALVINGS)
        counts = [_count(each, places, volume_of(turned)) for each in grids]
        for halvings in range(1, len(grids)):
            told = halvings > 1
            takes = counts[halvings] + told * counts[halvings - 1]
            resolved = size.thickness > _RESOLVED * size.side / 2**halvings
            if resolved and takes < _MORE * cells and (not best or halvings > best.halvings):
                best = size._replace(halvings=halvings, told=told)
    return (best or sizes(surface, cells))._replace(edges=fine)


def _count(grid: Grid, places: Array, volume: float) -> float:
    """Return about how many cells hold a body of a volume (m^3) with such places on its surface."""
    crossed = np.unique(grid.number(places))
    inside = volume / grid.side**3 - float((grid.sides[crossed] ** 3).sum()) / grid.side**3 / 2
    return len(crossed) + max(0.0, inside)


def solve(parts: Parts, size: Sizes, degree: int, count: int) -> Solution:
    """Return a solid's `count` lowest modes, rigid motions among them."""
    turned = [Surface(each.points @ TILT.T, each.faces) for each in parts.surfaces]
    whole = together(*turned)
    grids = graded(grid_about(whole, size.side, size.rays), whole, size.halvings)
    if not size.told or len(grids) == 1:
        pieces, inside = _in_pieces(turned, grids[-1], _inside(turned, grids[-1], degree))
        where = _NOWHERE if size.told else hollow(whole, grids[-1]) if size.edges else None
        return of_points(inside, pieces, parts.materials, degree, count, where)
    coarse = _inside(turned, grids[-2], degree)
    fine = _inside(turned, grids[-1], degree, coarse)
    found = []
    for grid, met in ((grids[-2], coarse), (grids[-1], fine)):
        pieces, inside = _in_pieces(turned, grid, met)
        if grid is grids[-1] or not pieces.gaps:  # how far a gap goes in the cell that it ends in is chance
            found.append(of_points(inside, pieces, parts.materials, degree, count, _NOWHERE))
    if len(found) == 1:
        return found[0]
    frequency = extrapolated(found[0].frequency, found[1].frequency, _shared(*found) ** 2)
    return found[1]._replace(frequency=frequency)


def _shared(one: Solution, other: Solution) -> Array:
    """Return the integrals (n, m) of the products of two solutions' modes, times the density. The other one's cells are
    those of the first, or parts of them."""
    mesh, moved = other.mesh, _moved(one, other)
    found = np.zeros((moved.shape[2], other.displacement.shape[2]))
    for nodes, mass in zip(mesh.nodes, other.masses, strict=True):
        heavy = (mass @ other.displacement[nodes].reshape(len(nodes), -1)).reshape(3 * len(nodes), -1)
        found += moved[nodes].reshape(3 * len(nodes), -1).T @ heavy
    return found


def _moved(one: Solution, other: Solution) -> Array:
    """Return the shapes (nodes, 3, n) of a solution at the nodes of another one, whose cells are its own, or parts."""
    mesh, coarse = other.mesh, one.mesh
    local = cube_of(lobatto(mesh.degree))
    found = np.zeros((mesh.size, 3, one.displacement.shape[2]))
    for row, (nodes, of) in enumerate(zip(mesh.nodes, coarse.elements(other.inside).tolist(), strict=True)):
        if of < 0:
            continue
        places = (mesh.corners[row] + mesh.sides[row] * local - coarse.corners[of]) / coarse.sides[of]
        values = products(places, mesh.degree)[0]
        shapes = np.tensordot(values @ coarse.ties.get(of, np.eye(len(local))), one.displacement[coarse.nodes[of]], 1)
        tie = mesh.ties.get(row, np.eye(len(local)))
        own, node = np.nonzero((tie == 1) & (np.count_nonzero(tie, axis=1) == 1)[:, None])
        found[nodes[node]] = shapes[own]
    return found


def _inside(turned: list[Surface], grid: Grid, degree: int, coarse: list[Quadrature] | None = None) -> list[Quadrature]:
    """Return the points inside of each of the parts that are turned against a grid; coarse: those on a grid that is one
    halving behind it."""
    found = []
    for number, own in enumerate(turned):
        without = together(*turned[:number]) if number else None
        found.append(quadrature(own, grid, degree, without, coarse[number] if coarse else None))
    if not any(len(each.weights) or len(each.full) for each in found):
        raise MeshError("no ray meets the inside: expected a closed surface with a thickness")
    return found


def _in_pieces(turned: list[Surface], grid: Grid, inside: list[Quadrature]) -> tuple[Pieces, list[Quadrature]]:
    """Return the pieces of the parts, and the points inside of them, which have the volume that the triangles tell."""
    weighed = []
    for own, found in zip(turned, inside, strict=True):
        true, weight = volume_of(own), float(found.weights.sum())
        got = weight + float((grid.sides[found.full] ** 3).sum())
        right = (true - got) / max(weight, 1e-300) if abs(got / true - 1) < _AGREED else 0.0
        weighed.append(found._replace(weights=found.weights * (1 + right)))
    return divided(together(*turned), grid, weighed, _LEAST_FILLED)


def solve_sheet(parts: Parts, wall: float, size: Sizes, degree: int, count: int) -> Solution:
    """Return the lowest modes of a sheet of a wall (m) about surfaces."""
    turned = [Surface(each.points @ TILT.T, each.faces) for each in parts.surfaces]
    grid = grid_about(together(*turned), size.side, size.rays, wall)
    inside = [of_sheet(each, wall, grid, degree) for each in turned]
    return of_points(inside, undivided(grid), parts.materials, degree, count)


def of_points(
    inside: list[Quadrature],
    pieces: Pieces,
    materials: tuple[Material, ...],
    degree: int,
    count: int,
    yielding: Indices | None = None,
) -> Solution:
    """Return the modes of a body that quadratures stand for, one for each of its materials. yielding: the cells, at
    inner edges, in which walls that meet yield across; None: all in which they do."""
    grid = pieces.grid
    of = np.repeat(np.arange(len(inside)), [len(each.cells) for each in inside])
    places, weights, cells, normals, through = (
        np.concatenate([getattr(each, name) for each in inside])
        for name in ("places", "weights", "cells", "normals", "through")
    )
    order = np.argsort(cells * len(inside) + of, kind="stable")
    volumes = np.bincount(cells, weights, grid.size)
    full = np.concatenate([each.full for each in inside])
    numbers = np.sort(np.r_[np.flatnonzero(volumes > _LEAST_FILLED * grid.sides**3), full])
    if not len(numbers):
        side = f"{1e3 * grid.sides.max():.3g} mm"
        raise MeshError(f"walls too thin for cells of {side}: expected thicker ones, or their wall (m), of a sheet")
    mesh = mesh_of(pieces, degree, numbers)
    points = Points(places[order], weights[order], cells[order], of[order], normals[order], through[order])
    laws: list[_Law | None] = [_WHERE_BENT] * len(mesh.cells)
    if yielding is not None:
        at_edges = np.isin(grid.number(mesh.corners + mesh.sides[:, None] / 2), yielding)
        laws = [_AT_EDGES if each else None for each in at_edges]
    stiffness, mass, shares = _matrices(mesh, points, [each.full for each in inside], materials, laws)
    elements = Elements(mesh.nodes, mesh.corners + mesh.sides[:, None] / 2, 3, mesh.size)
    length = float(((mesh.corners + mesh.sides[:, None]).max(axis=0) - mesh.corners.min(axis=0)).max())
    speed = max(np.sqrt(each.youngs_modulus / each.density) for each in materials)
    shift = (2 * np.pi * _SHIFT * speed / length) ** 2
    values, vectors = _modes(elements, stiffness, mass, shift, count)
    displacement = np.einsum("ij,aim->ajm", TILT, vectors.reshape(mesh.size, 3, -1))
    kept = np.isin(points.cells, mesh.cells)
    cubes = np.array([float((grid.sides[each.full] ** 3).sum()) for each in inside])
    volume = np.bincount(points.of[kept], points.weights[kept], len(inside)) + cubes
    total = sum(each.density * float(own) for each, own in zip(materials, volume, strict=True))
    energy = np.ones((1, len(values)))
    if len(materials) > 1:
        energy = _energies(mesh, shares, vectors, len(materials))
    leaks = max(each.leaks for each in inside)
    frequency, within = np.sqrt(np.maximum(values, 0)) / (2 * np.pi), _within(mesh, points)
    return Solution(frequency, displacement, mesh, total, float(volume.sum()), leaks, energy, mass, within)


def _within(mesh: Mesh, points: Points) -> Array:
    """Return a place (e, 3) of the body in each cell in use: the middle of those that are full."""
    found = mesh.corners + mesh.sides[:, None] / 2
    order = np.argsort(points.weights, kind="stable")
    row = np.searchsorted(mesh.cells, points.cells[order])
    some = mesh.cells[np.minimum(row, len(mesh.cells) - 1)] == points.cells[order]
    found[row[some]] = points.places[order[some]]
    return found


def _matrices(
    mesh: Mesh, points: Points, full: list[Indices], materials: tuple[Material, ...], laws: list[_Law | None]
) -> tuple[Array, Array, list[_Share]]:
    """Return the stiffness (e, 3 m, 3 m) and the mass (e, m, m) of each cell, and the pieces of cells that hold several
    materials. full: numbers of the cells that are full of each material; laws: by which walls yield in each cell."""
    degree = mesh.degree
    nodes, weights = gauss(degree + 1)
    at = cube_of(nodes)
    cube = (weights[:, None, None] * weights[:, None] * weights).ravel()
    whole = [_of_cell(at, cube, 1.0, degree, material) for material in materials]
    wide = mesh.nodes.shape[1]
    stiffness, mass = np.zeros((len(mesh.cells), 3 * wide, 3 * wide)), np.zeros((len(mesh.cells), wide, wide))
    filled, last = np.zeros(len(mesh.cells)), np.zeros(len(mesh.cells), np.int64)
    pieces = []

    def add(number: int, of: int, stiff: Array, heavy: Array) -> None:
        stiff, heavy = _by_nodes(mesh, number, stiff), _by_nodes(mesh, number, heavy)
        stiffness[number] += stiff
        mass[number] += heavy
        if len(materials) > 1:
            pieces.append(_Share(number, of, stiff))

    for begin, end in _spans(mesh, points):
        own = points.part(begin, end)
        number, of = int(np.searchsorted(mesh.cells, own.cells[0])), int(own.of[0])
        add(number, of, *_of_piece(own, mesh, number, materials[of], laws[number]))
        filled[number] += float(own.weights.sum()) / mesh.sides[number] ** 3
        last[number] = of
    for of, cells in enumerate(full):
        for number in np.searchsorted(mesh.cells, cells):
            side = mesh.sides[number]
            add(int(number), of, side * whole[of][0], side**3 * whole[of][1])
            filled[number] = 1.0
    for number, share in enumerate(filled):
        if share < 1:
            soft = min(_VOID, _SLIVER * share**3) * mesh.sides[number]
            stiffness[number] += _by_nodes(mesh, number, soft * whole[last[number]][0])
    # Of a large cube a small one beside it, across a gap, may have nodes alone: from its own part they are far.
    alone = np.bincount(mesh.nodes.ravel(), minlength=mesh.size) == 1
    for number in mesh.ties:
        rows = np.flatnonzero(np.repeat(alone[mesh.nodes[number]], 3))
        stiffness[number, rows, rows] += _FAR * mesh.sides[number] * whole[last[number]][0].max()
    return stiffness, mass, pieces


def _by_nodes(mesh: Mesh, number: int, matrix: Array) -> Array:
    """Return a matrix of a cell's polynomials (d m, d m), whose last axis runs fastest, by the cell's nodes."""
    tie = mesh.ties.get(number)
    if tie is None:
        return matrix
    d = len(matrix) // len(tie)
    half = np.einsum("man,mb->ban", matrix.reshape(len(tie), d, -1), tie, optimize=True).reshape(-1, len(tie), d)
    found: Array = np.einsum("rma,mb->rba", half, tie, optimize=True).reshape(len(half), -1)
    return found


def _spans(mesh: Mesh, points: Points) -> list[tuple[int, int]]:
    """Return where the points of each cell that is in use and of each of its materials begin and end."""
    change = (np.diff(points.cells) != 0) | (np.diff(points.of) != 0)
    begin = np.r_[0, np.flatnonzero(change) + 1][: len(points.cells)]
    end = np.r_[begin[1:], len(points.cells)][: len(begin)]
    used = np.isin(points.cells[begin], mesh.cells)
    return list(zip(begin[used].tolist(), end[used].tolist(), strict=True))


def _of_piece(own: Points, mesh: Mesh, number: int, material: Material, law: _Law | None) -> tuple[Array, Array]:
    """Return the stiffness and the mass of a cell's points of one material."""
    side = float(mesh.sides[number])
    places = (own.places - mesh.corners[number]) / side
    stiffness, mass = _of_cell(places, own.weights, side, mesh.degree, material)
    thickness = float(np.median(own.through)) / side
    if law and thickness < law.most and _is_bent(own.weights, own.normals):
        share = 1 - law.factor * thickness**law.power
        stiffness -= share * _held_across(own._replace(places=places), side, mesh.degree, material)
    return stiffness, mass


def _energies(mesh: Mesh, pieces: list[_Share], vectors: Array, count: int) -> Array:
    """Return the share (count, n) of each material in the energy that bends the body, of each mode."""
    shapes = vectors.reshape(mesh.size, 3, -1)
    found = np.zeros((count, shapes.shape[2]))
    for piece in pieces:
        moved = shapes[mesh.nodes[piece.number]].reshape(-1, shapes.shape[2])
        found[piece.of] += np.einsum("an,an->n", moved, piece.stiffness @ moved)
    return np.asarray(found / np.maximum(found.sum(axis=0), 1e-300))


def _of_cell(places: Array, weights: Array, side: float, degree: int, material: Material) -> tuple[Array, Array]:
    """Return the stiffness and the mass of a cell that is met at places (n, 3) of it, 0 to 1, with weights in m^3."""
    of, count = moments(places, weights, degree), (degree + 1) ** 3
    nu = material.poisson_ratio
    mu = material.youngs_modulus / (2 * (1 + nu)) / side**2
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
    """True if sheets meet at an angle in a cell, by the normals (n, 3) at its points."""
    first = np.linalg.eigh(np.einsum("p,pi,pj->ij", weights, normals, normals))[1][:, 2]
    return bool(weights[(normals @ first) ** 2 < 0.5].sum() > _BENT * weights.sum())


def _held_across(own: Points, side: float, degree: int, material: Material) -> Array:
    """Return the stiffness (3 m, 3 m) by which a cell's polynomials resist where sheets may yield: that of the stress
    along their normals (n, 3), which is none in a thin sheet.

    Where it is left, sheets that meet don't bend near their edge: the curvature of each would stretch the other across.
    """
    from scipy.linalg.blas import dsyrk

    nu = material.poisson_ratio
    mu = material.youngs_modulus / (2 * (1 + nu))
    lame = 2 * mu * nu / (1 - 2 * nu)
    half = np.zeros((3 * (degree + 1) ** 3,) * 2, order="F")
    for begin in range(0, len(own.weights), _AT_ONCE):
        some = own.part(begin, begin + _AT_ONCE)
        share = np.sqrt(some.weights / (lame + 2 * mu)) / side
        slopes = products(some.places, degree)[1]
        across = np.einsum("inm,ni->nm", slopes, 2 * mu * share[:, None] * some.normals)
        scaled = np.empty((*across.shape, 3))
        for axis in range(3):
            scaled[:, :, axis] = across * some.normals[:, axis, None]
            scaled[:, :, axis] += slopes[axis] * (lame * share)[:, None]
        half = dsyrk(1.0, scaled.reshape(len(share), -1).T, beta=1.0, c=half, overwrite_c=1)
    held: Array = half + np.triu(half, 1).T
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
