"""The fade of forces and sounds in a panic: without a step, and for good within 10 ms.

A force that acts goes on as exp(-a t) (A + B t + C t^2), with its value, slope and curvature of then: to let go of a
body at once would sound. The faster it was changing, the sooner it is gone.
"""

import math

import numpy as np

from ...native.jit import kernel
from ...native.typed import View
from ..memory.state import QUANTUM

RATES = np.array([0.0, *100.0 * 2.0 ** np.arange(10)])
"""1/s: a force takes the first a that is no slower than itself, and the very first if it changes more slowly than
_STEADY."""

_FADE = 0.01  # s
_STEADY = 25.0  # 1/s


@kernel
def note_force(forces: View[float], force: float) -> None:
    """Put the mean (N) of a force over a sample before those of the samples before."""
    forces[2], forces[1], forces[0] = forces[1], forces[0], force


@kernel
def pace_of(forces: View[float], rate: float) -> int:
    """Choose the rate in RATES at which a force decays, by its last means (N)."""
    slope = abs(forces[0] - forces[1]) * rate
    bend = abs(forces[0] - 2.0 * forces[1] + forces[2]) * rate * rate
    value = abs(forces[0])
    k = 0
    while k < len(RATES) - 1:
        pace = max(RATES[k], _STEADY)
        if pace * value >= slope and pace * pace * value >= bend:
            break
        k += 1
    return k


@kernel
def going_on(forces: View[float], k: int, rate: float) -> tuple[float, float, float, float]:
    """Return (q, u, v, w) of a force by its last means (N): in sample n from now it gives p = q^n (u + v n + w n^2) N
    s."""
    q = math.exp(-RATES[k] / rate)
    p1, p2, p3 = q * forces[0] / rate, q * q * forces[1] / rate, q * q * q * forces[2] / rate
    w = 0.5 * (p1 - 2.0 * p2 + p3)
    u = 3.0 * (p1 - p2) + p3
    return q, u, u - p1 + w, w


@kernel
def tilt_of(q: float, u: float, v: float, w: float) -> tuple[float, float, float]:
    """Return (u', v', w') of such a force's first Legendre moments: a twelfth of the difference of p after and
    before."""
    after, before = q / 12.0, 1.0 / (12.0 * q)
    more, less = after + before, after - before
    return less * (u + w) + more * v, less * v + 2.0 * more * w, less * w


@kernel
def fade_length(rate: float) -> int:
    """Return the frames that a fade lasts."""
    return QUANTUM * max(int(_FADE * rate / QUANTUM + 0.5), 1)


@kernel
def left_of(rate: float, frames: int) -> float:
    """Return the share left of a sound some frames after a panic, 1 to 0, without a step in slope or curvature."""
    x = min(frames / fade_length(rate), 1.0)
    return 1.0 - x * x * x * (10.0 - x * (15.0 - 6.0 * x))
