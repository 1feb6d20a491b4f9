"""The record of the sound that the spectral bank has laid out ahead for modes that have left it."""

import numpy as np

from .capacity import MODES, MODES_PER_OBJECT, OBJECTS

TAIL_MODES = MODES + MODES_PER_OBJECT
"""The modes of all tails: an object has one at most, and one may not fit at the end."""

TAIL = np.dtype(
    [
        ("first", np.int64),  # of its modes
        ("size", np.int64),
        ("end", np.int64),  # samples: when the block ends in which it was laid out
        ("gain", np.float64, 2),  # with which it is in there
    ],
    align=True,
)

TAILS = np.dtype(
    [
        ("entries", TAIL, OBJECTS),  # a ring
        ("first", np.int64),  # number of the oldest
        ("count", np.int64),
        ("top", np.int64),  # the mode after the newest
        ("y1", np.float64, TAIL_MODES),
        ("y2", np.float64, TAIL_MODES),
        ("a1", np.float64, TAIL_MODES),
        ("a2", np.float64, TAIL_MODES),
        ("balance", np.float64, TAIL_MODES),
    ],
    align=True,
)
