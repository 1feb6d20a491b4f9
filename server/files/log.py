"""Writes what an engine carries out as a score that renders to the same sound."""

import time
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import version
from itertools import chain
from pathlib import Path

from ...dsp.runtime.engine import Engine
from ...dsp.schema import GESTURES
from ..osc.addresses import calls
from ..osc.score import format_line
from ..osc.sensor_verbs import SENSOR
from ..osc.wire import Argument, Message
from ..provenance import computed_by
from ..scene.shattering import NOTHING
from ..scene.transaction import Sent
from .outfile import OutFile

_OF_OTHER = "by", "by_position", "by_point", "by_direction"
_SENSORS = "/sensor/"
_LONGEST_STEM = 50  # characters of a name that is made another's


class Log:
    """A score of what was carried out, and when: on the very sample, in order, as it goes on.

    Patterns stand as the objects that they matched; what was refused, or forgotten by a panic, is not there. Where the
    clock was set so that an object came before its namesake had gone, it has another name. Where an object went before
    a sensor on it came, later sensors may have other channels than they had. An existing file is left as it is until
    `start`. OSError if it can't be opened.
    """

    def __init__(self, engine: Engine, path: Path, head: Sequence[Message] = ()) -> None:
        """Begin a log with `head`: messages that were carried out before anything else, so that a render is like what
        was heard."""
        self.path = path
        self._engine = engine
        self._head = head
        self._file = OutFile(path)
        self._waiting: dict[int, Sent] = {}  # by the number of the command
        self._names: dict[int, str] = {}  # of the objects that are there, by serial
        self._sensors: set[str] = set()  # addresses that take those away that are there
        self.error: str | None = None
        """Reason for which it gave up, if it did."""
        engine.note()

    def start(self) -> None:
        """Begin to write."""
        self._file.begin()
        day = time.strftime("%Y-%m-%d %H:%M:%S")
        self._write(
            [
                f"# carom {version('carom')}, {day}; {computed_by(self._engine)}; "
                f"render it at --rate {self._engine.rate:.0f}\n",
                *(format_line(0.0, message) + "\n" for message in self._head),
            ]
        )

    def expect(self, first: int, sent: list[Sent]) -> None:
        """Remember what commands stand for, from the command with the number `first` on."""
        for n, each in enumerate(sent):
            # A message is one line for each object, however many commands it takes.
            if n == 0 or each.message is not sent[n - 1].message or each.serial != sent[n - 1].serial:
                self._waiting[first + n] = each

    def write(self) -> None:
        """Write what has been carried out since the last call; a crash loses no more than what came after it."""
        lines = []
        for number, sample in self._engine.noted():
            sent = self._waiting.pop(number, None)
            if sent and sample >= 0.0 and not self.error:
                try:
                    if message := self._named(sent):
                        lines.append(format_line(sample / self._engine.rate, message) + "\n")
                except ValueError as error:
                    self.error = f"the log {self._file.path} ended: {error}"
        if lost := self._engine.stats.notes_lost:
            self.error = f"the log {self._file.path} ended: {lost} events came too fast to write"
        if not self.error:
            self._write(lines)

    def remark(self, frame: int, text: str) -> None:
        """Note what is no message of a score, and at which frame it happened."""
        if not self.error:
            self._write([f"# {frame / self._engine.rate!r} {text} at frame {frame}\n"])

    def _named(self, sent: Sent) -> Message | None:
        """Return a message as it is carried out, on the one object that it is about; None if it takes a sensor away
        that never was there, as its object went before."""
        message, serial = sent.message, sent.serial
        if message.address.startswith(_SENSORS):
            return self._of_sensor(message, serial)
        if message.address == "/object/new":
            stem, *rest = message.args
            name, count = str(stem), 1
            while name in self._names.values():
                count += 1
                name = f"{str(stem)[:_LONGEST_STEM]}~{count}"
            self._names[serial] = name
            return Message(message.address, (name, *rest))
        if serial not in self._names:
            return message
        action = message.address.split("/", 3)[3]
        name = self._names.pop(serial) if action == "free" else self._names[serial]
        return Message(f"/object/{name}/{action}", self._struck(sent) if sent.by else message.args)

    def _of_sensor(self, message: Message, serial: int) -> Message | None:
        """Return a message that mounts a sensor or takes it away as it is carried out, None as `_named`."""
        if message.address == SENSOR:
            sensor, _, *rest = message.args
            self._sensors.add(f"{_SENSORS}{sensor!s}/free")
            return Message(SENSOR, (sensor, self._names[serial], *rest))
        if message.address not in self._sensors:
            return None
        self._sensors.remove(message.address)
        return message

    def _struck(self, sent: Sent) -> tuple[Argument, ...]:
        """Return the arguments that name the other object as the log does. Where that was removed before, a
        striking object is its mass alone."""
        args = sent.message.args
        verb = calls(sent.message)[0].verb
        assert verb
        if GESTURES[verb.action].what:
            return self._names.get(sent.by, args[0]), *args[1:]
        first = next(n for n, arg in enumerate(args) if isinstance(arg, str))
        keys = dict(verb.pairs(args[first:]))
        if sent.by in self._names:
            keys["onto" if GESTURES[verb.action].breaks else "by"] = self._names[sent.by]
        elif GESTURES[verb.action].breaks:
            keys["onto"] = NOTHING
        else:
            keys = {key: value for key, value in keys.items() if key not in _OF_OTHER}
            keys["mass"] = sent.mass
        return *args[:first], *chain.from_iterable(keys.items())

    def _write(self, lines: list[str]) -> None:
        """Append lines; where there is no room for all, as many as there is room for."""
        try:
            self._file.require_name()
            self._file.write("".join(lines).encode())
        except OSError as error:
            self.error = f"the log {self._file.path} ended: {error.strerror}"
            with suppress(OSError):
                for line in lines:
                    self._file.write(line.encode())

    def close(self) -> None:
        """Write what is left, and the end; a file that was never started is taken away again."""
        if self._file.begun and not self._file.is_closed:
            self.write()
            if not self.error:
                # Objects that ring and bodies that roll on were heard up to here.
                self._write([format_line(self._engine.position / self._engine.rate, Message("/panic")) + "\n"])
        self._file.close()
