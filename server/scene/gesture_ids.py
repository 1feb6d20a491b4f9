"""Gestures by their ids: who started them, and how they ended.

An id stands for a number in the engine, which decides what it means when the time of a message has come. Several
gestures may share an id. Of each that was sent the engine tells once what became of it.
"""

from collections import deque
from dataclasses import dataclass, field
from typing import Any

from ...dsp.engine.state import End
from ...dsp.runtime.engine import Engine

_REMEMBERED = 4_096  # ids: to steer what has ended is no mistake
_MOST_ENDS = 65_536  # that wait to be told
_LONGEST_STEM = 40  # characters of an object's name in an id for a gesture that was given none


@dataclass(eq=False)
class Id:
    """A name of gestures: its number in the engine, and for each that hasn't ended the address that started it and who
    sent that, the oldest first."""

    name: str
    number: int
    times: int = 0  # that it was given
    started: deque[tuple[str, Any]] = field(default_factory=deque)


@dataclass(frozen=True)
class Ended:
    """A gesture that is over: its id, the address that started it, who sent that, and how it ended."""

    id: str
    address: str
    source: Any
    end: End


class Gestures:
    """The gestures of an engine, by id."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._ids: dict[str, Id] = {}  # the most recently started last
        self._numbers: dict[int, Id] = {}
        self._ends: deque[Ended] = deque(maxlen=_MOST_ENDS)
        self._named = 0
        self._last = 0

    def new(self, name: str, address: str, source: Any) -> Id:
        """The id of a gesture about to be sent; `forget` it if it is not."""
        id = self._ids.pop(name, None)
        if id is None:
            self._last += 1
            id = Id(name, self._last)
            self._numbers[id.number] = id
        self._ids[name] = id
        id.times += 1
        id.started.append((address, source))
        return id

    def forget(self, id: Id) -> None:
        """Take back `new`."""
        id.started.pop()
        id.times -= 1
        if id.times == 0:
            del self._ids[id.name], self._numbers[id.number]

    def numbered(self, name: str) -> str:
        """An id for a gesture that was given none."""
        self._named += 1
        return f"{name[:_LONGEST_STEM]}-{self._named}"

    def goes_on(self, name: str, address: str) -> bool:
        """Was something of that id sent to start at an address that hasn't ended yet?"""
        return name in self._ids and any(started == address for started, _ in self._ids[name].started)

    def known(self) -> list[Id]:
        """The ids of what runs or was started not long ago."""
        return list(self._ids.values())

    def end_at_once(self, name: str, address: str, source: Any) -> None:
        """Tell of the end of a gesture that did not move."""
        self._ends.append(Ended(name, address, source, End.RESTED))

    def collect(self) -> None:
        """Learn from the engine what has ended, and forget ids of long ago."""
        for number, end in self._engine.ended():
            id = self._numbers.get(number)
            if id and id.started:
                # A roll that was steered is still the one that began it.
                address, source = id.started.pop() if end is End.JOINED else id.started.popleft()
                if end is not End.JOINED:
                    self._ends.append(Ended(id.name, address, source, end))
        if len(self._ids) > _REMEMBERED:
            over = [id for id in self._ids.values() if not id.started]
            for id in over[: len(self._ids) - _REMEMBERED]:
                del self._ids[id.name], self._numbers[id.number]

    def take_ends(self) -> list[Ended]:
        """What has ended since the last call."""
        self.collect()
        ends = list(self._ends)
        self._ends.clear()
        return ends
