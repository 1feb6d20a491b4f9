"""Curved surfaces of flat triangles: what lies between their corners, by the normals there.

A place of a triangle moves half of the way to the planes that touch the surface at its corners (Phong tessellation: T.
Boubekeur, M. Alexa, ACM Trans. Graph. 27, 2008, who go further). Half of it is right for any surface that curves
evenly: what its chord misses at a share u of its length L is u (1 - u) L^2/(2 R), what the planes say twice that.
"""

import numpy as np

from ..bodies.material import Array
from .cleaning import edges_of
from .surface import Indices, Surface, faces_of

CREASE = 0.77
"""Cosine of the angle between two faces: a sharper edge is one."""

_WAY = 0.5  # to the corners' planes
_GROWS = 1.15
"""Times its area that a triangle has at most when it is round: one of a ball whose faces turn by a crease from each
other, the most that is rounded, has 1.09. More is of a strip that twists, whose normals show nothing round."""


def corner_normals(surface: Surface) -> Array:
    """Return unit normals (m, 3, 3) at the corners of each face: the mean of the faces about that turn less than a
    crease from it, either way round, by their angles there, so that it does not matter how a surface is cut."""
    normals, angles = faces_of(surface).normals, _angles(surface).ravel()
    corners = surface.faces.ravel()
    order = np.argsort(corners, kind="stable")
    begin = np.flatnonzero(np.r_[True, np.diff(corners[order]) > 0, True])
    size = np.diff(begin)
    start, size = np.repeat(begin[:-1], size), np.repeat(size, size)
    face = order // 3
    total = np.zeros((len(order), 3))
    for step in range(int(size.max())):
        there = step < size
        corner = order[np.where(there, start + step, 0)]
        other = corner // 3
        cosine = np.einsum("ij,ij->i", normals[face], normals[other])
        weight = np.where(there & (np.abs(cosine) > CREASE), angles[corner] * np.sign(cosine), 0.0)
        total += weight[:, None] * normals[other]
    found = np.zeros((len(order), 3))
    found[order] = _unit(total)
    return found.reshape(-1, 3, 3)


def rounded(corners: Array, normals: Array, at: Array) -> tuple[Array, Array]:
    """Return places and normals (f, n, 3) of triangles at shares (n, 3) of their corners."""
    flat = np.einsum("gc,fcd->fgd", at, corners)
    below = np.einsum("fgcd,fcd->fgc", corners[:, None] - flat[:, :, None], normals)
    places = flat + _WAY * np.einsum("gc,fgc,fcd->fgd", at, below, normals)
    return places, _unit(np.einsum("gc,fcd->fgd", at, normals))


def middles_of(surface: Surface) -> Array:
    """Return the middles (e, 3) of the edges, in the order of `edges_of`. On a crease each of the two faces gives how
    far its surface lies off the chord; the middle is on both. The edges of a triangle that would grow too much stay
    straight."""
    _, number, _ = edges_of(surface.faces)
    at = np.array([[0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]])
    corners = surface.points[surface.faces]
    chords = np.einsum("gc,fcd->fgd", at, corners).reshape(-1, 3)
    places, looks = (each.reshape(-1, 3) for each in rounded(corners, corner_normals(surface), at))
    moved = places - chords
    order = np.argsort(number.ravel(), kind="stable")
    count = np.bincount(number.ravel())
    one = order[np.cumsum(count) - count]
    other = order[np.cumsum(count) - count + np.minimum(count - 1, 1)]
    cosine = np.einsum("ij,ij->i", looks[one], looks[other])
    first, second = (np.einsum("ij,ij->i", moved[each], looks[each]) for each in (one, other))
    apart = np.maximum(1 - cosine**2, 1 - CREASE**2)[:, None]
    both = (first - cosine * second)[:, None] * looks[one] + (second - cosine * first)[:, None] * looks[other]
    mean = (moved[one] + moved[other]) / 2
    found: Array = chords[one] + np.where((np.abs(cosine) < CREASE)[:, None], both / apart, mean)
    faces, most = _quarters(surface), _GROWS * faces_of(surface).areas
    while True:
        areas = faces_of(Surface(np.vstack([surface.points, found]), faces)).areas
        grown = number[areas.reshape(4, -1).sum(axis=0) > most]
        if (found[grown] == chords[one][grown]).all():
            return found
        found[grown] = chords[one][grown]


def quartered(surface: Surface) -> Surface:
    """Return a surface each triangle of which is four."""
    return Surface(np.vstack([surface.points, middles_of(surface)]), _quarters(surface))


def _quarters(surface: Surface) -> Indices:
    """Return the faces (4 m, 3) that a surface has once a middle of each edge follows its points."""
    _, number, _ = edges_of(surface.faces)
    a, b, c = surface.faces.T
    x, y, z = len(surface.points) + number.T
    faces: Indices = np.concatenate([np.stack(each, axis=1) for each in ((a, x, z), (x, b, y), (z, y, c), (x, y, z))])
    return faces


def _angles(surface: Surface) -> Array:
    """Return the angles (m, 3) of faces at their corners, in rad."""
    corners = surface.points[surface.faces]
    ahead, back = (_unit(np.roll(corners, -turn, axis=1) - corners) for turn in (1, 2))
    return np.asarray(np.arccos(np.clip(np.einsum("fcd,fcd->fc", ahead, back), -1, 1)))


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300))
