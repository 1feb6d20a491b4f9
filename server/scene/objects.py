"""The objects that an engine plays, by name. A name may be another's later, so it is looked up for a time."""

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

from ...dsp.bodies.modes import Modes
from ...dsp.engine.memory.commands import Handle
from ...dsp.macros import MACROS, MORPH, NEUTRAL, SHAPING
from ...dsp.runtime.engine import Engine
from ...dsp.schema import SETTINGS
from ...presets import ObjectPreset
from ..osc.arguments import Point
from ..osc.patterns import Selection, is_pattern
from ..osc.wire import Argument

Shaped: TypeAlias = tuple[bool, str]

RETUNED = ("tune", "decay", "damp")
"""Settings that change the modes of an object."""
_USUAL = {
    **dict.fromkeys(MACROS, NEUTRAL), MORPH.name: 0.0, **{name: SETTINGS[name].default or 0.0 for name in RETUNED}
}  # fmt: skip
_SHAPING = {each.name for each in SHAPING}


class Turn(NamedTuple):
    """A change of a macro, of the share of the way to another object, or of a setting that changes modes."""

    time: float
    """Samples."""
    name: str
    value: float
    points: tuple[Point, ...] = ()
    """Values that it goes to, one after the other."""
    preset: str = ""
    """The object that a morph goes to."""
    order: int = 0
    """Number of the command that comes next as it is sent: of what is for the same time, what was sent first counts."""


@dataclass(eq=False)
class PlayedObject:
    """An object in the engine: the preset that it was made from, its modes and its time (samples)."""

    handle: Handle
    preset: ObjectPreset
    modes: Modes
    born: float
    """Nothing happens to it before."""
    freed: float = math.inf
    """Time from which its name is free."""
    made: tuple[Argument, ...] = ()
    """The arguments of its /object/new."""
    settings: dict[str, float] = field(default_factory=dict)
    """Settings as they were last set, in the units of messages."""
    macros: dict[str, float] = field(default_factory=lambda: {**_USUAL})
    """Macros, the share of the way to another object, and the settings that change modes, at the time of the message
    that is carried out."""
    turns: list[Turn] = field(default_factory=list)
    """Changes of these that were sent ahead, the earliest first."""
    settled: dict[str, float] = field(default_factory=lambda: {**_USUAL})
    """The same now."""
    shaped: Shaped | None = None
    """Whether its modes follow its material, and the preset that they may go to, at that time; None: they change by no
    macro."""
    settled_shape: Shaped | None = None
    """The same now."""
    reshaped: list[tuple[float, int, Shaped]] = field(default_factory=list)
    """Times (samples) from which it will be shaped otherwise, the numbers of the commands that do it, and how."""
    ahead: list[Any] = field(default_factory=list)
    """Gestures that were sent ahead of their time, as ahead.py makes them, the earliest first: those on it, and those
    of which it is the other object."""
    tables: dict[Shaped, int] = field(default_factory=dict)
    """Tables of its macros in the engine, by that."""
    heard: dict[tuple[object, ...], Modes] = field(default_factory=dict)
    """Its modes as its macros have them, for make-up."""
    thrown: list[dict[str, float]] = field(default_factory=list)
    """Macros before each throw of the dice."""
    heavier: float = 1.0
    """Factor of its mass by its macros."""
    copies: dict[str, "PlayedObject"] = field(default_factory=dict)
    """Copies on which its notes are played, by name; a name may be another's by now."""
    stands: int = 0
    """Number of the gesture by which it rests where it stands by itself; 0: it hangs freely."""
    warned_of_stand_in: bool = False
    """True if its maker was warned which material stands in for the one that it lacks."""

    def recall(self, time: float, now: float, order: float = math.inf) -> None:
        """Have `macros` be those at a time (samples), for what was sent before a command of that number; changes up to
        now are not kept apart."""
        while self.turns and self.turns[0].time <= now:
            turn = self.turns.pop(0)
            self.settled[turn.name] = turn.value
            self.settled_shape = _shaped_by(turn, self.settled_shape)
        past = [turn for turn in self.turns if turn.time < time or (turn.time == time and turn.order < order)]
        self.macros = {**self.settled, **{turn.name: turn.value for turn in past}}
        self.shaped = self.settled_shape
        for turn in past:
            self.shaped = _shaped_by(turn, self.shaped)

    @property
    def last_macros(self) -> dict[str, float]:
        """The macros as they were last set."""
        return {**self.settled, **{turn.name: turn.value for turn in list(self.turns)}}

    def shapes(self) -> Iterator[tuple[float, Shaped]]:
        """Yield the times (samples) of changes that were sent ahead from which it is shaped otherwise, and how."""
        before = self.settled_shape
        for turn in self.turns:
            shaped = _shaped_by(turn, before)
            if shaped is not None and shaped != before:
                yield turn.time, shaped
            before = shaped

    @property
    def mass(self) -> float:
        """kg."""
        return self.modes.mass * self.heavier


def _shaped_by(turn: Turn, before: Shaped | None) -> Shaped | None:
    """Return how an object is shaped after a change."""
    if turn.name not in _SHAPING:
        return before
    of_material, other = before or (False, "")
    return of_material or turn.name == "material", turn.preset or other


class ObjectTable(Mapping[str, PlayedObject]):
    """Objects by name: for each name the one that has it, or is the next to have it."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._newest: dict[str, PlayedObject] = {}
        self.version = 0
        """Counts the changes of `names`."""
        self.replaced: list[tuple[str, PlayedObject]] = []
        """Objects that are still there, with a name that was given to a newer one."""
        self.slots: dict[int, str] = {}
        """Name of the object that was there last, by place in the engine."""

    def __getitem__(self, name: str) -> PlayedObject:
        return self._newest[name]

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._newest))  # another thread may ask: OSCQuery's

    def __len__(self) -> int:
        return len(self._newest)

    @property
    def names(self) -> Collection[str]:
        """All names that are given, also to objects that have a namesake by now."""
        return {**{name: None for name, _ in self.replaced}, **self._newest}.keys()

    def at(self, pattern: str, time: float, selection: Selection | None = None) -> dict[str, PlayedObject]:
        """Return the objects whose names match a pattern and that are there, or the next to be, at a time (samples).

        TooMuch as `Selection.names`.
        """
        now = max(time, float(self._engine.position))
        if is_pattern(pattern):
            names = dict.fromkeys((selection or Selection()).names(pattern, self))
            named = [(name, obj) for name, obj in self.replaced if name in names]
            named += [(name, self._newest[name]) for name in names if name in self._newest]
        else:  # most are not patterns, and to look through all objects for one takes long
            named = [(name, obj) for name, obj in self.replaced if name == pattern]
            named += [(pattern, self._newest[pattern])] if pattern in self._newest else []
        found: dict[str, PlayedObject] = {}
        for name, obj in named:
            if obj.freed > now:
                found.setdefault(name, obj)
        return found

    def there(self, time: float) -> Iterator[str]:
        """Return the names of the objects that are there, or the next to be, at a time (samples)."""
        now = max(time, float(self._engine.position))
        return (name for name, obj in self._newest.items() if obj.freed > now)

    def start_of(self, obj: PlayedObject, time: float) -> float:
        """Return the time (samples) of a command to an object: one for now waits for an object that is yet to be."""
        return max(time, obj.born) if obj.born > self._engine.position else time

    def add(self, name: str, obj: PlayedObject) -> Callable[[], None]:
        """Give a name to a new object; return how to undo it."""
        self.slots[obj.handle.slot] = name
        before = self._newest.get(name)
        self._newest[name] = obj
        self.version += 1
        if before is None:
            return lambda: self._forget(name)
        entry = name, before
        self.replaced.append(entry)

        def undo() -> None:
            self._newest[name] = before
            self.replaced.remove(entry)
            self.version += 1

        return undo

    def forget_ahead(self, time: float) -> Callable[[], None]:
        """Forget what was sent ahead and comes after a time (samples), as a panic does; return how to undo it."""
        now = max(time, float(self._engine.position))
        there = [*self._newest.values(), *(obj for _, obj in self.replaced)]
        before = [(obj, list(obj.turns), list(obj.ahead)) for obj in there if obj.turns or obj.ahead]
        for obj, turns, ahead in before:
            obj.turns = [each for each in turns if each.time <= now]
            obj.ahead = [each for each in ahead if each.time <= now]
            obj.recall(now, float(self._engine.position))

        def undo() -> None:
            for obj, turns, ahead in before:
                obj.turns, obj.ahead = turns, ahead

        return undo

    def forget_gone(self) -> None:
        """Forget the objects whose time is over."""
        gone = self._engine.position
        if self.replaced:
            self.replaced = [(name, obj) for name, obj in self.replaced if obj.freed > gone]
            self.version += 1
        for name in [name for name, obj in self._newest.items() if obj.freed <= gone]:
            self._forget(name)

    def _forget(self, name: str) -> None:
        del self._newest[name]
        self.version += 1
