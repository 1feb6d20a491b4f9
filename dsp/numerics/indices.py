"""Indices of floats."""

from ..native.jit import kernel


@kernel
def index_of(x: float, count: int) -> int:
    """Return the whole part of x as an index of `count` > 0 values: the first where x is below 0 or no number, the last
    where it is beyond. The order of arguments says so: a comparison with what is no number is false."""
    return int(min(max(0.0, x), count - 1.0))
