"""The objects that an engine plays, by name. A name may be another's later, so it is looked up for a time."""

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field

from ...dsp.bodies.modes import Modes
from ...dsp.engine.memory.commands import Handle
from ...dsp.macros import MACROS, MORPH, NEUTRAL
from ...dsp.runtime.engine import Engine
from ...presets import ObjectPreset
from ..osc.patterns import Selection, is_pattern
from ..osc.wire import Argument


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
    macros: dict[str, float] = field(default_factory=lambda: {**dict.fromkeys(MACROS, NEUTRAL), MORPH.name: 0.0})
    """Macros, and the share of the way to another object, at the time of the message that is carried out."""
    turns: list[tuple[float, str, float]] = field(default_factory=list)
    """Changes of these that were sent ahead: time (samples), name and value, the earliest first."""
    settled: dict[str, float] = field(default_factory=lambda: {**dict.fromkeys(MACROS, NEUTRAL), MORPH.name: 0.0})
    """The same now."""
    shaped: tuple[bool, str] = (False, "")
    """Whether its modes follow its material, and the preset that they may go to."""
    tables: dict[tuple[bool, str], int] = field(default_factory=dict)
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

    def recall(self, time: float, now: float) -> None:
        """Have `macros` be those at a time (samples); changes up to now are not kept apart."""
        while self.turns and self.turns[0][0] <= now:
            _, name, value = self.turns.pop(0)
            self.settled[name] = value
        self.macros = {**self.settled, **{name: value for at, name, value in self.turns if at <= time}}

    @property
    def last_macros(self) -> dict[str, float]:
        """The macros as they were last set."""
        return {**self.settled, **{name: value for _, name, value in list(self.turns)}}

    @property
    def mass(self) -> float:
        """kg."""
        return self.modes.mass * self.heavier


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
