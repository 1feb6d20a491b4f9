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
        self._begins = begins = np.flatnonzero(np.diff(number, prepend=-1))
        mine = np.searchsorted(each, family[asked])
        first, last = begins[mine], np.append(begins[1:], given.size)[mine] - 2
        i = np.searchsorted(number * apart + place[given], mine * apart + place[asked]) - 1
        self._at = np.clip(i, first, last)
        self._places = place[given], place[asked]

    def fill(self, loads: Load) -> None:
        """Set the loads of the modes that are wanted."""
        if not self._asked.size:
            return
        x, wanted = self._places
        level = np.log(np.maximum(loads.resistance[self._given], _LEAST))
        y = np.stack([level, loads.mass[self._given]])
        level, mass = _value(x, y, _slopes(x, y, self._begins), self._at, wanted)
        loads.resistance[self._asked], loads.mass[self._asked] = np.exp(level), mass


def _cubic(x: Array, y: Array, wanted: Array) -> Array:
    """Interpolate three points or more by Hermite's cubics; the slope at a point is that of the parabola around it."""
    at = np.clip(np.searchsorted(x, wanted) - 1, 0, x.size - 2)
    return _value(x, y, _slopes(x, y, np.zeros(1, np.intp)), at, wanted)


def _slopes(x: Array, y: Array, begins: Indices) -> Array:
    """Return the slopes (..., k) at the points of families, each of which begins at one of these places."""
    step = np.diff(x)
    step[begins[1:] - 1] = 1.0  # from one family to the next: no slope asks for it
    rise = np.diff(y) / step
    slope = np.empty_like(y)
    slope[..., 1:-1] = (step[1:] * rise[..., :-1] + step[:-1] * rise[..., 1:]) / (step[1:] + step[:-1])
    ends = np.append(begins[1:], x.size) - 1
    first = 2 * rise[..., begins] - slope[..., begins + 1]
    slope[..., ends] = 2 * rise[..., ends - 1] - slope[..., ends - 1]
    slope[..., begins] = first
    return slope


def _value(x: Array, y: Array, slope: Array, i: Indices, wanted: Array) -> Array:
    """Return the value at each place that is wanted, between the points i and i + 1."""
    step = x[i + 1] - x[i]
    here, there = y[..., i], y[..., i + 1]
    rise = (there - here) / step
    t = (wanted - x[i]) / step
    bend = (slope[..., i] - rise) * (1 - t) + (rise - slope[..., i + 1]) * t
    value: Array = here + step * t * (rise + (1 - t) * bend)
    return value
