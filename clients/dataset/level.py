"""The levels of samples: full scale, and the steps of whole numbers."""

from __future__ import annotations

import math
from typing import Any

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
    pressure: NDArray[np.float32], peak: float, full_scale: float, samples: str
) -> NDArray[np.float32] | NDArray[np.float64]:
    """Return a pressure, of which nothing is above a peak, as samples: floats, or the nearest whole numbers of steps,
    in floats as well; in the pressure's own memory where that holds them."""
    if samples not in QUANTIZED:
        return pressure / np.float32(full_scale)
    most = 2 ** (QUANTIZED[samples] - 1)
    factor = most / full_scale
    steps: NDArray[Any] = pressure.astype(_exact(factor), copy=False)
    steps *= factor
    np.rint(steps, out=steps)
    if round(peak * factor) >= most:  # there is no such number above 0
        np.clip(steps, -most, most - 1, out=steps)
    steps += 0.0  # no -0, which whole numbers do not have
    return steps


def pascals(samples: NDArray[Any], full_scale: float, form: str) -> NDArray[np.float32]:
    """Return samples of a form as a pressure: what a reader of their file multiplies by the full scale; in the samples'
    own memory where that holds it."""
    if form not in QUANTIZED:
        return (samples.astype(np.float64) * full_scale).astype(np.float32)
    step = step_of(full_scale, form)
    found: NDArray[Any] = samples.astype(_exact(step), copy=False)
    found *= step
    return found.astype(np.float32, copy=False)


def _exact(factor: float) -> np.dtype[np.float32] | np.dtype[np.float64]:
    """Return the precision in which products with a factor are exact: single where it is a power of two, else
    double."""
    return np.dtype(np.float32) if math.frexp(factor)[0] == 0.5 else np.dtype(np.float64)
