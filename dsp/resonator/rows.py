"""The motion of a point by modes that ring freely, many samples ahead: rows of its values at some times of each
sample."""

import numpy as np
from numpy.polynomial import Legendre

from ..native.jit import simd_kernel
from ..native.typed import View
from ..numerics.checks import Array
from ..numerics.legendre import AHEAD, FINE
from .bank import MOBILITY, RESPONSES, Modes, Point
from .simd import LANES, dot, put_product

_STRIDE = 8  # samples: of a recursion whose steps do not wait for each other
_COURSE = AHEAD + _STRIDE  # values of a mode: AHEAD + 1 are needed


def row_weights(time: float, derivative: bool) -> Array:
    """Return the weights of the table that answers forces (coefficients.py) for a displacement at a time in [0, 1] of a
    sample, or its derivative: FINE of them."""
    series = [Legendre.basis(k, domain=[0, 1]) for k in range(FINE)]
    return np.array([(-1) ** k * (each.deriv() if derivative else each)(time) for k, each in enumerate(series)])


def room_for_rows(rows: int) -> int:
    """Return the number of values that `lay_rows` needs room for."""
    return (2 * rows + _COURSE) * LANES


@simd_kernel
def lay_rows(
    modes: Modes, point: Point, weights: tuple[tuple[float, ...], ...], room: View[float], out: View[float]
) -> None:
    """Add the point's motion over the coming AHEAD samples without a force to `out`: one row after the other.

    weights: a tuple for each row, by `row_weights`. Displacements are in m, derivatives in m per sample. `room`
    (float64) has `room_for_rows` values.
    """
    y1, y2, a1, a2, response = modes.y1, modes.y2, modes.a1, modes.a2, modes.response
    w = point.weights[0], point.weights[1], point.weights[2], point.weights[3]
    rows = len(weights)
    course = 2 * rows * LANES
    for first in range(0, len(y1), LANES):
        group = first // LANES * RESPONSES
        phi = dot(point.shape, point.row * point.stride + first, point.stride, w)
        mobility = dot(response, group + MOBILITY, 0, (1.0,))
        decay = dot(a2, first, 0, (1.0,))
        put_product(room, course, phi, mobility)
        scale = dot(room, course, 0, (1.0,))
        put_product(room, course, scale, decay)
        scale_before = dot(room, course, 0, (1.0,))
        for r in range(rows):
            # As `observe` does: by the state a sample later and the one before that.
            put_product(room, 2 * r * LANES, scale, dot(response, group, 2 * LANES, weights[r]))
            put_product(room, (2 * r + 1) * LANES, scale_before, dot(response, group + LANES, 2 * LANES, weights[r]))
        for k in range(LANES):
            _ring(y1[first + k], y2[first + k], a1[first + k], a2[first + k], room, course + k * _COURSE)
        for r in range(rows):
            for half in range(0, LANES, LANES // 2):
                _add_four(room, 2 * r * LANES + half, course + half * _COURSE, out, r * AHEAD)


@simd_kernel
def _ring(here: float, before: float, p: float, q: float, room: View[float], course: int) -> None:
    """Write the coming samples of a mode: sample by sample, then by the recursion of its samples _STRIDE apart."""
    for n in range(2 * _STRIDE):
        before, here = here, p * here + q * before
        room[course + n] = here
    for _ in range(3):
        p, q = p * p + 2.0 * q, -q * q
    for n in range(course + 2 * _STRIDE, course + _COURSE):
        room[n] = p * room[n - _STRIDE] + q * room[n - 2 * _STRIDE]


@simd_kernel
def _add_four(room: View[float], factor: int, course: int, out: View[float], at: int) -> None:
    """Add four modes' part of a row."""
    p0, p1, p2, p3 = room[factor], room[factor + 1], room[factor + 2], room[factor + 3]
    factor += LANES
    q0, q1, q2, q3 = room[factor], room[factor + 1], room[factor + 2], room[factor + 3]
    one, two, three = course + _COURSE, course + 2 * _COURSE, course + 3 * _COURSE
    for n in range(AHEAD):
        total = p0 * room[course + n + 1] + q0 * room[course + n]
        total += p1 * room[one + n + 1] + q1 * room[one + n]
        total += p2 * room[two + n + 1] + q2 * room[two + n]
        total += p3 * room[three + n + 1] + q3 * room[three + n]
        out[at + n] += total
