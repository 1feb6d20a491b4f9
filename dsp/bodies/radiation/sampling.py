"""Loads of many modes from those of a few: within a family they are smooth."""

import numpy as np

from ..air import Load
from ..material import Array
from ..modes import Indices

_LEAST = 1e-300
_GROWTH = 1.25  # from one member to the next, where not all are solved


def members(count: int, dense: int) -> Indices:
    """Choose which of `count` members to solve: the first `dense`, then fewer and fewer, and the last."""
    chosen = list(range(min(dense, count)))
    while chosen and chosen[-1] < count - 1:
        chosen.append(min(count - 1, max(chosen[-1] + 1, round(chosen[-1] * _GROWTH))))
    return np.array(chosen, np.intp)


def between(known: Array, loads: Load, wanted: Array) -> Load:
    """Return the loads at `wanted` (n,) from those at `known` places (k,), ascending: a cubic of ln R and of the
    mass."""
    if np.array_equal(known, wanted):
        return loads
    level = np.log(np.maximum(loads.resistance, _LEAST))
    return Load(np.exp(_cubic(known, level, wanted)), _cubic(known, loads.mass, wanted))


def fill(loads: Load, place: Array, known: Indices, wanted: Indices) -> None:
    """Set the loads of `wanted` members from those of `known` ones by their places (n,)."""
    known = known[np.argsort(place[known])]
    found = between(place[known], Load(loads.resistance[known], loads.mass[known]), place[wanted])
    loads.resistance[wanted], loads.mass[wanted] = found


def _cubic(x: Array, y: Array, wanted: Array) -> Array:
    """Interpolate three points or more by Hermite's cubics; the slope at a point is that of the parabola around it."""
    step = np.diff(x)
    rise = np.diff(y) / step
    slope = np.empty_like(y)
    slope[1:-1] = (step[1:] * rise[:-1] + step[:-1] * rise[1:]) / (step[1:] + step[:-1])
    slope[0], slope[-1] = 2 * rise[0] - slope[1], 2 * rise[-1] - slope[-2]
    i = np.clip(np.searchsorted(x, wanted) - 1, 0, x.size - 2)
    t = (wanted - x[i]) / step[i]
    bend = (slope[i] - rise[i]) * (1 - t) + (rise[i] - slope[i + 1]) * t
    value: Array = y[i] + step[i] * t * (rise[i] + (1 - t) * bend)
    return value
