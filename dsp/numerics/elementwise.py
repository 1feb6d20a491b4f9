"""Functions of numbers, compiled as functions of arrays."""

from collections.abc import Callable
from functools import wraps
from typing import Any

import numpy as np
from numba import vectorize

from .checks import Array


def elementwise(function: Callable[..., Any]) -> Callable[..., Array]:
    """Decorator: a function of numbers takes arrays that broadcast, as a NumPy ufunc does; float64 in and out.

    It is compiled at the first call. What overflows or underflows on the way is the function's own business.
    """
    ufunc = vectorize(function)

    @wraps(function)
    def call(*arguments: Any) -> Array:
        with np.errstate(all="ignore"):
            result: Array = ufunc(*arguments)
        return result

    return call
