"""Paths as data: that of a body's lowest point, piece by piece."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..numerics.checks import checked
from ..rolling.path import PATH, PIECES, extend_path, restart_path


@njit(error_model="numpy")
def restart(path, surface, radius, corners, speed, place):
    """Begin a body's path on a surface at a place."""
    path.surface = surface
    path.radius = radius
    path.corners = corners
    path.speed = speed
    path.roughness = 1.0
    path.coarseness = 1.0
    restart_path(path, place, -1, 0.0)


@njit(error_model="numpy")
def pieces_of(path, end, pieces):
    """Put a path's pieces up to `end` m into rows of `pieces`; how many there are."""
    total = 0.0
    for n in range(len(pieces)):
        extend_path(path, n + 1)
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
    """Return the path of a body over a surface, piece by piece.

    Parameters
    ----------
    surface : SURFACE record
        As `make_surface` returns it.
    radius : float
        Radius of the body, m.
    speed : float
        Speed, m/s, at which the path is as detailed as is audible.
    length : float
        Length of the path, m.
    corners : int, default 0
        Number of the body's corners; 0: round.
    place : int, default 0
        Beginning, in units of the surface.
    most : int, default 1000000
        Largest number of rows.

    Returns
    -------
    array (pieces, 4)
        float64: beginning of the piece (m from the first, which is at or just before `place`), and the path's height
        (m), slope and curvature (1/m) there.

    Raises
    ------
    ValueError
        An argument is out of range; the text names it.
    """
    radius, speed, length = (
        float(checked(name, value, 0.0)) for name, value in (("radius", radius), ("speed", speed), ("length", length))
    )
    path = np.zeros(1, PATH)[0]
    angular = float(checked("corners", corners, 0.0, strict=False))
    restart(path, surface, radius, angular, speed, int(place))
    pieces = np.empty((most, 4))
    return pieces[: pieces_of(path, length, pieces)].copy()
