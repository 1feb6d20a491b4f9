"""A kernel that runs one of several by number."""

from collections.abc import Callable, Sequence
from typing import TypeVar

from .jit import Kernel, kernel

A = TypeVar("A")
B = TypeVar("B")
C = TypeVar("C")
R = TypeVar("R")


def one_of(kernels: Sequence[Callable[[A, B, C], R]]) -> Kernel[[int, A, B, C], R]:
    """Return the kernel `choose(number, a, b, c)`, which runs kernels[number](a, b, c): the last for any higher number.

    All take three arguments, and return the same type.
    """
    first, rest = kernels[0], kernels[1:]
    if all(each is first for each in rest):

        @kernel
        def choose(number: int, a: A, b: B, c: C) -> R:
            return first(a, b, c)

        return choose
    others = one_of(rest)

    @kernel
    def choose_further(number: int, a: A, b: B, c: C) -> R:
        if number == 0:
            return first(a, b, c)
        return others(number - 1, a, b, c)

    return choose_further
