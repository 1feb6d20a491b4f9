"""MIDI as a client: what it plays becomes packets, which are carried out, and logged, as those of any other."""

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from ...dsp.macros import MACROS
from ..net.network import Source
from ..net.remote import Doorway, Remote
from ..osc.arguments import Refused, Values, require_name
from ..osc.midi_verbs import BEND, HIGHEST, LOWEST, PRESSURE
from ..osc.questions import in_parts
from ..osc.wire import IMMEDIATELY, Message, encode_bundle, parse
from ..scene.session import Session
from .controls import Control, Controls, control
from .keys import Keys
from .parts import MOST, Part, Parts

if TYPE_CHECKING:
    from .ports import Ports

_PEDAL, _SOUND_OFF, _NOTES_OFF, _MODES = 64, 120, 123, 120  # controllers; from _MODES on they are no controllers
_MOST = 2_048  # packets that wait
_QUIET = 10.0  # s in which the same warning comes once
_MOST_SAID = 64

_MIDDLE = 60  # the note by which an object is found for a controller
_MACROS = {str(macro.controller): name for name, macro in MACROS.items()}

Handler = Callable[[Values, Source], Iterator[Message] | None]


class Midi(Remote):
    """Plays a session as MIDI says. Ports call `hear`, each in its thread; all else happens in the server's."""

    def __init__(self, doorway: Doorway, session: Session, warn: Callable[[str], None]) -> None:
        super().__init__(self._answered)
        self.ports: Ports | None = None
        self._doorway, self._objects, self._warn = doorway, session.objects, warn
        self._lock = threading.Lock()
        self._keys, self._controls = Keys(), Controls()
        self._parts = Parts()
        self._learning: tuple[Values, Source] | None = None
        self._learnt: deque[tuple[Control, Source]] = deque()
        self._dropped = self._told = 0
        self._said: dict[str, float] = {}
        self.handlers: dict[str, Handler] = {
            "/midi/notes": self._notes,
            "/midi/learn": self._learn,
            "/midi/control": self._control,
            "/midi/forget": self._forget,
            "/midi/controls": self._listed,
        }
        """Handlers of the messages that say what MIDI does, by address."""

    @property
    def state(self) -> str:
        """The inputs that are open, or no."""
        return ", ".join(self.ports.names) if self.ports and self.ports.names else "no"

    def hear(self, message: Any) -> None:
        """Take in a message of mido's; any thread may."""
        with self._lock:
            messages = self._translated(message)
        if not messages:
            return
        if len(self.arrived) >= _MOST:
            self._dropped += 1
            return
        self._doorway.hand_in(self, encode_bundle(IMMEDIATELY, messages, real="d"))

    def look(self, reply: Callable[[Message, Source], object]) -> None:
        """Report what has happened since the last call."""
        while self._learnt:
            learnt, source = self._learnt.popleft()
            reply(Message("/midi/learnt", (learnt.address, learnt.controller, learnt.channel)), source)
        if self._dropped > self._told:
            self._warn(f"{self._dropped - self._told} MIDI messages dropped: they came too fast")
            self._told = self._dropped
        for text in self.ports.look() if self.ports else ():
            self._warn(text)

    def _translated(self, message: Any) -> list[Message]:
        """Translate a message of MIDI."""
        kind = message.type
        if kind in ("note_on", "note_off"):
            channel = message.channel + 1
            if kind == "note_off" or message.velocity == 0:
                return self._keys.release(channel, message.note)
            name = self._player(channel, message.note)
            return self._keys.press(channel, name, message.note, message.velocity) if name else []
        if kind == "control_change":
            return self._controlled(message.control, message.channel + 1, message.value)
        if kind == "pitchwheel":
            share = 0.5 + message.pitch / (16_384 if message.pitch < 0 else 16_382)
            return self._moved(BEND, message.channel + 1, share)
        if kind == "aftertouch":
            return self._moved(PRESSURE, message.channel + 1, message.value / 127)
        return []

    def _controlled(self, number: int, channel: int, value: int) -> list[Message]:
        if number < _MODES and (moved := self._moved(str(number), channel, value / 127)):
            return moved
        if number == _PEDAL:
            return self._keys.pedal(channel, value / 127)
        if number == _NOTES_OFF:
            return self._keys.release_all(channel)
        return [Message("/panic")] if number == _SOUND_OFF else []

    def _moved(self, controller: str, channel: int, share: float) -> list[Message]:
        """Return the messages that a moved controller sets; learn the controller if one is to be learnt."""
        if self._learning and int(self._learning[0].number("channel")) in (0, channel):
            (values, source), self._learning = self._learning, None
            learnt = control(values, controller)
            with suppress(Refused):  # others were bound meanwhile
                self._controls.bind(learnt)
                self._learnt.append((learnt, source))
        return [
            each.message(share) for each in self._controls.of(controller, channel) or self._macro(controller, channel)
        ]

    def _macro(self, controller: str, channel: int) -> list[Control]:
        """Return the control that turns a macro of the object that plays a channel's notes, where no other is bound."""
        name = self._player(channel, _MIDDLE) if controller in _MACROS else ""
        return (
            [control(Values(words={"address": f"/object/{name}/macro/{_MACROS[controller]}"}), controller)]
            if name
            else []
        )

    def _player(self, channel: int, note: int) -> str:
        """Return the object that plays a note of a channel: the newest if none was given; "" if none is there."""
        if name := self._parts.player(channel, note):
            return name
        for name in reversed(list(self._objects)):
            with suppress(KeyError):  # it has just gone
                if self._objects[name].freed == math.inf and not self._is_copy(name):
                    return name
        return ""

    def _is_copy(self, name: str) -> bool:
        stem, _, note = name.rpartition(".")
        return self._keys.is_copy(name) or (note.isdecimal() and stem in self._objects)

    def _answered(self, packet: bytes) -> bool:
        """Warn of what was refused: MIDI itself can't be answered."""
        for bundle in parse(packet):
            for message in bundle.messages:
                if message.address != "/fail":
                    continue
                address, reason = (str(arg) for arg in message.args[:2])
                _, _, name, action = (*address.split("/"), "", "", "")[:4]
                if action == "damp" and self._keys.is_copy(name):  # somebody has freed it
                    with self._lock:
                        self._keys.forget(name)
                else:
                    self._say(f"MIDI: {address}: {reason}")
        return True

    def _say(self, text: str) -> None:
        """Warn, but not all the time: a controller that is turned says the same some hundred times."""
        now = time.monotonic()
        self._said = {each: since for each, since in self._said.items() if now - since < _QUIET}
        if text not in self._said and len(self._said) < _MOST_SAID:
            self._said[text] = now
            self._warn(text)

    # Handlers of messages about MIDI.

    def _notes(self, values: Values, source: Source) -> Iterator[Message]:
        name = values.words["object"]
        require_name("object", name)
        low, high = (
            values.numbers.get(each.name, end) for each, end in ((LOWEST, LOWEST.low), (HIGHEST, HIGHEST.high))
        )
        if low > high:
            raise Refused(f"low = {low:g}: expected at most high, {high:g}")
        with self._lock:
            if not self._parts.add(Part(name, int(values.number("channel")), low, high)):
                raise Refused(f"object = {name}: expected at most {MOST} ranges of keys")
        yield Message("/done", ("/midi/notes",))

    def _learn(self, values: Values, source: Source) -> Iterator[Message]:
        if not self.ports:
            raise Refused("no MIDI input is open: expected the server to be started with --midi")
        control(values, "")
        with self._lock:
            self._controls.require_room(values.words["address"])
            self._learning = values, source
        yield Message("/done", ("/midi/learn", values.words["address"]))

    def _control(self, values: Values, source: Source) -> Iterator[Message]:
        bound = control(values, values.words["controller"])
        with self._lock:
            self._controls.bind(bound)
        yield Message("/done", ("/midi/control", bound.address))

    def _forget(self, values: Values, source: Source) -> Iterator[Message]:
        with self._lock:
            self._learning = None
            self._controls.forget(values.words.get("address", ""))
        yield Message("/done", ("/midi/forget",))

    def _listed(self, values: Values, source: Source) -> Iterator[Message]:
        with self._lock:
            controls = list(self._controls.listed())
        yield from in_parts("/midi/controls.reply", (), controls)
