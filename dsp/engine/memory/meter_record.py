"""The record of the level meter, and the filters of ITU-R BS.1770 that it weighs by."""

import math
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from ...native.typed import Record, View, View2D, f32
from .capacity import MOST_CHANNELS

METERED = 1_280
"""Quanta that are kept: 0.4 s at the highest rate, and some that may be written meanwhile."""
WINDOW = 0.4
"""s over which momentary loudness is taken."""


class Meter(Record):
    """The level meter: its filters, and what it measured of late."""

    on: int
    shelf: Annotated[View[float], 5]  # b0, b1, b2, a1, a2
    high_pass: Annotated[View[float], 5]
    memory: Annotated[View2D[float], MOST_CHANNELS, 4]  # two of each filter
    power: Annotated[View[float], METERED]  # of each quantum: the weighted mean square, all channels added
    peak: Annotated[View2D[f32], METERED, MOST_CHANNELS]


def k_weighting(rate: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the shelf and the high pass at a sampling rate (Hz): each b0, b1, b2, a1, a2.

    They are the standard's at 48 kHz; at other rates the bilinear transform of the analogue filters behind these.
    """
    k, q = math.tan(math.pi * 1681.974450955533 / rate), 0.7071752369554196
    high = 10.0 ** (3.999843853973347 / 20.0)
    middle = high**0.4996667741545416
    a0 = 1.0 + k / q + k * k
    shelf = high + middle * k / q + k * k, 2.0 * (k * k - high), high - middle * k / q + k * k
    poles = 2.0 * (k * k - 1.0), 1.0 - k / q + k * k
    k, q = math.tan(math.pi * 38.13547087602444 / rate), 0.5003270373238773
    b0 = 1.0 + k / q + k * k
    high_pass = 1.0, -2.0, 1.0, 2.0 * (k * k - 1.0) / b0, (1.0 - k / q + k * k) / b0
    return np.array((*shelf, *poles)) / a0, np.array(high_pass)
