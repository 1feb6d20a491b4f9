"""The point of a surface that is nearest to a place."""

import numpy as np

from ..bodies.material import Array
from ..bodies.triangles import shares_of
from .surface import Indices, Surface

_TRIED = 24  # triangles whose middles are nearest


class Nearest:
    """Look-up of nearest points; the nearest of the triangles about is found, which need not be alike large."""

    def __init__(self, surface: Surface) -> None:
        """Prepare to look up points of a surface."""
        from scipy.spatial import cKDTree

        self._corners = surface.points[surface.faces]
        self._tree = cKDTree(self._corners.mean(axis=1))
        self._tried = min(_TRIED, len(self._corners))

    def to(self, places: Array) -> tuple[Indices, Array]:
        """Return the triangle (n,) nearest to each place (n, 3), and the shares (n, 3) of its corners there."""
        near = self._tree.query(places, k=self._tried)[1].reshape(len(places), -1)
        best, shares = np.full(len(places), np.inf), np.zeros((len(places), 3))
        face = np.zeros(len(places), np.int64)
        for column in near.T:
            corners = self._corners[column]
            share = shares_of(corners, places)
            distance = np.linalg.norm(np.einsum("nc,nck->nk", share, corners) - places, axis=1)
            closer = distance < best
            best[closer], shares[closer], face[closer] = distance[closer], share[closer], column[closer]
        return face, shares
