"""Contacts on curved surfaces and on edges: by how much they are softer or stiffer than on a plane."""

import math

import numpy as np

from .modes import Faces
from .triangles import nearest

EDGE_RADIUS = 5e-4
"""m: the radius of an edge of which a mesh says none. Edges of parts that are machined or moulded are broken by 0.2 to
0.5 mm and more (ISO 13715); of a mesh's edges nobody knows it. Stiffness goes with its power of about 1/4."""

_HOLLOW = 0.02  # of the striker's curvature: what is left of it at least, where it lies in a hollow that nearly fits
_HALVINGS = 60


def curvatures_at(faces: Faces, point: tuple[float, float, float]) -> tuple[float, float]:
    """Return both principal curvatures (1/m) of a surface at its point nearest to another (m), positive where convex;
    on an edge, that of its radius and 0."""
    (number,), (share,) = nearest(faces.corners, np.array([point]))
    corners = faces.corners[number]
    twice = float(np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])))
    for side in range(3):
        length = float(np.linalg.norm(corners[(side + 1) % 3] - corners[side]))
        if faces.edges[number, side] and share[(side + 2) % 3] * twice < EDGE_RADIUS * length:
            return 1 / EDGE_RADIUS, 0.0
    one, other = share @ faces.curvature[number]
    return float(one), float(other)


def stiffness_share(radius: float, curvatures: tuple[float, float]) -> float:
    """Return the stiffness of a sphere of a radius (m) on a surface of two principal curvatures (1/m), over that on a
    plane.

    The contact is an ellipse: k = 4/3 E* sqrt(Re) F2^(-3/2), 1/Re^2 the product of the relative curvatures (K. L.
    Johnson, Contact Mechanics, 1985, 4.26 to 4.32). A hollow that fits the sphere counts as one that nearly does.
    """
    low, high = sorted(max(1 + radius * each, _HOLLOW) for each in curvatures)
    return float((low * high) ** -0.25 * _flattened(high / low) ** -1.5)


def _flattened(ratio: float) -> float:
    """Return Johnson's F2 of a ratio of relative curvatures of at least 1: by how much less than a circle's the
    compression is."""
    if ratio < 1 + 1e-9:
        return 1.0
    low, high = 0.0, 1.0  # the axes' ratio b/a
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        k, e = _elliptic(middle)
        low, high = (low, middle) if (e / middle**2 - k) / (k - e) < ratio else (middle, high)
    axes = (low + high) / 2
    k, e = _elliptic(axes)
    cube = 4 / (math.pi * (1 - axes**2)) * axes**1.5 * math.sqrt((e / axes**2 - k) * (k - e))
    return float(2 / math.pi * math.sqrt(axes) * k / cube ** (1 / 3))


def _elliptic(axes: float) -> tuple[float, float]:
    """Return the complete elliptic integrals K and E of the eccentricity of an ellipse of an axes' ratio, by the
    arithmetic-geometric mean."""
    a, b, total, power = 1.0, axes, (1 - axes**2) / 2, 1.0
    while a - b > 1e-15:
        a, b, c = (a + b) / 2, math.sqrt(a * b), (a - b) / 2
        total += power * c * c
        power *= 2
    k = math.pi / (a + b)
    return k, k * (1 - total)
