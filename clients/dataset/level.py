"""The levels of samples: full scale, and the steps of whole numbers."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

QUANTIZED = {"16": 16, "24": 24}
"""Bits of samples that are whole numbers."""

_MOST, _LEAST = 40, -120  # exponents of a full scale of its own


def whole_of(peak: float) -> float:
    """Return the least power of two above a peak (Pa): samples over it lose nothing but their last bits."""
    if peak == 0.0:
        return 1.0
    return 2.0 ** min(max(math.frexp(peak)[1], _LEAST), _MOST)


def step_of(full_scale: float, samples: str) -> float:
    """Return the step (Pa) of samples."""
    return full_scale / 2.0 ** (QUANTIZED[samples] - 1)


def quantized(
    pressure: NDArray[np.float64], full_scale: float, samples: str
) -> NDArray[np.float32] | NDArray[np.int32]:
    """Return a pressure as samples: floats, or the nearest whole numbers of steps, int32."""
    if samples not in QUANTIZED:
        return pressure.astype(np.float32) / np.float32(full_scale)
    most = 2 ** (QUANTIZED[samples] - 1)
    steps = pressure * (most / full_scale)
    np.rint(steps, out=steps)
    np.clip(steps, -most, most - 1, out=steps)
    whole: NDArray[np.int32] = steps.astype(np.int32)
    return whole
