"""The air's load on discs and membranes."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..air import Complex, Load, endless_plate, load, wavenumber
from ..material import Array
from ..modes import Indices
from .disc import Waves, baffled_disc, free_disc
from .sampling import fill

_FAST = 1.5  # times the speed of sound: faster waves radiate from both sides of a disc as if it stood in a wall
_CLOSED, _WAVES = 1.08, 3.0  # the same, and by how many wavenumbers: faster ones radiate as on an endless plate
_SLOW = 0.35  # the same: of slower ones not all need be solved, from some orders and numbers on
_ALL_ORDERS, _DENSE, _MANY = 12, 6, 600
_WORTH = 6  # modes of an order that are solved in two parts
_SETTLED = 1e-3  # of a frequency: a solution for one as near as this serves


class Round(NamedTuple):
    """A round surface: its radius (m), its mass per area (kg/m^2), and how it is baffled, a word of `heard.BAFFLES`.

    Its modes' angular orders, and their radial waves as in `disc.Waves`, mass-normalised, (k,).
    """

    radius: float
    areal: float
    baffle: str
    order: Array
    root: Array
    growing: Array
    scale: Array

    def only(self, modes: Indices) -> "Round":
        """Return the surface with some of its modes."""
        return Round(*self[:3], *(each[modes] for each in self[3:]))


class Loads:
    """The load as a function of the modes' frequencies in air."""

    def __init__(self, body: Round) -> None:
        self._body = body
        self._solved_at = np.zeros(body.order.size)
        self._impedance: Complex = np.zeros(body.order.size, np.complex128)
        self._number = np.zeros(body.order.size, np.intp)  # of its order's modes, from 0
        for row in _families(body.order, np.ones(body.order.size, np.bool_)):
            self._number[row[np.argsort(body.root[row])]] = np.arange(row.size)
        place = {key: i for i, key in enumerate(zip(body.order, self._number, strict=True))}
        self._next = np.array([place.get((m, n + 1), -1) for m, n in place])
        self._above = np.array([place.get((m + 1, n), -1) for m, n in place])
        self._odd = (body.order > _ALL_ORDERS) & (body.order % 2 == 1)

    def __call__(self, frequency: Array) -> Load:
        body = self._body
        x = wavenumber(frequency) * body.radius
        speed = x / body.root
        sides = 1.0 if body.baffle == "closed" else 2.0
        closed = (speed > _CLOSED) & (x - body.root > _WAVES)
        self._impedance[closed] = sides / 2 * endless_plate(body.areal, speed[closed] ** 2)
        skipped = self._between(speed)
        stale = ~closed & ~skipped & (np.abs(self._solved_at / frequency - 1) > _SETTLED)
        walled = (speed > _FAST) | (body.baffle != "free")
        rows = [part for row in _families(body.order, stale & ~walled) for part in self._parts(row)]
        for row, impedance in zip(rows, free_disc([self._waves(row, x) for row in rows], body.radius), strict=True):
            self._impedance[row] = impedance
        for row in _families(body.order, stale & walled):
            self._impedance[row] = sides * baffled_disc(self._waves(row, x), body.radius)
        self._solved_at[stale] = frequency[stale]
        found = load(self._impedance, frequency)
        inside = skipped & ~self._odd
        for row in _families(body.order, inside):
            fill(found, body.root, np.flatnonzero((body.order == body.order[row[0]]) & ~skipped), row)
        for row in _families(self._number, skipped & self._odd):
            fill(found, body.order, np.flatnonzero((self._number == self._number[row[0]]) & ~self._odd), row)
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

    def _parts(self, row: Indices) -> list[Indices]:
        """Return the slow modes of an order and the fast ones, if there are many: slow ones need fewer terms and
        points."""
        row = row[np.argsort(self._body.root[row])]
        return [row] if row.size < _WORTH else np.array_split(row, 2)

    def _waves(self, row: Indices, x: Array) -> Waves:
        body = self._body
        return Waves(int(body.order[row[0]]), body.root[row], body.growing[row], body.scale[row], x[row])


def _families(number: npt.NDArray[Any], which: npt.NDArray[np.bool_]) -> list[Indices]:
    """Group those modes into families of the same number."""
    return [np.flatnonzero(which & (number == each)) for each in np.unique(number[which])]
