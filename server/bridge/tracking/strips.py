"""A point of a body: where on its object's strike path it is, and how round the body is there."""

import math

from ....dsp.bodies.material import ROUNDNESS
from ....dsp.native.jit import kernel
from ....dsp.native.typed import Items

POINT, DISC, BAR, PLATE, WALL = range(5)
"""Kinds of paths: there is one place; from the middle to the edge; along an axis; from corner to corner of a plate; one
place on a wall around z, whose ends are still."""

_ENDS = 0.9  # of the half length, or of an end's radius: beyond, a point is at an end, or at its rim


@kernel
def place_on(strip: Items[int], edges: Items[float], point: Items[float]) -> float:
    """Return the place 0 to 1 that is nearest to a point (m), in the body's axes.

    strip: a kind and two axes; edges: of the box around the body (m).
    """
    if strip[0] == POINT or strip[0] == WALL:
        return 0.0
    if strip[0] == DISC:
        far = math.sqrt(point[0] * point[0] + point[1] * point[1])
        return 0.5 + 0.5 * min(1.0, far / (0.5 * edges[0]))
    u = min(max(point[strip[1]] / edges[strip[1]] + 0.5, 0.0), 1.0)
    if strip[0] == BAR:
        return u
    v = min(max(point[strip[2]] / edges[strip[2]] + 0.5, 0.0), 1.0) - 0.5
    u -= 0.5
    return 0.5 + math.copysign(0.5 * (abs(u) + abs(v)), u if abs(u) > abs(v) else v)


@kernel
def is_still(strip: Items[int], edges: Items[float], point: Items[float]) -> bool:
    """True if a body's modes do not move at a point (m), in its axes: at the ends of a wall."""
    return strip[0] == WALL and abs(point[2]) > 0.5 * _ENDS * edges[2]


@kernel
def radius_at(side: float, flat: int, edges: Items[float], point: Items[float], stays: bool) -> float:
    """Return the radius (m) of the surface about a point (m), in the body's axes; of a face it is infinite.

    side: the radius of the body's side, 0 for one with edges; flat: 1 if the side ends at two faces across z. stays:
    True of a contact that lasts: along a rim it meets the side's radius. A blow on a rim meets the mean curvature, of
    the side and of a corner.
    """
    corner = min(corner_of(edges), 0.5 * min(edges[0], edges[1], edges[2]))
    if side > 0.0:
        if flat == 0 or abs(point[2]) <= 0.5 * _ENDS * edges[2]:
            return side
        if math.sqrt(point[0] * point[0] + point[1] * point[1]) <= _ENDS * side:
            return math.inf
        return side if stays else 2.0 / (1.0 / side + 1.0 / corner)
    ends = 0
    for k in range(3):
        if abs(point[k]) > 0.5 * _ENDS * edges[k]:
            ends += 1
    return math.inf if ends < 2 else corner


@kernel
def corner_of(edges: Items[float]) -> float:
    """Return the radius (m) of the corners of a body: as those of a cube of the volume of the box around it."""
    radius: float = 0.5 * ROUNDNESS * (edges[0] * edges[1] * edges[2]) ** (1 / 3)
    return radius
