"""Loads of many modes from those of a few: within a family they are smooth."""

from typing import Any

import numpy as np
import numpy.typing as npt

from ..air import Load
from ..material import Array
from ..modes import Indices

Mask = npt.NDArray[np.bool_]

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


class Filling:
    """The way in which the loads of `wanted` modes (n,) follow from those of `known` ones of their families, by their
    places there; the same for all loads."""

    def __init__(self, family: npt.NDArray[Any], place: Array, known: Mask, wanted: Mask) -> None:
        self._asked = asked = np.flatnonzero(wanted)
        if not asked.size:
            return
        given = np.flatnonzero(known & np.isin(family, family[asked]))
        self._given = given = given[np.lexsort((place[given], family[given]))]
        each, number = np.unique(family[given], return_inverse=True)
        apart = 2 * (np.abs(place).max() + 1)  # families one after the other, so that one search finds all
        begins = np.flatnonzero(np.diff(number, prepend=-1))
        mine = np.searchsorted(each, family[asked])
        first, last = begins[mine], np.append(begins[1:], given.size)[mine] - 2
        i = np.searchsorted(number * apart + place[given], mine * apart + place[asked]) - 1
        self._curves = _Cubics(place[given], begins, np.clip(i, first, last), place[asked])

    def fill(self, loads: Load) -> None:
        """Set the loads of the modes that are wanted."""
        if not self._asked.size:
            return
        level = np.log(np.maximum(loads.resistance[self._given], _LEAST))
        level, mass = self._curves(np.array([level, loads.mass[self._given]]))
        loads.resistance[self._asked], loads.mass[self._asked] = np.exp(level), mass


def _cubic(x: Array, y: Array, wanted: Array) -> Array:
    """Interpolate three points or more by Hermite's cubics; the slope at a point is that of the parabola around it."""
    at = np.clip(np.searchsorted(x, wanted) - 1, 0, x.size - 2)
    return _Cubics(x, np.zeros(1, np.intp), at, wanted)(y)


class _Cubics:
    """Hermite's cubics as in `_cubic`, through the points x (k,) of families, each of which begins at one of `begins`:
    at the places that are wanted (n,), between the points `at` and the next."""

    def __init__(self, x: Array, begins: Indices, at: Indices, wanted: Array) -> None:
        self._step = step = np.diff(x)
        step[begins[1:] - 1] = 1.0  # from one family to the next: no slope asks for it
        self._both = step[1:] + step[:-1]
        self._begins, self._ends = begins, np.append(begins[1:], x.size) - 1
        self._at, self._wide = at, x[at + 1] - x[at]
        self._along = (wanted - x[at]) / self._wide

    def __call__(self, y: Array) -> Array:
        """Return the values (..., n) of curves with the values y (..., k) at the points."""
        step, i, t = self._step, self._at, self._along
        rises = np.diff(y) / step
        slope = np.empty_like(y)
        slope[..., 1:-1] = (step[1:] * rises[..., :-1] + step[:-1] * rises[..., 1:]) / self._both
        first = 2 * rises[..., self._begins] - slope[..., self._begins + 1]
        slope[..., self._ends] = 2 * rises[..., self._ends - 1] - slope[..., self._ends - 1]
        slope[..., self._begins] = first
        here, there = y.take(i, axis=-1), y.take(i + 1, axis=-1)
        rise = (there - here) / self._wide
        bend = (slope.take(i, axis=-1) - rise) * (1 - t) + (rise - slope.take(i + 1, axis=-1)) * t
        value: Array = here + self._wide * t * (rise + (1 - t) * bend)
        return value
