"""The motion of a point by modes that ring freely, many samples ahead: rows of its values at some times of each
sample."""

import numpy as np
from numpy.polynomial import Legendre, legendre

from ..native.jit import simd_kernel
from ..native.typed import View
from ..numerics.checks import Array
from ..numerics.legendre import AHEAD, FINE
from ..numerics.sums import line_of
from .bank import MOBILITY, RESPONSES, Modes, Point
from .simd import LANES, dot, put_product
from .simd_rows import add_courses, add_lanes, put_factors

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


@simd_kernel
def lay_rows(
    modes: Modes, point: Point, weights: tuple[tuple[float, ...], ...], samples: int, room: View[float],
    out: View[float],
) -> float:  # fmt: skip
    """Add the point's motion over so many coming samples, AHEAD at most, without a force to `out`: one row after the
    other, each of AHEAD values.

    Return the last row's value a sample before its first: the point's displacement now (m), if that row is the
    displacement at the sample's end. weights: a tuple for each row, AT_ONCE of them at most, by `row_weights` or
    `course_weights`. Displacements are in m, rates in m per sample. `room` (float64) has ROOM_FOR_ROWS values.
    """
    room = room[line_of(room) :]
    begin, size = AHEAD * len(weights) * LANES, len(modes.y1)
    rung = modes.y1, modes.y2, modes.a1, modes.a2
    for i in range(samples * len(weights) * LANES):
        room[i] = 0.0
    now = begin + (4 * len(weights) + 1) * LANES
    for i in range(LANES):
        room[now + i] = 0.0
    for first in range(0, size - LANES, 2 * LANES):
        second = first + LANES
        _put(modes, point, weights, room, (first, begin))
        _put(modes, point, weights, room, (second, begin + 2 * len(weights) * LANES))
        add_courses(room, rung, (first, second), weights, samples)
    if size % (2 * LANES) > 0:
        _put(modes, point, weights, room, (size - LANES, begin))
        add_courses(room, rung, (size - LANES,), weights, samples)
    add_lanes(out, room, weights, samples)
    place = 0.0
    for i in range(LANES):
        place += room[now + i]
    return place


@simd_kernel
def _put(
    modes: Modes, point: Point, weights: tuple[tuple[float, ...], ...], room: View[float], at: tuple[int, int]
) -> None:
    """Write the factors of LANES modes in rows.

    at: the first mode, and the factors' place in `room`, in which one more value for each mode follows.
    """
    first, begin = at
    group, aside = first // LANES * RESPONSES, begin + 2 * len(weights) * LANES
    w = point.weights[0], point.weights[1], point.weights[2], point.weights[3]
    phi = dot(point.shape, point.row * point.stride + first, point.stride, w)
    put_product(room, aside, phi, dot(modes.response, group + MOBILITY, 0, (1.0,)))
    scale = dot(room, aside, 0, (1.0,))
    put_product(room, aside, scale, dot(modes.a2, first, 0, (1.0,)))
    # As `observe` does: by the state a sample later and the one before that.
    put_factors(room, begin, (scale, dot(room, aside, 0, (1.0,))), modes.response, group, weights)
