"""How urgent a packet is: questions yield to all else, and some can be answered amid another client's bundle."""

import re
from contextlib import suppress
from enum import IntFlag

from .wire import BadPacket, parse


class Urgency(IntFlag):
    """Properties of a packet, by which it gets its turn."""

    COMMAND = 0
    QUESTION = 1
    """It only asks: it yields, and it may be dropped once it has waited for long."""
    ASIDE = 2
    """It neither reads nor changes objects and gestures: no bundle needs to be done first."""


_KINDS = {
    **dict.fromkeys(("/sync", "/notify", "/dump"), Urgency.ASIDE),
    **dict.fromkeys(("/version", "/status", "/presets"), Urgency.QUESTION | Urgency.ASIDE),
    **dict.fromkeys(("/objects", "/gestures", "/midi/controls"), Urgency.QUESTION),
}
_OF_OBJECTS = re.compile(r"/object/[^/]+/get")
_BEGINNINGS = tuple(
    each.encode() for each in ("#bundle\0", *(f"/{first}" for first in ("object", *(key[1:] for key in _KINDS))))
)
_LONGEST = 512  # bytes of a packet that is read for this: a longer one asks for much at once


def urgency(packet: bytes) -> Urgency:
    """Return how urgent a packet is; one that is no OSC is a command, as it is refused at once."""
    if len(packet) > _LONGEST or not packet.startswith(_BEGINNINGS):
        return Urgency.COMMAND
    kind = Urgency.QUESTION | Urgency.ASIDE
    with suppress(BadPacket):
        for bundle in parse(packet):
            for message in bundle.messages:
                kind &= _kind(message.address)
        return kind
    return Urgency.COMMAND


def _kind(address: str) -> Urgency:
    if _OF_OBJECTS.fullmatch(address):
        return Urgency.QUESTION
    return _KINDS.get(address, Urgency.COMMAND)
