"""Packets that wait for objects, bodies or tables to be made, while others are carried out.

The packets of a client are carried out in their order: later ones wait behind one that makes an object. So do packets
of others that name such an object, or tell the simulation of which a body is made: each message of a shell script comes
from a client of its own.
"""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

from ..dsp.schema import GESTURES
from .making import NAMED, Maker, Making, makes
from .net.network import Network, Source
from .osc.addresses import Call
from .osc.patterns import is_pattern, match, work
from .packets import Packet

MOST_BYTES = 1 << 22
"""Most bytes of datagrams that wait; further ones are dropped. Streams pause instead, with a packet each."""

_ALONG = frozenset(name for name, gesture in GESTURES.items() if gesture.along)
_OVERHEAD = 64  # bytes that a packet takes besides its own
_MOST_LINES = 256  # clients whose packets wait
_MOST_WORK = 50_000  # of matching a packet's patterns: some 5 ms
_WORLD = "/world/"
_AT_ONCE = 16  # packets of a client that are carried out before others are heard


@dataclass(eq=False)
class _Line:
    """The packets of a client that wait: the first, and those behind it."""

    first: Packet | None = None
    names: frozenset[str] = frozenset()
    """Names of the objects and gestures that the first packet makes, or if it makes none, that it names."""
    behind: deque[bytes] = field(default_factory=deque)


class Waiting:
    """The packets that wait, in the order in which their clients began to."""

    def __init__(self, network: Network, maker: Maker) -> None:
        self._network, self._maker = network, maker
        self._lines: dict[Source, _Line] = {}
        self._bytes = 0
        self._moved = False  # whether a packet may have become ready since the last look

    def __len__(self) -> int:
        return len(self._lines)

    def look(self) -> None:
        """Look at what was made; any thread may ask for it."""
        self._moved = True
        self._network.wake()

    def queue(self, packet: bytes, source: Source) -> bool:
        """Queue a packet behind others of its client, if there are any; return False if there are none."""
        line = self._lines.get(source)
        if line is None:
            return False
        if isinstance(source, tuple):
            if self._bytes + len(packet) + _OVERHEAD > MOST_BYTES:
                self._network.drop(source)
                return True
            self._bytes += len(packet) + _OVERHEAD
        line.behind.append(packet)
        return True

    @property
    def is_full(self) -> bool:
        """True if the next datagram may find no room. A stream's client waits with one packet, and finds room."""
        return self._bytes > MOST_BYTES // 2 or len(self._lines) >= _MOST_LINES

    def put_last(self, packet: bytes, source: Source) -> None:
        """Queue a packet behind others of its client, to wait for its turn."""
        self._lines.setdefault(source, _Line())
        self._network.pause(source)
        self.queue(packet, source)

    def hold(self, packet: Packet) -> bool:
        """Hold a packet back if it makes objects, or names one that is in the making; return False if it need not
        wait."""
        new = [call for call in packet.calls if makes(call)]
        if not new and not (self._lines and self._is_about(packet.calls, self._names())):
            return False
        datagram = isinstance(packet.source, tuple)
        if datagram and packet.source not in self._lines and len(self._lines) >= _MOST_LINES:
            self._network.drop(packet.source)
            return True
        # It is the last now of those that were read.
        line = self._lines.pop(packet.source) if packet.source in self._lines else _Line()
        self._lines[packet.source] = line
        line.first, line.names = packet, _made_names(packet.calls) if new else _given_names(packet.calls)
        self._network.pause(packet.source)
        if new:
            packet.making = Making(new)
            self._maker.make(packet.making)
        return True

    def make_table(self, packet: Packet, exponent: float) -> None:
        """Put a packet off until the table of an exponent's pulses is made for it."""
        line = self._lines.setdefault(packet.source, _Line())
        line.first, line.names, packet.begun = packet, _made_names(packet.calls), False
        packet.tables.add(exponent)
        packet.making = Making([], [exponent])
        self._network.pause(packet.source)
        self._maker.make(packet.making)

    def put_off(self, packet: Packet) -> None:
        """Put a packet that is carried out in part off until others had their turns."""
        line = self._lines.setdefault(packet.source, _Line())
        line.first, line.names = packet, frozenset()
        packet.begun = self._moved = True
        self._network.pause(packet.source)

    def ready(self) -> Iterator[Packet | tuple[bytes, Source]]:
        """Yield packets whose time has come, those that were read and, some of each client, those that were not. Carry
        each out before the next is asked for."""
        if self._moved:
            self._moved = False
            before: set[str] = set()
            for source, line in tuple(self._lines.items()):
                first = line.first
                if first and (first.begun or self._is_ready(first, before)):
                    line.first, self._moved = None, True
                    yield first
                if line.first:
                    before |= line.names
                elif not line.behind:
                    self._leave(source)
        for source, line in tuple(self._lines.items()):
            for _ in range(_AT_ONCE):
                if line.first or not line.behind:
                    break
                packet = line.behind.popleft()
                if isinstance(source, tuple):
                    self._bytes -= len(packet) + _OVERHEAD
                yield packet, source
            if not (line.first or line.behind):
                self._leave(source)

    def _is_ready(self, packet: Packet, before: set[str]) -> bool:
        """True if a packet's objects are made, and those of packets before it that it names."""
        return (packet.making is None or packet.making.done) and not self._is_about(packet.calls, before)

    @property
    def in_a_hurry(self) -> bool:
        """True if packets wait that can be carried out."""
        return self._moved or any(line.first is None for line in self._lines.values())

    def _leave(self, source: Source) -> None:
        if self._lines.pop(source, None):
            self._network.resume(source)

    def _names(self) -> set[str]:
        return {name for line in self._lines.values() if line.first for name in line.names}

    @staticmethod
    def _is_about(calls: Iterable[Call], names: set[str]) -> bool:
        """True if one of some calls names, or may by a pattern, one of some objects and gestures."""
        left = _MOST_WORK
        for call in calls if names else ():
            given = (call.target, *call.message.args, *_world(call))
            if any(isinstance(name, str) and name in names for name in given):
                return True
            if is_pattern(call.target):
                left -= work(call.target) * len(names)
                if left < 0 or any(match(call.target, name) for name in names):
                    return True
        return False


def _made_names(calls: Iterable[Call]) -> frozenset[str]:
    """Return the names of objects that calls make, and the ids of their gestures."""
    names: set[object] = set()
    for call in calls:
        names.update(_world(call))
        if call.verb and call.verb.address in NAMED:
            names.update(call.message.args[:1])
        else:
            names.update(_values(call, ("id",)))
            if call.verb and call.verb.action in _ALONG:  # it has the object's name for an id
                names.add(call.target)
    return frozenset(name for name in names if isinstance(name, str) and name)


def _given_names(calls: Iterable[Call]) -> frozenset[str]:
    """Return the names of objects and gestures that stand in calls, but for patterns."""
    names = {name for call in calls for name in (call.target, *_values(call, ("id", "by")), *_world(call))}
    return frozenset(name for name in names if isinstance(name, str) and name and not is_pattern(name))


def _world(call: Call) -> tuple[str, ...]:
    """Return the name of the simulation, if a call tells of it: no object's name begins so."""
    return (_WORLD,) if call.message.address.startswith(_WORLD) else ()


def _values(call: Call, keys: tuple[str, ...]) -> Iterator[object]:
    """Return the values of some keys."""
    return (value for key, value in pairwise(call.message.args) if key in keys)
