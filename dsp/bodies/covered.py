"""What a pad that covers an area of a body finds of its modes: the mean of their squares over the area.

A resistance R that is spread evenly over the area takes R <phi^2>/2 (1/s) of a mode, with the mean over the area. The
body as a whole has <phi^2> = 1/M, of the mass M, as its shapes are mass-normalised.

Across a strike path a shape is not known, but for its wave number k_t, as it bends with k in all: k_t^2 = k^2 - k_s^2,
of k_s along the path. So phi(s, t) = X(s) Y(t), Y = a cos(k_t t) + b sin(k_t t). The path gives X^2 a^2, and the body's
mean a^2 + b^2 = 2/(M <X^2>). Over a pad of radius r Y^2 has the mean (a^2 (1 + u) + b^2 (1 - u))/2, u = sin(2 k_t r)/(2
k_t r). This is exact of shapes that are such products; others are within a factor of 2, most of them.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from .material import Array, Material
from .modes import Faces, Modes

_ROWS = 4  # between which a position is read
_LEAST = 1e-300
_ALIKE = 0.1
"""Share of the body's mean with which a shape counts as even along its path: of a path along a node alone is known that
the pad reaches beyond it. With it a free plate's modes are within 3 dB in 80 of 100 places."""


def mean_squares(
    modes: Modes, shape: str, geometry: Mapping[str, Any], material: Material | None, area: float,
    point: tuple[float, ...] | None = None,
) -> Array:  # fmt: skip
    """Return the mean squares of modes over a pad.

    Parameters
    ----------
    modes : Modes
        Modes of the body.
    shape, geometry, material : str, Mapping, Material or None
        What the body was made of.
    area : float
        Area of the pad, m^2.
    point : tuple of 3 float, optional
        Point of a body with a surface on which the pad lies. Default: it lies on the strike path.

    Returns
    -------
    float64 (P, n)
        Means in 1/kg at P equally spaced positions along the strike path. Bodies without known shapes have 1/M of the
        body's mass M at each.
    """
    radius, rows = math.sqrt(area / math.pi), max(len(modes.strike), _ROWS)
    if not modes.frequency.size:
        return np.zeros((rows, 0))
    if modes.faces is not None:
        return _on_faces(modes, modes.faces, radius, point)
    if shape in ("bar", "string") and len(modes.strike) > 1:
        squares = _smoothed(modes.strike**2, np.ones(rows), float(geometry["length"]), radius)
        evened: Array = squares / np.maximum(modes.mass * squares.mean(axis=0), _LEAST)
        return evened
    if shape in ("plate", "disc", "membrane") and material is not None:
        return _on_plate(modes, shape, geometry, material, radius)
    return np.full((rows, modes.frequency.size), 1.0 / modes.mass)


def _on_plate(modes: Modes, shape: str, geometry: Mapping[str, Any], material: Material, radius: float) -> Array:
    """Return the mean squares of what bends, or is tense, in two directions, as the module says."""
    strike, count = modes.strike, len(modes.strike)
    if shape == "plate":
        sides = np.array([geometry["length"], geometry["width"]])
        ends = geometry.get("path_from", (0.0, 0.0)), geometry.get("path_to", (1.0, 1.0))
        length, share = float(np.linalg.norm(np.subtract(*ends) * sides)), np.ones(count)
    else:  # on a diameter; so much of a disc is as far from its centre
        length, share = 2.0 * geometry["radius"], np.abs(np.linspace(-1.0, 1.0, count))
    if shape == "membrane":
        wave = _FIRST_ROOT / geometry["radius"] * modes.frequency / modes.frequency[0]
    else:
        speed = geometry["thickness"] * math.sqrt(material.contact_modulus / 12.0 / material.density)
        wave = np.sqrt(2.0 * math.pi * modes.frequency / speed)
    if length == 0.0 or count < _ROWS:
        return np.full((max(count, _ROWS), modes.frequency.size), 1.0 / modes.mass)
    share = share / share.sum()
    slopes = np.gradient(strike, length / (count - 1), axis=0)
    mean, rest = share @ strike**2, _ALIKE / modes.mass
    turned = 2.0 * radius * np.sqrt(np.maximum(wave**2 - share @ slopes**2 / (mean + rest), 0.0))
    evened = np.sinc(turned / math.pi)
    there = modes.mass * mean  # a^2 over (a^2 + b^2)/2
    across = 0.5 * (there * (1.0 + evened) + np.maximum(2.0 - there, 0.0) * (1.0 - evened))
    found: Array = (_smoothed(strike**2, share, length, radius) + rest) / (mean + rest) * across / modes.mass
    return found


_FIRST_ROOT = 2.405  # of J_0: k r of a membrane's lowest mode


def _smoothed(squares: Array, share: Array, length: float, radius: float) -> Array:
    """Return means of rows along a path of a length (m) over a disc about each; `share`: how much of the body is as far
    along the path."""
    place, share = np.linspace(0.0, length, len(squares)), share + share.max() / len(share)
    chord = np.sqrt(np.maximum(radius**2 - np.subtract.outer(place, place) ** 2, 0.0)) * share
    found: Array = chord / chord.sum(axis=1, keepdims=True) @ squares
    return found


def _on_faces(modes: Modes, faces: Faces, radius: float, point: tuple[float, ...] | None) -> Array:
    """Return the mean squares over the triangles of a surface whose middles are under the pad, or over the nearest."""
    middle = faces.corners.mean(axis=1)
    sides = faces.corners[:, 1:] - faces.corners[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    places = faces.line if point is None else np.array([point])
    apart = np.linalg.norm(places[:, None] - middle, axis=2)
    under = areas * (apart <= np.maximum(radius, apart.min(axis=1, keepdims=True)))
    under /= under.sum(axis=1, keepdims=True)
    used = under.any(axis=0)
    squares = np.mean([modes.strike[faces.rows[used] + corner] ** 2 for corner in range(3)], axis=0)
    found: Array = under[:, used] @ squares
    return np.repeat(found, _ROWS, axis=0) if len(found) < _ROWS else found
