"""The motion of a point by modes that ring freely, many samples ahead: rows of its values at some times of each
sample."""

import numpy as np
from numpy.polynomial import Legendre, legendre

from ..native.jit import simd_kernel
from ..native.typed import View
from ..numerics.checks import Array
from ..numerics.legendre import FINE
from .bank import MOBILITY, RESPONSES, Modes, Point
from .simd import LANES, dot, put_product
from .simd_rows import COURSE, add_courses, put_courses, put_factors

_SERIES = [Legendre.basis(k, domain=[0, 1]) for k in range(FINE)]


def row_weights(time: float) -> Array:
    """Return the weights of the table that answers forces (coefficients.py) for a displacement at a time in [0, 1] of a
    sample: FINE of them."""
    return np.array([(-1.0) ** k * each(time) for k, each in enumerate(_SERIES)])


def course_weights(degree: int, begin: float, end: float) -> Array:
    """Return those for the mean of a displacement's rate from `begin` to `end`, times the Legendre polynomial of a
    degree over that time."""
    x, w = legendre.leggauss(FINE)
    times, shares = begin + (end - begin) * 0.5 * (x + 1.0), 0.5 * w * Legendre.basis(degree)(x)
    return np.array([(-1.0) ** k * (shares @ each.deriv()(times)) for k, each in enumerate(_SERIES)])


def room_for_rows(rows: int) -> int:
    """Return the number of values that `lay_rows` needs room for."""
    return (2 * rows + COURSE) * LANES


@simd_kernel
def lay_rows(
    modes: Modes, point: Point, weights: tuple[tuple[float, ...], ...], room: View[float], out: View[float]
) -> float:
    """Add the point's motion over the coming AHEAD samples without a force to `out`: one row after the other.

    Return the point's displacement now (m). weights: a tuple for each row, by `row_weights` or `course_weights`; the
    last one's is the displacement at the sample's end. Displacements are in m, rates in m per sample. `room` (float64)
    has `room_for_rows` values.
    """
    w = point.weights[0], point.weights[1], point.weights[2], point.weights[3]
    course = 2 * len(weights) * LANES
    last = course - 2 * LANES
    place = 0.0
    for first in range(0, len(modes.y1), LANES):
        group = first // LANES * RESPONSES
        phi = dot(point.shape, point.row * point.stride + first, point.stride, w)
        put_product(room, course, phi, dot(modes.response, group + MOBILITY, 0, (1.0,)))
        scale = dot(room, course, 0, (1.0,))
        put_product(room, course, scale, dot(modes.a2, first, 0, (1.0,)))
        # As `observe` does: by the state a sample later and the one before that.
        put_factors(room, (scale, dot(room, course, 0, (1.0,))), modes.response, group, weights)
        put_courses(room, course, modes.y1, modes.y2, modes.a1, modes.a2, first)
        add_courses(out, room, course, weights)
        for k in range(LANES):  # what the last row would have been a sample ago
            place += room[last + k] * room[course + k * COURSE] + room[last + LANES + k] * modes.y1[first + k]
    return place
