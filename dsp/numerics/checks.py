"""Checks of what Python hands to kernels."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


def checked(name: str, value: ArrayLike, low: float, high: float = math.inf, strict: bool = True) -> NDArray:
    """`value` as float64, or ValueError naming it where it is not finite or not in (low, high] ([low, high] if not
    strict)."""
    array = np.asarray(value, np.float64)
    inside = (array > low if strict else array >= low) & (array <= high) & np.isfinite(array)
    if not inside.all():
        culprit = array[~inside].flat[0]
        bounds = f"{'above' if strict else 'at least'} {low:g}" + (f" and at most {high:g}" if high < math.inf else "")
        raise ValueError(f"{name} = {culprit:g}: expected a finite number {bounds}")
    return array
