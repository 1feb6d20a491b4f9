"""A session: messages in, engine commands out, alike for a live server and a score."""

from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from ...dsp.engine.memory.commands import Command
from ...dsp.engine.memory.state import RING
from ...dsp.runtime.arena import EngineFull
from ...dsp.runtime.engine import NOW, Engine
from ...presets import PresetError, Presets
from ..osc.addresses import Call, calls
from ..osc.arguments import GestureEnded, Refused
from ..osc.patterns import Selection, TooMuch
from ..osc.wire import Message
from .ahead import remember, renew
from .gesture_ids import Ended, GestureIds
from .limits import ContactLaws, least_radius
from .makeup import MakeUp
from .objects import ObjectTable, PlayedObject
from .scale import USUAL_SCALE, Scale
from .sensors import SensorTable
from .space_table import SpaceTable
from .transaction import Sent, Transaction
from .translate import translate

if TYPE_CHECKING:
    from ..bridge.simulation import Simulation
    from ..bridge.wire import TellsWorld
    from .transaction import Made


class Session:
    """The objects and gestures of an engine, by name, and the messages that make and change them."""

    def __init__(
        self, engine: Engine, presets: Presets, steers_ended: bool = False, scale: Scale = USUAL_SCALE
    ) -> None:
        """Begin a session. steers_ended: answer the steering of a gesture that has ended by /warning, not /fail; a
        score can't know when friction ends a roll. scale: of the samples; a calibrated one goes with an engine that has
        no limiter."""
        self.engine = engine
        self.presets = presets
        self.objects = ObjectTable(engine)
        self.gestures = GestureIds(engine)
        self.sensors = SensorTable(engine)
        self.space = SpaceTable()
        self._laws = ContactLaws(presets)
        self.makeup = MakeUp()
        self._world: TellsWorld | None = None
        self._steers_ended = steers_ended
        self.scale = scale
        self.on_sent: Callable[[int, list[Sent]], object] = lambda first, sent: None
        """Called with all commands that are sent: the number of the first, and what each stands for."""

    def rewind(self) -> None:
        """Return to where its objects were just made, as its engine did. None of them rested then."""
        self.gestures = GestureIds(self.engine)
        self.makeup.on = False
        for name in self.objects:
            self.objects[name].warned_of_stand_in = False
            self.objects[name].ahead.clear()

    def _told_world(self) -> "TellsWorld":
        """Return the simulation that messages report, which few sessions have."""
        if self._world is None:
            from ..bridge.wire import TellsWorld  # slow to load

            self._world = TellsWorld(self.presets, self.engine.top_frequency, self.engine.channels)
        return self._world

    @property
    def simulation(self) -> "Simulation | None":
        """The simulation that was reported, if there is one."""
        return self._world.told if self._world else None

    def perform(self, messages: Iterable[Message], time: float, source: Any = None) -> list[Message]:
        """Carry out messages of a source together at a time (samples); return /done and /fail replies.

        A message that is refused leaves no trace and does not hold up the others. Either all their commands reach the
        engine or, where it has no room for them, none.
        """
        return self.perform_calls([call for message in messages for call in calls(message)], time, source)

    def perform_calls(
        self, calls: Sequence[Call], time: float, source: Any = None,
        made: "Mapping[int, Made]" = MappingProxyType({}), selection: Selection | None = None,
        pause: Callable[[], object] = lambda: None, beside: Collection[Hashable] | None = None,
    ) -> list[Message]:  # fmt: skip
        """Perform messages whose patterns are expanded, else as `perform`. made: objects, or the errors that they met,
        by the identity of the calls that ask for them; others are made here. selection: of the packet, if these are not
        all of its calls. pause, beside: as a transaction's;
        NotMade as a transaction raises it: nothing is carried out then."""
        self.gestures.collect()
        self.objects.forget_gone()
        transaction = Transaction(
            self.engine,
            self.presets,
            self._laws,
            self.objects,
            self.gestures,
            self.scale,
            time,
            source,
            self._told_world,
            self.sensors,
            self.space,
            made,
            selection=selection or Selection(),
            pause=pause,
            beside=beside,
            makeup=self.makeup,
        )
        accepted: list[str] = []
        try:
            accepted = self._translate(transaction, calls)
            renew(transaction)
            first = self.engine.sent
            self.engine.send(transaction.commands)
        except EngineFull as error:
            failed = [reply for reply in transaction.replies if reply.address == "/fail"]
            transaction.undo_to()
            return failed + [fail(address, str(error)) for address in accepted]
        except BaseException:
            transaction.undo_to()
            raise
        remember(transaction, first)
        transaction.keep()
        self.on_sent(first, transaction.sent)
        return transaction.replies

    def _translate(self, transaction: Transaction, calls: Sequence[Call]) -> list[str]:
        """Add what calls ask for to a transaction; return the addresses of those that are not refused."""
        accepted: list[str] = []
        for place, call in enumerate(calls):
            transaction.pause()
            savepoint = transaction.savepoint()
            try:
                translate(transaction, call)
            except (Refused, TooMuch, PresetError, EngineFull) as error:
                transaction.undo_to(savepoint)
                transaction.replies.append(self._refusal(call, transaction.reason(error), error))
            else:
                accepted.append(call.message.address)
            if len(transaction.commands) > RING:  # they will never be sent: spare the time to translate the rest
                accepted += [rest.message.address for rest in calls[place + 1 :]]
                break
        return accepted

    def command_of(self, message: Message) -> Command:
        """Return the one command that a message asks for, and is not sent. Refused or PresetError say why there is
        none."""
        (call,) = calls(message)
        transaction = Transaction(
            self.engine, self.presets, self._laws, self.objects, self.gestures, self.scale, NOW, None, self._told_world,
            self.sensors, self.space,
        )  # fmt: skip
        try:
            translate(transaction, call)
            (command,) = transaction.commands
        finally:
            transaction.undo_to()
        return command

    def least_radius(self, surface: str) -> float:
        """Return the least radius (m) of what rolls or slides on a surface. PresetError if there is none."""
        return least_radius(self._laws.surface(surface), 1.0)

    def _refusal(self, call: Call, reason: str, error: Exception) -> Message:
        """Return the reply to a message that met an error."""
        error.__traceback__ = None  # its frames hold the objects that were made, of which it may be one: a circle
        harmless = self._steers_ended and isinstance(error, GestureEnded)
        return (warning if harmless else fail)(call.message.address, reason)

    def objects_at(self, pattern: str) -> dict[str, PlayedObject]:
        """Return the objects that are there and whose names match a pattern; TooMuch as `Selection.names`."""
        return self.objects.at(pattern, NOW)

    def objects_there(self) -> dict[str, PlayedObject]:
        """Return the objects that are there."""
        return {name: self.objects[name] for name in self.objects.there(NOW)}

    def running(self) -> list[tuple[str, str]]:
        """Return the ids of gestures that run, with the addresses that began them."""
        return [(id.name, address) for id in self.gestures.running() for address, _ in tuple(id.running)]

    def take_ends(self) -> Iterator[Ended]:
        """Return the gestures that have ended and were not taken before, one by one."""
        return self.gestures.take_ends()


def warning(address: str, reason: str) -> Message:
    """Return the reply to a message that is carried out as far as there is anything to do."""
    return Message("/warning", (f"{address}: {reason}",))


def fail(address: str, reason: str) -> Message:
    """Return the reply to a message that is not carried out."""
    return Message("/fail", (address, reason))
