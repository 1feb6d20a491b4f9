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


class Elements(NamedTuple):
    """Finite elements: nodes (e, a) of each, their middles (e, 3), unknowns for each node, and nodes in all."""

    nodes: Indices
    middles: Array
    unknowns: int
    size: int


class Front(NamedTuple):
    """A part of the tree: the unknowns that it solves for and those on its rim, and the factor's two blocks."""

    own: Indices
    rim: Indices
    diagonal: Array
    below: Array


class _Rest(NamedTuple):
    """The rest that a part of the tree leaves to the one above: nodes, the matrix between them, and how many elements
    of each are in it."""

    nodes: Indices
    matrix: Array
    seen: Indices


class Factor:
    """The Cholesky factor of a sum of element matrices (e, a d, a d)."""

    def __init__(self, elements: Elements, matrices: Array, leaf: int) -> None:
        """Compute the factor; `leaf`: the most elements of a part that is not halved. MeshError if it is too large."""
        self._elements, self._matrices, self._leaf = elements, matrices, leaf
        self._needed = np.bincount(elements.nodes.ravel(), minlength=elements.size)
        self._fronts: list[Front] = []
        self.numbers = 0
        self._part(np.arange(len(elements.nodes)))
        del self._matrices

    def solve(self, right: Array) -> Array:
        """Return the solution (n, k) for right sides (n, k)."""
        from scipy.linalg.blas import dtrsm

        x = np.array(right, order="F")
        for front in self._fronts:
            y = dtrsm(1.0, front.diagonal, x[front.own], lower=1)
            x[front.own] = y
            if front.rim.size:
                x[front.rim] -= front.below @ y
        for front in reversed(self._fronts):
            y = x[front.own]
            if front.rim.size:
                y = y - front.below.T @ x[front.rim]
            x[front.own] = dtrsm(1.0, front.diagonal, y, lower=1, trans_a=1)
        return x

    def _part(self, which: Indices) -> _Rest:
        """Compute the part of the factor that some elements have."""
        if len(which) <= self._leaf:
            return self._solved(self._summed(which))
        middles = self._elements.middles[which]
        order = np.argsort(middles[:, np.argmax(np.ptp(middles, axis=0))], kind="stable")
        half = len(order) // 2
        return self._solved(self._joined(self._part(which[order[:half]]), self._part(which[order[half:]])))

    def _summed(self, which: Indices) -> _Rest:
        nodes, local = np.unique(self._elements.nodes[which], return_inverse=True)
        local = local.reshape(len(which), -1)
        matrix = np.zeros((len(nodes) * self._elements.unknowns,) * 2)
        for at, each in zip(local, self._matrices[which], strict=True):
            rows = self._unknowns(at)
            matrix[rows[:, None], rows] += each
        return _Rest(nodes, matrix, np.bincount(local.ravel(), minlength=len(nodes)))

    def _joined(self, *parts: _Rest) -> _Rest:
        nodes = np.union1d(parts[0].nodes, parts[1].nodes)
        matrix = np.zeros((len(nodes) * self._elements.unknowns,) * 2)
        seen = np.zeros(len(nodes), np.int64)
        for part in parts:
            at = np.searchsorted(nodes, part.nodes)
            rows = self._unknowns(at)
            matrix[np.ix_(rows, rows)] += part.matrix
            seen[at] += part.seen
        return _Rest(nodes, matrix, seen)

    def _solved(self, part: _Rest) -> _Rest:
        """Solve for the nodes whose elements are all in a part, and return what is left of it."""
        from scipy.linalg.blas import dsyrk, dtrsm
        from scipy.linalg.lapack import dpotrf

        done = part.seen == self._needed[part.nodes]
        order = np.r_[np.flatnonzero(done), np.flatnonzero(~done)]
        own = int(done.sum()) * self._elements.unknowns
        rows = self._unknowns(order)
        matrix = np.asfortranarray(part.matrix[rows[:, None], rows])
        diagonal, info = dpotrf(matrix[:own, :own], lower=1, clean=1)
        if info:
            x, y, z = self._elements.middles.mean(axis=0)
            raise MeshError(f"a part about ({x:.3g}, {y:.3g}, {z:.3g}) m is too thin for its cells: give its wall (m)")
        below = dtrsm(1.0, diagonal, matrix[own:, :own], side=1, lower=1, trans_a=1) if own < len(matrix) else None
        self.numbers += own * (own + 1) // 2 + (0 if below is None else below.size)
        if self.numbers > MOST_NUMBERS:
            raise MeshError(f"too large: expected a factor of at most {MOST_NUMBERS:,} numbers; simplify the mesh")
        first, rest = part.nodes[order[: int(done.sum())]], order[int(done.sum()) :]
        none = np.zeros((0, own))
        self._fronts.append(
            Front(self._unknowns(first), self._unknowns(part.nodes[rest]), diagonal, none if below is None else below)
        )
        if below is None:
            return _Rest(part.nodes[:0], np.zeros((0, 0)), part.seen[:0])
        left = dsyrk(-1.0, below, beta=1.0, c=matrix[own:, own:], lower=1)
        left = np.tril(left) + np.tril(left, -1).T
        sort = np.argsort(part.nodes[rest])
        rows = self._unknowns(sort)
        return _Rest(part.nodes[rest][sort], left[rows[:, None], rows], part.seen[rest][sort])

    def _unknowns(self, nodes: Indices) -> Indices:
        """Return the numbers of the unknowns of nodes."""
        d = self._elements.unknowns
        unknowns: Indices = (nodes[:, None] * d + np.arange(d)).ravel()
        return unknowns
