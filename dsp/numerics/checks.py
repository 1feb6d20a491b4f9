"""Checks of what Python hands to kernels."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def checked(name: str, value: ArrayLike, low: float = -math.inf, high: float = math.inf, strict: bool = True) -> Array:
    """Return `value` as a float64 array of its shape.

    ValueError names `name`, the first number that is not finite or not in (low, high] ([low, high] if not strict), and
    the bounds that are given.
    """
    array = np.asarray(value, np.float64)
    inside = (array > low if strict else array >= low) & (array <= high) & np.isfinite(array)
    if not inside.all():
        culprit = array[~inside].flat[0]
        bounds = [f"{'above' if strict else 'at least'} {low:g}"] * (low > -math.inf)
        bounds += [f"at most {high:g}"] * (high < math.inf)
        raise ValueError(f"{name} = {culprit:g}: expected a finite number {' and '.join(bounds)}".rstrip())
    return array


def checked_scalar(
    name: str, value: ArrayLike, low: float = -math.inf, high: float = math.inf, strict: bool = True
) -> float:
    """Return `value` as a float; ValueError as by `checked`, and if it is more than one number."""
    array = checked(name, value, low, high, strict)
    if array.ndim:
        raise ValueError(f"{name} has the shape {array.shape}: expected one number")
    return float(array)
