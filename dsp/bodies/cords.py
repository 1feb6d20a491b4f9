"""Cords that a tuned bar lies on or hangs in, at the nodes of its lowest mode: what they take from the others.

Each cord resists what moves there up and down as a dashpot of R (kg/s), and so takes R phi(x)^2/2 (1/s) from a mode of
the mass-normalised shape phi. Of a twist it is the mean over the bar's width. Motion along the cord goes on as it is,
and the lowest mode loses next to nothing.
"""

from collections.abc import Callable

import numpy as np

from .material import Array

_PLACES = np.linspace(0.0, 1.0, 401)
_BISECTIONS = 40


def nodes(shape: Callable[[Array], Array]) -> Array:
    """Return the first and the last position in 0..1 where the lowest mode of shapes, positions (p,) -> (p, n), stands
    still. ValueError where it does so at fewer than two: a bar that is 30,000 times as long as thick has its lowest
    modes lost in rounding."""
    found = np.flatnonzero(np.diff(np.signbit(shape(_PLACES)[:, 0])))
    if found.size < 2:
        raise ValueError("cords: expected a thicker or shorter bar, whose lowest mode has nodes that can be found")
    changes = found[[0, -1]]
    low, high = _PLACES[changes], _PLACES[changes + 1]
    below = np.signbit(shape(low)[:, 0])
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        before = np.signbit(shape(middle)[:, 0]) == below
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return low


def require_resistance(cords: float) -> None:
    """Raise ValueError unless cords resist, and do not push."""
    if not cords >= 0:
        raise ValueError(f"cords = {cords}: expected 0 or more")
