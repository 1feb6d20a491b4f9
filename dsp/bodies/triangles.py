"""The points of triangles that are nearest to places."""

import numpy as np

from .material import Array, Indices

_CHUNK = 400_000  # pairs of places and triangles that are tried at a time


def shares_of(corners: Array, places: Array) -> Array:
    """Return the shares (n, 3) of the corners (n, 3, 3) at the points of triangles nearest to places (n, 3)."""
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


def nearest(corners: Array, places: Array) -> tuple[Indices, Array]:
    """Return the triangle (n,) of corners (f, 3, 3) that is nearest to each of the places (n, 3), the first of those
    that are as near, and the shares (n, 3) of its corners there."""
    face, shares = np.zeros(len(places), np.int64), np.zeros((len(places), 3))
    step = max(1, _CHUNK // len(corners))
    for begin in range(0, len(places), step):
        some = places[begin : begin + step]
        tried = np.broadcast_to(corners, (len(some), *corners.shape)).reshape(-1, 3, 3)
        wanted = np.repeat(some, len(corners), axis=0)
        each = shares_of(tried, wanted)
        away = np.einsum("nc,nck->nk", each, tried) - wanted
        best = (away**2).sum(axis=1).reshape(len(some), -1).argmin(axis=1)
        face[begin : begin + step] = best
        shares[begin : begin + step] = each.reshape(len(some), -1, 3)[np.arange(len(some)), best]
    return face, shares
