"""A transaction: the commands of messages that belong together. The engine gets all of them, or none."""

import math
from collections.abc import Callable, Collection, Hashable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeVar, cast

from ...dsp.engine.memory.commands import Command
from ...dsp.runtime.engine import Engine
from ...dsp.schema import BY_DIRECTION, DIRECTION
from ...dsp.wording import suggestion
from ...presets import NoPreset, Presets
from ..new_object import NewObject
from ..osc.addresses import Call
from ..osc.patterns import Selection
from ..osc.wire import Message
from .gesture_ids import GestureIds
from .limits import ContactLaws
from .makeup import MakeUp, Measure, Pair
from .objects import ObjectTable, PlayedObject
from .scale import Scale

if TYPE_CHECKING:
    from ...presets.reshaping import Axes, Wanted
    from ..bridge.bodies import Body
    from ..bridge.wire import TellsWorld
    from .sensors import SensorTable
    from .space_table import SpaceTable

    Made: TypeAlias = NewObject | Body | Exception

MadeOf = TypeVar("MadeOf", "NewObject", "Body")
"""An object, or a body of a simulation."""

_MOST_SUGGESTIONS = 8


class NotMade(Exception):
    """A table of pulses, or the measurement of a pair, has to be made before a message can be carried out."""

    def __init__(self, key: Hashable, make: Callable[[], object]) -> None:
        """Report what is missing, by its key, and of what makes it."""
        super().__init__(key)
        self.key, self.make = key, make


class Sent(NamedTuple):
    """The origin of a command: the canonical message, which leaves no choice open; the serials of its object and of
    the one that strikes it (0: none); the mass (kg) that strikes; and whether it does so off the strike path."""

    message: Message
    serial: int
    by: int
    mass: float
    off_path: bool = False


_OFF_PATH = ("on_surface", "by_on_surface", *(each.name for each in (*DIRECTION, *BY_DIRECTION)))


def is_off_path(command: Command) -> bool:
    """True if a command acts at a point of a surface or in a direction of its own."""
    return any(command.values.get(name) for name in _OFF_PATH)


def _make_table(exponent: float) -> None:
    from ...dsp.swarm.tables import pulse_table  # slow to load

    pulse_table(exponent)


@dataclass
class Transaction:
    """Messages of one source that are carried out at one time (samples), and all that they act on."""

    engine: Engine
    presets: Presets
    laws: ContactLaws
    objects: ObjectTable
    gestures: GestureIds
    scale: Scale
    time: float
    source: Any
    world_of: "Callable[[], TellsWorld]"
    """Returns the simulation that messages report."""
    sensors: "SensorTable"
    space: "SpaceTable"
    made: "Mapping[int, Made]" = field(default_factory=dict)
    """Objects and bodies that were made before, or the errors they met, by the identity of their calls."""
    commands: list[Command] = field(default_factory=list)
    sent: list[Sent] = field(default_factory=list)
    """The origin of each command."""
    replies: list[Message] = field(default_factory=list)
    selection: Selection = field(default_factory=Selection)
    """The matches of its messages' patterns."""
    pause: Callable[[], object] = lambda: None
    """Called before each message, and before each object of a message that reaches several."""
    beside: Collection[Hashable] | None = None
    """Keys of the tables of pulses and measurements that were made beside; None where each is made when it is asked
    for."""
    makeup: MakeUp = field(default_factory=MakeUp)
    turned: "dict[PlayedObject, float]" = field(default_factory=dict)
    """Objects that macros change, and from when on (samples)."""
    order: float = math.inf
    """Number of the command before which counts what is for the same time; of what is carried out anew."""
    ahead: list[Any] = field(default_factory=list)
    """Gestures that it sends ahead of their time, as ahead.py makes them."""
    _compared: int = 0
    _exponents: set[float] = field(default_factory=set)
    """Exponents of which its commands take the tables of pulses."""
    _undo: list[Callable[[], object]] = field(default_factory=list)

    @property
    def world(self) -> "TellsWorld":
        """The simulation that messages report."""
        return self.world_of()

    def add(self, command: Command, sent: Sent) -> None:
        """Add a command."""
        self.commands.append(command)
        self.sent.append(sent)

    def made_of(self, call: Call, make: Callable[[Call, Presets, float], MadeOf]) -> MadeOf:
        """Return the object or the body that a call asks for. Refused or PresetError say why there is none."""
        made = self.made.get(id(call))
        if isinstance(made, Exception):
            raise made
        return cast(MadeOf, made) if made else make(call, self.presets, self.engine.top_frequency)

    def pulses(self, exponent: float) -> dict[str, float]:
        """Return the value `pulses` that the commands of swarms take, as Engine.lay_out_pulses does. NotMade: its table
        is to be made beside."""
        if self.beside is not None and exponent not in self.beside and self.engine.lacks_pulses(exponent):
            raise NotMade(exponent, partial(_make_table, exponent))
        self._exponents.add(exponent)
        return self.engine.lay_out_pulses(exponent, self._exponents)

    def measured(self, pair: Pair) -> Measure:
        """Return how loud a pair of a gesture and an object is. NotMade: it is to be measured beside."""
        digest = self.makeup.digest(pair)
        measure = self.makeup.known(digest)
        if measure is None and self.beside is not None and digest not in self.beside:
            raise NotMade(digest, partial(self.makeup.measure, digest, pair))
        return measure or self.makeup.measure(digest, pair)

    def axes(self, wanted: "Wanted") -> "Axes":
        """Return how the macros of an object change its modes. NotMade: that is to be made beside."""
        from ...presets.reshaping import axes_of, known_axes

        known = known_axes(wanted)
        if known is None and self.beside is not None and wanted.key not in self.beside:
            raise NotMade(wanted.key, partial(axes_of, wanted))
        return known or axes_of(wanted)

    @contextmanager
    def has_made(self, call: Call, made: "Made") -> Iterator[None]:
        """Use, for a while, what is made already for a call."""
        before, self.made = self.made, {id(call): made}
        try:
            yield
        finally:
            self.made = before  # before another call has this one's identity

    def suggestion(self, word: str, known: Collection[str]) -> str:
        """Return names near a word; none for the later ones of many refusals, as to find them takes 1 ms."""
        return suggestion(word, known) if self.explains() else ""

    def explains(self) -> bool:
        """True if there is time to say more of another refusal than that it is one."""
        self._compared += 1
        return self._compared <= _MOST_SUGGESTIONS

    def reason(self, error: Exception) -> str:
        """Return the reason for a refusal; of later ones without the names that there are, as to look for them takes
        long."""
        return str(error) if not isinstance(error, NoPreset) or self.explains() else error.text

    def on_undo(self, action: Callable[[], object]) -> None:
        """Do an action if what was requested so far is not carried out; the latest comes first."""
        self._undo.append(action)

    def keep(self) -> None:
        """Keep for good what was done. The steps that would undo it hold the transaction in a circle: with them, all
        its messages would stay in memory until the next search for garbage."""
        self._undo.clear()

    def savepoint(self) -> tuple[int, int, int]:
        """Return the state of the transaction, for `undo_to`."""
        return len(self.commands), len(self.replies), len(self._undo)

    def undo_to(self, savepoint: tuple[int, int, int] = (0, 0, 0)) -> None:
        """Take back all that was done since a savepoint, or since the beginning."""
        commands, replies, undo = savepoint
        del self.commands[commands:], self.sent[commands:], self.replies[replies:]
        while len(self._undo) > undo:
            self._undo.pop()()
