"""Flat faces that lie folded on each other, as of a concave polygon that was cut into a fan: they become the polygon.

A fan's triangles outside of the polygon are turned over and lie on others, so that areas and volumes are right by their
signs, and no side of the surface is. What goes round such faces is the polygon, whatever lies within.
"""

import numpy as np

from ..bodies.material import Array
from .polygons import clipped
from .surface import Indices, MeshError, Surface, faces_of

_FLAT = 1 - 1e-6  # cosine of the normals of faces that lie in one plane, or on each other: within 0.1 degrees
_MEET = 8  # faces at an edge: a fan's few, those of walls, and of parts that touch there; a fan's meet in its order
_FOLDED = 1e-5  # of a patch's area: what lies folded is more
_OFF = 1e-6  # of the size: how far corners of a flat patch lie off its plane, as those of a file in float32 may
_COVERED = 1e-6  # of a polygon's area: triangles cover as much as the fan did by its signs


def unfolded(surface: Surface, sides: Indices) -> tuple[Indices, int]:
    """Return faces without folds, and how many faces took part in one. sides (m, 3): the edge of each side."""
    faces, areas = faces_of(surface)
    patch = _patches(faces, (sides, surface.faces))
    vectors = faces * areas[:, None]
    count = int(patch.max(initial=-1)) + 1
    whole = np.stack([np.bincount(patch, each, count) for each in vectors.T], axis=1)
    signed, total = np.linalg.norm(whole, axis=1), np.bincount(patch, areas, count)
    gone, made = np.zeros(len(patch), bool), []
    for number in np.flatnonzero((signed < (1 - _FOLDED) * total) & (signed > _COVERED * total)):
        own = np.flatnonzero(patch == number)
        found = _polygon(surface, own, whole[number], float(total[number]))
        if found is not None:
            gone[own] = True
            made.append(found)
    return np.vstack([surface.faces[~gone], *made]), int(gone.sum())


def _patches(normals: Array, meetings: tuple[Indices, ...]) -> Indices:
    """Return the number (m,) of the flat patch that each face belongs to.

    meetings: numbers (m, 3) of what faces meet at, edges or points: of those that lie in one plane, near ones in their
    order are of one patch.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    ones, others = [], []
    for numbers in meetings:
        order = np.argsort(numbers.ravel(), kind="stable")
        at, face = numbers.ravel()[order], order // 3
        for step in range(1, _MEET):
            one, other = face[:-step], face[step:]
            flat = at[:-step] == at[step:]
            flat &= np.abs(np.einsum("ij,ij->i", normals[one], normals[other])) > _FLAT
            ones.append(one[flat])
            others.append(other[flat])
    rows, columns = np.concatenate(ones), np.concatenate(others)
    links = coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(normals),) * 2)
    patches: Indices = connected_components(links, directed=False)[1].astype(np.int64)
    return patches


def _polygon(surface: Surface, own: Indices, whole: Array, total: float) -> Indices | None:
    """Return triangles (t, 3) of the polygon that flat faces go round, whose areas add up to `whole` (3,) as vectors
    and to `total` as numbers; None where it is none, or more than one."""
    corners = surface.faces[own]
    points = surface.points[np.unique(corners)]
    area = float(np.linalg.norm(whole))
    off = (points - points.mean(axis=0)) @ (whole / area)
    if np.abs(off).max() > _OFF * float(np.ptp(surface.points, axis=0).max()):
        return None
    rings = _outlines(corners)
    if rings is None:
        return None
    turns = []
    for ring in rings:
        at = surface.points[ring] - surface.points[ring[0]]
        turns.append(float(np.cross(at, np.roll(at, -1, axis=0)).sum(axis=0) @ whole))
    if sum(turn > 0 for turn in turns) != 1:
        return None
    rings.insert(0, rings.pop(int(np.argmax(turns))))
    try:
        made = clipped(surface.points, rings)
    except MeshError:
        return None
    covered = float(faces_of(Surface(surface.points, made)).areas.sum()) if len(made) else 0.0
    return made if abs(covered - area) < _COVERED * total else None


def _outlines(faces: Indices) -> list[Indices] | None:
    """Return the lines that go round faces, each as numbers of points; None where one crosses another."""
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2).tolist()
    left: dict[int, list[int]] = {}
    for one, other in sides:
        left.setdefault(one, []).append(other)
    for one, other in sides:  # what is run through both ways lies within
        if one in left.get(other, ()) and other in left.get(one, ()):
            left[one].remove(other)
            left[other].remove(one)
    after = {one: others for one, others in left.items() if others}
    if any(len(others) > 1 for others in after.values()):
        return None
    rings = []
    while after:
        start, (here,) = after.popitem()
        ring = [start]
        while here != start:
            if here not in after:
                return None
            ring.append(here)
            (here,) = after.pop(here)
        rings.append(np.array(ring, np.int64))
    return rings
