"""How a panic lets forces and sounds go: without a step, and for good within 10 ms.

A force that acts goes on as exp(-a t) (A + B t), with its value and its slope of then: to let go of a body at once
would sound. The faster it was changing, the sooner it is gone.
"""

import math

import numpy as np

from ..native.jit import kernel
from .state import QUANTUM

RATES = np.array([0.0, *100.0 * 2.0 ** np.arange(10)])
"""1/s: a force takes the first a that is no slower than itself, and the very first if it changes more slowly than
_STEADY."""

_FADE = 0.01  # s
_STEADY = 25.0  # 1/s


@kernel
def pace_of(value, slope):
    """Which of RATES a force of some value (N) and slope (N/s) takes."""
    k = 0
    while k < len(RATES) - 1 and max(RATES[k], _STEADY) * abs(value) < abs(slope):
        k += 1
    return k


@kernel
def going_on(force, before, k, rate):
    """(q, u, v) of a force that was `before` and `force` (N) over the last samples: p[n] = q^n (u + v n) N s."""
    q = math.exp(-RATES[k] / rate)
    v = q * (force - before + force * RATES[k] / rate) / rate
    return q, q * force / rate + v, v


@kernel
def tilt_of(q, u, v):
    """(u', v') of such a force's first Legendre moments, q^n (u' + v' n): a twelfth of p[n + 1] - p[n - 1]."""
    return (q * (u + v) - (u - v) / q) / 12.0, (q - 1.0 / q) * v / 12.0


@kernel
def fade_length(rate):
    """Frames that a fade lasts."""
    return QUANTUM * max(int(_FADE * rate / QUANTUM + 0.5), 1)


@kernel
def left_of(rate, frames):
    """What is left of a sound some frames after a panic, 1 to 0, without a step in slope or curvature."""
    x = min(frames / fade_length(rate), 1.0)
    return 1.0 - x * x * x * (10.0 - x * (15.0 - 6.0 * x))
