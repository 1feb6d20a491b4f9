"""Symmetric positive definite systems of finite elements: multifrontal Cholesky over a tree of elements.

Elements are halved along their longest side until few are left. Each part of the tree adds up what lies below it and
solves for the nodes that nobody else shares. This needs half the numbers that SuperLU does, in blocks that LAPACK
works on (I. Duff and J. Reid, ACM Trans. Math. Softw. 9, 1983).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from .surface import Indices, MeshError

MOST_NUMBERS = 150_000_000
"""Numbers of a factor at most: 1.2 GB."""

_LONGER = 0.4  # of the longest side: sides that are cut
_ASIDE = 0.1  # of the elements: how far from the middle a cut may lie


class Elements(NamedTuple):
    """Finite elements: nodes (e, a) of each, their middles (e, 3), unknowns for each node, and nodes in all. frame (3,
    3): middles times it are places of the body."""

    nodes: Indices
    middles: Array
    unknowns: int
    size: int
    frame: Array = np.eye(3)


class Front(NamedTuple):
    """A part of the tree: where the unknowns that it solves for begin and end, those on its rim, and the factor's two
    blocks."""

    begin: int
    end: int
    rim: Indices
    diagonal: Array
    below: Array


class _Part(NamedTuple):
    """A part of the tree: its elements if it is not halved, and where the nodes that it solves for begin and end."""

    elements: Indices | None
    begin: int
    end: int


class _Rest(NamedTuple):
    """The rest that a part of the tree leaves to the one above: nodes, ascending, and the matrix between them, the
    lower half of which counts."""

    nodes: Indices
    matrix: Array


class Factor:
    """The Cholesky factor of a sum of element matrices (e, a d, a d)."""

    def __init__(self, elements: Elements, matrices: Array, leaf: int, most: int | None = None) -> None:
        """Compute the factor; `leaf`: the most elements of a part that is not halved. MeshError if it takes over `most`
        numbers, or over MOST_NUMBERS."""
        self._elements, self._leaf = elements, leaf
        self._most = MOST_NUMBERS if most is None else most
        self._needed = np.bincount(elements.nodes.ravel(), minlength=elements.size)
        self._place = np.zeros(elements.size, np.int64)  # of each node in the order in which they are solved for
        self._parts: list[_Part] = []
        self._placed = self.numbers = 0
        self._plan(np.arange(len(elements.nodes)))
        self._rows = self._unknowns(np.argsort(self._place, kind="stable"))
        self._fronts: list[Front] = []
        rests: list[_Rest] = []
        for part in self._parts:
            which = part.elements
            whole = self._joined(rests.pop(), rests.pop()) if which is None else self._summed(which, matrices)
            rests.append(self._solved(part, whole))

    def solve(self, right: Array) -> Array:
        """Return the solution (n, k) for right sides (n, k)."""
        from scipy.linalg.blas import dtrsm

        x = np.ascontiguousarray(right[self._rows])
        for begin, end, rim, diagonal, below in self._fronts:
            x[begin:end] = y = dtrsm(1.0, diagonal, x[begin:end].T, side=1, lower=1, trans_a=1).T
            if rim.size:
                x[rim] -= below @ y
        for begin, end, rim, diagonal, below in reversed(self._fronts):
            y = x[begin:end]
            if rim.size:
                y = y - below.T @ x[rim]
            x[begin:end] = dtrsm(1.0, diagonal, y.T, side=1, lower=1).T
        found = np.empty_like(x)
        found[self._rows] = x
        return found

    def _plan(self, which: Indices) -> tuple[Indices, Indices]:
        """Lay out the part of the tree that some elements have, those that it is halved to before it; return the nodes
        that are left to the part above, and how many elements of each are in it."""
        leaf = len(which) <= self._leaf
        if leaf:
            nodes, seen = np.unique(self._elements.nodes[which], return_counts=True)
        else:
            halves = [self._plan(half) for half in self._halves(which)]
            both, count = (np.concatenate(each) for each in zip(*halves, strict=True))
            nodes, number = np.unique(both, return_inverse=True)
            seen = np.bincount(number.ravel(), count).astype(np.int64)
        done = seen == self._needed[nodes]
        begin, own = self._placed, int(done.sum())
        self._place[nodes[done]] = np.arange(begin, begin + own)
        self._placed += own
        self._parts.append(_Part(which if leaf else None, begin, begin + own))
        rows = own * self._elements.unknowns
        self.numbers += rows * (rows + 1) // 2 + rows * (len(nodes) - own) * self._elements.unknowns
        if self.numbers > self._most:
            raise MeshError(f"too large: expected a factor of at most {self._most:,} numbers; simplify the mesh")
        return nodes[~done], seen[~done]

    def _halves(self, which: Indices) -> list[Indices]:
        """Return some elements in two parts that share few nodes: cut across a longer side, near the middle."""
        middles, nodes = self._elements.middles[which], self._elements.nodes[which]
        number = np.unique(nodes, return_inverse=True)[1].reshape(nodes.shape)
        sides = np.ptp(middles, axis=0)
        cuts = [_cut(number, middles[:, axis]) for axis in np.flatnonzero(sides >= _LONGER * sides.max())]
        order, cut, _ = min(cuts, key=lambda each: each[2])
        return np.split(which[order], [cut])

    def _summed(self, which: Indices, matrices: Array) -> _Rest:
        """Return the sum of some elements."""
        nodes, local = np.unique(self._place[self._elements.nodes[which]], return_inverse=True)
        rows = self._unknowns(local.reshape(-1)).reshape(len(which), -1)
        size = len(nodes) * self._elements.unknowns
        place = rows[:, None, :] * size + rows[:, :, None]  # by columns
        matrix = np.asarray(np.bincount(place.ravel(), matrices[which].ravel(), size**2), np.float64)
        return _Rest(nodes, matrix.reshape(size, size).T)

    def _joined(self, one: _Rest, other: _Rest) -> _Rest:
        """Return the sum of what two parts leave, its lower half."""
        nodes = np.union1d(one.nodes, other.nodes)
        matrix = np.zeros((len(nodes) * self._elements.unknowns,) * 2, order="F")
        for part in (one, other):
            runs = self._runs(np.searchsorted(nodes, part.nodes))
            for n, (begin, end, at) in enumerate(runs):
                columns = slice(at, at + end - begin)
                for first, last, to in runs[n:]:
                    matrix[to : to + last - first, columns] += part.matrix[first:last, begin:end]
        return _Rest(nodes, matrix)

    def _runs(self, at: Indices) -> list[tuple[int, int, int]]:
        """Return where runs of unknowns begin and end, and where each goes, by the places of ascending nodes."""
        begin = np.flatnonzero(np.diff(at, prepend=-2) != 1)
        end = np.append(begin, len(at))[1:]
        return [(a, b, to) for a, b, to in (np.stack([begin, end, at[begin]], 1) * self._elements.unknowns).tolist()]

    def _solved(self, part: _Part, whole: _Rest) -> _Rest:
        """Solve for the nodes whose elements are all in a part, its first ones, and return what is left of it."""
        from scipy.linalg.blas import dsyrk, dtrsm
        from scipy.linalg.lapack import dpotrf

        unknowns, count = self._elements.unknowns, part.end - part.begin
        own, matrix = count * unknowns, whole.matrix
        diagonal, info = dpotrf(matrix[:own, :own], lower=1, clean=0)
        if info:
            at_node = self._place[self._elements.nodes] == part.begin + (info - 1) // unknowns
            x, y, z = self._elements.middles[at_node.any(axis=1)].mean(axis=0) @ self._elements.frame
            place = f"a part about ({x:.3g}, {y:.3g}, {z:.3g}) m"
            raise MeshError(f"{place} is too thin for its cells: give its wall (m); or it is loose: join it")
        begin, end, rest = part.begin * unknowns, part.end * unknowns, whole.nodes[count:]
        if not len(rest):
            self._fronts.append(Front(begin, end, rest, diagonal, np.zeros((0, own))))
            return _Rest(rest, np.zeros((0, 0)))
        below = dtrsm(1.0, diagonal, matrix[own:, :own], side=1, lower=1, trans_a=1)
        self._fronts.append(Front(begin, end, self._unknowns(rest), diagonal, below))
        return _Rest(rest, dsyrk(-1.0, below, beta=1.0, c=matrix[own:, own:], lower=1))

    def _unknowns(self, nodes: Indices) -> Indices:
        """Return the numbers of the unknowns of nodes."""
        d = self._elements.unknowns
        unknowns: Indices = (nodes[:, None] * d + np.arange(d)).ravel()
        return unknowns


def _cut(nodes: Indices, along: Array) -> tuple[Indices, int, int]:
    """Return elements with nodes (e, a) in the order in which they lie along an axis, where to cut them, and how many
    nodes both parts share then."""
    count = len(nodes)
    order = np.argsort(along, kind="stable")
    each, at = nodes[order].ravel(), np.repeat(np.arange(count), nodes.shape[1])
    first, last = np.zeros((2, nodes.max() + 1), np.int64)
    first[each[::-1]], last[each] = at[::-1], at
    met, left = (np.bincount(seen + 1, minlength=count + 1) for seen in (first, last))
    shared = np.cumsum(met - left)  # by how many elements come before the cut
    aside = np.arange(int(_ASIDE * count) + 1)
    cuts = count // 2 + np.stack([aside, -aside], axis=1).ravel()  # the nearest to the middle first
    cut = int(cuts[np.argmin(shared[cuts])])
    return order, cut, int(shared[cut])
