"""Functions of numbers, compiled as functions of arrays."""

import functools
from collections.abc import Callable
from ctypes import c_int64, c_void_p
from typing import Any

import numpy as np

from ..native.jit import CFunction, Kernel, carray, kernel, to_fixed_tuple
from .checks import Array


class Elementwise(CFunction):
    """A function of numbers that takes arrays which broadcast, as a NumPy ufunc does; float64 in and out."""

    def __init__(self, function: Callable[..., Any]) -> None:
        inner = function if isinstance(function, Kernel) else kernel(function)
        function, count = inner.py_func, inner.py_func.__code__.co_argcount

        def each(rows: int, values: int, size: int) -> None:
            arguments, found = carray(rows, (size, count), np.float64), carray(values, (size,), np.float64)
            for i in range(size):
                found[i] = inner(*to_fixed_tuple(arguments[i], count))

        each.__name__ = each.__qualname__ = f"each{function.__name__}"
        each.__module__ = function.__module__
        super().__init__(each, None, (c_void_p, c_void_p, c_int64))
        functools.update_wrapper(self, function)

    def __call__(self, *arguments: Any) -> Any:
        rows = np.stack(np.broadcast_arrays(*arguments), axis=-1, dtype=np.float64)
        values = np.empty(rows.shape[:-1])
        super().__call__(rows.ctypes.data, values.ctypes.data, values.size)
        return values[()]


def elementwise(function: Callable[..., Any]) -> Callable[..., Array]:
    """Make a function of numbers, or a kernel of the same module, take arrays, a decorator; the module's are compiled
    together, as its C functions."""
    return Elementwise(function)
