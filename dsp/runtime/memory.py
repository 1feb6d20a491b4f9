"""Room for objects in the engine's memory: slots, modes in the bank, and values in the table of mode shapes."""

import math

import numpy as np

from ..bodies.modes import Modes
from ..engine.commands import Handle
from ..engine.state import MODES, MODES_PER_OBJECT, OBJECTS, SHAPE_VALUES
from ..resonator.simd import LANES
from .arena import Arena, EngineFull

_QUIETEST = 1e-9  # share of the loudest weight below which no weight at the left output goes: -180 dB
_LEAST_ROWS = 4  # of a shape table: mode shapes are interpolated by cubics


class Memory:
    """The places of objects in a record of STATE."""

    def __init__(self, record: np.void) -> None:
        self._bank, self._objects = record["bank"], record["objects"]
        self._modes = Arena("modes", MODES)
        self._shapes = Arena("values of mode shapes", SHAPE_VALUES)
        self._leaving: list[Handle] = []
        self._slots = list(range(OBJECTS - 1, -1, -1))
        self._serial = 0

    def lay_out(self, modes: Modes, level: float, top: float) -> tuple[Handle, dict[str, float]]:
        """Put an object's modes up to a frequency (Hz) into the bank, as `Engine.lay_out` says."""
        self._collect()
        order = np.argsort(modes.decay, kind="stable")  # the longest ringing first: the rest falls silent from the end
        order = order[modes.frequency[order] <= top]
        count = len(order)
        if count > MODES_PER_OBJECT:
            raise EngineFull(f"{count} modes: an object holds at most {MODES_PER_OBJECT}")
        if not self._slots:
            raise EngineFull(f"no room for another object: all {OBJECTS} are taken")
        size = max(LANES, math.ceil(count / LANES) * LANES)
        strike = modes.strike if len(modes.strike) >= _LEAST_ROWS else np.repeat(modes.strike[:1], _LEAST_ROWS, axis=0)
        rows = len(strike)
        first = self._modes.take(size)
        try:
            table = self._shapes.take(rows * size)
        except EngineFull:
            self._modes.give(first)
            raise
        record = self._bank
        for name in ("y1", "y2", "a1", "a2", "weight", "balance", "frequency", "sigma"):
            record[name][first : first + size] = 0.0
        record["frequency"][first : first + count] = modes.frequency[order]
        record["sigma"][first : first + count] = modes.decay[order]
        left, right = modes.pickup[:, order] * level
        least = max(_QUIETEST * max(np.abs(left).max(initial=0), np.abs(right).max(initial=0)), _QUIETEST**2)
        weight = np.where(np.abs(left) > least, left, least)  # the bank divides by it
        record["weight"][first : first + count] = weight
        record["balance"][first : first + count] = right / weight
        shape = record["shape"][table : table + rows * size].reshape(rows, size)
        shape[:] = 0.0
        shape[:, :count] = strike[:, order]
        self._serial += 1
        layout: dict[str, float] = {"first": first, "size": size, "table": table, "rows": rows}
        return Handle(self._slots.pop(), self._serial, first, table), layout

    def leave(self, handle: Handle) -> None:
        """Remember that an object was told to go; its place is used again once the engine has given it up."""
        self._leaving.append(handle)

    def stay(self, handle: Handle) -> None:
        """Take back `leave`, where the command did not reach the engine."""
        self._leaving.remove(handle)

    def release(self, handle: Handle) -> None:
        """Take back the place of an object that the engine doesn't have, or has no more."""
        self._slots.append(handle.slot)
        self._modes.give(handle.first)
        self._shapes.give(handle.table)

    def _collect(self) -> None:
        """Take back the places of objects that the engine has given up."""
        # An object can only be gone if it was told to go and the engine has seen it.
        slots = self._objects
        gone = [h for h in self._leaving if slots[h.slot]["serial"] == h.serial and not slots[h.slot]["used"]]
        for handle in gone:
            self._leaving.remove(handle)
            self.release(handle)
