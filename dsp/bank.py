"""The modal bank: modes that ring, and the injection of a contact's force into them.

A mode obeys q'' + 2 sigma q' + (omega^2 + sigma^2) q = phi F with a mass-normalised shape phi (kg^-1/2). Its state is
z with z' = (-sigma + i omega) z + phi F, so that omega q = Im z; |z|^2/2 is its energy (J) up to sigma/omega. What is
kept is y = Im z at the last two samples: ringing is the two-pole recursion y <- a1 y1 + a2 y2, the fewest operations
there are, in float64, where it is exact at any frequency and decay.

Heard is omega q: the amplitude of the mode's velocity, in the phase of its displacement, which a blow leaves
continuous.

Modes are stored in lanes of LANES: an object's bank is a whole number of lanes, padded by modes at rest.
"""

import math

from .jit import kernel, simd_kernel
from .lanes import LANES, add_product, dot
from .pulse import MOMENTS

RESPONSES = 2 * MOMENTS * LANES
"""Coefficients for injection in one group of modes: by moment, by sample (last, last but one), by mode."""

NYQUIST_SHARE = 0.95
"""No mode is made above this share of the Nyquist frequency."""

_BESSEL_START = 24  # where the downward recursion of the spherical Bessel functions starts; |z| <= 1.6 needs 18


@simd_kernel
def ring(y1, y2, a1, a2, balance, out, start, stop):
    """Let modes ring from frame `start` to `stop`: out[0], out[1] (float64, at least `stop` long) are overwritten.

    y1, y2, a1, a2, balance: float64 of one length, a multiple of LANES. The state is scaled by the modes' weights at
    the left output, so that left is a sum, which costs no multiplication; `balance` is the weight at the right over
    that at the left.
    """
    n = len(y1)
    t = start
    while t + 4 <= stop:
        l0 = l1 = l2 = l3 = r0 = r1 = r2 = r3 = 0.0
        for i in range(n):
            p = a1[i]
            q = a2[i]
            u = y1[i]
            v = y2[i]
            v = p * u + q * v
            l0 += v
            r0 += balance[i] * v
            u = p * v + q * u
            l1 += u
            r1 += balance[i] * u
            v = p * u + q * v
            l2 += v
            r2 += balance[i] * v
            u = p * v + q * u
            l3 += u
            r3 += balance[i] * u
            y1[i] = u
            y2[i] = v
        out[0, t] = l0
        out[0, t + 1] = l1
        out[0, t + 2] = l2
        out[0, t + 3] = l3
        out[1, t] = r0
        out[1, t + 1] = r1
        out[1, t + 2] = r2
        out[1, t + 3] = r3
        t += 4
    while t < stop:
        l0 = r0 = 0.0
        for i in range(n):
            v = a1[i] * y1[i] + a2[i] * y2[i]
            y2[i] = y1[i]
            y1[i] = v
            l0 += v
            r0 += balance[i] * v
        out[0, t] = l0
        out[1, t] = r0
        t += 1


@simd_kernel
def inject(y1, y2, response, shape, stride, row, weights, moments):
    """Add a force over the coming sample, given by its moments (N s), to the modes before they take that sample.

    The force acts at a point between four rows of the shape table (flat, `stride` modes a row, from `row`), weighted by
    `weights`. `response` is the modes' table made by `set_mode`.
    """
    m = (moments[0], moments[1], moments[2], moments[3], moments[4], moments[5], moments[6], moments[7])
    w = (weights[0], weights[1], weights[2], weights[3])
    for first in range(0, len(y1), LANES):
        group = first // LANES * RESPONSES
        phi = dot(shape, row * stride + first, stride, w)
        add_product(y1, first, phi, dot(response, group, 2 * LANES, m))
        add_product(y2, first, phi, dot(response, group + LANES, 2 * LANES, m))


@kernel
def state_of(y1, y2, a1, a2):
    """z of a mode from its last two samples: (Re z, Im z)."""
    r = math.sqrt(-a2)
    cosine = 0.5 * a1 / r
    sine = math.sqrt(1.0 - cosine * cosine)
    return (y1 * cosine - r * y2) / sine, y1


@kernel
def set_mode(i, frequency, decay, rate, weight, y1, y2, a1, a2, response):
    """Give mode i a frequency (Hz) and decay (1/s) at a sampling rate (Hz); what it is ringing goes on without a step.

    `weight` scales what it will answer to a force. frequency = 0 makes a mode that rests for ever.
    """
    base = (i // LANES) * RESPONSES + i % LANES
    if frequency <= 0.0:
        y1[i] = y2[i] = a1[i] = a2[i] = 0.0
        for k in range(2 * MOMENTS):
            response[base + k * LANES] = 0.0
        return
    theta = 2.0 * math.pi * frequency / rate
    loss = decay / rate
    r = math.exp(-loss)
    if a2[i] != 0.0:
        re, im = state_of(y1[i], y2[i], a1[i], a2[i])
        y2[i] = (im * math.cos(theta) - re * math.sin(theta)) / r
    a1[i] = 2.0 * r * math.cos(theta)
    a2[i] = -r * r
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
        if k <= MOMENTS:
            b = base + 2 * (k - 1) * LANES
            response[b] = here.real
            response[b + LANES] = here.imag
    # exp(z)/total normalises the i_k and exp(-z) is the factor above: what is left is 1/total.
    scale = total.conjugate() * (1.0 / (total.real * total.real + total.imag * total.imag))
    before = complex(math.cos(theta), -math.sin(theta)) * (1.0 / r)
    for k in range(MOMENTS):
        b = base + 2 * k * LANES
        g = complex(response[b], response[b + LANES]) * scale * (weight * (2 * k + 1))
        if k % 2 == 1:
            g = -g
        response[b] = g.imag
        response[b + LANES] = (g * before).imag
