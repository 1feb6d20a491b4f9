"""A filter of one pole that moves, of which four samples are found at once."""

from ..native.jit import kernel
from ..native.typed import View


@kernel
def run_pole(values: View[float], before: float, more: float, last: float) -> float:
    """Replace each x[n] by y[n] = p[n] y[n - 1] + x[n], p[n] = before + (n + 1) more, y[-1] = last; return the last.

    There is a multiple of four values. Each is found from the one before its four, so that they don't wait for each
    other.
    """
    y = last
    for n in range(0, len(values) - 3, 4):
        p = before + (n + 1) * more
        q, r, s = p + more, p + 2.0 * more, p + 3.0 * more
        two, three = p * q, p * q * r
        first = values[n]
        second = values[n + 1] + q * first
        third = values[n + 2] + r * second
        fourth = values[n + 3] + s * third + three * s * y
        values[n] = first + p * y
        values[n + 1] = second + two * y
        values[n + 2] = third + three * y
        values[n + 3] = fourth
        y = fourth
    return y
