"""Gauss and Legendre's rule in panels."""

import math
from functools import lru_cache

import numpy as np

from ..material import Array
from ..modes import read_only

_PANEL = 16  # nodes; one rule serves intervals of all lengths


def segment(low: float, high: float, points: float) -> tuple[Array, Array]:
    """Return nodes and weights of an integral from low to high: `points` or more, in panels of equal width."""
    unit, weights = panels(max(1, math.ceil(points / _PANEL)))
    return low + (high - low) * unit, (high - low) * weights


@lru_cache(maxsize=128)
def panels(count: int) -> tuple[Array, Array]:
    """Return nodes and weights in 0..1 of so many panels; read-only."""
    nodes, weights = np.polynomial.legendre.leggauss(_PANEL)
    starts = np.arange(count)[:, None]
    unit, share = ((starts + (nodes + 1) / 2) / count).ravel(), np.tile(weights / (2 * count), count)
    read_only(unit, share)
    return unit, share
