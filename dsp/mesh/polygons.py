"""Polygons of meshes, and the triangles that they are made of."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from ..errors import MissingLibrary
from .surface import Indices, MeshError

_STRAIGHT = 1e-7  # rad: a polygon that turns by less goes straight on
_CROSSED = 1e-3  # of the area, or of the square of half the size: triangles cover as much of a polygon as it has
_FOLDED = 2.0  # times its area: the most of a fan's triangles; a polygon that crosses itself has more
_LEAST = 1e-9  # of a polygon's area: triangles of a fan that have less of it, or are turned over, make no fan


class Polygons(NamedTuple):
    """Faces as a file has them: points (n, 3) in its unit, the corners of all faces one after the other (c,), how many
    each face has (m,), the part (m,) that each belongs to, and the names of each part."""

    points: Array
    corners: Indices
    sizes: Indices
    of: Indices
    names: tuple[tuple[str, ...], ...]


class Triangles(NamedTuple):
    """Points (n, 3), triangles (t, 3), the part (t,) of each, and the names of each part."""

    points: Array
    faces: Indices
    of: Indices
    names: tuple[tuple[str, ...], ...]


def triangulated(polygons: Polygons) -> Triangles:
    """Return the triangles of polygons: a fan where that covers the polygon, else what ear clipping finds in its plane.

    All corners stay, so that neighbours go on sharing whole sides. MissingLibrary says what concave polygons need.
    """
    points, corners, sizes, of, names = polygons
    begin = np.cumsum(sizes) - sizes
    faces, own = [], []
    for size in np.unique(sizes):
        if size < 3:
            continue
        some = np.flatnonzero(sizes == size)
        rings = corners[begin[some, None] + np.arange(size)]
        fans = np.stack([np.broadcast_to(rings[:, :1], (len(rings), size - 2)), rings[:, 1:-1], rings[:, 2:]], axis=2)
        plain = np.ones(len(rings), bool)
        if size > 3:
            at = points[rings]
            arms = at[:, 1:] - at[:, :1]
            each = np.cross(arms[:, :-1], arms[:, 1:])
            whole = each.sum(axis=1)
            square = np.einsum("ij,ij->i", whole, whole)
            plain = ~(np.einsum("ikj,ij->ik", each, whole) < _LEAST * square[:, None]).any(axis=1)
            plain &= np.linalg.norm(each, axis=2).sum(axis=1) <= _FOLDED * np.sqrt(square)
            plain |= ~np.isfinite(square)  # the clean-up says it
        faces.append(fans[plain].reshape(-1, 3))
        own.append(np.repeat(some[plain], size - 2))
        for ring, face in zip(rings[~plain], some[~plain], strict=True):
            made = clipped(points, [ring])
            faces.append(made)
            own.append(np.full(len(made), face))
    every = np.concatenate(faces) if faces else np.zeros((0, 3), np.int64)
    row = np.concatenate(own) if own else np.zeros(0, np.int64)
    order = np.argsort(row, kind="stable")
    return Triangles(points, every[order], of[row[order]], names)


def clipped(points: Array, rings: list[Indices]) -> Indices:
    """Return the triangles (t, 3) of a polygon in the plane that it lies nearest to.

    rings: the corners (k,) of its outline, then of each hole, which goes round the other way. MeshError if it crosses
    itself.
    """
    try:
        from mapbox_earcut import triangulate_float64
    except ImportError as error:
        raise MissingLibrary(f"a concave polygon needs mapbox_earcut ({error}): pip install 'carom[mesh]'") from error
    every = np.concatenate(rings)
    at = points[every] - points[every[0]]
    begin = np.cumsum([0, *(len(ring) for ring in rings)])
    after = np.concatenate([np.roll(np.arange(low, high), -1) for low, high in pairwise(begin)])
    look = np.cross(at, at[after]).sum(axis=0)
    length = float(np.linalg.norm(look))
    size = float(np.abs(at).max())
    if not length > _CROSSED * size**2:
        if np.linalg.norm(np.cross(at[:-1], at[1:]), axis=1).max() > _CROSSED * size**2:
            raise _crossed(points[every])
        if not length > 0:
            return np.zeros((0, 3), np.int64)  # it has no area
    across = np.linalg.svd(look[None] / length)[2][1:]
    if np.cross(*across) @ look < 0:
        across = across[::-1]
    flat = np.ascontiguousarray(at @ across.T)
    unit = max(float(np.abs(flat).max()), 1e-300)
    flat /= unit
    bent = [low + _bent(flat[low:high]) for low, high in pairwise(begin)]
    some, ends = np.concatenate(bent), np.cumsum([len(each) for each in bent])
    made = some[triangulate_float64(flat[some], ends.astype(np.uint32)).reshape(-1, 3).astype(np.int64)]
    a, b, c = flat[made].transpose(1, 0, 2)
    twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    whole, covered = length / unit**2, float(np.abs(twice).sum())
    if abs(covered - whole) > _CROSSED * max(covered, 1.0):
        raise _crossed(points[every])
    made = np.where((twice < 0)[:, None], made[:, ::-1], made)
    for low, high in pairwise(begin):
        made = _with_all(made, low, high)
    return every[made]


def _crossed(corners: Array) -> MeshError:
    """Return the error of a polygon that goes over itself."""
    x, y, z = corners.mean(axis=0)
    return MeshError(
        f"a face of {len(corners)} corners about ({x:.3g}, {y:.3g}, {z:.3g}) crosses itself: expected polygons that do "
        "not, or triangles"
    )


def _bent(flat: Array) -> Indices:
    """Return the numbers of a polygon's corners (k, 2) at which it turns: those that lie on a side between others would
    make triangles without an area."""
    some = np.arange(len(flat))
    while len(some) > 3:
        before, after = flat[some] - flat[np.roll(some, 1)], flat[np.roll(some, -1)] - flat[some]
        twice = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        along = np.einsum("ij,ij->i", before, after)
        straight = (np.abs(twice) <= _STRAIGHT * along) & (along > 0)
        # Of two in a row one at a time: the other may turn then.
        straight &= ~np.roll(straight, 1) | (np.arange(len(some)) % 2 == 0)
        if not straight.any():
            break
        some = some[~straight]
    return some


def _with_all(made: Indices, begin: int, end: int) -> Indices:
    """Return triangles (t, 3) with those corners of a ring, `begin` to `end`, too, that lay on a side between others
    and were left out: the triangle at such a side is split."""
    used = np.unique(made[(made >= begin) & (made < end)])
    count = end - begin
    if len(used) in (0, count):
        return made
    triangles = [tuple(map(int, each)) for each in made]
    for low, high in zip(used.tolist(), np.roll(used, -1).tolist(), strict=True):
        steps = (high - low - 1) % count
        between = [begin + (low - begin + step + 1) % count for step in range(steps)]
        if not between:
            continue
        for number, (a, b, c) in enumerate(triangles):
            found = next((t for t in ((a, b, c), (b, c, a), (c, a, b)) if t[:2] == (low, high)), None)
            if found:
                line = [low, *between, high]
                triangles[number : number + 1] = [(one, other, found[2]) for one, other in pairwise(line)]
                break
    return np.array(triangles, np.int64).reshape(-1, 3)


def require_indices(where: str, corners: Indices, count: int) -> None:
    """Raise MeshError for corners that are not among so many points."""
    wrong = corners[(corners < 0) | (corners >= count)]
    if len(wrong):
        raise MeshError(f"{where}: a face of point {int(wrong[0])}: expected numbers from 0 to {count - 1}")
