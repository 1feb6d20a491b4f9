"""Bytes of a MIDI cable: running status, system exclusive that is cut short, and bytes at random."""

import random
from collections.abc import Iterator

from carom.dsp.runtime.engine import Engine
from carom.presets import Presets
from carom.server.midi.midi import Midi
from carom.server.net.remote import Remote
from carom.server.osc.addresses import VERBS
from carom.server.osc.arguments import Refused
from carom.server.osc.wire import Message, encode, parse
from carom.server.scene.session import Session
from tests.attack import Tried, kind
from tests.attack.arguments import message
from tests.attack.children import Child, Died
from tests.attack.playing import tried

_MADE = (Message("/object/new", ("a", "wood-block")), Message("/object/new", ("b", "marimba-bar")))
_SECONDS = 0.05
_FACE = "/midi/"
_PRESETS = Presets()


class _Cable:
    """A session that MIDI plays as bytes come."""

    def __init__(self) -> None:
        self._session = Session(Engine(48_000, 2, 65_536, 64), _PRESETS)
        self._session.perform(list(_MADE), 0.0)
        self.became: list[Message] = []
        self.midi = Midi(self, self._session, lambda text: None)  # type: ignore[arg-type]

    def hand_in(self, client: Remote, packet: bytes) -> None:
        """Carry out what a packet says, and answer."""
        for bundle in parse(packet):
            self.became += bundle.messages
            for reply in self._session.perform(bundle.messages, -1.0):
                client.send(encode(reply.address, *reply.args))


@kind("midi", 20)
def midi(chance: random.Random) -> Iterator[Tried]:
    """Messages to MIDI's own addresses, then bytes; and what they become is played."""
    with Child() as child:
        while True:
            said = [each for each in (message(chance) for _ in range(60)) if each.address.startswith(_FACE)]
            data = stream(chance)
            try:
                refused, became = child.run(heard, said, data)
            except Died as died:
                yield Tried(faults=(f"{died}: {said} {data.hex()}",))
                continue
            yield Tried(refused, len(said) - refused)
            yield tried(child, [*_MADE, *became], _SECONDS)


def heard(said: list[Message], data: bytes) -> tuple[int, list[Message]]:
    """Return how many messages about MIDI were refused, and what bytes become after them."""
    from mido import Parser

    cable, parser, refused = _Cable(), Parser(), 0
    for each in said:
        verb = VERBS[each.address]
        try:
            list(cable.midi.handlers[each.address](verb.parse(each.args), ("127.0.0.1", 9)) or ())
        except Refused:
            refused += 1
    for n in range(0, len(data), 64):
        parser.feed(data[n : n + 64])
        for one in parser:
            cable.midi.hear(one)
        cable.midi.look(lambda message, source: None)
    return refused, cable.became


def stream(chance: random.Random) -> bytes:
    """Return bytes as a cable may have them: messages whole and cut, and others."""
    parts = []
    for _ in range(chance.randrange(1, 40)):
        status = chance.choice((0x80, 0x90, 0x90, 0x90, 0xA0, 0xB0, 0xB0, 0xC0, 0xD0, 0xE0)) + chance.choice((0, 0, 15))
        two = [chance.choice((0, 1, 60, 64, 120, 123, 127)) for _ in range(2 * chance.choice((1, 1, 3)))]
        whole = bytes([status, *two])  # and more by its status, which is told once
        exclusive = b"\xf0" + bytes(chance.randrange(128) for _ in range(chance.choice((0, 3, 3_000))))
        parts.append(
            chance.choice(
                [whole, whole, whole[: chance.randrange(3)], exclusive, exclusive + b"\xf7", chance.randbytes(9)]
            )
        )
    return b"".join(parts)
