"""A kernel that runs one of several by number."""

from collections.abc import Sequence
from typing import Any

from .jit import kernel


def one_of(kernels: Sequence[Any]) -> Any:
    """Return the kernel `choose(number, a, b, c)`, which runs kernels[number](a, b, c): the last for any higher number.

    All take three arguments, and return the same type.
    """
    first, rest = kernels[0], kernels[1:]
    if all(each is first for each in rest):

        @kernel
        def choose(number, a, b, c):
            return first(a, b, c)

        return choose
    others = one_of(rest)

    @kernel
    def choose_further(number, a, b, c):
        if number == 0:
            return first(a, b, c)
        return others(number - 1, a, b, c)

    return choose_further
