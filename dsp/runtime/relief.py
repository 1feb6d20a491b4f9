"""The relief modes, which keep a slow force from being heard.

A mode is heard by omega q, with a weight that holds at its own frequency. Below, a mode that is merely bent hardly
radiates, for sound pressure follows acceleration, but omega q = phi F/omega follows the force: without more, a blow by
a soft mallet would thump as no body does. So the modes of a band of two octaves have one heavily damped mode beside
them, which no contact feels: it answers slow forces by what they answer, with the opposite sign, up to about twice the
band's middle. The rest falls as the frequency; where modes ring it makes no difference.
"""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from ..numerics.constants import RELIEF_DAMPING as DAMPING
from ..numerics.settled import single

OCTAVES = 2.0
REACH = 2.0  # times the middle of a band: a relief's natural frequency
TURN = (1 - DAMPING**2) ** 0.5  # frequency over natural frequency


class Relief(NamedTuple):
    """Heavily damped modes: frequency (Hz) and decay (1/s) (b,), and what each answers on each side (s, P, b)."""

    frequency: Array
    decay: Array
    shape: Array


def relief(frequency: Array, decay: Array, sides: Array, strike: Array, top: float, rows: int | None = None) -> Relief:
    """Return the relief of modes: frequency (Hz), decay (1/s) (n,), weights (s, n), shapes (P, n); none above `top`
    (Hz). The first `rows` of them, or all, say how loud a mode is. What is not heard has none."""
    if not sides.any():
        return Relief(np.empty(0), np.empty(0), np.empty((len(sides), len(strike), 0)))
    band = np.floor(np.log2(frequency / frequency.min()) / OCTAVES)
    order = np.argsort(band, kind="stable")
    band, omega, decay, sides = band[order], 2 * np.pi * frequency[order], decay[order], sides[:, order]
    shapes = strike[:, order]
    first = np.array([0, *(np.flatnonzero(band[1:] != band[:-1]) + 1)])
    weight = sides * omega / (omega**2 + decay**2)  # of what a shape answers to a steady force
    size = np.sqrt(_mean_square(shapes[:rows]) * _mean_square(weight)) + 1e-300
    middle = np.exp(np.add.reduceat(np.log(omega) * size, first) / np.add.reduceat(size, first))
    natural = single(np.minimum(REACH * middle, 2 * np.pi * top / TURN))
    # Summed without BLAS, whose last bits are not the same with any number of threads.
    static = single(np.add.reduceat(shapes * weight[:, None], first, axis=-1))
    return Relief(TURN * natural / (2 * np.pi), DAMPING * natural, -static * natural / TURN)


def _mean_square(rows: Array) -> Array:
    """Return the mean of the squares of rows."""
    found: Array = np.add.reduce(rows**2) / len(rows)
    return found
