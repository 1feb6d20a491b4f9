"""The air's load on discs and membranes."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..air import Complex, Load, endless_plate, load, wavenumber
from ..material import Array
from ..modes import Indices
from .disc import Waves, baffled_disc, free_disc
from .lattice import COLUMNS, Curves
from .sampling import fill

_FAST = 1.5  # times the speed of sound: faster waves radiate from both sides of a disc as if it stood in a wall
_CLOSED, _WAVES = 1.08, 3.0  # the same, and by how many wavenumbers: faster ones radiate as on an endless plate
_SLOW = 0.35  # the same: of slower ones not all need be solved, from some orders and numbers on
_ALL_ORDERS, _DENSE, _MANY = 12, 6, 600


class Every:
    """All waves that round surfaces with one edge have, up to a root: orders, roots and c as in `disc.Waves`, (k,).

    And the impedances of those that were asked for, for a radius and a scale of 1: free, and in a wall on one side.
    """

    def __init__(self, order: Array, root: Array, growing: Array) -> None:
        self.order, self.root, self.growing = order, root, growing
        number = numbers(order, root)
        self.column = number % COLUMNS
        kinds, self.group = np.unique(order * order.size + number // COLUMNS, return_inverse=True)
        places = np.argsort(self.group * order.size + number, kind="stable")
        members = np.split(places, np.cumsum(np.bincount(self.group))[:-1])

        def waves(group: int) -> Waves:
            mine = members[group]
            return Waves(int(order[mine[0]]), root[mine], growing[mine], np.ones(mine.size))

        self.free = Curves(kinds.size, lambda group, x: free_disc(waves(group), x, 1.0))
        self.walled = Curves(kinds.size, lambda group, x: baffled_disc(waves(group), x, 1.0))


class Round(NamedTuple):
    """A round surface: its radius (m), its mass per area (kg/m^2), and how it is baffled, a word of `heard.BAFFLES`.

    Its modes by their numbers in `every`; the factors (k,) that make their shapes mass-normalised.
    """

    radius: float
    areal: float
    baffle: str
    every: Every
    mode: Indices
    scale: Array

    @property
    def order(self) -> Array:
        """The modes' angular orders."""
        return self.every.order[self.mode]

    @property
    def root(self) -> Array:
        """The modes' wavenumbers times the radius."""
        return self.every.root[self.mode]

    def only(self, modes: Indices) -> "Round":
        """Return the surface with some of its modes."""
        return self._replace(mode=self.mode[modes], scale=self.scale[modes])


class Loads:
    """The load as a function of the frequencies in air of some of a surface's modes."""

    def __init__(self, body: Round) -> None:
        self._body, self._order, self._root = body, body.order, body.root
        self._number = numbers(self._order, self._root)  # of its order's modes, from 0
        step = int(self._number.max(initial=0)) + 2
        keys = self._order.astype(np.intp) * step + self._number
        self._next, self._above = _places(keys, keys + 1), _places(keys, keys + step)
        self._odd = (self._order > _ALL_ORDERS) & (self._order % 2 == 1)

    def __call__(self, frequency: Array) -> Load:
        body, every = self._body, self._body.every
        x = wavenumber(frequency) * body.radius
        speed = x / self._root
        sides = 1.0 if body.baffle == "closed" else 2.0
        closed = (speed > _CLOSED) & (x - self._root > _WAVES)
        impedance: Complex = np.zeros(x.size, np.complex128)
        impedance[closed] = sides / 2 * endless_plate(body.areal, speed[closed] ** 2)
        skipped = self._between(speed)
        walled = (speed > _FAST) | (body.baffle != "free")
        for curves, which, factor in ((every.free, ~walled, 1.0), (every.walled, walled, sides)):
            row = np.flatnonzero(~closed & ~skipped & which)
            mode = body.mode[row]
            size = factor * (body.radius * body.scale[row]) ** 2
            impedance[row] = size * curves.at(every.group[mode], every.column[mode], x[row])
        found = load(impedance, frequency)
        fill(found, self._order, self._root, ~skipped, skipped & ~self._odd)
        fill(found, self._number, self._order, ~self._odd, skipped & self._odd)
        return found

    def _between(self, speed: Array) -> npt.NDArray[np.bool_]:
        """True for modes to interpolate, where there are many: slow ones between others, every other of an order, and
        most of odd orders."""
        if speed.size < _MANY:
            return np.zeros(speed.size, np.bool_)
        slow = speed < _SLOW
        alternate = ~self._odd & (self._number >= _DENSE) & (self._number % 2 == _DENSE % 2)
        neighbours = np.where(self._odd, self._above, self._next)
        inside: npt.NDArray[np.bool_] = slow & (self._odd | alternate) & (neighbours >= 0) & slow[neighbours]
        return inside


def _places(keys: Indices, asked: Indices) -> Indices:
    """Return the places of numbers among different keys, -1 for those that are none."""
    order = np.argsort(keys)
    found = order[np.minimum(np.searchsorted(keys[order], asked), keys.size - 1)]
    return np.where(keys[found] == asked, found, -1)


def numbers(order: Array, root: Array) -> Indices:
    """Return the number of each mode among those of its order, from 0."""
    number = np.zeros(order.size, np.intp)
    ranked = np.lexsort((root, order))
    begins = np.flatnonzero(np.diff(order[ranked], prepend=-1.0))
    number[ranked] = np.arange(order.size) - np.repeat(begins, np.diff(begins, append=order.size))
    return number
