"""Gauss and Legendre's rule in panels, and Bessel functions of many orders at once."""

import math
from functools import lru_cache

import numpy as np

from ..material import Array
from ..modes import read_only

_SPARE, _SPREAD = 4, 6.0  # orders from which Miller's recurrence starts, with a relative error of 1e-11
_PANEL = 16  # nodes; one rule serves intervals of all lengths


def segment(low: float, high: float, points: float) -> tuple[Array, Array]:
    """Return nodes and weights of an integral from low to high: `points` or more, in panels of equal width."""
    unit, weights = panels(max(1, math.ceil(points / _PANEL)))
    return low + (high - low) * unit, (high - low) * weights


@lru_cache(maxsize=128)
def panels(count: int) -> tuple[Array, Array]:
    """Return nodes and weights in 0..1 of so many panels; read-only."""
    nodes, weights = np.polynomial.legendre.leggauss(_PANEL)
    starts = np.arange(count)[:, None]
    unit, share = ((starts + (nodes + 1) / 2) / count).ravel(), np.tile(weights / (2 * count), count)
    read_only(unit, share)
    return unit, share


def spherical_bessel(count: int, x: Array) -> Array:
    """Return the spherical Bessel functions j_0 to j_(count - 1) at x >= 0: (count, *x.shape)."""
    return _by_recurrence(count, x, 0.5)


def bessel(count: int, x: Array) -> Array:
    """Return Bessel functions J_0 to J_(count - 1) at x >= 0: (count, *x.shape)."""
    return _by_recurrence(count, x, 0.0)


def _by_recurrence(count: int, x: Array, half: float) -> Array:
    """Return Bessel functions of either kind by f_(n-1) + f_(n+1) = 2 (n + half)/x f_n: upwards where x > n, by Miller
    downwards elsewhere."""
    far = x > count
    if not far.any():
        return _downwards(count, x, half)
    out = np.empty((count, *x.shape))
    out[:, far] = _upwards(count, x[far], half)
    out[:, ~far] = _downwards(count, x[~far], half)
    return out


def _first_two(x: Array, half: float) -> tuple[Array, Array]:
    if half:
        safe = np.maximum(x, 1e-3)
        zero = np.where(x < 1e-3, 1 - x**2 / 6, np.sin(safe) / safe)
        one = np.where(x < 1e-3, x / 3 * (1 - x**2 / 10), (np.sin(safe) / safe - np.cos(safe)) / safe)
        return zero, one
    from scipy.special import j0, j1

    return j0(x), j1(x)


def _upwards(count: int, x: Array, half: float) -> Array:
    out = np.empty((max(count, 2), *x.shape))
    out[0], out[1] = _first_two(x, half)
    inverse = 2 / x
    for n in range(1, count - 1):
        out[n + 1] = (n + half) * inverse * out[n] - out[n - 1]
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
