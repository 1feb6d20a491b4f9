"""The tables of swarms' pulses in the engine's memory: one for each exponent of a contact law, and one for drops."""

from collections import OrderedDict
from collections.abc import Collection, Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..engine.memory.commands import Command
from ..native.atomics import observe
from ..swarm.record import PULSES, TABLE
from .arena import Arena, EngineFull

if TYPE_CHECKING:
    from ..swarm.tables import Table

DROPS = 0.0
"""The place of drops among exponents, which are 1 at least."""


class _Place(NamedTuple):
    """The place of a table, and its first value."""

    number: int
    first: int


class PulseTables:
    """The tables in a record of STATE. Each is made when it is first requested, within a second.

    A table is needed by each command of a swarm from when it is sent until the engine says that the swarm has ended, or
    never begins. Where there is no room for another, those that none needs make room, those that were requested least
    recently first.
    """

    def __init__(self, record: np.void) -> None:
        self._record = record["pulses"]
        self._places: OrderedDict[float, _Place] = OrderedDict()
        self._free = list(range(PULSES))
        self._values = Arena("values of pulses", TABLE)
        self._sent = [0] * PULSES

    def lay_out(self, exponent: float, kept: Collection[float] = ()) -> dict[str, float]:
        """Return the value `pulses` for a contact law's exponent, or DROPS. EngineFull if there is no room, though the
        tables of all exponents but those in `kept` may go."""
        if exponent not in self._places:
            from ..swarm.tables import pulse_table  # slow to load

            if not self._has_room(kept):
                raise self._full(exponent)
            table = pulse_table(exponent)
            place = self._take(exponent, len(table.values), kept)
            self._write(place, table)
            self._places[exponent] = place
        self._places.move_to_end(exponent)
        return {"pulses": self._places[exponent].number + 1}

    @property
    def numbers(self) -> dict[float, int]:
        """The value `pulses` of each exponent that has a table."""
        return {exponent: place.number + 1 for exponent, place in self._places.items()}

    @property
    def reached(self) -> int:
        """Values up to which tables lie."""
        sizes = self._record["tables"]["size"]
        return max((place.first + int(sizes[place.number]) for place in self._places.values()), default=0)

    def lacks(self, exponent: float) -> bool:
        """True if there is room for the table of an exponent, which is not made."""
        from ..swarm.tables import is_made  # slow to load

        return exponent not in self._places and not is_made(exponent) and self._has_room(())

    def count(self, commands: Iterable[Command]) -> None:
        """Count the commands of swarms among those that were sent."""
        for command in commands:
            if number := int(command.values.get("pulses", 0)):
                self._sent[number - 1] += 1

    def _has_room(self, kept: Collection[float]) -> bool:
        return bool(self._free) or self._idle(kept) is not None

    def _idle(self, kept: Collection[float]) -> float | None:
        """Return the exponent whose table no swarm needs, that was requested least recently; None if there is none."""
        for exponent, place in self._places.items():
            left = observe(self._record["left"][place.number : place.number + 1])
            if exponent not in kept and left == self._sent[place.number]:
                return exponent
        return None

    def _take(self, exponent: float, size: int, kept: Collection[float]) -> _Place:
        """Take room for a table, from others if need be."""
        while True:
            if self._free:
                with suppress(EngineFull):
                    first = self._values.take(size)
                    return _Place(self._free.pop(0), first)
            idle = self._idle(kept)
            if idle is None:
                raise self._full(exponent)
            place = self._places.pop(idle)
            self._values.give(place.first)
            self._free.append(place.number)

    def _full(self, exponent: float) -> EngineFull:
        what = "drops" if exponent == DROPS else f"gestures of small blows with exponent {exponent:g}"
        others = ", ".join("of drops" if each == DROPS else f"of {each:g}" for each in sorted(self._places))
        if not others:
            return EngineFull(f"no capacity for {what}: an engine of {TABLE} values has none")
        return EngineFull(f"no capacity for {what}: others, {others}, go on or wait for their time")

    def _write(self, place: _Place, table: "Table") -> None:
        entry = self._record["tables"]
        entry[place.number : place.number + 1] = table.record
        entry[place.number]["first"] += place.first
        self._record["values"][place.first : place.first + len(table.values)] = table.values
