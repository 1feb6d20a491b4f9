"""Triangles made smaller: long sides are split, so that neighbours go on sharing whole sides."""

import math
from collections.abc import Callable

import numpy as np

from ..bodies.material import Array
from .cleaning import edges_of
from .rounding import middles_of
from .surface import Indices, Surface, faces_of

SLIVER = 1e-3
"""Of a side squared: a triangle of less area is a sliver."""
_MOST_SPLIT = 4  # times the triangles wanted: long thin ones are not split beyond
_ROUNDS = 24


def refined(surface: Surface, count: int, most: int | None = None) -> Surface:
    """Return a surface of about so many triangles at least: sides that are too long are split, on the surface where it
    is round, as far as it stays below `most`, and slivers are left out."""
    longest = 1.5 * math.sqrt(float(faces_of(surface).areas.sum()) / count * 2)
    bound = _MOST_SPLIT * count
    points, faces = divided(surface, longest, bound if most is None else min(bound, most), middles_of)
    corners = points[faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    faces = faces[area > SLIVER * ((corners - np.roll(corners, -1, axis=1)) ** 2).sum(axis=2).max(axis=1)]
    used = np.unique(faces)
    return Surface(points[used], np.searchsorted(used, faces))


def divided(surface: Surface, longest: float, most: int, middles: Callable[[Surface], Array] | None = None) -> Surface:
    """Return a surface whose sides are at most `longest` (m), or to split which all once more makes over `most`
    triangles. middles: function of those of a surface's edges; None: they are straight."""
    points, faces = surface
    for _ in range(_ROUNDS):
        edges, number, _ = edges_of(faces)
        length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
        each = length[number]
        # A side is split if it is too long, and the longest of one of its triangles.
        wanted = np.zeros(len(edges), bool)
        worst = number[np.arange(len(faces)), each.argmax(axis=1)]
        wanted[worst[each.max(axis=1) > longest]] = True
        if not wanted.any() or len(faces) + int(wanted[number].sum()) > most:
            break
        middle = np.where(wanted, len(points) + np.cumsum(wanted) - 1, -1)
        new = points[edges[wanted]].mean(axis=1) if middles is None else middles(Surface(points, faces))[wanted]
        points = np.vstack([points, new])
        faces = _split(faces, middle[number])
    return Surface(points, faces)


def _split(faces: Indices, middle: Indices) -> Indices:
    """Return faces of which the sides with a middle (m, 3; -1: none) are split, one at a time."""
    while (middle >= 0).any():
        side = np.argmax(middle >= 0, axis=1)
        has = (middle >= 0).any(axis=1)
        row = np.arange(len(faces))
        turned, between = (np.stack([each[row, (side + k) % 3] for k in range(3)], axis=1) for each in (faces, middle))
        a, b, c = turned.T
        m = between[:, 0]
        none = np.full(len(faces), -1)
        first = np.stack([a, m, c], axis=1), np.stack([none, none, between[:, 2]], axis=1)
        second = np.stack([m, b, c], axis=1), np.stack([none, between[:, 1], none], axis=1)
        faces = np.concatenate([turned[~has], first[0][has], second[0][has]])
        middle = np.concatenate([between[~has], first[1][has], second[1][has]])
    return faces
