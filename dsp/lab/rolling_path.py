"""Paths as data: that of a body's lowest point, piece by piece."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..numerics.checks import checked
from ..rolling.path import PATH, PIECES, make_pieces, restart_path


@njit(error_model="numpy")
def restart(path, surface, radius, corners, speed, place):
    """Begin a body's path on a surface at a place."""
    path.surface = surface
    path.radius = radius
    path.corners = corners
    path.speed = speed
    path.roughness = 1.0
    path.coarseness = 1.0
    restart_path(path, place)


@njit(error_model="numpy")
def pieces_of(path, end, pieces):
    """Put a path's pieces up to `end` m into rows of `pieces`; how many there are."""
    total = 0.0
    for n in range(len(pieces)):
        while path.made <= n:
            make_pieces(path)
        i = n & (PIECES - 1)
        pieces[n, 0] = total
        pieces[n, 1] = path.level[i]
        pieces[n, 2] = path.incline[i]
        pieces[n, 3] = path.curvature[i]
        total += path.length[i]
        if total >= end:
            return n + 1
    return len(pieces)


def path_pieces(
    surface: np.void,
    radius: float,
    speed: float,
    length: float,
    corners: int = 0,
    place: int = 0,
    most: int = 1_000_000,
) -> NDArray[np.float64]:
    """Return the path of a body of a radius (m) over `length` (m) of a surface, piece by piece.

    It is as detailed as it is heard at a speed (m/s). Rows of where the piece begins (m from the first, which is at or
    just before `place`), and the path's height (m), slope and curvature (1/m) there; float64 (pieces, 4), `most` at
    most. corners: the body's, 0 if it is round. ValueError names what is out of range.
    """
    radius, speed, length = (
        float(checked(name, value, 0.0)) for name, value in (("radius", radius), ("speed", speed), ("length", length))
    )
    path = np.zeros(1, PATH)[0]
    angular = float(checked("corners", corners, 0.0, strict=False))
    restart(path, surface, radius, angular, speed, int(place))
    pieces = np.empty((most, 4))
    return pieces[: pieces_of(path, length, pieces)].copy()
