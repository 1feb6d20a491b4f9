"""The motion of a point of the modes at samples, as a sensor there measures it.

Velocity is that of all modes at a sample. Acceleration is what they do by themselves then, and what forces do directly:
sum phi_s phi_f F, with the mean of each force over the sample before. Both are sums over modes, of y1 and y2 with
weights that stay while the mode does.
"""

import math

from ..native.jit import kernel, simd_kernel
from ..native.typed import View, View2D
from .bank import Point

SHAPE = 2
SENSED_ROWS = SHAPE + 1
"""Numbers of each mode: the weights of y1 and y2 in what is sensed, and its shape under the sensor."""


@kernel
def set_sensed(
    rows: View2D[float], i: int, a1: float, a2: float, shape: float, weight: float, rate: float, acceleration: bool
) -> None:
    """Set the rows of mode i, whose samples are scaled by a weight; a mode that is none counts nothing."""
    for k in range(SENSED_ROWS):
        rows[k, i] = 0.0
    if a2 == 0.0 or weight == 0.0:
        return
    r = math.sqrt(-a2)
    cosine = min(max(0.5 * a1 / r, -1.0), 1.0)
    sine = math.sqrt(1.0 - cosine * cosine)
    if sine == 0.0:
        return
    omega, sigma, scale = math.acos(cosine) * rate, -math.log(r) * rate, shape / weight
    lag = sigma / omega
    # Re z by y1 and y2; the velocity is Re z - lag Im z, and Im z = y1.
    re1, re2 = cosine / sine, -r / sine
    if acceleration:
        rows[0, i] = scale * (sigma * lag - omega - 2.0 * sigma * re1)
        rows[1, i] = -2.0 * sigma * scale * re2
        rows[SHAPE, i] = shape
    else:
        rows[0, i], rows[1, i] = scale * (re1 - lag), scale * re2


@simd_kernel
def sum_sensed(y1: View[float], y2: View[float], weights1: View[float], weights2: View[float]) -> float:
    """Return what is sensed of modes at their last sample."""
    total = 0.0
    for i in range(len(y1)):
        total += weights1[i] * y1[i] + weights2[i] * y2[i]
    return total


@simd_kernel
def sum_pushed(shape: View[float], point: Point) -> float:
    """Return the acceleration that a force of 1 N at a point causes directly under a sensor with a shape (n,)."""
    total = 0.0
    for i in range(len(shape)):
        phi = 0.0
        for k in range(4):
            phi += point.weights[k] * point.shape[(point.row + k) * point.stride + i]
        total += shape[i] * phi
    return total
