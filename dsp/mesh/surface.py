"""Triangle meshes: corners, normals, areas, volumes."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..bodies.material import Array
from ..errors import CaromError

Indices = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]


class MeshError(CaromError, ValueError):
    """A mesh of which no model can be made; the text says why, and where."""


class Surface(NamedTuple):
    """A triangle mesh: points (n, 3) in m, and faces (m, 3), numbers of points, counter-clockwise from outside."""

    points: Array
    faces: Indices


class Faces(NamedTuple):
    """The triangles of a surface: unit normals (m, 3) and areas (m,) in m^2."""

    normals: Array
    areas: Array


def faces_of(surface: Surface) -> Faces:
    """Return unit normals and areas; a triangle without area has the normal 0."""
    a, b, c = surface.points[surface.faces.T].transpose(0, 2, 1)
    (x, y, z), (u, v, w) = b - a, c - a
    twice = np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)
    length = np.sqrt(np.einsum("ij,ij->i", twice, twice))
    return Faces(twice / np.maximum(length, 1e-300)[:, None], length / 2)


def volume_of(surface: Surface) -> float:
    """Return the volume (m^3) that a closed surface encloses; parts that overlap count twice."""
    a, b, c = surface.points[surface.faces].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a - surface.points.mean(axis=0), np.cross(b - a, c - a)) / 6)


def size_of(surface: Surface) -> Array:
    """Return the extents (3,) of a surface in m."""
    extents: Array = np.ptp(surface.points, axis=0)
    return extents


def rotation(angles: tuple[float, float, float]) -> Array:
    """Return the matrix (3, 3) that turns about z by the last of three angles (rad), then about y, then x."""
    matrix = np.eye(3)
    for axis, angle in enumerate(angles):
        cosine, sine = np.cos(angle), np.sin(angle)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(3)
        turn[i, i] = turn[j, j] = cosine
        turn[i, j], turn[j, i] = -sine, sine
        matrix = matrix @ turn
    return matrix
