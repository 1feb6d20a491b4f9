"""Packets as they are carried out: read once, in turns of a few ms, with a bound on what their patterns may cost."""

from collections import deque
from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from .making import Making
from .net.network import Source
from .osc.addresses import Call, calls
from .osc.patterns import Selection, is_pattern
from .osc.wire import Bundle, Message, parse

if TYPE_CHECKING:
    from .scene.transaction import Made

_MOST_CALLS = 2_048
"""Most calls that the patterns of a packet may make, beyond one each."""


@dataclass(eq=False)
class Packet:
    """A packet that was read, and how far it was carried out."""

    source: Source
    bundles: deque[tuple[Bundle, list[Call]]] = field(default_factory=deque)
    """Bundles that are left, with the calls that each makes."""
    rest: deque[Callable[[], object]] = field(default_factory=deque)
    """Remaining work of a bundle that was carried out: replies, and messages about the server."""
    overfull: list[Message] = field(default_factory=list)
    """Messages whose patterns match too many addresses."""
    selection: Selection = field(default_factory=Selection)
    """The matches of its patterns."""
    making: Making | None = None
    """The objects and bodies that it asks for."""
    made: "Mapping[int, Made]" = field(default_factory=dict)
    """Objects and bodies that are made, by the identity of their calls."""
    kept: list[Call] = field(default_factory=list)
    """All its calls: `made` goes by their identities, which no others may take while it is carried out."""
    beside: set[Hashable] = field(default_factory=set)
    """Keys of the tables of pulses and measurements that were made for it."""
    begun: bool = False
    """True if a part of it was carried out."""

    @property
    def calls(self) -> Iterator[Call]:
        """All calls of the bundles that are left."""
        return (call for _, asked in self.bundles for call in asked)

    @property
    def done(self) -> bool:
        """True if nothing is left to be done."""
        return not (self.bundles or self.rest)


def read(data: bytes, source: Source) -> Packet:
    """Read a packet from its bytes. BadPacket says what is wrong with them."""
    packet = Packet(source)
    left = _MOST_CALLS
    for bundle in parse(data):
        asked: list[Call] = []
        for message in bundle.messages:
            if message.address == "/fail":  # two servers that answer each other's /fail would never end
                continue
            if left < 0 and is_pattern(message.address):
                packet.overfull.append(message)
                continue
            found = calls(message)
            left -= len(found) - 1
            asked += found
        packet.bundles.append((bundle, asked))
        packet.kept += asked
    return packet
