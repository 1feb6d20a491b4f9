"""The air's load on discs and membranes."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..air import Complex, Load, endless_plate, load, wavenumber
from ..material import Array
from ..modes import Indices
from .disc import Waves, baffled_disc, free_disc
from .lattice import COLUMNS, Curves
from .sampling import Filling

_FAST = 1.5  # times the speed of sound: faster waves radiate from both sides of a disc as if it stood in a wall
_CLOSED, _WAVES = 1.08, 3.0  # the same, and by how many wavenumbers: faster ones radiate as on an endless plate
_SLOW = 0.35  # the same: of slower ones not all need be solved, from some orders and numbers on
_ALL_ORDERS, _DENSE, _MANY = 12, 6, 600


class Every:
    """All waves that round surfaces with one edge have, up to a root: orders, roots and c as in `disc.Waves`, (k,).

    And the impedances of those that were requested, for a radius and a scale of 1: free, and in a wall on one side.
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
        self._body, self._families = body, _families(body.every, body.mode.tobytes())

    def __call__(self, frequency: Array) -> Load:
        body, every = self._body, self._body.every
        x = wavenumber(frequency) * body.radius
        root = self._families.root
        speed = x / root
        sides = 1.0 if body.baffle == "closed" else 2.0
        closed = (speed > _CLOSED) & (x - root > _WAVES)
        impedance: Complex = np.zeros(x.size, np.complex128)
        impedance[closed] = sides / 2 * endless_plate(body.areal, speed[closed] ** 2)
        skipped = self._between(speed)
        walled = (speed > _FAST) | (body.baffle != "free")
        for curves, which, factor in ((every.free, ~walled, 1.0), (every.walled, walled, sides)):
            row = np.flatnonzero(~closed & ~skipped & which)
            if not row.size:
                continue
            mode = body.mode[row]
            size = factor * (body.radius * body.scale[row]) ** 2
            impedance[row] = size * curves.at(every.group[mode], every.column[mode], x[row])
        found = load(impedance, frequency)
        for each in _fillings(every, body.mode.tobytes(), skipped.tobytes()):
            each.fill(found)
        return found

    def _between(self, speed: Array) -> npt.NDArray[np.bool_]:
        """True for modes to interpolate, where there are many: slow ones between others, every other of an order, and
        most of odd orders."""
        if speed.size < _MANY:
            return np.zeros(speed.size, np.bool_)
        slow, (_, _, number, following, above, odd) = speed < _SLOW, self._families
        alternate = ~odd & (number >= _DENSE) & (number % 2 == _DENSE % 2)
        neighbours = np.where(odd, above, following)
        inside: npt.NDArray[np.bool_] = slow & (odd | alternate) & (neighbours >= 0) & slow[neighbours]
        return inside


class _Families(NamedTuple):
    """Modes by families (n,): orders and roots, the number of each in its order, from 0, the places of the next of its
    order and of that of the next order, -1 for none, and whether it is of an odd order of which most are skipped."""

    order: Array
    root: Array
    number: Indices
    following: Indices
    above: Indices
    odd: npt.NDArray[np.bool_]


@lru_cache(maxsize=16)  # 50 kB each at most
def _families(every: Every, modes: bytes) -> _Families:
    """Return some modes of all waves, whose numbers there are given as bytes."""
    mode = np.frombuffer(modes, np.intp)
    order, root = every.order[mode], every.root[mode]
    number = numbers(order, root)
    step = int(number.max(initial=0)) + 2
    keys = order.astype(np.intp) * step + number
    odd = (order > _ALL_ORDERS) & (order % 2 == 1)
    return _Families(order, root, number, _places(keys, keys + 1), _places(keys, keys + step), odd)


@lru_cache(maxsize=16)  # 80 kB each at most
def _fillings(every: Every, modes: bytes, skips: bytes) -> tuple[Filling, Filling]:
    """Return how the loads of modes that are skipped follow, one after the other; skips: a mask of these, as bytes."""
    order, root, number, _, _, odd = _families(every, modes)
    skipped = np.frombuffer(skips, np.bool_)
    slow, rest = Filling(order, root, ~skipped, skipped & ~odd), Filling(number, order, ~odd, skipped & odd)
    return slow, rest


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
