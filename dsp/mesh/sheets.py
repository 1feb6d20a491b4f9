"""Points and weights inside of a sheet: a wall about any triangles, open or closed, for finite cells.

Each triangle is cut into small ones and rounded by its corners' normals, so that coarse meshes of round things are
round.
"""

import numpy as np

from ..bodies.material import Array
from .grids import Grid
from .polynomials import gauss
from .rays import Quadrature
from .rounding import corner_normals, rounded
from .surface import Surface, faces_of

_FINE = 6  # small triangles along a cell's side


def of_sheet(surface: Surface, wall: float, grid: Grid, layers: int) -> Quadrature:
    """Return points in a wall (m) about a surface, in so many layers."""
    normals = corner_normals(surface)
    corners = surface.points[surface.faces]
    side = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    cuts = np.maximum(1, np.ceil(side * _FINE / grid.side).astype(np.int64))
    area = faces_of(surface).areas
    places, weights, across = [], [], []
    nodes, shares = gauss(layers)
    for count in np.unique(cuts):
        these = cuts == count
        at = _barycentric(int(count))
        middle, normal = rounded(corners[these], normals[these], at)
        weight = np.repeat(area[these, None] / len(at), len(at), axis=1).ravel()
        for node, share in zip(nodes, shares, strict=True):
            places.append((middle + (node - 0.5) * wall * normal).reshape(-1, 3))
            weights.append(weight * share * wall)
            across.append(normal.reshape(-1, 3))
    every = np.vstack(places)
    cells, none = grid.number(every), np.zeros(0, np.int64)
    return Quadrature(every, np.concatenate(weights), cells, none, np.vstack(across), np.full(len(every), wall), 0.0)


def _barycentric(count: int) -> Array:
    """Return the shares (n, 3) of a triangle's corners at three points of each of count^2 small ones."""
    small = []
    for i in range(count):
        for j in range(count - i):
            small.append([[i, j], [i + 1, j], [i, j + 1]])
            if i + j < count - 1:
                small.append([[i + 1, j], [i + 1, j + 1], [i, j + 1]])
    inner = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6
    at = np.einsum("gc,bcd->bgd", inner, np.array(small) / count).reshape(-1, 2)
    return np.asarray(np.c_[1 - at.sum(axis=1), at])
