"""Where on an object's strike path a point of its body is."""

import math

from ..native.jit import kernel

POINT, DISC, BAR, PLATE = range(4)
"""Kinds of paths: there is one place; from the middle to the edge; along an axis; from corner to corner of a plate."""


@kernel
def place_on(strip, edges, point):
    """The place 0 to 1 that is nearest to a point (m), in the body's axes.

    strip: a kind and two axes; edges: of the box around the body (m).
    """
    if strip[0] == POINT:
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
