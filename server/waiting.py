"""Packets that wait for objects, bodies or tables to be made, while others are carried out.

The packets of a client are carried out in their order: later ones wait, in the network's queues, behind one that makes
an object. So do packets of others that name such an object, or report the simulation of which a body is made: each
message of a shell script comes from a client of its own.
"""

import time
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

from ..dsp.schema import GESTURES
from .making import NAMED, Maker, Making, makes
from .net.network import Network, Source, host_of
from .net.rotation import Rotation
from .osc.addresses import Call
from .osc.patterns import is_pattern, match, work
from .packets import Packet
from .scene.transaction import NotMade
from .turns import TURN

_ALONG = frozenset(name for name, gesture in GESTURES.items() if gesture.along)
_MOST_LINES = 256  # addresses whose datagrams wait for something to be made; a host may have as many as are left
_MOST_CALLS = 16_384  # that wait of a host, some 12 MB, before another long packet of it is read
_MOST_WORK = 50_000  # of matching a packet's patterns: some 5 ms
_WORLD = "/world/"


@dataclass(eq=False)
class _Line:
    """A client's packet that waits; None while it is carried out."""

    first: Packet | None = None
    names: frozenset[str] = frozenset()
    """Names of the objects and gestures that the packet makes, or if it makes none, that it names."""


class Waiting:
    """The packets that wait, in the order in which their clients began to."""

    def __init__(self, network: Network, maker: Maker) -> None:
        self._network, self._maker = network, maker
        self._lines: dict[Source, _Line] = {}
        self._moved = False  # whether a packet may have become ready since the last look
        self._looking: Iterator[Packet | None] | None = None
        self._begun: Rotation[_Line] = Rotation()
        self._begun_next = False
        self._calls: dict[Source, int] = {}  # of the packets that wait, or are carried out in part
        self._calls_of: Counter[str] = Counter()  # the same by host

    def __len__(self) -> int:
        return len(self._lines)

    def look(self) -> None:
        """Look at what was made; any thread may ask for it."""
        self._moved = True
        self._network.wake()

    def hold(self, packet: Packet) -> bool:
        """Hold a packet back if it makes objects, or names one that is in the making; return False if it need not
        wait."""
        new = [call for call in packet.calls if makes(call)]
        if not new and not (self._lines and self._is_about(packet.calls, self._names())):
            return False
        datagram = isinstance(packet.source, tuple)
        if datagram and packet.source not in self._lines and not self._has_room(packet.source):
            self._network.drop(packet.source)
            return True
        # It is the last now of those that were read.
        line = self._lines.pop(packet.source) if packet.source in self._lines else _Line()
        self._lines[packet.source] = line
        line.first, line.names = packet, _made_names(packet.calls) if new else _given_names(packet.calls)
        self._network.pause(packet.source)
        self._count(packet.source, len(packet.kept))
        if new:
            packet.making = Making(new)
            self._maker.make(packet.making)
        return True

    def _has_room(self, source: Source) -> bool:
        """True if another address of a host may wait."""
        own = sum(isinstance(each, tuple) and each[0] == host_of(source) for each in self._lines)
        return own < _MOST_LINES - len(self._lines)

    def make_beside(self, packet: Packet, missing: NotMade) -> None:
        """Put a packet off until what is missing is made for it."""
        line = self._lines.setdefault(packet.source, _Line())
        line.first, line.names, packet.begun = packet, _made_names(packet.calls), False
        packet.beside.add(missing.key)
        packet.making = Making([], missing.make)
        self._network.pause(packet.source)
        self._count(packet.source, len(packet.kept))
        self._maker.make(packet.making)

    def put_off(self, packet: Packet) -> None:
        """Put a packet that is carried out in part off until others had their turns."""
        line = self._lines.setdefault(packet.source, _Line())
        line.first, line.names = packet, frozenset()
        packet.begun = True
        self._begun.add(host_of(packet.source), line)
        self._count(packet.source, len(packet.kept))
        self._network.pause(packet.source)

    def next(self) -> Packet | None:
        """Return a packet whose time has come, if there is one: carry it out, and call `end`.

        Those that were begun and those that were not take turns.
        """
        self._begun_next = not self._begun_next
        packet = None if self._begun_next and self._begun else self._next_ready()
        if packet is None and (line := self._begun.take()):
            packet, line.first = line.first, None
        return packet

    def end(self, source: Source) -> None:
        """Let a client go on whose packet is carried out, unless that was put off, or waits for a table."""
        if source in self._lines and self._lines[source].first is None:
            del self._lines[source]
            self._network.resume(source)
            self._count(source, 0)

    def _count(self, source: Source, calls: int) -> None:
        """Note how many calls of a client wait; a host of which too many do is read no long packet."""
        host = host_of(source)
        self._calls_of[host] += calls - self._calls.pop(source, 0)
        if calls:
            self._calls[source] = calls
        if self._calls_of[host] >= _MOST_CALLS:
            self._network.hold(host)
            return
        self._network.release(host)
        if not self._calls_of[host]:
            del self._calls_of[host]

    def _next_ready(self) -> Packet | None:
        if self._looking is None:
            if not self._moved:
                return None
            self._moved, self._looking = False, self._ready()
        try:
            return next(self._looking)
        except StopIteration:
            self._looking = None
            return None

    def _ready(self) -> Iterator[Packet | None]:
        """Yield packets that were not begun and whose time has come; None where a look takes long."""
        before: set[str] = set()
        end = time.monotonic() + TURN
        for source, line in tuple(self._lines.items()):
            first = line.first
            if self._lines.get(source) is not line or first is None or first.begun:
                continue
            if self._is_ready(first, before):
                line.first, self._moved = None, True
                yield first
            if line.first:
                before |= line.names
            if time.monotonic() > end:
                yield None
                end = time.monotonic() + TURN

    def _is_ready(self, packet: Packet, before: set[str]) -> bool:
        """True if a packet's objects are made, and those of packets before it that it names."""
        return (packet.making is None or packet.making.done) and not self._is_about(packet.calls, before)

    @property
    def in_a_hurry(self) -> bool:
        """True if packets may wait that can be carried out."""
        return self._moved or self._looking is not None or bool(self._begun)

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
    """Return the name of the simulation, if a call is about it: no object's name begins so."""
    return (_WORLD,) if call.message.address.startswith(_WORLD) else ()


def _values(call: Call, keys: tuple[str, ...]) -> Iterator[object]:
    """Return the values of some keys."""
    return (value for key, value in pairwise(call.message.args) if key in keys)
