"""Room for objects in the engine's memory: slots, modes in the bank, and values in the table of mode shapes."""

import math
import mmap

import numpy as np

from ..bodies.material import Array
from ..bodies.modes import Modes
from ..engine.commands import Handle
from ..engine.state import BANK, MODES, MODES_PER_OBJECT, OBJECTS, SHAPE_VALUES
from ..resonator.click import CLICK_MODES
from ..resonator.simd import LANES
from .arena import Arena, EngineFull
from .relief import relief
from .unheard import settled

_QUIETEST = 1e-9  # share of the loudest weight below which no weight at the left output goes: -180 dB
_FAINT = 1e-6  # weight at the left of what is heard at the right alone: -120 dB
_LEAST_ROWS = 4  # of a shape table: mode shapes are interpolated by cubics


class Memory:
    """The places of objects in a record of STATE."""

    def __init__(self, record: np.void) -> None:
        self._bank, self._objects = record["bank"], record["objects"]
        self._nyquist = 0.5 * float(record["rate"])
        self._has_sides = record["output"]["channels"] == 2
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
        sides = modes.pressure[:, order] * level
        if not self._has_sides:  # a mode is heard at one point, with the power of both sides
            sides = np.tile(np.copysign(np.sqrt(0.5 * (sides**2).sum(axis=0)), sides[0]), (2, 1))
        strike = modes.strike if len(modes.strike) >= _LEAST_ROWS else np.repeat(modes.strike[:1], _LEAST_ROWS, axis=0)
        still = relief(modes.frequency[order], modes.decay[order], sides, strike[:, order], top)
        unheard = settled(modes.unheard, self._nyquist)
        felt, bands = len(order), len(still.frequency)
        starts = _starts_of_clicks(felt + 2 * bands, len(modes.clicks))
        bent = starts[0] if starts else felt + 2 * bands
        heard = math.ceil((starts[-1] + CLICK_MODES if starts else bent) / LANES) * LANES
        count = heard + len(unheard.frequency)
        if count > MODES_PER_OBJECT:
            raise EngineFull(f"{count} modes: an object holds at most {MODES_PER_OBJECT}")
        size, rows = math.ceil(count / LANES) * LANES, len(strike)
        first, table = self._take(size, rows)
        shape = self._cleared(first, size, table, rows)
        self._fill(first, slice(0, felt), modes.frequency[order], modes.decay[order], *_weights(sides))
        shape[:, :felt] = strike[:, order]
        for side, weights in enumerate(((1.0, 0.0), (_FAINT, 1 / _FAINT))):
            span = slice(felt + side * bands, felt + (side + 1) * bands)
            self._fill(first, span, still.frequency, still.decay, *weights)
            shape[:, span] = still.shape[side]
        # Clicks are moved by any force, wherever that acts, and are heard alike on both sides.
        for start, click in zip(starts, modes.clicks, strict=True):
            span = slice(start, start + CLICK_MODES)
            self._fill(first, span, click.frequency, click.decay, level * click.strength, 1.0)
            shape[:, span] = 1.0
        self._fill(first, slice(heard, count), unheard.frequency, unheard.decay, _least(sides), 1.0)
        shape[:, heard:count] = unheard.strike
        self._serial += 1
        layout: dict[str, float] = {
            "first": first,
            "size": size,
            "table": table,
            "rows": rows,
            "felt": felt,
            "bent": bent,
            "unheard": heard,
            "level": level,
            "glide": modes.glide,
            "cone": modes.cone,
        }
        return Handle(self._slots.pop(), self._serial, first, table), layout

    def _take(self, size: int, rows: int) -> tuple[int, int]:
        """Take room for so many modes and rows of shapes: the first mode, and the first value of the table."""
        if not self._slots:
            raise EngineFull(f"no room for another object: all {OBJECTS} are taken")
        first = self._modes.take(size)
        try:
            return first, self._shapes.take(rows * size)
        except EngineFull:
            self._modes.give(first)
            raise

    def _cleared(self, first: int, size: int, table: int, rows: int) -> Array:
        """The table of shapes (rows, size) of an object, empty as its modes are."""
        for name in set(self._bank.dtype.names) - {"response", "shape"}:
            self._bank[name][first : first + size] = 0.0
        shape: Array = self._bank["shape"][table : table + rows * size].reshape(rows, size)
        shape[:] = 0.0
        return shape

    def _fill(self, first: int, span: slice, *values: Array | float) -> None:
        """Write frequency, sigma, weight and balance of an object's modes."""
        for name, value in zip(("frequency", "sigma", "weight", "balance"), values, strict=True):
            self._bank[name][first + span.start : first + span.stop] = value

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


def touch(record: np.void) -> None:
    """Have a record of STATE hold now the 25 MB that dense traffic makes it hold sooner or later; any thread may.

    Not what mode shapes and the records of contacts and sound can take: that may be far more than is ever needed.
    """
    parts = [record[name] for name in ("ring", "queue", "objects", "contacts", "rolls", "notes", "ends")]
    parts += [record["bank"][name] for name in BANK.names or () if name not in ("response", "shape")]
    for part in parts:
        np.frombuffer(part, np.uint8)[:: mmap.PAGESIZE].sum()  # a page that is read is held


def _starts_of_clicks(count: int, clicks: int) -> list[int]:
    """Where the modes of each click begin, after `count` others: in one group, as contacts act on whole groups."""
    starts = []
    for _ in range(clicks):
        count = count if count % LANES <= LANES - CLICK_MODES else math.ceil(count / LANES) * LANES
        starts.append(count)
        count += CLICK_MODES
    return starts


def _weights(sides: Array) -> tuple[Array, Array]:
    """Weights at the left output, by which the bank divides, and those at the right over them, of (2, n) weights."""
    left, right = sides
    least = _least(sides)
    weight = np.where(np.abs(left) > least, left, least)
    return weight, right / weight


def _least(sides: Array) -> float:
    """The weight of a mode that nobody hears, beside those with (2, n) weights."""
    return float(max(_QUIETEST * np.abs(sides).max(initial=0), _QUIETEST**2))
