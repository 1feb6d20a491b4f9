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
        # Find four values from number n on by the last one, and return the last of them.
        poles = (q, r, s)
        products = (p, two, three, three * s)
        first = values[n]
        second = values[n + 1] + poles[0] * first
        third = values[n + 2] + poles[1] * second
        fourth = values[n + 3] + poles[2] * third + products[3] * y
        values[n] = first + products[0] * y
        values[n + 1] = second + products[1] * y
        values[n + 2] = third + products[2] * y
        values[n + 3] = fourth
        y = fourth
    return y
