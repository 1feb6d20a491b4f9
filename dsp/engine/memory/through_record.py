"""The record of the direct path from a roll's force to the sound of an object."""

import numpy as np

from ...resonator.fed import REACH

THROUGH = np.dtype(
    [
        ("serial", np.int64),  # of the object
        ("retuned", np.int64),  # times its modes had got new coefficients
        ("modes", np.int64),  # on which the roll acts
        ("row", np.int64),  # the first of four rows of its mode shapes
        ("taps", np.float64, (4, 2, REACH + 1)),  # of each of these rows, left and right
    ],
    align=True,
)
"""Taps from a roll's force to an object's sound (resonator/fed.py), for as long as they stay what they are."""
