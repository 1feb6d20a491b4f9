"""What the engine keeps of the few modes that stand for an object's many where a body rolls on it."""

import numpy as np

from ..resonator.bank import RESPONSES
from ..resonator.simd import LANES

MOST = 64
"""Reduced modes of one roll; a multiple of LANES."""

REDUCED = np.dtype(
    [
        ("size", np.int64),  # how many there are, a multiple of LANES
        ("place", np.int64, MOST),  # of a band's mode among them, -1: it has none
        ("members", np.int64, MOST),  # how many modes are in a band
        ("top", np.float64),  # Hz: the end of the last band
        ("shape", np.float64, MOST),  # kg^-1/2, where the body is
        ("one", np.float64, 4),  # weights of a point that has one shape
        ("y1", np.float64, MOST),
        ("y2", np.float64, MOST),
        ("a1", np.float64, MOST),
        ("a2", np.float64, MOST),
        ("balance", np.float64, MOST),
        ("response", np.float64, MOST // LANES * RESPONSES),
    ],
    align=True,
)
"""Reduced modes, and how they ring."""
