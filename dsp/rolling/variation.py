"""The difference of a surface from place to place: smooth patches, scratched ones, grain, dust.

The rms height about a place is the surface's own times exp(s n - c). n is smooth noise of an rms of 1 on two lattices,
one four times as fine as the other; s is the standard deviation of the logarithm; c keeps the mean square, so that the
surface is as rough as ever on the whole. A body that slides over it sounds in bursts: Gaussian noise has a kurtosis of
3, and of up to 3 exp(4 s^2) if its variance varies so.
"""

import math
from typing import Annotated

import numpy as np

from ..native.jit import kernel, noinline_kernel
from ..native.typed import Record, View
from ..numerics.random import STEP, mixed
from .lattice import CREST, EDGE, TO_HEIGHT, cubic_weights, drawn


class Variation(Record):
    """A surface's roughness as it varies from place to place."""

    spread: float  # s over the square root of 2: of each lattice; 0: the surface is even
    mean: float  # c
    most: float  # the greatest rms height of a place, over the surface's own
    level: int  # log2 of the coarser lattice's spacing in places
    seed: Annotated[View[np.uint64], 2]  # of the coarser lattice and of the finer one


MOST_VARIATION = 12.0
"""dB: beyond that a surface is flat, with lumps."""

_FINER = 2  # log2 of the coarser lattice's spacing over the finer one's
_MOST_LEVEL = 60
_NODES = 32  # of a cell, over which the mean is taken


@noinline_kernel
def begin_variation(variation: Variation, decibels: float, length: float, unit: float, seed: int) -> None:
    """Set it up: the local rms height has a standard deviation of some decibels and changes over a length (m); places
    are a unit (m) apart."""
    variation.spread = decibels * math.log(10.0) / 20.0 * math.sqrt(0.5)
    variation.level = int(min(max(math.floor(math.log2(length / unit) + 0.5), _FINER), _MOST_LEVEL))
    variation.seed[0] = mixed(np.uint64(seed) + np.uint64(2) * STEP)
    variation.seed[1] = mixed(variation.seed[0])
    mean = 0.0
    for i in range(_NODES):
        w0, w1, w2, w3 = cubic_weights((i + 0.5) / _NODES)
        reach = 2.0 * variation.spread * EDGE
        mean += _mean_power(reach * w0) * _mean_power(reach * w1) * _mean_power(reach * w2) * _mean_power(reach * w3)
    variation.mean = math.log(mean / _NODES)
    variation.most = math.exp(2.0 * variation.spread * CREST - variation.mean)


@kernel
def _mean_power(x: float) -> float:
    """Return the mean of exp(x u), u between -1 and 1: sinh(x)/x."""
    return math.sinh(x) / x if abs(x) > 1e-4 else 1.0 + x * x / 6.0


@kernel
def local_roughness(variation: Variation, place: int) -> float:
    """Return the rms height about a place over the surface's own."""
    if variation.spread == 0.0:
        return 1.0
    noise = 0.0
    for n in range(len(variation.seed)):
        level, seed = variation.level - n * _FINER, variation.seed[n]
        cell = place >> level
        w0, w1, w2, w3 = cubic_weights((place - (cell << level)) / (np.int64(1) << level))
        z = w0 * drawn(seed, cell) + w1 * drawn(seed, cell + 1)
        noise += TO_HEIGHT * (z + w2 * drawn(seed, cell + 2) + w3 * drawn(seed, cell + 3))
    return math.exp(variation.spread * noise - variation.mean)
