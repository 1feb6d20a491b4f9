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

PHASES = 1024
"""Fractions at which the taps are kept for what moves: what rounding adds is below -60 dB of a tone of 16 kHz."""
_TABLE = np.ascontiguousarray(((np.arange(PHASES + 1) / PHASES - 0.5)[:, None] ** np.arange(DEGREE + 1)) @ _WEIGHTS)


@kernel
def tap_weight(fraction: float, tap: int) -> float:
    """Return the weight of a tap for a fraction of 0 to 1."""
    f, total = fraction - 0.5, 0.0
    for p in range(DEGREE, -1, -1):
        total = total * f + _WEIGHTS[p, tap]
    return total


@simd_kernel
def read_steady(window: View[float], fraction: float, weights: View[float], out: View[float], count: int) -> None:
    """Read `count` samples that lie a fraction after window[TAPS // 2 - 1], one after the other."""
    for k in range(TAPS):
        weights[k] = tap_weight(fraction, k)
    for n in range(count):
        out[n] = 0.0
    for k in range(TAPS):
        for n in range(count):
            out[n] += weights[k] * window[n + k]


@kernel
def read_moving(window: View[float], first: int, places: View[float], out: View[float], count: int) -> None:
    """Read `count` samples at places, of which window[0] is number `first`; places are rounded to 1/PHASES."""
    for n in range(count):
        whole = math.floor(places[n])
        phase = int((places[n] - whole) * PHASES + 0.5)
        at = whole - first - (TAPS // 2 - 1)
        a = _TABLE[phase, 0] * window[at] + _TABLE[phase, 1] * window[at + 1]
        b = _TABLE[phase, 2] * window[at + 2] + _TABLE[phase, 3] * window[at + 3]
        c = _TABLE[phase, 4] * window[at + 4] + _TABLE[phase, 5] * window[at + 5]
        d = _TABLE[phase, 6] * window[at + 6] + _TABLE[phase, 7] * window[at + 7]
        e = _TABLE[phase, 8] * window[at + 8] + _TABLE[phase, 9] * window[at + 9]
        out[n] = (a + b) + (c + d) + e
