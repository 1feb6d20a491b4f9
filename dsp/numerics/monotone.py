"""Cubic interpolation that overshoots nowhere."""

import numpy as np

from .checks import Array


def monotone_cubic(x: Array, values: Array, at: Array) -> Array:
    """Return values (n, p) at ascending x (p,), two or more, between these, at places (k,) among them: (n, k).

    Cubics by their slopes at x: between two rises of one sign their harmonic mean, weighed by the distances, else 0
    (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984); at an end that of the parabola, if it does not overshoot.
    """
    h = np.diff(x)
    rise = np.diff(values) / h
    slope = np.zeros_like(values)
    if len(h) == 1:
        slope[:] = rise
    else:
        slope[:, 1:-1] = _between(h, rise)
        slope[:, 0] = _at_end(h[0], h[1], rise[:, 0], rise[:, 1])
        slope[:, -1] = _at_end(h[-1], h[-2], rise[:, -1], rise[:, -2])
    i = np.clip(np.searchsorted(x, at, "right") - 1, 0, len(h) - 1)
    t, left, right = (at - x[i]) / h[i], values[:, i], values[:, i + 1]
    bow_left, bow_right = slope[:, i] * h[i] - (right - left), (right - left) - slope[:, i + 1] * h[i]
    found: Array = left + t * (right - left) + t * (1 - t) * ((1 - t) * bow_left + t * bow_right)
    return found


def _between(h: Array, rise: Array) -> Array:
    """Return the slopes between rises (n, p) over distances (p,)."""
    before, after = rise[:, :-1], rise[:, 1:]
    near, far = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    alike = before * after > 0
    sums = near / np.where(alike, before, 1.0) + far / np.where(alike, after, 1.0)
    return np.where(alike, (near + far) / np.where(alike, sums, 1.0), 0.0)


def _at_end(h: float, next_h: float, rise: Array, next_rise: Array) -> Array:
    """Return the slopes at an end from the first rises from it on, over their distances."""
    slope = ((2 * h + next_h) * rise - h * next_rise) / (h + next_h)
    turns = np.sign(rise) != np.sign(next_rise)
    slope = np.where(turns & (np.abs(slope) > 3 * np.abs(rise)), 3 * rise, slope)
    return np.where(np.sign(slope) == np.sign(rise), slope, 0.0)
