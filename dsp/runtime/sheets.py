"""Room for plates whose modes can be coupled: their records, and the tables of their grids."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..karman.layout import FAINT, LEVELS, MOST_ORDERS, SHEETS, SPACE, TABLE_VALUES
from ..native.records import LONGEST
from ..sizes import MOST_COUPLED
from .arena import Arena, EngineFull

if TYPE_CHECKING:
    from ..bodies.karman import Laid, Tables


class Sheets:
    """The places of plates in a record of STATE."""

    def __init__(self, record: np.void) -> None:
        self._sheets, self._values, self._rate = record["sheets"], record["curves"], float(record["rate"])
        self._places = Arena("plates whose modes are coupled", SHEETS)
        self._room = Arena("values of plates' grids", TABLE_VALUES)
        first = -self._values.ctypes.data % LINE // self._values.itemsize
        if first > 0:
            self._room.take(first)  # what it gives begins with a line of the cache
        self._tables: dict[int, tuple[int, int]] = {}  # by layout: first value, and how many plates have it
        self._users: dict[int, Laid] = {}  # by place
        self.used = False
        """True if a plate ever had a place."""

    def lay_out(self, laid: Laid) -> int:
        """Give a plate a place; EngineFull if there is none."""
        _check(laid)
        place = self._places.take(1)
        try:
            begin = self._take_tables(laid)
        except EngineFull:
            self._places.give(place)
            raise
        self._users[place], self.used = laid, True
        self._fill(self._sheets[place], laid, begin)
        return place

    def release(self, place: int) -> None:
        """Take back the place of a plate."""
        laid = self._users.pop(place)
        self._places.give(place)
        begin, users = self._tables[id(laid)]
        if users > 1:
            self._tables[id(laid)] = begin, users - 1
        else:
            self._room.give(begin)
            del self._tables[id(laid)]

    def _take_tables(self, laid: Laid) -> int:
        """Return the first value of a layout's tables, which are written if no plate has them."""
        begin, users = self._tables.get(id(laid), (-1, 0))
        if users == 0:
            values = np.concatenate([grid.values for grid in laid.grids])
            begin = self._room.take(values.size)
            self._values[begin : begin + values.size] = np.where(np.abs(values) < FAINT, 0.0, values)
        self._tables[id(laid)] = begin, users + 1
        return begin

    def _fill(self, sheet: np.void, laid: Laid, begin: int) -> None:
        """Write the record of a plate whose tables begin at a value; of what had its place it keeps no number."""
        for name in (each for each in sheet.dtype.names or () if sheet.dtype[each].itemsize <= LONGEST):
            sheet[name] = np.zeros((), sheet.dtype[name])
        sheet["functions"], sheet["plain"], sheet["every"] = laid.functions, laid.plain, 1
        sheet["highest"] = laid.highest
        sheet["growth"], sheet["least"] = laid.growth, laid.least
        sheet["scale"] = sheet["strained"] = sheet["tension"] = sheet["share"] = 1.0
        sheet["drained"][: laid.drained.size] = laid.drained
        sheet["follows"] = FOLLOWS
        self._fill_ladder(sheet, laid)
        for grid, tables in zip(sheet["grids"], laid.grids, strict=True):
            _fill_grid(grid, tables, begin)
            begin += tables.values.size

    def _fill_ladder(self, sheet: np.void, laid: Laid) -> None:
        """Write what modes exchange energy above those that are coupled."""
        ladder = laid.ladder
        sheet["modes"], sheet["rungs"], sheet["below"] = laid.mode.size, ladder.place.size, ladder.below
        sheet["span"] = ladder.span
        sheet["ladder"][: ladder.place.size] = ladder.place
        sheet["start"], sheet["free"], sheet["mixing"] = ladder.start, ladder.free, ladder.mixing
        sheet["mixes"], sheet["mixed"], sheet["drawn"] = max(round(self._rate / MIXES), 1), 0, 0


MIXES = 6_000.0
"""Exchanges of energy above the coupled modes, per second."""
FOLLOWS = 0.0001
"""s in which the auxiliary variable follows the grid's."""
LINE = 64
"""Bytes of a line of the cache."""


def _fill_grid(grid: np.void, tables: Tables, begin: int) -> None:
    """Write the record of a grid whose tables begin at a value."""
    grid["orders"] = tables.first.size
    grid["stresses"] = tables.stress.size - 1
    grid["points"], grid["angles"] = tables.points, tables.angles
    for name in ("first", "count", "row", "stress", "strain"):
        values = getattr(tables, name)
        grid[name][: values.size] = values
    for name, place in tables.places.items():
        grid[name] = np.add(begin, place)
    grid["domed"] = int(tables.strain[-1] > 0)


def _check(laid: Laid) -> None:
    """Raise EngineFull if a plate's grids are larger than there is room to compute with."""
    for tables in laid.grids:
        width, rows = 3 * tables.points, max(tables.first.size, tables.stress.size)
        largest = max(2 * tables.first.size * width, 4 * tables.angles * width)
        if rows > MOST_ORDERS or largest > SPACE or laid.functions > MOST_COUPLED or len(laid.grids) != LEVELS:
            raise EngineFull(f"{laid.mode.size} coupled modes: their grid of {largest} values exceeds {SPACE}")
