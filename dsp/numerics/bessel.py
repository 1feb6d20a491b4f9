"""Bessel functions of whole orders of all kinds, and the spherical ones, by numpy alone.

J_n, and j_n, by f_(n-1) + f_(n+1) = 2 n/x f_n (spherical: 2 n + 1): upwards where x is above all orders, else by Miller
downwards from an order of which nothing is left, scaled to J_0 or J_1. These two are the means of cos(x sin t) and of
sin t sin(x sin t) over a turn, and Hankel's series for large x. Y_0 and Y_1 are Neumann's series (Abramowitz and
Stegun, 9.1.88 and 9.1.89); the further ones follow upwards. I_n: Perron's continued fraction of I_n/I_(n-1), scaled by
exp x = I_0 + 2 sum I_n. K_n: the mean of exp(-x cosh t) cosh(n t). Each errs by 1e-13 of itself at most, where it is
not near a zero.
"""

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .checks import Array

Order = NDArray[Any] | float
"""Whole numbers, of any type."""

_SPARE, _SPREAD = 8, 7.5  # orders from which Miller's recurrence starts: the rest is less than rounding
_COUNT = 160  # orders that are computed at once, or twice as many and so on: what one gives hangs on no other
_TOGETHER = 4096  # arguments, the same
_FAR = 25.0  # from here on Hankel's series
_TERMS = 24  # of it
_POINTS = 16  # in a quarter of a turn: exact up to _FAR
_NEUMANN = 60  # orders of Neumann's series, up to _FAR
_FADED = 40.0  # of an exponent: less than rounding
_STEPS = 128  # of the integral of K_n below 1, and a quarter above
_SQUARE_ROOTS = 9.0  # of x: I_n of n further up is exp(-40) of what it was


def jn(order: Order, x: Array) -> Array:
    """Return J_n(x) of whole orders at x >= 0, each alike, whatever others are requested with it; arrays that
    broadcast."""
    order, x = np.asarray(order), np.asarray(x, np.float64)
    above = np.abs(order).astype(np.int64)
    count = _COUNT << max(0, math.ceil(math.log2((above.max(initial=0) + 1) / _COUNT)))
    above, at = np.broadcast_arrays(above, np.arange(x.size).reshape(x.shape))
    found = np.empty(above.shape)
    for first in range(0, x.size, _TOGETHER):
        some = (at >= first) & (at < first + _TOGETHER)
        found[some] = _by_recurrence(count, x.ravel()[first : first + _TOGETHER], 0.0)[above[some], at[some] - first]
    return np.where((order < 0) & (order % 2 == 1), -found, found)


def ine(order: Order, x: Array) -> Array:
    """Return exp(-x) I_n(x) of whole orders n >= 0 at x > 0; arrays that broadcast."""
    share, above = _growing(order, x, 0.0)
    return np.asarray(share / (1 + 2 * above))


def spherical_ine(order: Order, x: Array) -> Array:
    """Return exp(-x) i_n(x), the spherical functions, of whole orders n >= 0 at x > 0; arrays that broadcast."""
    return np.asarray(-np.expm1(-2 * x) / (2 * x) * _growing(order, x, 0.5)[0])


def _growing(order: Order, x: Array, half: float) -> tuple[Array, Array]:
    """Return f_n/f_0 of the functions that grow, and the sum of all f_n/f_0 from n = 1 on."""
    order, x = np.asarray(order), np.asarray(x, np.float64)
    most = int(order.max(initial=0))
    start = most + math.ceil(_SQUARE_ROOTS * math.sqrt(x.max(initial=0.0))) + _SPARE
    ratio, above = np.zeros_like(x), np.zeros_like(x)
    share = np.ones(np.broadcast_shapes(order.shape, x.shape))
    for n in range(start, 0, -1):
        ratio = x / (2 * (n + half) + x * ratio)
        above = ratio * (1 + above)
        if n <= most:
            share *= np.where(order >= n, ratio, 1.0)
    return share, above


def kne_table(count: int, x: Array) -> Array:
    """Return exp(x) K_0(x) to exp(x) K_(count - 1)(x) at x > 0, (count, *x.shape); infinite where they are too large
    for a number."""
    flat = np.ravel(x)
    out = np.empty((max(count, 2), flat.size))
    small = flat < 1
    for some, steps in ((small, _STEPS), (~small, _STEPS // 4)):
        out[:2, some] = _falling(flat[some], steps)
    with np.errstate(over="ignore"):
        for n in range(1, count - 1):
            out[n + 1] = out[n - 1] + 2 * n / flat * out[n]
    return out[:count].reshape(count, *np.shape(x))


def _falling(x: Array, steps: int) -> tuple[Array, Array]:
    """Return exp(x) K_0(x) and exp(x) K_1(x)."""
    most = np.arccosh(1 + _FADED / x)
    above = 2 * np.sinh(most * (np.arange(steps + 1)[:, None] / (2 * steps))) ** 2  # cosh t - 1
    weight = np.exp(-x * above) * (most / steps)
    weight[0] /= 2
    return weight.sum(axis=0), (weight * (1 + above)).sum(axis=0)


def yn_table(count: int, x: Array) -> Array:
    """Return Y_0 to Y_(count - 1) at x > 0, (count, *x.shape); minus infinity where they are too large for a number."""
    flat = np.ravel(x)
    return _upwards(count, flat, 0.0, *_second_kind(flat)).reshape(count, *np.shape(x))


def spherical_yn_table(count: int, x: Array) -> Array:
    """Return y_0 to y_(count - 1), the spherical functions, at x > 0, (count, *x.shape); minus infinity where they are
    too large for a number."""
    flat = np.ravel(x)
    zero = -np.cos(flat) / flat
    return _upwards(count, flat, 0.5, zero, (zero - np.sin(flat)) / flat).reshape(count, *np.shape(x))


def derivatives(table: Array, x: Array, spherical: bool = False) -> Array:
    """Return the derivatives by x of a table of J_n or Y_n of the orders from 0 on, (count, *x.shape), all but the last
    one's."""
    n = np.arange(len(table) - 1).reshape(-1, *[1] * np.ndim(x))
    with np.errstate(over="ignore", invalid="ignore"):  # infinities
        return np.asarray(n / x * table[:-1] - table[1:]) if spherical else _whole_derivatives(table)


def _whole_derivatives(table: Array) -> Array:
    below = np.concatenate([-table[1:2], table[:-2]])
    return np.asarray((below - table[1:]) / 2)


def spherical_bessel(count: int, x: Array) -> Array:
    """Return the spherical Bessel functions j_0 to j_(count - 1) at x >= 0: (count, *x.shape)."""
    return _by_recurrence(count, np.ravel(x), 0.5).reshape(count, *np.shape(x))


def bessel(count: int, x: Array) -> Array:
    """Return Bessel functions J_0 to J_(count - 1) at x >= 0: (count, *x.shape)."""
    return _by_recurrence(count, np.ravel(x), 0.0).reshape(count, *np.shape(x))


def _by_recurrence(count: int, x: Array, half: float) -> Array:
    """Return those of either kind at x (k,) by f_(n-1) + f_(n+1) = 2 (n + half)/x f_n: upwards where x > n, by Miller
    downwards elsewhere."""
    far = x > count
    if not far.any():
        return _downwards(count, x, half)
    out = np.empty((count, *x.shape))
    out[:, far] = _upwards(count, x[far], half, *_first_two(x[far], half))
    out[:, ~far] = _downwards(count, x[~far], half)
    return out


def _first_two(x: Array, half: float) -> tuple[Array, Array]:
    if half:
        safe = np.maximum(x, 1e-3)
        zero = np.where(x < 1e-3, 1 - x**2 / 6, np.sin(safe) / safe)
        one = np.where(x < 1e-3, x / 3 * (1 - x**2 / 10), (np.sin(safe) / safe - np.cos(safe)) / safe)
        return zero, one
    zero, one = np.empty_like(x), np.empty_like(x)
    far = x > _FAR
    zero[far], one[far] = _hankel(x[far])[:2]
    near = x[~far]
    turns = [math.sin((k + 0.5) * math.pi / (2 * _POINTS)) for k in range(_POINTS)]
    zero[~far] = sum(np.cos(near * each) for each in turns) / _POINTS
    one[~far] = sum(each * np.sin(near * each) for each in turns) / _POINTS
    return zero, one


def _second_kind(x: Array) -> tuple[Array, Array]:
    """Return Y_0 and Y_1."""
    zero, one = np.empty_like(x), np.empty_like(x)
    far = x > _FAR
    zero[far], one[far] = _hankel(x[far])[2:]
    near = x[~far]
    j = _downwards(_NEUMANN + 2, near, 0.0)
    log = np.log(near / 2) + np.euler_gamma
    k = np.arange(1, _NEUMANN // 2 + 1)
    sign = -((-1.0) ** k)
    zero[~far] = 2 / math.pi * (log * j[0] + 2 * np.tensordot(sign / k, j[2 * k], 1))
    rest = np.tensordot(sign * (2 * k + 1) / (k * (k + 1)), j[2 * k + 1], 1)
    one[~far] = 2 / math.pi * ((log - 1) * j[1] - j[0] / near + rest)
    return zero, one


def _hankel(x: Array) -> tuple[Array, Array, Array, Array]:
    """Return J_0, J_1, Y_0 and Y_1 at large x, by Hankel's series."""
    size, cosine, sine = np.sqrt(1 / (math.pi * x)), np.cos(x), np.sin(x)
    sums = np.zeros((4, x.size))
    for terms in _hankel_series():
        sums = sums / x**2 + terms
    even, odd, even1, odd1 = sums * np.stack([np.ones_like(x), 1 / x] * 2)
    a, b = cosine + sine, sine - cosine  # of the phase x - pi/4, times the root of 2
    zero, one = size * (even * a - odd * b), size * (even1 * b + odd1 * a)
    return zero, one, size * (even * b + odd * a), size * (odd1 * b - even1 * a)


@cache
def _hankel_series() -> Array:
    """Return the coefficients of Hankel's series by falling powers of 1/x^2, (powers, 4, 1): of the orders 0 and 1, the
    even terms and the odd ones; with their signs."""
    both = []
    for four in (0, 4):  # 4 n^2
        terms = [1.0]
        for k in range(1, _TERMS):
            terms.append(terms[-1] * (four - (2 * k - 1) ** 2) / (8 * k))
        signed = [(-1) ** (k // 2) * each for k, each in enumerate(terms)]
        both += [signed[::2], signed[1::2]]
    return np.array(both).T[::-1, :, None]


def _upwards(count: int, x: Array, half: float, zero: Array, one: Array) -> Array:
    out = np.empty((max(count, 2), *x.shape))
    out[0], out[1] = zero, one
    with np.errstate(over="ignore", invalid="ignore"):
        for n in range(1, count - 1):
            out[n + 1] = 2 * (n + half) / x * out[n] - out[n - 1]
    return out[:count]


def _downwards(count: int, x: Array, half: float) -> Array:
    """Return them with the orders' leading powers x^n taken out, f_n = power_n g_n, so that nothing overflows."""
    out = np.empty((max(count, 2), *x.shape))
    if not x.size:
        return out[:count]
    start = count + _SPARE + math.ceil(_SPREAD * count ** (1 / 3))
    above, here, step = np.zeros_like(x), np.ones_like(x), np.empty_like(x)
    quarter = x**2 / 4
    for n in range(start, 0, -1):
        np.multiply(quarter, -1 / ((n + half) * (n + half + 1)), out=step)
        step *= above
        above, here = here, np.add(here, step, out=out[n - 1] if n <= len(out) else above)
    zero, one = _first_two(x, half)
    larger = np.abs(zero) > np.abs(one)
    leading = np.where(larger, zero, one) / np.where(larger | (out[1] == 0), out[0], out[1] * (x / (2 * (1 + half))))
    out[0] *= leading
    double = x / 2
    for n in range(1, len(out)):
        leading *= double
        leading /= n + half
        out[n] *= leading
    return out[:count]
