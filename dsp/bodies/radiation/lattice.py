"""Impedances of modes over the frequency, solved at fixed places of x = k a, whatever body asks for them.

A body's size, thickness and density say where its modes lie, but not how a mode of that shape radiates at an x. So it
is solved at the places of a lattice, which are the same for all bodies, kept, and interpolated between them. A value
depends on its place and its group of modes alone, and not on what was requested before, to the bit.
"""

from collections.abc import Callable
from threading import Lock

import numpy as np

from ..air import Complex
from ..material import Array
from ..modes import Indices

COLUMNS = 8
"""Modes that are solved together, at most."""

_BEND = 3.0  # x from which on the places are equally far apart in x, and below which in ln x
_NEWTON_STEPS = 8
_STEP = 0.2  # of ln x + x/_BEND, between places
_NODES = 4  # between which a value is interpolated
_BITS = 3
_AT_ONCE = 1 << _BITS  # places that are solved together
_LOWEST, _PIECES = -25, 200  # pieces of so many places: from x = 1e-17 to 800
_NOISE = 1e-15  # of an impedance: less resistance is rounding
_NUMBERS = np.arange(_NODES)[:, None]

Solve = Callable[[int, Array], Complex]
"""A group's number and places x (p,) -> impedances of its modes there, (p, modes)."""


class Curves:
    """The impedances of groups of modes, as far as they were requested. Any thread may ask."""

    def __init__(self, groups: int, solve: Solve) -> None:
        self._solve = solve
        self._slot = np.full((groups, _PIECES), -1, np.int32)
        self._values = np.empty((16, _AT_ONCE, COLUMNS, 2))  # ln R, and the mass times c over the radius
        self._count = 0
        self._lock = Lock()

    def at(self, group: Indices, column: Indices, x: Array) -> Complex:
        """Return the impedances of modes (n,), by their groups and columns there, at x > 0 (n,), interpolated by cubics
        of ln R and of the mass."""
        along = _along(x) / _STEP
        first = np.floor(along).astype(np.intp) - _NODES // 2 + 1
        places = first + _NUMBERS
        piece, within = (places >> _BITS) - _LOWEST, places & (_AT_ONCE - 1)
        mine = group * _PIECES + piece  # of the table as one row
        with self._lock:
            slot = self._slot.take(mine)
            if slot.min(initial=0) < 0:
                self._add(mine[slot < 0])
                slot = self._slot.take(mine)
            found = self._values.reshape(-1, 2).take((slot * _AT_ONCE + within) * COLUMNS + column, axis=0)
        weights = cubic_weights(along - first)
        resistance, mass = ((weights * found[..., i]).sum(axis=0) for i in (0, 1))
        return np.asarray(np.exp(resistance) + 1j * x * mass)

    def _add(self, numbers: Indices) -> None:
        """Solve groups of modes at pieces of the lattice, by their numbers in the table as one row."""
        for number in np.unique(numbers):
            group, piece = divmod(int(number), _PIECES)
            x = _x_of((piece + _LOWEST) * _AT_ONCE + np.arange(_AT_ONCE))
            solved = self._solve(group, x)
            if self._count == len(self._values):
                self._values = np.concatenate([self._values, np.empty_like(self._values)])
            mine = self._values[self._count, :, : solved.shape[1]]
            mine[..., 0] = np.log(np.maximum(solved.real, _NOISE * np.abs(solved)))
            mine[..., 1] = solved.imag / x[:, None]
            self._slot[group, piece] = self._count
            self._count += 1


def _along(x: Array) -> Array:
    return np.asarray(np.log(x) + x / _BEND)


def _x_of(place: Indices) -> Array:
    """Return the x of places by their numbers: of ln x + x/_BEND = number _STEP."""
    wanted = place * _STEP
    x = np.exp(np.minimum(wanted, 0.0)) + _BEND * np.maximum(wanted, 0.0)
    for _ in range(_NEWTON_STEPS):  # to rounding
        x *= (1 + wanted - np.log(x)) / (1 + x / _BEND)
    return np.asarray(x)


def cubic_weights(t: Array) -> Array:
    """Return the weights (_NODES, n) of values at 0, 1, 2, 3 in a cubic's value at t."""
    a, b, c, d = t, t - 1, t - 2, t - 3
    return np.array([-b * c * d / 6, a * c * d / 2, -a * b * d / 2, a * b * c / 6])
