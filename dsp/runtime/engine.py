"""The engine from Python: it checks, lays out memory and sends commands; the compiled callback does the rest."""

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bodies.modes import Modes
from ..engine.state import (
    ENDED,
    EVENTS,
    MODES,
    MODES_PER_OBJECT,
    NOTES,
    OBJECTS,
    RING,
    SHAPE_VALUES,
    TAP,
    Command,
    End,
    new_state,
)
from ..native.atomics import observe, publish
from ..native.system import clock_ns
from ..resonator.bank import LANES, NYQUIST_SHARE
from .arena import Arena, EngineFull
from .callback import compile_callback
from .code_cache import kept

NOW = -1.0
"""A time that is always past: a command for as soon as possible."""

KEPT_FOR_NOW = 2_048
"""Places among the EVENTS that wait that are kept from what is further ahead than half a second."""

_SOON = 0.5  # s
_STEADY = 1e-3  # s by which the clock may turn out to be wrong before what is said of it changes
_QUIETEST = 1e-9  # share of the loudest weight below which no weight at the left output goes: -180 dB

_NO_TIMES = np.zeros(3)

_LEAST_ROWS = 4  # of a shape table: mode shapes are interpolated by cubics


class Stamp(float):
    """A time of the clock, as the sample that it is likely to be; in the engine it is `clock`, CLOCK_MONOTONIC in ns,
    that decides."""

    clock: int

    def __new__(cls, sample: float, clock: int) -> "Stamp":
        self = super().__new__(cls, sample)
        self.clock = clock
        return self


@cache
def _callback() -> Any:
    return kept(compile_callback)


@dataclass(frozen=True)
class Handle:
    """An object in the engine; commands to one that is gone are ignored."""

    slot: int
    serial: int
    first: int
    table: int


class Engine:
    """A running engine at one sampling rate (Hz).

    `process` computes sound here and now; a sound card's thread may do the same through `address` and `pointer`, while
    one other thread at a time makes objects and sends commands.
    """

    def __init__(self, rate: float) -> None:
        self.state = new_state(rate)
        self._callback = _callback()
        self._record = self.state[0]
        self._pace: tuple[int, float, float] | None = None
        self._modes = Arena("modes", MODES)
        self._shapes = Arena("values of mode shapes", SHAPE_VALUES)
        self._leaving: list[Handle] = []
        self._slots = list(range(OBJECTS - 1, -1, -1))
        self._serial = 0
        self._ends_read = 0

    @property
    def rate(self) -> float:
        return float(self._record["rate"])

    @property
    def address(self) -> int:
        """Of the compiled callback, with PortAudio's signature."""
        return self._callback.address

    @property
    def pointer(self) -> int:
        """The callback's user data."""
        return self.state.ctypes.data

    @property
    def measured_rate(self) -> float:
        """Hz, by the clock, as the callbacks come."""
        period = float(self._record["clock"]["period"])
        return 1e9 / period if period else self.rate

    def set_latency(self, latency: float) -> None:
        """Say how long (s) after its callback a sound is heard: what has a time begins that much earlier."""
        self._record["clock"]["latency"] = latency * self.rate

    def forget_thread(self) -> None:
        """Let the next callback say in which thread it runs."""
        self._record["thread"] = 0

    @property
    def position(self) -> int:
        """Samples computed so far."""
        return int(self._record["position"])

    def stamp(self, time: int) -> Stamp:
        """A time of `clock_ns` for `send`. Two stamps compare as their times do, unless the clock is set meanwhile."""
        clock = self._record["clock"]
        turn = -1
        while turn % 2 or turn != observe(clock["turn"]):
            turn = observe(clock["turn"])
            origin = int(clock["origin"]) or clock_ns()  # before the first callback, that is now
            period = 1e9 / self.measured_rate
            begin = float(clock["sample"]) - float(clock["time"]) / period - float(clock["latency"])
        if self._pace is None or abs(_sample(time, *self._pace) - _sample(time, origin, begin, period)) > (
            _STEADY * self.rate
        ):
            self._pace = origin, begin, period
        return Stamp(_sample(time, *self._pace), time)

    @property
    def top_frequency(self) -> float:
        """Hz: modes above it are not made."""
        return NYQUIST_SHARE * 0.5 * self.rate

    def counter(self, name: str) -> Any:
        """A number of the state, such as `impacts` or `load`, by its name in STATE."""
        return self._record[name].item()

    def process(self, frames: int) -> NDArray[np.float32]:
        """The next `frames` frames, float32 (frames, 2)."""
        out = np.empty((frames, 2), np.float32)
        call = self._callback.ctypes
        times = _NO_TIMES.ctypes.data_as(call.argtypes[3])
        call(None, out.ctypes.data_as(call.argtypes[1]), frames, times, 0, self.pointer)
        return out

    def quiet(self) -> bool:
        """Does nothing sound, and is nothing waiting to?"""
        idle = self._record["queued"] == 0 and self._record["sounding"] == 0 and self._record["contacts_active"] == 0
        return bool(idle and self.room() == RING and self._record["position"] > 0)

    def room(self) -> int:
        """Commands that can be sent now."""
        return RING - int(self._record["written"][0]) + int(observe(self._record["read"]))

    def send(self, commands: list[tuple[float, Command, Handle | None, tuple[float, ...]]]) -> None:
        """Send (time in samples, command, object, values) all at once, or EngineFull and none of them."""
        if len(commands) > self.room():
            raise EngineFull(f"no room for {len(commands)} events: {self.room()} of {RING} can be queued now")
        # What is for now must find room in the queue, however much waits there for later.
        soon = self.position + _SOON * self.rate
        waiting = int(self._record["queued"]) + RING - self.room()
        if waiting + len(commands) > EVENTS - KEPT_FOR_NOW and any(command[0] > soon for command in commands):
            raise EngineFull(
                f"no room for {len(commands)} events ahead of their time: {waiting} of {EVENTS - KEPT_FOR_NOW} wait"
            )
        written = int(self._record["written"][0])
        ring = self._record["ring"]
        for n, (when, kind, handle, values) in enumerate(commands):
            entry = ring[(written + n) % RING]
            entry["time"] = when
            entry["clock"] = when.clock if isinstance(when, Stamp) else 0
            entry["number"] = written + n
            entry["kind"] = kind
            entry["slot"] = handle.slot if handle else 0
            entry["serial"] = handle.serial if handle else 0
            entry["values"][: len(values)] = values
            entry["values"][len(values) :] = 0.0
        publish(self._record["written"], written + len(commands))

    def ended(self) -> list[tuple[int, End]]:
        """Gestures (by number) that have ended since the last call, and how: one for each that was sent."""
        count = int(observe(self._record["ended_count"]))
        first = max(self._ends_read, count - ENDED)
        self._ends_read = count
        ended = self._record["ended"]
        ends = ended[np.arange(first, count) % ENDED].tolist()
        return [(serial, End(end)) for serial, end in ends]

    @property
    def sent(self) -> int:
        """Commands sent so far: the number of the next."""
        return int(self._record["written"][0])

    def note(self) -> None:
        """Keep what becomes of commands from here on for `noted`."""
        self._record["noting"] = 1

    def noted(self) -> list[tuple[int, float]]:
        """What became of commands since the last call, in the order it did: number, and the sample at which it was
        carried out, or less than 0 for what never is."""
        read = int(self._record["note_read"][0])
        noted = int(observe(self._record["noted"]))
        notes = self._record["notes"][np.arange(read, noted) % NOTES]
        publish(self._record["note_read"], noted)
        return list(zip(notes["number"].tolist(), notes["time"].tolist(), strict=True))

    def record(self) -> None:
        """Keep the sound from here on for `recorded`."""
        self._record["recording"] = 1

    def recorded(self) -> NDArray[np.float32]:
        """What has sounded since the last call, float32 (frames, 2)."""
        read = int(self._record["tap_read"][0])
        tapped = int(observe(self._record["tapped"]))
        frames = self._record["tap"][np.arange(read, tapped) % TAP]
        publish(self._record["tap_read"], tapped)
        return frames

    def lay_out(self, modes: Modes, level: float) -> tuple[Handle, int, int]:
        """Put an object's modes into the bank; returns its handle, padded number of modes and rows of shapes.

        `level` (amplitude) is full scale per m/s at the pickups. EngineFull if there is no room.
        """
        self._collect()
        order = np.argsort(modes.decay, kind="stable")  # the longest ringing first: the rest falls silent from the end
        order = order[modes.frequency[order] <= self.top_frequency]
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
        record = self._record
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
        return Handle(self._slots.pop(), self._serial, first, table), size, rows

    def leave(self, handle: Handle) -> None:
        """Remember that an object was told to go; its place is used again once the engine has let go of it."""
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
        """Take back the places of objects that the engine has let go of."""
        objects = self._record["objects"]
        # Only what was told to go and has been seen by the engine can be gone.
        gone = [h for h in self._leaving if objects[h.slot]["serial"] == h.serial and not objects[h.slot]["used"]]
        for handle in gone:
            self._leaving.remove(handle)
            self.release(handle)


def _sample(time: int, origin: int, begin: float, period: float) -> float:
    return begin + (time - origin) / period
