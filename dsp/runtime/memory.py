"""Room for objects in the engine's memory: slots, modes in the bank, and values in the table of mode shapes."""

import mmap
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bodies.macros import Change
from ..bodies.modes import Modes
from ..engine.memory.commands import Handle
from ..engine.memory.state import BANK
from ..native.atomics import hold_page, observe
from ..native.pages import map_of
from ..resonator.simd import LANES
from .arena import Arena, EngineFull
from .plan import COLUMNS, Plan, planned
from .sheets import Sheets


class Memory:
    """The places of objects in a record of STATE: at most so many modes and objects, and mode shapes in an arena."""

    def __init__(self, record: np.void, modes: int, objects: int, shapes: Arena) -> None:
        self._bank, self._objects = record["bank"], record["objects"]
        self._nyquist = 0.5 * float(record["rate"])
        self._has_sides = record["output"]["channels"] == 2
        self._modes = Arena("modes", modes)
        self._shapes = shapes
        self._sheets = Sheets(record)
        self._leaving: list[Handle] = []
        self._most = objects
        self._slots: list[int] = []  # that were used and are free again
        self._serial = 0
        self._plans: dict[tuple[int, float], tuple[Plan, int]] = {}  # with its table, while an object has it
        self._tables: dict[int, tuple[tuple[int, float], int]] = {}  # by table: whose, and how many objects'
        self._reshaped: dict[int, list[int]] = {}  # first values of the tables of macros, by an object's first mode
        self.reached = 0
        """Slots that have ever been used: the first so many."""

    @property
    def free(self) -> int:
        """Number of objects for which there is a place."""
        return self._most - self.reached + len(self._slots)

    @property
    def had_plates(self) -> bool:
        """True if it ever had a plate whose modes can be coupled."""
        return self._sheets.used

    def lay_out(self, modes: Modes, level: float, top: float) -> tuple[Handle, dict[str, float]]:
        """Put an object's modes up to a frequency (Hz) into the bank, as `Engine.lay_out` says."""
        self._collect()
        key = id(modes), top
        plan, table = self._plans.get(key, (None, -1))
        plan = plan or self.plan(modes, top)
        size = plan.shape.shape[1]
        if not self.free:
            raise EngineFull(f"no capacity for another object: all {self._most} are taken")
        sheet = -1 if plan.laid is None else self._sheets.lay_out(plan.laid)
        try:
            first = self._modes.take(size)
        except EngineFull:
            self._give_sheet(sheet)
            raise
        if table < 0:
            table = self._take_table(key, plan, first, sheet)
        self._tables[table] = key, self._tables[table][1] + 1
        for name, values in zip(COLUMNS, plan.columns, strict=True):
            self._bank[name][first : first + size] = values * level if name == "weight" else values
        self._serial += 1
        layout: dict[str, float] = {
            "first": first,
            "size": size,
            "table": table,
            "rows": plan.rows,
            "faces": len(plan.faces),
            "surface": table + plan.shape.size,
            "block": plan.block,
            "felt": plan.felt,
            "bent": plan.bent,
            "unheard": plan.heard,
            "level": level,
            "glide": modes.glide,
            "cone": modes.cone,
            "sheet": sheet,
            "lighter": 0.0,
        }
        slot = self._slots.pop() if self._slots else self.reached
        self.reached = max(self.reached, slot + 1)
        return Handle(slot, self._serial, first, table, sheet), layout

    def plan(self, modes: Modes, top: float) -> Plan:
        """Return the plan of an object's modes up to a frequency (Hz), as `planned` does."""
        return planned(modes, top, self._nyquist, self._has_sides)

    def _give_sheet(self, sheet: int) -> None:
        """Take back the place of a plate, if there is one."""
        if sheet >= 0:
            self._sheets.release(sheet)

    def _take_table(self, key: tuple[int, float], plan: Plan, first: int, sheet: int) -> int:
        """Lay out the shapes of a plan, for modes that have been taken: the first value of the table."""
        try:
            table = self._shapes.take(plan.shape.size + plan.faces.size)
        except EngineFull:
            self._modes.give(first)
            self._give_sheet(sheet)
            raise
        shapes, own = self._bank["shape"], plan.shape.size
        shapes[table : table + own] = plan.shape.ravel()
        shapes[table + own : table + own + plan.faces.size] = plan.faces.ravel()
        self._plans[key], self._tables[table] = (plan, table), (key, 0)
        return table

    def lay_out_macros(
        self, handle: Handle, modes: Modes, level: float, top: float, axes: Sequence[Sequence[Change]]
    ) -> int:
        """Put the table of an object's macros among the mode shapes; return its first value. EngineFull: no room."""
        from .reshaping import table_of  # with what it is for

        table = table_of(self.plan(modes, top), level, axes)
        first = self._shapes.take(-(-table.size // LANES) * LANES)  # what follows lies at whole lanes
        self._bank["shape"][first : first + table.size] = table
        self._reshaped.setdefault(handle.first, []).append(first)
        return first

    def leave(self, handle: Handle) -> None:
        """Remember that an object is being removed; its place is used again once the engine has given it up."""
        self._leaving.append(handle)

    def stay(self, handle: Handle) -> None:
        """Take back `leave`, where the command did not reach the engine."""
        self._leaving.remove(handle)

    def release(self, handle: Handle) -> None:
        """Take back the place of an object that the engine doesn't have, or has no more."""
        self._slots.append(handle.slot)
        self._modes.give(handle.first)
        for first in self._reshaped.pop(handle.first, []):
            self._shapes.give(first)
        self._give_sheet(handle.sheet)
        key, users = self._tables[handle.table]
        if users > 1:
            self._tables[handle.table] = key, users - 1
            return
        size = self._shapes.give(handle.table)
        _give_back(self._bank["shape"][handle.table : handle.table + size])
        del self._plans[key], self._tables[handle.table]

    def _collect(self) -> None:
        """Take back the places of objects that the engine has given up."""
        # An object can only be gone if it was freed and the engine has seen it.
        serials, used = self._objects["serial"], self._objects["used"]
        gone = [h for h in self._leaving if serials[h.slot] == h.serial and not observe(used[h.slot : h.slot + 1])]
        for handle in gone:
            self._leaving.remove(handle)
            self.release(handle)


def touch(record: np.void, modes: int, objects: int) -> None:
    """Touch the memory of a record of STATE that dense traffic would touch sooner or later, so that it is held now; any
    thread may.

    That is 25 MB for as many modes and objects as are usual. Not what mode shapes, the spectral bank and the records of
    contacts and sound can take: that may be far more than is ever needed.
    """
    parts = [record[name] for name in ("ring", "queue", "contacts", "rolls", "notes", "ends")]
    parts += [record["objects"][:objects]]
    parts += [record["bank"][name][:modes] for name in BANK.names or () if name not in ("response", "shape")]
    for part in parts:
        begin = np.frombuffer(part, np.uint8).ctypes.data
        for address in range(begin - begin % 8, begin + part.nbytes, mmap.PAGESIZE):
            hold_page(address)


def _give_back(part: NDArray[Any]) -> None:
    """Give the whole pages of a contiguous part of a state back to the system until they are written again.

    Their contents are lost. Nothing happens where the system cannot do it.
    """
    memory = map_of(part)
    if memory is None or not hasattr(mmap, "MADV_DONTNEED"):
        return
    begin = part.ctypes.data - np.frombuffer(memory, np.uint8).ctypes.data
    first, end = -(-begin // mmap.PAGESIZE) * mmap.PAGESIZE, (begin + part.nbytes) // mmap.PAGESIZE * mmap.PAGESIZE
    if first < end:
        memory.madvise(mmap.MADV_DONTNEED, first, end - first)
