"""Nodes of cells: which of them cells of one size, and smaller ones beside larger ones, have in common.

Round a node the cells between which the body goes on share it; those of other parts of the body have one of their own.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from .grids import Grid
from .pieces import Pieces
from .polynomials import lagrange, lobatto
from .surface import Flags, Indices

_BESIDE = (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1), (1, 1, 1)


class Mesh(NamedTuple):
    """The cells in use: their numbers, lowest corners (e, 3) and sides (e,) in m, nodes (e, m) and how many nodes there
    are; of small cells beside large ones, what their polynomials (m, m) are in terms of the nodes."""

    pieces: Pieces
    degree: int
    cells: Indices
    corners: Array
    sides: Array
    nodes: Indices
    size: int
    ties: dict[int, Array]

    def elements(self, places: Array) -> Indices:
        """Return the places (n,) among the cells in use of those that hold places (n, 3) of the body; of no cell in
        use, -1."""
        numbers = self.pieces.marks.nearest(places, self.pieces.grid.number(places))
        found = np.clip(np.searchsorted(self.cells, numbers), 0, len(self.cells) - 1)
        return np.where(self.cells[found] == numbers, found, -1)


def mesh_of(pieces: Pieces, degree: int, numbers: Indices) -> Mesh:
    """Return the cells with their nodes numbered. What is small beside what is large has the nodes of that."""
    grid, steps = pieces.grid, np.arange(degree + 1)
    local = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    used = np.zeros(grid.size, bool)
    used[numbers] = True
    most = (grid.counts << int(grid.levels.max())) * degree + 1
    known: dict[int, tuple[Indices, Array]] = {}

    def by_nodes(cell: int) -> tuple[Indices, Array]:
        """Return the keys (n,) of the nodes that a cube's polynomials (m, n) depend on, and how."""
        if cell not in known:
            at = grid.at[cell] * degree + local
            own = ((grid.levels[cell] * most[0] + at[:, 0]) * most[1] + at[:, 1]) * most[2] + at[:, 2]
            known[cell] = own, np.eye(len(local))
            held = _held(grid, used, cell, local) if grid.whole[cell] >= 0 else np.zeros(1, bool)
            if held.any():
                keys, values = by_nodes(int(grid.whole[cell]))
                values = _halves(degree, *(grid.at[cell] % 2))[held] @ values
                some = np.abs(values).max(axis=0) > 1e-12
                tie = np.zeros((len(local), int(some.sum()) + int((~held).sum())))
                tie[held, : int(some.sum())] = values[:, some]
                tie[~held, int(some.sum()) :] = np.eye(int((~held).sum()))
                known[cell] = np.r_[keys[some], own[~held]], tie
        return known[cell]

    each = [by_nodes(int(number)) for number in numbers]
    wide = max(len(keys) for keys, _ in each)
    ties = {
        row: np.hstack([np.zeros((len(local), wide - tie.shape[1])), tie])
        for row, (own, tie) in enumerate(each)
        if wide > len(local) or grid.levels[numbers[row]]
    }
    named = [keys for keys, _ in each]
    names = _alike(named) if pieces.links is None else _apart(named, numbers, pieces.links)
    # Cells with fewer nodes repeat their first one, without weight, ahead of the others.
    nodes = np.stack([np.r_[np.full(wide - len(own), own[0]), own] for own in names])
    size = int(nodes.max()) + 1
    return Mesh(pieces, degree, numbers, grid.corners[numbers], grid.sides[numbers], nodes, size, ties)


def _alike(keys: list[Indices]) -> list[Indices]:
    """Return numbers of nodes by their keys."""
    number = np.unique(np.concatenate(keys), return_inverse=True)[1].reshape(-1).astype(np.int64)
    return np.split(number, np.cumsum([len(own) for own in keys])[:-1])


def _apart(keys: list[Indices], numbers: Indices, links: Indices) -> list[Indices]:
    """Return numbers of nodes by their keys, and one for each group of cells (their numbers, ascending) that links hold
    together round them."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    begin = np.r_[0, np.cumsum([len(own) for own in keys])]
    pairs = [np.zeros((2, 0), np.int64)]
    for one, other in np.searchsorted(numbers, links):
        _, here, there = np.intersect1d(keys[one], keys[other], assume_unique=True, return_indices=True)
        pairs.append(np.stack([begin[one] + here, begin[other] + there]))
    a, b = np.concatenate(pairs, axis=1)
    graph = coo_array((np.ones(len(a), np.int8), (a, b)), shape=(begin[-1], begin[-1]))
    group = connected_components(graph, directed=False)[1].astype(np.int64)
    return np.split(group, begin[1:-1])


def _held(grid: Grid, used: Flags, cell: int, local: Indices) -> Flags:
    """Return which nodes (m,) of a half of a cube lie on a cell in use that is as large as the whole, or larger."""
    degree, part = int(local.max()), grid.at[cell] % 2
    step = ((local == degree) & (part == 1)).astype(np.int64) - ((local == 0) & (part == 0))
    side = float(grid.sides[grid.whole[cell]])
    middle = grid.at[grid.whole[cell]] + 0.5
    low, high = grid.corner, grid.corner + grid.side * grid.counts
    found = np.zeros(len(local), bool)
    for axes in np.array(_BESIDE):
        towards, which = np.unique(step * axes, axis=0, return_inverse=True)
        places = grid.corner + side * (middle + towards)
        beside = grid.number(places)
        there = used[beside] & (grid.sides[beside] >= side * 0.99) & ((places > low) & (places < high)).all(axis=1)
        there &= (np.abs(towards) == axes).all(axis=1)
        found |= there[which.ravel()]
    return found


@lru_cache(maxsize=64)
def _halves(degree: int, *part: int) -> Array:
    """Return the values (m, m) at the nodes of a half of a cube by those at the nodes of the whole."""
    x, y, z = (lagrange((lobatto(degree) + place) / 2, degree)[0] for place in part)
    return np.asarray(np.einsum("ai,bj,ck->abcijk", x, y, z).reshape(((degree + 1) ** 3,) * 2))
