"""A mode by its last two samples: its energy, and how it rings on at another frequency.

The tension of a membrane or a string rises with what rings on it: its rise is stretched length, and so goes with the
square of the slope. By Kirchhoff (1876), Carrier (1945) and Berger (1955) the tension is one number T for the whole
body, T(t) = T_0 (1 + 2 g V(t)), with V the potential energy of all modes and g, in 1/J, a constant of the body
(`Modes.glide`). Averaged over a period V is half of the energy E, so the tension of all modes rises by the share g E.
A mode of energy E_i beats with itself: its share of V is largest where it is displaced itself, which raises its own
stiffness by half as much again, g E_i/2 (the 3/4 of Duffing's oscillator).
"""

import math

from ..native.jit import kernel, simd_kernel
from ..native.typed import View
from .bank import Modes, state_of

HIGHEST = 2.2
"""Times the Nyquist frequency: no mode is higher, though none above it is heard."""
APART = 0.0003
"""Times the Nyquist frequency: from its multiples at least."""


@kernel
def mode_energy(y1: float, y2: float, a1: float, a2: float, weight: float) -> float:
    """Return a mode's energy (J), |z|^2/2, its samples being scaled by a weight that is not 0."""
    scale = 4.0 * a2 + a1 * a1  # -4 r^2 sin(theta)^2
    square = (y1 * y1 - a1 * y1 * y2 - a2 * y2 * y2) * 4.0 * a2
    return 0.5 * square / (scale * weight * weight) if scale != 0.0 else 0.0


@simd_kernel
def energy_of(modes: Modes, weights: View[float], count: int) -> float:
    """Return the energy (J) of the first `count` modes at most, their samples being scaled by weights (n,) that are not
    0."""
    y1, y2, a1, a2 = modes.y1, modes.y2, modes.a1, modes.a2
    total = 0.0
    for i in range(min(len(y1), count)):
        scale = (4.0 * a2[i] + a1[i] * a1[i]) * weights[i] * weights[i]
        square = (y1[i] * y1[i] - a1[i] * y1[i] * y2[i] - a2[i] * y2[i] * y2[i]) * 4.0 * a2[i]
        total += 0.5 * square / (scale if scale != 0.0 else -1.0)
    return total


@kernel
def settle_under(modes: Modes) -> None:
    """Bring modes to rest under a force that lasts: they hold what a sample of it gives them, b; y = A (y + b)."""
    for i in range(len(modes.y1)):
        b1, b2, a1, a2 = modes.y1[i], modes.y2[i], modes.a1[i], modes.a2[i]
        modes.y1[i] = ((a1 + a2) * b1 + a2 * b2) / (1.0 - a1 - a2)
        modes.y2[i] = modes.y1[i] + b1


@kernel
def recurring(frequency: float, nyquist: float) -> float:
    """Return the frequency (Hz) nearest to one at which two samples show how a mode rings, and what it answers to a
    force.

    That is at no multiple of the Nyquist frequency, and not so high that FINE moments of a force over a sample would
    not do for contacts that are exact to -110 dB.
    """
    share = min(frequency / nyquist, HIGHEST)
    nearest = math.floor(share + 0.5)
    if nearest >= 1.0 and abs(share - nearest) < APART:
        share = nearest + (APART if share >= nearest else -APART)
    return share * nyquist


@kernel
def ring_at(modes: Modes, i: int, frequency: float, decay: float, rate: float) -> None:
    """Retune mode i to a frequency > 0 (Hz) and decay (1/s): it keeps its energy and makes no step.

    It answers forces as before.
    """
    y1, y2, a1, a2 = modes.y1, modes.y2, modes.a1, modes.a2
    theta = 2.0 * math.pi * frequency / rate
    r = math.exp(-decay / rate)
    if a2[i] != 0.0:
        re, im = state_of(y1[i], y2[i], a1[i], a2[i])
        re = -re if math.sin(theta) < 0.0 else re  # above the Nyquist frequency a mode turns the other way
        y2[i] = (im * math.cos(theta) - re * math.sin(theta)) / r
    a1[i] = 2.0 * r * math.cos(theta)
    a2[i] = -r * r


@kernel
def ring_from(modes: Modes, i: int, frequency: float, decay: float, rate: float, share: float) -> None:
    """Retune mode i as `ring_at` does, but as if after a share in [0, 1] of the coming sample: so its phase is that of
    a mode that rings as before until then, whatever the rate. Modes above the Nyquist frequency change at once."""
    y1, y2, a1, a2 = modes.y1, modes.y2, modes.a1, modes.a2
    theta = 2.0 * math.pi * frequency / rate
    if a2[i] != 0.0 and theta < math.pi:
        re, im = state_of(y1[i], y2[i], a1[i], a2[i])
        before = math.atan2(math.sqrt(-a2[i] - 0.25 * a1[i] * a1[i]), 0.5 * a1[i])
        cosine, sine = math.cos(share * (before - theta)), math.sin(share * (before - theta))
        re, im = re * cosine - im * sine, im * cosine + re * sine
        r = math.sqrt(-a2[i])
        y1[i] = im
        y2[i] = (im * math.cos(before) - re * math.sin(before)) / r
    ring_at(modes, i, frequency, decay, rate)
