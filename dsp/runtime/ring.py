"""The ring of commands, as Python writes it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..engine.memory.commands import Command, write
from ..engine.memory.state import EVENTS, RING
from ..native.addresses import as_bytes
from ..native.atomics import observe, publish
from .arena import EngineFull

NOW = -1.0
"""A time that is always past: a command for as soon as possible."""

KEPT_FOR_NOW = 2_048
"""Places among the EVENTS that wait that are kept from what is further ahead than half a second."""

SOON = 0.5
"""s: what is no further ahead has these places, too."""


class Ring:
    """Commands on their way into an engine, whose record this takes."""

    def __init__(self, record: Any) -> None:
        self._record = record
        ring = record["ring"]
        self._written, self._read = ring["written"], ring["read"]
        self.entries: NDArray[np.void] = ring["entries"]
        """The commands, by their numbers modulo RING. Whoever writes them has requested room, sets their numbers, and
        publishes."""
        self.bytes = as_bytes(self.entries)

    @property
    def sent(self) -> int:
        """Commands sent so far: the number of the next."""
        return int(self._written[0])

    def room(self) -> int:
        """Return how many commands can be sent now."""
        return RING - self.sent + observe(self._read)

    def send(self, commands: Sequence[Command]) -> None:
        """Send commands all at once, or EngineFull and none of them."""
        self.require_room(len(commands), max((command.time for command in commands), default=NOW))
        written = self.sent
        for number, command in enumerate(commands, written):
            write(self.entries[number % RING], number, command)
        publish(self._written, written + len(commands))

    def publish(self, number: int) -> None:
        """Publish to the engine what was written into `entries` before a number."""
        publish(self._written, number)

    def require_room(self, count: int, latest: float) -> None:
        """Raise EngineFull unless there is room for so many commands, the last for a time (samples)."""
        room = self.room()
        if count > room:
            raise EngineFull(f"no capacity for {count} events: {room} of {RING} can be queued now")
        # An event for now must find room in the queue, however many wait there for later.
        record = self._record
        waiting, most = int(record["queue"]["size"]) + RING - room, EVENTS - KEPT_FOR_NOW
        if waiting + count > most and latest > int(record["position"]) + SOON * float(record["rate"]):
            raise EngineFull(f"no capacity for {count} events ahead of their time: {waiting} of {most} wait")
