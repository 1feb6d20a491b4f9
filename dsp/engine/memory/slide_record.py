"""The engine's record of a slide."""

import numpy as np

from ...friction.stick_slip import FRICTION
from ...resonator.velocity import ROWS

SLID = 1024
"""Modes of an object that friction acts on."""

SLIDE = np.dtype(
    [
        ("friction", FRICTION),
        ("rows", np.float64, (2, ROWS * SLID)),  # of velocity.py, for both objects
        ("modes", np.int64, 2),
        ("row", np.int64, 2),  # of their shape tables, as friction acts on them
        ("weights", np.float64, (2, 4)),
        ("moved", np.int64),  # 1: since it was settled
        ("along", np.float64),
        ("position", np.float64),
        ("sweep", np.float64),  # m/s, gliding
        ("slip", np.float64),  # m/s: the driver's at the quantum's beginning
        ("laid", np.float64),  # share of the normal force that friction feels
        ("pull", np.float64),  # N: friction's mean
        ("press", np.int64),  # gesture whose force its friction feels; 0: its own
        ("pressed", np.int64),  # place of that contact, -1: none
    ],
    align=True,
)
"""The state of a slide besides its roll, which has the same place."""
