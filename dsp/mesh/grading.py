"""Smaller cells where the surface has inner edges, and what still smaller ones would change.

At an inner edge stress has no bound, and walls that meet there bend apart: polynomials over a cell can't follow. There
cells are halved, and halved again. What is left of the error falls by the same share with each halving (of an edge of
90 degrees as the side of the cells to the power of 1.09), so that two such grids give the rest of it.
"""

import numpy as np

from ..bodies.material import Array
from .grids import Grid
from .surface import Indices, Surface, faces_of

_SAMPLES = 120_000  # of the surface
_APART = 0.5  # cosine of the angle between two normals: the surface turns by more
_FACING = -0.95  # cosine: of normals that turn by more faces lie across a gap, which ends elsewhere
_FRONT = 0.02  # of a cube's side: how far two places of the surface are in front of each other at least
_NARROW = 0.5  # of a cube's side: a narrow gap
_PAIRS, _GAP_PAIRS = 96, 400  # places of a cube that are compared, and where a narrow gap may end
_LEFT = 0.886  # of what the last halving changed: 1/(2^1.09 - 1)
_ALIKE = 0.8  # of a mode: what modes of the coarser grid must make up
_MOST_CHANGE = 0.2  # of a frequency, by a halving: more is another mode


def graded(grid: Grid, surface: Surface, halvings: int) -> list[Grid]:
    """Return a grid, and those in which cells at inner edges are halved once, twice and so on; fewer where no cell
    holds such an edge."""
    found = [grid]
    places, normals = places_on(surface, _SAMPLES) if halvings else (np.zeros((0, 3)),) * 2
    for _ in range(halvings):
        which = _hollow(places, normals, found[-1])
        if not len(which):
            break
        found.append(found[-1].halved(which))
    return found


def hollow(surface: Surface, grid: Grid) -> Indices:
    """Return the numbers of the smallest cells of a grid that hold inner edges of a surface."""
    return _hollow(*places_on(surface, _SAMPLES), grid)


def places_on(surface: Surface, count: int) -> tuple[Array, Array]:
    """Return places (n, 3) on a surface, at random, and its normals there."""
    normals, areas = faces_of(surface)
    rng = np.random.default_rng(0)
    face = rng.choice(len(areas), count, p=areas / areas.sum())
    places = np.einsum("ij,ijk->ik", rng.dirichlet((1, 1, 1), count), surface.points[surface.faces[face]])
    return places, normals[face]


def _hollow(places: Array, normals: Array, grid: Grid) -> Indices:
    """Return the numbers of the smallest cells in which places (n, 3) of a surface look at each other, by its
    normals."""
    numbers = grid.number(places)
    some = np.flatnonzero(grid.levels[numbers] == grid.levels.max())
    order = some[np.argsort(numbers[some], kind="stable")]
    cells, begin, count = np.unique(numbers[order], return_index=True, return_counts=True)
    found = []
    for cell, first, many in zip(cells, begin, count, strict=True):
        own = order[first : first + many]
        at, look = places[own] / grid.sides[cell], normals[own]
        if _look(at[:_PAIRS], look[:_PAIRS])[0] or all(_look(*_of_all_sides(at, look))):
            found.append(cell)
    return np.array(found, np.int64)


def _look(at: Array, look: Array) -> tuple[bool, bool]:
    """Return two flags: that some of the places (n, 3) of a cube look at each other by their normals as at an inner
    edge, and that some do across a narrow gap."""
    ahead = look @ at.T - np.einsum("ij,ij->i", look, at)[:, None]
    cosine, near = look @ look.T, np.minimum(ahead, ahead.T)
    edge = (near > _FRONT) & (cosine < _APART) & (cosine > _FACING)
    return bool(edge.any()), bool(((near > _FRONT) & (near < _NARROW) & (cosine <= _FACING)).any())


def _of_all_sides(at: Array, look: Array) -> tuple[Array, Array]:
    """Return some of the places (n, 3) of a cube and their normals, of each direction as many: of the end of a narrow
    gap there are few beside those of its sides."""
    way = np.round(2 * look) @ (25, 5, 1)
    order = np.argsort(way, kind="stable")
    _, begin, count = np.unique(way[order], return_index=True, return_counts=True)
    turn = np.arange(len(order)) - np.repeat(begin, count)
    some = order[np.argsort(turn, kind="stable")[:_GAP_PAIRS]]
    return at[some], look[some]


def extrapolated(before: Array, after: Array, shares: Array) -> Array:
    """Return the frequencies (n,) on the finer of two grids, `after`, less the error that their change from the coarser
    one, `before` (m,), gives. shares (m, n): how much each mode there has of each one here, by their mass."""
    return np.asarray(after - _LEFT * np.maximum(changes(before, after, shares), 0))


def changes(before: Array, after: Array, shares: Array) -> Array:
    """Return by how much the frequencies (n,) of modes were higher before (m,); 0 of those that it is not known of.

    A mode's frequency before is the root mean square of those of the modes that make it up.
    """
    shares = np.where(np.abs(before[:, None] - after) < _MOST_CHANGE * after, shares, 0)
    total = shares.sum(axis=0)
    squares = np.einsum("i,ij->j", before**2, shares) / np.maximum(total, 1e-300)
    return np.where(total > _ALIKE, np.sqrt(squares) - after, 0)
