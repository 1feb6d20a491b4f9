"""Reading a sound between its samples: ten taps that are polynomials of the fraction.

They were fitted to a pure delay up to 16.5 kHz at 48 kHz: up to 16 kHz the error is below -47 dB of a tone, and its
amplitude is right within 0.04 dB.
"""

import math

import numpy as np

from ..native.jit import kernel, simd_kernel
from ..native.typed import View

TAPS = 10
AHEAD_OF = TAPS // 2
"""Samples after the one before the place that is read."""
DEGREE = 5
"""The degree of a tap's polynomial over the fraction."""

# By degree and tap, over the fraction less a half; tests/documents/taps.py fits and writes them.
_FITTED = (
    (
        0.005289931348727711, -0.024121132709799223, 0.06821670029751375, -0.17103131107592548, 0.6217988796092554,
        0.6217988796092513, -0.17103131107592262, 0.06821670029751223, -0.0241211327097981, 0.0052899313487268715,
    ),
    (
        -0.0009775813977851433, 0.006143773250378626, -0.025804164929361093, 0.11189638997334472, -1.241110116983537,
        1.2411101169835375, -0.11189638997334228, 0.025804164929363146, -0.006143773250381068, 0.000977581397787683,
    ),
    (
        -0.02522710803570513, 0.11433736446185078, -0.3183702495980538, 0.7507930638038494, -0.5222668024652097,
        -0.5222668024651624, 0.7507930638038139, -0.318370249598034, 0.11433736446183973, -0.02522710803570312,
    ),
    (
        0.004645220988584775, -0.029020308649022164, 0.12005977754166863, -0.4899814179703007, 1.032096444723229,
        -1.0320964447232202, 0.4899814179702848, -0.1200597775416451, 0.029020308649012103, -0.004645220988579141,
    ),
    (
        0.01632371773644839, -0.07163143978500625, 0.18247108324478878, -0.2672162547538609, 0.1405404673719472,
        0.1405404673719438, -0.26721625475385036, 0.18247108324479766, -0.07163143978500698, 0.016323717736447363,
    ),
    (
        -0.0029442666539487377, 0.017806973918907096, -0.06745238778573129, 0.16974686586627646, -0.27085648220359265,
        0.27085648220355163, -0.1697468658661908, 0.06745238778561394, -0.017806973918803905, 0.002944266653870568,
    ),
)  # fmt: skip
_WEIGHTS = np.array(_FITTED)
_LAID = 16
_ROWS = np.zeros((DEGREE + 1, _LAID))
_ROWS[:, :TAPS] = _WEIGHTS


@simd_kernel
def read_steady(window: View[float], fraction: float, weights: View[float], out: View[float], count: int) -> None:
    """Read `count` samples that lie a fraction after window[TAPS // 2 - 1], one after the other; `weights` has room for
    16."""
    f = fraction - 0.5
    for k in range(_LAID):
        even = _ROWS[0, k] + f * f * (_ROWS[2, k] + f * f * _ROWS[4, k])
        odd = _ROWS[1, k] + f * f * (_ROWS[3, k] + f * f * _ROWS[5, k])
        weights[k] = even + f * odd
    a, b, c, d, e = weights[0], weights[1], weights[2], weights[3], weights[4]
    v, w, x, y, z = weights[5], weights[6], weights[7], weights[8], weights[9]
    for n in range(count):
        before = a * window[n] + b * window[n + 1] + c * window[n + 2] + d * window[n + 3] + e * window[n + 4]
        after = v * window[n + 5] + w * window[n + 6] + x * window[n + 7] + y * window[n + 8] + z * window[n + 9]
        out[n] = before + after


@kernel
def read_moving(window: View[float], first: int, places: View[float], out: View[float], count: int) -> None:
    """Read `count` samples, number n at n + places[n], of which window[TAPS // 2 - 1] is at `first`: stretch by
    stretch, over which places lie between the same samples."""
    begin = 0
    while begin < count:
        lag = math.floor(places[begin])
        end = begin + 1
        while end < count and lag <= places[end] < lag + 1:
            end += 1
        read_stretch(window[begin + lag - first :], places[begin:end], lag, out[begin:end])
        begin = end


@kernel
def read_stretch(window: View[float], places: View[float], whole: int, out: View[float]) -> None:
    """Read samples, number n at n + places[n], all of which lie between `whole` and the next; window[n + TAPS // 2 - 1]
    is the one before. Taps lie alike on both sides of the middle, so that polynomials of even degree see sums, and
    those of odd degree differences."""
    for n in range(len(out)):
        f = places[n] - whole - 0.5
        a, b, c, d, e = window[n], window[n + 1], window[n + 2], window[n + 3], window[n + 4]
        v, w, x, y, z = window[n + 9], window[n + 8], window[n + 7], window[n + 6], window[n + 5]
        sums, differences = (a + v, b + w, c + x, d + y, e + z), (a - v, b - w, c - x, d - y, e - z)
        even = _by(0, sums) + f * f * (_by(2, sums) + f * f * _by(4, sums))
        odd = _by(1, differences) + f * f * (_by(3, differences) + f * f * _by(5, differences))
        out[n] = even + f * odd


@kernel
def _by(degree: int, x: tuple[float, float, float, float, float]) -> float:
    """Return the sum of numbers by the first taps' weights of a degree."""
    w = _WEIGHTS[degree]
    total: float = w[0] * x[0] + w[1] * x[1] + w[2] * x[2] + w[3] * x[3] + w[4] * x[4]
    return total
