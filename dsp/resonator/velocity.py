"""The velocity of a point of the modes over the coming sample, for a contact that pushes along it: friction.

It is a sum over modes of the shape times y1 and y2 with weights that stay while the mode does. So weights are kept for
what is requested in each sample: the velocity a third into it and at its end, its mean, and its first moment. All come
from the Legendre series that `observe_velocity` finds in full, FINE terms of the table by which modes answer forces:
what a force does and what it sees belong together, and no energy gets lost between them.
"""

import math

import numpy as np
from numpy.polynomial import Legendre

from ..native.jit import kernel, simd_kernel
from ..native.typed import View
from ..numerics.legendre import FINE
from .bank import MOBILITY, RESPONSES, Modes, Point, project
from .simd import LANES
from .sizes import ROWS, SENSED

SHAPE = 0
_WEIGHTS = 1  # of y1 and y2 for those
_SUMS = _WEIGHTS + 2 * SENSED  # of y1 and y2 in the two sums of `bank.project`
_ANSWER = _SUMS + 4  # those sums after a unit impulse, over the shape's square

assert ROWS == _ANSWER + 2

THIRD = 1.0 / 3.0

_AT_THIRD, _AT_END = (np.array([Legendre.basis(k, domain=[0, 1])(t) for k in range(FINE)]) for t in (THIRD, 1.0))


@kernel
def set_rows(modes: Modes, weights: View[float], rows: View[float], stride: int) -> None:
    """Set the rows of as many modes, but for their shapes: rows[j stride + i]. To be called when modes are retuned.

    weights: those that scale their samples.
    """
    response = modes.response
    for i in range(len(modes.a1)):
        base = i // LANES * RESPONSES + i % LANES
        a1, a2 = modes.a1[i], modes.a2[i]
        mobility, size = response[base + MOBILITY], response[base + MOBILITY + LANES]
        for j in range(_WEIGHTS, ROWS):
            rows[j * stride + i] = 0.0
        if size == 0.0:
            continue
        lag = response[base + MOBILITY + 2 * LANES]
        sine = math.copysign(math.sqrt(max(-a2 - 0.25 * a1 * a1, 1e-300)), mobility)
        # The velocity, Re z - lag Im z, now (u) and a sample ago (v), by y1 and y2; then the same two sums of it as for
        # a displacement.
        u1, u2 = 0.5 * a1 / sine - lag, a2 / sine
        v1, v2 = 1.0 / sine, -0.5 * a1 / sine - lag
        square = weights[i] * weights[i] * sine
        c = 1.0 / square
        after1, after2 = a1 * u1 + a2 * v1, a1 * u2 + a2 * v2
        here1, here2 = c * (a1 * after1 + a2 * u1), c * (a1 * after2 + a2 * u2)
        before1, before2 = c * a2 * after1, c * a2 * after2
        _set_row(rows, _SUMS, stride, i, here1, here2)
        _set_row(rows, _SUMS + 2, stride, i, before1, before2)
        d = size / (mobility * sine * square)
        after = 0.5 * a1 - lag * sine
        _set_row(rows, _ANSWER, stride, i, d * (a1 * after + a2), d * a2 * after)
        third1 = third2 = end1 = end2 = 0.0
        sign = 1.0
        for k in range(FINE):
            now, ago = sign * response[base + 2 * k * LANES], sign * response[base + (2 * k + 1) * LANES]
            first, second = here1 * now + before1 * ago, here2 * now + before2 * ago
            third1, third2 = third1 + _AT_THIRD[k] * first, third2 + _AT_THIRD[k] * second
            end1, end2 = end1 + _AT_END[k] * first, end2 + _AT_END[k] * second
            if k == 0:
                _set_row(rows, _WEIGHTS + 4, stride, i, first, second)
            if k < 2:
                share = 0.5 if k == 0 else 1.0 / 6.0
                rows[(_WEIGHTS + 6) * stride + i] += share * first
                rows[(_WEIGHTS + 7) * stride + i] += share * second
            sign = -sign
        _set_row(rows, _WEIGHTS, stride, i, third1, third2)
        _set_row(rows, _WEIGHTS + 2, stride, i, end1, end2)


@kernel
def _set_row(rows: View[float], row: int, stride: int, i: int, first: float, second: float) -> None:
    """Set a mode's place in a row and in the next one."""
    rows[row * stride + i] = first
    rows[(row + 1) * stride + i] = second


@simd_kernel
def set_shapes(n: int, point: Point, scale: float, rows: View[float], stride: int) -> None:
    """Set the shapes of n modes at a point, times `scale`. To be called when the point moves."""
    for i in range(n):
        phi = 0.0
        for k in range(4):
            phi += point.weights[k] * point.shape[(point.row + k) * point.stride + i]
        rows[SHAPE * stride + i] = scale * phi


@simd_kernel
def sense(modes: Modes, rows: View[float], stride: int) -> tuple[float, float, float, float]:
    """Return the SENSED velocities of the point over the coming sample, if no force acts."""
    y1, y2 = modes.y1, modes.y2
    n = len(y1)
    shape, weights = rows[:n], rows[_WEIGHTS * stride :]
    third1, third2, end1, end2, mean1, mean2, moment1, moment2 = (
        weights[:n], weights[stride:][:n], weights[2 * stride :][:n], weights[3 * stride :][:n],
        weights[4 * stride :][:n], weights[5 * stride :][:n], weights[6 * stride :][:n], weights[7 * stride :][:n],
    )  # fmt: skip
    third = end = mean = moment = 0.0
    for i in range(n):
        u, v = shape[i] * y1[i], shape[i] * y2[i]
        third += third1[i] * u + third2[i] * v
        end += end1[i] * u + end2[i] * v
        mean += mean1[i] * u + mean2[i] * v
        moment += moment1[i] * u + moment2[i] * v
    return third, end, mean, moment


@simd_kernel
def observe_velocity(
    modes: Modes, rows: View[float], stride: int, work: View[float], coefficients: View[float]
) -> None:
    """Find the same velocity in full: FINE Legendre coefficients (m/s). `work` as in `bank.observe`."""
    y1, y2 = modes.y1, modes.y2
    n = len(y1)
    shape, sums = rows[:n], rows[_SUMS * stride :]
    here1, here2, before1, before2 = sums[:n], sums[stride:][:n], sums[2 * stride :][:n], sums[3 * stride :][:n]
    here, before = work[n : 2 * n], work[2 * n : 3 * n]
    for i in range(n):
        u, v = shape[i] * y1[i], shape[i] * y2[i]
        here[i] = here1[i] * u + here2[i] * v
        before[i] = before1[i] * u + before2[i] * v
    project(n, modes.response, work, coefficients)


@simd_kernel
def velocity_response(
    modes: Modes, rows: View[float], stride: int, work: View[float], coefficients: View[float]
) -> None:
    """Find the point's velocity over a sample after a unit impulse there: FINE Legendre coefficients, (m/s)/(N s).

    `work` as in `bank.observe`; its first n values are the modes' shapes at the point afterwards.
    """
    n = len(modes.y1)
    shape, here, before = rows[:n], rows[_ANSWER * stride :][:n], rows[(_ANSWER + 1) * stride :][:n]
    for i in range(n):
        work[i] = shape[i]
        work[n + i] = here[i] * shape[i] * shape[i]
        work[2 * n + i] = before[i] * shape[i] * shape[i]
    project(n, modes.response, work, coefficients)
