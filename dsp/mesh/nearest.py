"""The point of a surface that is nearest to a place."""

import numpy as np

from ..bodies.material import Array
from ..bodies.triangles import shares_of
from .surface import Flags, Indices, Surface

_TOGETHER = 1024  # places that are looked up at a time


class Nearest:
    """Look-up of nearest points, exact for triangles of any shape and size.

    A triangle lies in a ball. Balls of alike radii are in one tree. Of each tree those triangles are tried whose ball
    is nearer to the place than the best point that is known.
    """

    def __init__(self, surface: Surface) -> None:
        """Prepare to look up points of a surface."""
        from scipy.spatial import cKDTree

        self._corners = surface.points[surface.faces]
        middles = (self._corners.min(axis=1) + self._corners.max(axis=1)) / 2
        radii = np.linalg.norm(self._corners - middles[:, None], axis=2).max(axis=1)
        octave = np.floor(np.log2(np.maximum(radii, 1e-30)))
        kinds: list[Flags] = [octave == each for each in np.unique(octave)]
        self._classes = [(np.flatnonzero(some), float(radii[some].max()), cKDTree(middles[some])) for some in kinds]

    def to(self, places: Array) -> tuple[Indices, Array]:
        """Return the triangle (n,) nearest to each place (n, 3), the first of those that are as near, and the shares
        (n, 3) of its corners there."""
        found = [self._to(places[begin : begin + _TOGETHER]) for begin in range(0, len(places), _TOGETHER)]
        if not found:
            return np.zeros(0, np.int64), np.zeros((0, 3))
        return np.concatenate([face for face, _ in found]), np.concatenate([shares for _, shares in found])

    def _to(self, places: Array) -> tuple[Indices, Array]:
        best, own = np.full(len(places), np.inf), np.arange(len(places))
        face, shares = np.zeros(len(places), np.int64), np.zeros((len(places), 3))

        def look(row: Indices, tried: Indices) -> None:
            """Try triangles for the places of some rows."""
            corners = self._corners[tried]
            share = shares_of(corners, places[row])
            away = np.linalg.norm(np.einsum("nc,nck->nk", share, corners) - places[row], axis=1)
            order = np.lexsort((tried, away, row))
            first = order[np.r_[True, np.diff(row[order]) > 0]] if len(order) else order
            at = row[first]
            closer = (away[first] < best[at]) | ((away[first] == best[at]) & (tried[first] < face[at]))
            at, first = at[closer], first[closer]
            best[at], shares[at], face[at] = away[first], share[first], tried[first]

        for numbers, _, tree in self._classes:
            look(own, numbers[tree.query(places)[1]])
        for numbers, radius, tree in self._classes:
            near = tree.query_ball_point(places, best + radius, return_sorted=False)
            count = np.array([len(each) for each in near])
            look(np.repeat(own, count), numbers[np.concatenate(near).astype(np.int64)])
        return face, shares
