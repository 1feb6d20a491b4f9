"""The coefficients of a mode: how it rings, and how it answers the moments of a force over a sample."""

import math

from ..native.jit import kernel
from ..numerics.legendre import FINE
from .bank import FED, MOBILITY, PACE, RESPONSES, Modes
from .fed import feed_tap
from .mode import ring_at
from .simd import LANES
from .sizes import REACH

_LOSSY = 0.1  # per sample: what loses more counts as faster than all
_BESSEL_START = 24  # where the downward recursion of the spherical Bessel functions starts; |z| <= 3.5 needs 22


@kernel
def set_mode(modes: Modes, i: int, frequency: float, decay: float, rate: float, weight: complex) -> None:
    """Give mode i a frequency (Hz) and decay (1/s) at a sampling rate (Hz); its ringing goes on without a step.

    `weight` scales what it will answer to a force; where it is complex, the output is Im(weight z): a mode whose output
    has a phase, which no contact feels. frequency = 0 makes a mode that rests for ever.
    """
    response = modes.response
    base = (i // LANES) * RESPONSES + i % LANES
    if frequency <= 0.0:
        modes.y1[i] = modes.y2[i] = modes.a1[i] = modes.a2[i] = 0.0
        for k in range(RESPONSES // LANES):
            response[base + k * LANES] = 0.0
        return
    theta = 2.0 * math.pi * frequency / rate
    loss = decay / rate
    r = math.exp(-loss)
    ring_at(modes, i, frequency, decay, rate)
    # exp(-s t) over the sample, s = -loss + i theta, in Legendre polynomials: (2k+1) (-1)^k exp(-s/2) i_k(s/2), with
    # i_k the modified spherical Bessel functions, by Miller's downward recursion; sum (2k+1) i_k(z) = exp(z) scales it.
    # (Reciprocals by the conjugate: numba's complex division can raise.)
    z = complex(-0.5 * loss, 0.5 * theta)
    reciprocal = z.conjugate() * (1.0 / (z.real * z.real + z.imag * z.imag))
    upper = 0.0j
    here = 1e-100 + 0.0j
    total = (2 * _BESSEL_START + 1) * here
    for k in range(_BESSEL_START, 0, -1):
        upper, here = here, upper + (2 * k + 1) * reciprocal * here
        total += (2 * k - 1) * here
        if k <= FINE:
            b = base + 2 * (k - 1) * LANES
            response[b] = here.real
            response[b + LANES] = here.imag
    # exp(z)/total normalises the i_k and exp(-z) is the factor above: what is left is 1/total.
    scale = total.conjugate() * (weight * (1.0 / (total.real * total.real + total.imag * total.imag)))
    before = complex(math.cos(theta), -math.sin(theta)) * (1.0 / r)
    for k in range(FINE):
        b = base + 2 * k * LANES
        g = complex(response[b], response[b + LANES]) * scale * (2.0 * k + 1.0)
        if k % 2 == 1:
            g = -g
        response[b] = g.imag
        response[b + LANES] = (g * before).imag
    # Set what `observe` and `receptance` need of a mode: nothing where its output has a phase.
    omega = 2.0 * math.pi * frequency
    sine = r * math.sin(theta)
    real, is_felt = weight.real, weight.real != 0.0 and weight.imag == 0.0
    response[base + MOBILITY] = 1.0 / (omega * real * real * sine) if is_felt else 0.0
    response[base + MOBILITY + LANES] = 1.0 / (omega * real) if is_felt else 0.0
    response[base + MOBILITY + 2 * LANES] = loss / theta
    response[base + PACE] = theta + 2.0 * loss if loss < _LOSSY else math.inf
    felt = weight.real if weight.imag == 0.0 else 0.0
    response[base + FED] = felt * r * math.sin(theta)
    for k in range(REACH + 1):
        response[base + FED + (k + 1) * LANES] = felt * feed_tap(theta, k)


@kernel
def yield_less(modes: Modes, i: int, share: float) -> None:
    """Scale the shape of mode i, that has just got its coefficients, by a share wherever forces act."""
    base = (i // LANES) * RESPONSES + i % LANES
    for k in range(2 * FINE):
        modes.response[base + k * LANES] *= share
    modes.response[base + MOBILITY + LANES] *= share
    for k in range(REACH + 2):
        modes.response[base + FED + k * LANES] *= share
