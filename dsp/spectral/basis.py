"""The basis of a ringing mode's block: a few functions of time that all modes share.

Over a block of FRAMES samples about its middle, a mode c exp(lambda n) lies near the middle of a bin of frequencies:
lambda n = i omega_b n + zeta tau, with tau from -1 to 1. Its zeta is small, and exp(zeta tau) is a polynomial of degree
TERMS - 1 in zeta, whose coefficients psi_j(tau) are the same for all modes: the one that is right at TERMS points of
the rectangle in which zeta can be (Lagrange). Between them it errs by at most -115 dB of the mode's amplitude in the
middle of the block.
"""

import math

import numpy as np
from numpy.typing import NDArray

FRAMES = 512
"""Length of a block."""
BINS = FRAMES
"""Number of bins of frequencies, from 0 to Nyquist's."""
TERMS = 8
SIZE = 2 * BINS
"""Points of the Fourier transform."""

MOST_LOSS = math.log(1000.0) / (0.05 * 48_000.0)
"""The largest decay, in nepers a sample, of a mode in the bank: a decay time (60 dB) of 0.05 s at 48 kHz."""

_HALF_WIDTH = 0.25 * math.pi * FRAMES / BINS  # of zeta's imaginary part
CENTRE = -0.25 * MOST_LOSS * FRAMES
"""Centre of the real part of zeta, which is between 0 and twice that."""
RADIUS = math.hypot(_HALF_WIDTH, CENTRE)
"""Zeta is kept as (zeta - CENTRE)/RADIUS, which is in the unit circle."""

# Found by minimizing the largest error; in halves of the rectangle's sides, with their conjugates.
_NODES = ((0.0, 0.314), (0.876, 0.945), (-0.888, 0.942), (-0.03, 0.683))


def _nodes() -> list[complex]:
    """Return the points at which the polynomial is right, in the unit circle."""
    upper = [complex(-x * CENTRE, y * _HALF_WIDTH) / RADIUS for x, y in _NODES]
    return [*upper, *(node.conjugate() for node in upper)]


def _lagrange(nodes: list[complex], k: int) -> list[complex]:
    """Return the coefficients of the polynomial that is 1 at node k and 0 at the others."""
    polynomial = [1.0 + 0.0j]
    for node in nodes[:k] + nodes[k + 1 :]:
        scale = 1.0 / (nodes[k] - node)
        raised = [0.0j, *polynomial]
        polynomial = [(a - node * b) * scale for a, b in zip(raised, [*polynomial, 0.0j], strict=True)]
    return polynomial


def _basis() -> NDArray[np.float64]:
    """Return psi_j of each frame, (FRAMES, TERMS)."""
    # In Python's arithmetic, which is the same on all machines; NumPy's is not.
    nodes = _nodes()
    polynomials = [_lagrange(nodes, k) for k in range(TERMS)]
    rows = []
    for n in range(FRAMES):
        tau = 2.0 * n / FRAMES - 1.0
        values = [_exp((node * RADIUS + CENTRE) * tau) for node in nodes]
        rows.append([sum(v * p[j] for v, p in zip(values, polynomials, strict=True)).real for j in range(TERMS)])
    return np.array(rows)


def _exp(z: complex) -> complex:
    return math.exp(z.real) * complex(math.cos(z.imag), math.sin(z.imag))


PSI = 0.5 * _basis().ravel()
"""psi_j(tau) at [n TERMS + j], halved: the transform has each bin and its conjugate."""
TWIDDLES = np.array([part(2.0 * math.pi * k / SIZE) for k in range(SIZE) for part in (math.cos, math.sin)])
"""cos and sin of k turns over SIZE, in pairs."""
