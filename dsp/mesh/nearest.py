"""The point of a surface that is nearest to a place."""

import numpy as np

from ..bodies.material import Array
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
            share = _shares(corners, places)
            distance = np.linalg.norm(np.einsum("nc,nck->nk", share, corners) - places, axis=1)
            closer = distance < best
            best[closer], shares[closer], face[closer] = distance[closer], share[closer], column[closer]
        return face, shares


def _shares(corners: Array, places: Array) -> Array:
    """Return shares (n, 3) of the corners (n, 3, 3) at the points of triangles nearest to places (n, 3)."""
    a = corners[:, 0]
    u, v, w = corners[:, 1] - a, corners[:, 2] - a, places - a
    uu, uv, vv = (np.einsum("ij,ij->i", *pair) for pair in ((u, u), (u, v), (v, v)))
    wu, wv = np.einsum("ij,ij->i", w, u), np.einsum("ij,ij->i", w, v)
    area = np.maximum(uu * vv - uv**2, 1e-300)
    p, q = (vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area
    inside = (p >= 0) & (q >= 0) & (p + q <= 1)
    ends = [np.clip(wu / np.maximum(uu, 1e-300), 0, 1), np.clip(wv / np.maximum(vv, 1e-300), 0, 1)]
    third = np.clip((wv - wu + uu - uv) / np.maximum(uu - 2 * uv + vv, 1e-300), 0, 1)
    zero = np.zeros(len(places))
    tried = [(ends[0], zero), (zero, ends[1]), (1 - third, third)]
    far = [np.linalg.norm(s[:, None] * u + t[:, None] * v - w, axis=1) for s, t in tried]
    side = np.argmin(far, axis=0)
    p = np.where(inside, p, np.choose(side, [s for s, _ in tried]))
    q = np.where(inside, q, np.choose(side, [t for _, t in tried]))
    return np.stack([1 - p - q, p, q], axis=1)
