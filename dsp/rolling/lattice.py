"""Smooth noise on a lattice: random heights, each a hash of its number and a seed, joined by Catmull-Rom cubics."""

import math

import numpy as np

from ..native.jit import kernel
from ..numerics.random import STEP, mixed
from ..numerics.settled import same_everywhere

# The cubic through lattice heights 1 and 2, with slopes from 0 and 3; and the mean of its squared weights.
CUBIC = 0.5 * np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]], np.float64)
_POWER = float(same_everywhere("POWER", np.trace(CUBIC.T @ (1 / (np.arange(4)[:, None] + np.arange(4) + 1)) @ CUBIC)))

EDGE = math.sqrt(3.0 / _POWER)
"""Greatest height on the lattice over the noise's rms height."""

CREST = EDGE * 1.25
"""Greatest height of the noise over its rms height."""

TO_HEIGHT = 2.0 * EDGE * 2.0**-53
"""Times a number that is `drawn`: a height on the lattice of noise of an rms height of 1."""

_HALF = 2.0**52


@kernel
def drawn(seed: np.uint64, number: int) -> float:
    """Draw a whole number from -2^52 to 2^52, all alike likely, for a point of a lattice."""
    bits = mixed(np.uint64(number) * STEP + seed)
    return np.float64(np.int64(bits >> np.uint64(11))) - _HALF


@kernel
def cubic_weights(t: float) -> tuple[float, float, float, float]:
    """Return the weights of a lattice's four heights at t, in [0, 1], of the cell in their middle."""
    return (
        CUBIC[0, 0] + t * (CUBIC[1, 0] + t * (CUBIC[2, 0] + t * CUBIC[3, 0])),
        CUBIC[0, 1] + t * (CUBIC[1, 1] + t * (CUBIC[2, 1] + t * CUBIC[3, 1])),
        CUBIC[0, 2] + t * (CUBIC[1, 2] + t * (CUBIC[2, 2] + t * CUBIC[3, 2])),
        CUBIC[0, 3] + t * (CUBIC[1, 3] + t * (CUBIC[2, 3] + t * CUBIC[3, 3])),
    )
