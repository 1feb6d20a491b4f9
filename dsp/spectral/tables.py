"""Tables of the basis of a ringing mode's block (basis.py): its functions at each frame, and the transform's roots."""

import math

import numpy as np
from numpy.typing import NDArray

from ..numerics.settled import same_everywhere
from .basis import CENTRE, FRAMES, HALF_WIDTH, RADIUS, SIZE, TERMS

# Found by minimizing the largest error; in halves of the rectangle's sides, with their conjugates.
_NODES = ((0.0, 0.314), (0.876, 0.945), (-0.888, 0.942), (-0.03, 0.683))


def _nodes() -> list[complex]:
    """Return the points at which the polynomial is right, in the unit circle."""
    upper = [complex(-x * CENTRE, y * HALF_WIDTH) / RADIUS for x, y in _NODES]
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


PSI = same_everywhere("PSI", 0.5 * _basis().ravel())
"""psi_j(tau) at [n TERMS + j], halved: the transform has each bin and its conjugate."""
TWIDDLES = same_everywhere(
    "TWIDDLES", [part(2.0 * math.pi * k / SIZE) for k in range(SIZE) for part in (math.cos, math.sin)]
)
"""cos and sin of k turns over SIZE, in pairs."""
