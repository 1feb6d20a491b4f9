"""Finite cells: the modes of a solid, or of a thick sheet, on a grid of cubes that needs no mesh of its own.

The displacement is a polynomial in each cube; the body is met by the quadrature alone (J. Parvizian, A. Duester,
E. Rank, Comput. Mech. 41, 2007). Outside, a stiffness of at most 1e-6 of the body's and no mass keep the system
definite. The body is turned against the grid, so that its flat faces don't lie along the rays.
"""

import numpy as np

from ..bodies.material import Array, Material
from .corners import AT_EDGES, WHERE_BENT, Law
from .forms import together
from .fronts import Elements, Factor
from .grading import extrapolated, graded, hollow
from .grids import TILT, Grid, grid_about
from .lanczos import lowest
from .matrices import energies, matrices
from .numbering import Mesh, mesh_of
from .parts import Parts
from .pieces import Pieces, divided, undivided
from .rays import Points, Quadrature, quadrature
from .sheets import of_sheet
from .sizing import Sizes
from .solutions import Solution, shared
from .surface import Indices, MeshError, Surface, volume_of

_LEAST_FILLED = 1e-3  # of a cell
_AGREED = 0.02  # of the volume, by triangles and by rays: within that the triangles' counts
_NOWHERE = np.zeros(0, np.int64)
_SHIFT = 0.02  # of a wave's frequency along the body
_COARSE = 10  # modes of one degree less beyond rigid motions, of which each loose part has six
_LOCKED = 2  # the degree at and below which cells are too stiff to tell anything
_RIGID = 1e-3  # of the highest frequency: below lie rigid motions


def solve(parts: Parts, size: Sizes, degree: int, count: int) -> Solution:
    """Return a solid's `count` lowest modes, rigid motions among them."""
    turned = [Surface(each.points @ TILT.T, each.faces) for each in parts.surfaces]
    whole = together(*turned)
    grids = graded(grid_about(whole, size.side, size.rays), whole, size.halvings)
    if not size.told or len(grids) == 1:
        pieces, inside = _in_pieces(turned, grids[-1], _inside(turned, grids[-1], degree))
        where = _NOWHERE if size.told else hollow(whole, grids[-1]) if size.edges else None
        return _with_coarse(inside, pieces, parts.materials, degree, count, where)
    coarse = _inside(turned, grids[-2], degree)
    fine = _inside(turned, grids[-1], degree, coarse)
    found = []
    for grid, met in ((grids[-2], coarse), (grids[-1], fine)):
        pieces, inside = _in_pieces(turned, grid, met)
        if grid is grids[-1]:
            found.append(_with_coarse(inside, pieces, parts.materials, degree, count, _NOWHERE))
        elif not pieces.gaps:  # how far a gap goes in the cell that it ends in is chance
            found.append(of_points(inside, pieces, parts.materials, degree, count, _NOWHERE))
    if len(found) == 1:
        return found[0]
    frequency = extrapolated(found[0].frequency, found[1].frequency, shared(*found) ** 2)
    return found[1]._replace(frequency=frequency)


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
    """Return the pieces of the parts, and the points inside of them, with the volume that the triangles enclose."""
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
    return _with_coarse(inside, undivided(grid), parts.materials, degree, count)


def _with_coarse(
    inside: list[Quadrature],
    pieces: Pieces,
    materials: tuple[Material, ...],
    degree: int,
    count: int,
    yielding: Indices | None = None,
) -> Solution:
    """Return the modes that `of_points` does, with the lowest frequencies by polynomials of one degree less."""
    found = of_points(inside, pieces, materials, degree, count, yielding)
    if degree - 1 <= _LOCKED:
        return found
    rigid = _first_bent(found.frequency)
    coarse = of_points(inside, pieces, materials, degree - 1, rigid + _COARSE, yielding)
    return found._replace(coarse=coarse.frequency)


def _first_bent(frequency: Array) -> int:
    """Return the number of the lowest of frequencies (n,) that is no rigid motion's."""
    return int(np.argmax(frequency > _RIGID * frequency[-1]))


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
    laws: list[Law | None] = [WHERE_BENT] * len(mesh.cells)
    if yielding is not None:
        at_edges = np.isin(grid.number(mesh.corners + mesh.sides[:, None] / 2), yielding)
        laws = [AT_EDGES if each else None for each in at_edges]
    stiffness, mass, shares = matrices(mesh, points, [each.full for each in inside], materials, laws)
    elements = Elements(mesh.nodes, mesh.corners + mesh.sides[:, None] / 2, 3, mesh.size, TILT)
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
        energy = energies(mesh, shares, vectors, len(materials))
    leaks = max(each.leaks for each in inside)
    frequency, within = np.sqrt(np.maximum(values, 0)) / (2 * np.pi), _within(mesh, points)
    first = vectors[:, _first_bent(frequency)].reshape(mesh.size, 3)
    each = first[mesh.nodes].reshape(len(mesh.nodes), -1)
    bent = np.einsum("ei,eij,ej->e", each, stiffness, each, optimize=True) / mass.sum(axis=(1, 2))
    weakest = within[int(bent.argmax())] @ TILT
    met = float(volume.sum())
    return Solution(frequency, displacement, mesh, total, met, leaks, energy, mass, within, weakest=weakest)


def _within(mesh: Mesh, points: Points) -> Array:
    """Return a place (e, 3) of the body in each cell in use: the middle of those that are full."""
    found = mesh.corners + mesh.sides[:, None] / 2
    order = np.argsort(points.weights, kind="stable")
    row = np.searchsorted(mesh.cells, points.cells[order])
    some = mesh.cells[np.minimum(row, len(mesh.cells) - 1)] == points.cells[order]
    found[row[some]] = points.places[order[some]]
    return found


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
