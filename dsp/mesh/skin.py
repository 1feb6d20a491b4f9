"""A coarse triangle mesh on a surface: the corners at which a model keeps its shapes, between which they are linear.

Corners lie about equally far apart, first where edges of the body meet, then along its edges, then between; closer
where the surface turns. On an edge a corner is there for each side. Triangles are Delaunay's in the plane of each
corner; those that two of their corners find are taken (as N. Amenta et al., Int. J. Comput. Geom. Appl. 12, 2002). So
it holds for any triangles, whether they fit together or not.
"""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from .cleaning import edges_of
from .nearest import Nearest
from .points import Samples, sampled
from .rounding import CREASE
from .surface import Flags, Indices, MeshError, Surface, faces_of

_SAMPLES = 24  # for each corner that is wanted
_DISCS = 0.82  # of the spacing: the radius in which one corner is
_STEP = 0.25  # of the spacing: between places of an edge that are tried
_REACH = 2.6  # spacings: neighbours of a corner
_TURNED = 0.3  # cosine of the normals of neighbours
_STEEP = 0.7  # of a neighbour's distance: how far it lies off the corner's plane
_OFF = 0.55  # of the spacing: how far a triangle's middle may lie from the surface
_BESIDE = 0.05  # of the spacing: how far from the surface, along itself, a place of a triangle may lie
_FACES = 0.5  # cosine of a triangle's normal and those of its corners
_FOUND = 2  # corners of a triangle that find it


class Skin(NamedTuple):
    """A coarse mesh: places (P, 3) in m with one outward normal (P, 3) each, so that a place on an edge of the body is
    there for each of its sides; faces (F, 3), numbers of places; edges (F, 3): whether the side from each corner to the
    next is a sharp edge of the body."""

    places: Array
    normals: Array
    faces: Indices
    edges: Flags


class _Corners(NamedTuple):
    """Corners that are tried: places (n, 3), normals (n, 3), numbers of the places (n,), which those at one place
    share, and whether each lies on a convex edge, or an open one."""

    places: Array
    normals: Array
    own: Indices
    sharp: Flags


def skin_of(surface: Surface, points: int) -> Skin:
    """Return the coarse mesh of a surface, of about so many corners or some more. MeshError if none fits it."""
    samples = sampled(surface, _SAMPLES * points)
    spacing = float(np.sqrt(samples.area * _SAMPLES))
    corners = _corners(surface, samples, spacing)
    faces = _triangles(surface, corners, samples, spacing)
    if not len(faces):
        raise MeshError(f"no triangle of {1e3 * spacing:.3g} mm fits the surface: expected more points")
    normals = _smoothed(corners, samples, spacing)
    a, b, c = corners.places[faces].transpose(1, 0, 2)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), normals[faces].sum(axis=1)) < 0
    faces[inward] = faces[inward][:, ::-1]
    used = np.unique(faces)
    faces = np.searchsorted(used, faces)
    sharp = corners.sharp[used]
    sides, number, _ = edges_of(faces)
    alone = np.bincount(number.ravel(), minlength=len(sides)) == 1
    return Skin(corners.places[used], normals[used], faces, (alone & sharp[sides].all(axis=1))[number])


def _corners(surface: Surface, samples: Samples, spacing: float) -> _Corners:
    """Return the corners of a coarse mesh."""
    from scipy.spatial import cKDTree

    places, sides, convex, first = _on_edges(surface, spacing)
    looks = np.concatenate([sides.sum(axis=1), samples.normals])
    looks /= np.maximum(np.linalg.norm(looks, axis=1), 1e-300)[:, None]
    every = np.concatenate([places, samples.places])
    tree = cKDTree(np.hstack([every, looks * spacing]))
    alive, chosen = np.ones(len(every), bool), []
    rank = np.concatenate([np.where(first, 0, 1), np.full(len(samples.places), 2)])
    for number in np.lexsort((np.random.default_rng(1).permutation(len(every)), rank)):
        if alive[number]:
            chosen.append(number)
            alive[tree.query_ball_point(tree.data[number], _DISCS * spacing)] = False
    numbers = np.array(chosen)
    edge = numbers[numbers < len(places)]
    own, side = np.nonzero((sides[edge] ** 2).sum(axis=2) > 0)
    flat = numbers[numbers >= len(places)] - len(places)
    return _Corners(
        np.concatenate([places[edge][own], samples.places[flat]]),
        np.concatenate([sides[edge][own, side], samples.normals[flat]]),
        np.concatenate([own, len(edge) + np.arange(len(flat))]),
        np.concatenate([convex[edge][own], np.zeros(len(flat), bool)]),
    )


def _on_edges(surface: Surface, spacing: float) -> tuple[Array, Array, Flags, Flags]:
    """Return places (n, 3) on the edges of a body, the normals (n, 3, 3) of the sides that meet there (0: fewer),
    whether the edge is convex or open, and whether edges meet or turn there."""
    ends, number, _ = edges_of(surface.faces)
    normals = faces_of(surface).normals
    face = np.repeat(np.arange(len(surface.faces)), 3)
    order = np.argsort(number.ravel(), kind="stable")
    count = np.bincount(number.ravel(), minlength=len(ends))
    begin = np.cumsum(count) - count
    one = face[order[begin]]
    other = face[order[np.minimum(begin + 1, len(order) - 1)]]
    cosine = np.einsum("ij,ij->i", normals[one], normals[other])
    sharp = (count != 2) | (cosine < CREASE)
    middle = surface.points[surface.faces].mean(axis=1)
    convex = (count != 2) | (np.einsum("ij,ij->i", normals[one], middle[other] - middle[one]) < 0)
    sides = np.stack(
        [normals[one], np.where((count > 1)[:, None], normals[other], 0.0), np.zeros((len(ends), 3))], axis=1
    )
    ends, sides, convex = ends[sharp], sides[sharp], convex[sharp]
    a, b = surface.points[ends[:, 0]], surface.points[ends[:, 1]]
    steps = np.ceil(np.linalg.norm(b - a, axis=1) / (_STEP * spacing)).astype(np.int64)
    edge = np.repeat(np.arange(len(ends)), steps)
    share = ((np.arange(len(edge)) - np.repeat(np.cumsum(steps) - steps, steps) + 0.5) / steps[edge])[:, None]
    at, looks, open_at = _meetings(surface, ends, sides, convex)
    first = np.arange(len(at) + len(edge)) < len(at)
    return (
        np.concatenate([at, a[edge] * (1 - share) + b[edge] * share]),
        np.concatenate([looks, sides[edge]]),
        np.concatenate([open_at, convex[edge]]),
        first,
    )


def _meetings(surface: Surface, ends: Indices, sides: Array, convex: Flags) -> tuple[Array, Array, Flags]:
    """Return the points at which edges meet or turn, with up to three normals of the sides there (n, 3, 3)."""
    points, count = surface.points, np.bincount(ends.ravel(), minlength=len(surface.points))
    way = points[ends[:, 1]] - points[ends[:, 0]]
    way /= np.maximum(np.linalg.norm(way, axis=1), 1e-300)[:, None]
    total = np.zeros((len(points), 3))
    np.add.at(total, ends[:, 0], way)
    np.add.at(total, ends[:, 1], -way)
    found = np.flatnonzero((count > 0) & ((count != 2) | ((total**2).sum(axis=1) > 2 - 2 * CREASE)))
    at: dict[int, list[int]] = {int(number): [] for number in found}
    for number, pair in enumerate(ends.tolist()):
        for end in pair:
            if end in at:
                at[end].append(number)
    looks = np.zeros((len(found), 3, 3))
    for row, numbers in enumerate(at.values()):
        kept: list[Array] = []
        for look in sides[numbers].reshape(-1, 3):
            if look.any() and all(look @ each < CREASE for each in kept) and len(kept) < 3:
                kept.append(look)
        looks[row, : len(kept)] = np.reshape(kept, (-1, 3))
    return points[found], looks, np.array([convex[numbers].all() for numbers in at.values()], bool)


def _triangles(surface: Surface, corners: _Corners, samples: Samples, spacing: float) -> Indices:
    """Return the triangles (F, 3) between corners."""
    from scipy.spatial import Delaunay, QhullError, cKDTree

    tree = cKDTree(corners.places)
    found: list[Indices] = []
    for number, near in enumerate(tree.query_ball_point(corners.places, _REACH * spacing, return_sorted=True)):
        near = _others(corners, number, np.array(near, np.int64))
        normal, way = corners.normals[number], corners.places[near] - corners.places[number]
        distance, depth = np.linalg.norm(way, axis=1), np.abs(way @ normal)
        fits = (corners.normals[near] @ normal > _TURNED) & (depth < _STEEP * distance)
        near, way = near[fits], way[fits]
        if len(near) < 2:
            continue
        across = np.linalg.svd(normal[None])[2][1:]
        try:
            made = Delaunay(np.vstack([np.zeros(2), way @ across.T]) / spacing, qhull_options="QJ Pp").simplices
        except QhullError:
            continue
        made = made[(made == 0).any(axis=1)]
        found.append(np.r_[number, near][made])
    if not found:
        return np.zeros((0, 3), np.int64)
    every, count = np.unique(np.sort(np.concatenate(found), axis=1), axis=0, return_counts=True)
    every = every[count >= _FOUND]
    middle, look = corners.places[every].mean(axis=1), corners.normals[every].sum(axis=1)
    look /= np.maximum(np.linalg.norm(look, axis=1), 1e-300)[:, None]
    skin = cKDTree(np.hstack([samples.places, samples.normals * spacing]))
    beside: Flags = skin.query(np.hstack([middle, look * spacing]))[0] < _OFF * spacing
    a, b, c = corners.places[every].transpose(1, 0, 2)
    cross = np.cross(b - a, c - a)
    area = np.linalg.norm(cross, axis=1)
    # Of corners in a row, along a rim, Delaunay's makes slivers across it.
    faces_so = np.abs(np.einsum("ij,ij->i", cross, look)) > _FACES * area
    kept: Indices = every[beside & faces_so & (area > 1e-4 * spacing**2)]
    return kept[_lying(surface, corners.places[kept], spacing)]


def _lying(surface: Surface, corners: Array, spacing: float) -> Flags:
    """Return which triangles, by their corners (t, 3, 3), lie on a surface: none that bridges a gap, as between two
    prongs. Where the surface is round a triangle lies below it, but not beside it."""
    a, b, c = corners.transpose(1, 0, 2)
    places = np.stack([(a + b) / 2, (b + c) / 2, (c + a) / 2, (a + b + c) / 3], axis=1)
    face, share = Nearest(surface).to(places.reshape(-1, 3))
    away = np.einsum("nc,nck->nk", share, surface.points[surface.faces[face]]).reshape(places.shape) - places
    look = np.cross(b - a, c - a)
    look /= np.maximum(np.linalg.norm(look, axis=1), 1e-300)[:, None]
    aside = away - np.einsum("tpk,tk->tp", away, look)[:, :, None] * look[:, None]
    found: Flags = np.linalg.norm(aside, axis=2).max(axis=1, initial=0.0) < _BESIDE * spacing
    return found


def _others(corners: _Corners, number: int, near: Indices) -> Indices:
    """Return the corners at other places, of each place the one whose normal is most alike."""
    near = near[corners.own[near] != corners.own[number]]
    near = near[np.argsort(-(corners.normals[near] @ corners.normals[number]), kind="stable")]
    others: Indices = near[np.sort(np.unique(corners.own[near], return_index=True)[1])]
    return others


def _smoothed(corners: _Corners, samples: Samples, spacing: float) -> Array:
    """Return the corners' normals, as those of the samples about turn less than an edge does."""
    from scipy.spatial import cKDTree

    near = cKDTree(samples.places).query_ball_point(corners.places, 0.5 * spacing, return_sorted=True)
    normals = corners.normals.copy()
    for number, numbers in enumerate(near):
        about = samples.normals[numbers]
        alike = about[about @ corners.normals[number] > CREASE]
        # On an edge all samples lie to one side, so a mean over them would lean.
        if len(alike) and not corners.sharp[number]:
            normals[number] = alike.mean(axis=0)
    unit: Array = normals / np.linalg.norm(normals, axis=1)[:, None]
    return unit
