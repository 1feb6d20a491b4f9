"""Functions of numbers, compiled as functions of arrays."""

from collections.abc import Callable
from functools import cache, wraps
from typing import Any

import numpy as np

from .checks import Array


def elementwise(function: Callable[..., Any]) -> Callable[..., Array]:
    """Make a function of numbers take arrays that broadcast, as a NumPy ufunc does: a decorator; float64 in and out.

    It is compiled at the first call. Overflow and underflow on the way are the function's own business.
    """

    @cache
    def ufunc() -> Any:
        from numba import vectorize  # it takes a while, and not everyone needs it

        return vectorize(function)

    @wraps(function)
    def call(*arguments: Any) -> Array:
        with np.errstate(all="ignore"):
            result: Array = ufunc()(*arguments)
        return result

    return call
