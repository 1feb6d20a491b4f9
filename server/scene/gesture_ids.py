"""Gestures by their ids: who started them, which of them run, and how they ended.

An id stands for a number in the engine, which decides what it means when the time of a message has come. Several
gestures may share an id. The engine reports the end of each that was sent once.
"""

import math
from bisect import bisect_right, insort
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import islice
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

from ...dsp.engine.memory.commands import Command
from ...dsp.engine.memory.state import End
from ...dsp.runtime.engine import Engine
from ..osc.patterns import Selection, is_pattern

if TYPE_CHECKING:
    from .makeup import Played
    from .objects import PlayedObject

_REMEMBERED = 4_096  # ids: one that is given again soon has the number that it had
_MOST_ENDS = 65_536  # that wait to be sent
_begin_of = itemgetter(0)
_time_of = attrgetter("time")
_LONGEST_STEM = 40  # characters of an object's name in an id for a gesture that was given none


class Begun(NamedTuple):
    """What macros change of a gesture: its kind, its object, and values as they are in the middle of all macros."""

    kind: str
    obj: "PlayedObject"
    values: dict[str, float]


@dataclass(eq=False, slots=True)
class Begin:
    """A gesture that begins with an id at a time (samples): what macros change of it, and, if it lasts, its make-up."""

    time: float
    begun: Begun
    lasts: bool
    played: "Played | None"
    order: int
    """Number of the command that came next as it was sent."""


@dataclass(eq=False, slots=True)
class GestureId:
    """A name of gestures and its number in the engine."""

    name: str
    number: int
    uses: int = 0
    """Number of gestures that were sent with it."""
    running: list[tuple[str, Any]] = field(default_factory=list)
    """Address and source of the message for each gesture that was sent and whose end is not known, the oldest first."""
    under: str = ""
    """Name of the object under its last rest; "" if that lies on a support, or there is none."""
    most_load: float = math.inf
    """N: up to which the load of its last rest may be steered."""
    begins: list[Begin] = field(default_factory=list)
    """Its gestures, the earliest first."""
    ahead: list[tuple[float, list[Command]]] = field(default_factory=list)
    """Times (samples) of changes that were sent ahead, the earliest first, and their commands but for a level."""

    def played_at(self, time: float) -> "Played | None":
        """Return the make-up of the lasting gesture that began last at a time (samples)."""
        return next((each.played for each in self._before(time) if each.lasts), None)

    def begun_at(self, time: float, order: float) -> Begun | None:
        """Return the gesture that began last at a time (samples), of those for that time if it was sent before a
        command of a number."""
        return next((each.begun for each in self._before(time, order)), None)

    def _before(self, time: float, order: float = math.inf) -> Iterator[Begin]:
        """Yield its gestures that have begun by a time (samples), on objects that were there then, the last first."""
        for each in reversed(self.begins):
            if (each.time, each.order) < (time, order) and each.time < each.begun.obj.freed:
                yield each

    def levels_of(self, time: float, commands: list[Command]) -> list[Command]:
        """Return the commands by which a level follows those of a change at a time (samples)."""
        played = self.played_at(time)
        return played.levels_of(commands) if played else []


class Ended(NamedTuple):
    """A gesture that is over: its id, the address that started it, who sent that, and how it ended."""

    id: str
    address: str
    source: Any
    end: End


class _Table:
    """Ids by name, the one that was used last at the end: a pattern is matched with these."""

    def __init__(self) -> None:
        self.names: dict[str, GestureId] = {}
        self.version = 0

    def put(self, id: GestureId) -> None:
        """Add an id, or put it at the end."""
        self.version += self.names.pop(id.name, None) is None
        self.names[id.name] = id

    def remove(self, name: str) -> None:
        """Remove an id, if it is there."""
        self.version += self.names.pop(name, None) is not None


class GestureIds:
    """The gestures of an engine, by id."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._known = _Table()
        self._numbers: dict[int, GestureId] = {}
        self._running = _Table()
        self._ends: deque[Ended] = deque(maxlen=_MOST_ENDS)
        self._made = 0
        self._last = 0

    def start(self, name: str, address: str, source: Any) -> GestureId:
        """Return the id of a gesture about to be sent; `take_back` it if it is not."""
        id = self._known.names.get(name)
        if id is None:
            self._last += 1
            id = GestureId(name, self._last)
            self._numbers[id.number] = id
        self._known.put(id)
        id.uses += 1
        id.running.append((address, source))
        self._running.put(id)
        return id

    def nameless(self) -> int:
        """Return a number for a gesture without an id: nobody is notified of its end."""
        self._last += 1
        return self._last

    def lay_on(self, name: str, under: str, most_load: float) -> None:
        """Remember what is under the rest that an id names, "" if that is a support, and its greatest load (N)."""
        self._known.names[name].under, self._known.names[name].most_load = under, most_load

    def begin(self, number: int, begin: Begin) -> Callable[[], object]:
        """Remember a gesture that begins with the id of a number; return how to undo that. What is over is
        forgotten."""
        known, now = self._numbers[number].begins, float(self._engine.position)
        past = known[: bisect_right(known, now, key=_time_of)]
        last = next((each for each in reversed(past) if each.lasts), None)
        known[: len(past)] = [each for each in past if each is last or each is past[-1]]
        insort(known, begin, key=_time_of)
        return lambda: known.remove(begin)

    def id_of(self, number: int) -> GestureId | None:
        """Return the id of the gestures that have a number; None where there is none, or none is remembered."""
        return self._numbers.get(number)

    def send_ahead(self, id: GestureId, time: float, commands: list[Command]) -> Callable[[], object]:
        """Remember a change of a gesture if it is sent ahead of its time (samples); return how to undo that. What is
        over is forgotten."""
        known, now = id.ahead, float(self._engine.position)
        del known[: bisect_right(known, now, key=_begin_of)]
        if time <= now:
            return lambda: None
        entry = time, commands
        insort(known, entry, key=_begin_of)
        return lambda: known.remove(entry)

    def take_back(self, id: GestureId) -> None:
        """Undo `start`."""
        id.running.pop()
        self._look_at(id)
        id.uses -= 1
        if id.uses == 0:
            self._forget(id)

    def made_for(self, object_name: str) -> str:
        """Return a new id for a gesture on an object that was given none."""
        self._made += 1
        return f"{object_name[:_LONGEST_STEM]}-{self._made}"

    def is_running(self, name: str, address: str) -> bool:
        """True if a gesture of an id that an address started runs, or was sent to begin later."""
        return name in self._known.names and any(started == address for started, _ in self._known.names[name].running)

    def number_of(self, name: str) -> int:
        """Return the number of a gesture's id; 0 if there is none."""
        return self._known.names[name].number if name in self._known.names else 0

    def name_of(self, number: int) -> str:
        """Return the id of the gestures that have a number; "" where there is none, or none is remembered."""
        return self._numbers[number].name if number in self._numbers else ""

    def running(self) -> list[GestureId]:
        """Return the ids of gestures that run, or were sent to begin later; any thread may ask."""
        return list(self._running.names.values())

    def newest_running(self) -> Iterator[str]:
        """Yield their names, the one that was used last first."""
        return reversed(self._running.names)

    def selected(self, pattern: str, selection: Selection) -> list[GestureId]:
        """Return those of them whose id is, or matches, a pattern; raise TooMuch as `Selection.names` does."""
        if is_pattern(pattern):
            return [self._running.names[name] for name in selection.names(pattern, self._running)]
        return [self._known.names[pattern]] if pattern in self._running.names else []

    def have_ended(self, pattern: str, selection: Selection) -> bool:
        """True if an id matches a pattern whose gestures have all ended, not long ago; raise TooMuch as
        `Selection.names` does."""
        if not is_pattern(pattern):
            return pattern in self._known.names and pattern not in self._running.names
        return any(name not in self._running.names for name in selection.names(pattern, self._known))

    def end_at_once(self, name: str, address: str, source: Any) -> None:
        """Report the end of a gesture that did not move; `take_back_end` if it was not to be."""
        self._ends.append(Ended(name, address, source, End.RESTED))

    def take_back_end(self) -> None:
        """Undo `end_at_once`."""
        self._ends.pop()

    def collect(self) -> None:
        """Learn from the engine which gestures have ended, and forget ids of long ago."""
        for number, end in self._engine.ended():
            id = self._numbers.get(number)
            if id and id.running:
                # A roll that was steered is still the one that began it.
                address, source = id.running.pop() if end is End.JOINED else id.running.pop(0)
                self._look_at(id)
                if end is not End.JOINED:
                    self._ends.append(Ended(id.name, address, source, end))
        if len(self._known.names) > _REMEMBERED:
            ended = (id for id in self._known.names.values() if not id.running)
            for id in tuple(islice(ended, len(self._known.names) - _REMEMBERED)):
                self._forget(id)

    def take_ends(self) -> Iterator[Ended]:
        """Yield the gestures that have ended and were not taken before, one by one."""
        self.collect()
        while self._ends:
            yield self._ends.popleft()

    def _look_at(self, id: GestureId) -> None:
        """Stop counting an id of which nothing runs any more as one that runs."""
        if not id.running:
            self._running.remove(id.name)

    def _forget(self, id: GestureId) -> None:
        self._known.remove(id.name)
        del self._numbers[id.number]
