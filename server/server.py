"""The live server: OSC in over UDP, TCP and web sockets, replies out, sound on a device."""

import sys
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING

from ..dsp.engine.memory.state import CONTACTS, ROLLS, End
from ..dsp.runtime.arena import EngineFull
from ..dsp.runtime.engine import NOW, Engine
from ..presets import PresetError, Presets
from .audio.supervisor import Player
from .files.log import Log
from .files.recorder import Recorder
from .governor import Governor
from .knowledge import Knowledge
from .making import Maker
from .midi.midi import Midi
from .monitor import Monitor
from .net.network import Network, Source
from .net.remote import Remote
from .osc.addresses import Call
from .osc.arguments import Refused, Values
from .osc.patterns import TooMuch
from .osc.questions import QUESTIONS, Answer
from .osc.wire import BadPacket, Bundle, Message
from .packets import Packet, read
from .recording import Recording
from .scene.gesture_ids import Ended
from .scene.scale import USUAL_SCALE, Scale
from .scene.session import Session, fail
from .scene.transaction import NotMade
from .scene.translate import sync
from .status import Status, version
from .subscribers import Subscribers
from .telling import Teller
from .texts import plain
from .time_tags import time_of
from .turns import TURN, every_turn
from .waiting import Waiting

if TYPE_CHECKING:
    from .web.server import WebServer

_POLL = 0.02  # s between looks at the engine
_NOBODY = ("", 0)  # no source: all others may ask
_METER = ("meter", 0)  # who asks for the limiter's gain
_PURE = frozenset(("/status", "/version", *QUESTIONS))  # questions: they do nothing but that they are answered
_REFUSALS = (Refused, EngineFull, TooMuch, PresetError)
_MOST_PRINTED = 1_000  # texts that are remembered, so that none is repeated


_UNLIMITED = fail("/limiter", "a client of another host can't turn it off: expected one of this machine, or --trust")


def _unlimits(call: Call) -> bool:
    """True if a call turns the limiter off."""
    return bool(call.verb and call.verb.address == "/limiter" and call.message.args[:1] in (("off",), ("0",), (0,)))


class Server:
    """A session that is played over OSC. `run` serves until /quit or `stop`."""

    def __init__(
        self,
        network: Network,
        engine: Engine,
        player: Player,
        presets: Presets,
        recorder: Recorder | None = None,
        log: Log | None = None,
        scale: Scale = USUAL_SCALE,
    ) -> None:
        self.player = player
        self.engine = engine
        self.address = network.address
        self.network = network
        self.web: WebServer | None = None
        self._session = Session(engine, presets, scale=scale)
        self._status = Status(engine, player, lambda: self._session.objects.slots)
        self._governor = Governor(engine)
        self._subscribers = Subscribers(network, self._reply)
        engine.meter.start()
        lowest_gain = partial(self._status.lowest_gain.since_last_asked, _METER)
        self.teller = Teller(engine, self._session, self._subscribers, self._reply, lowest_gain)
        self.known = Knowledge(self._session, presets, log.path if log else None)
        self.on_look: Callable[[Iterable[str]], object] = lambda there: None
        """Called at every look at the engine, with the names of the objects that are there."""
        self._syncs: dict[int, tuple[int, Source]] = {}
        self._sync_count = 0
        self._monitor: Monitor | None = None
        self._running = True
        self._log = log
        if log:
            self._session.on_sent = log.expect
        self._writers: dict[str, Recorder | Log | None] = {"recording": recorder, "logging": log}
        self._printed: set[str] = set()
        self.recording = Recording(engine, log, self._reply, self._warn)
        self.midi = Midi(network.doorway, self._session, self._warn)
        self._handlers = self._all_handlers()
        self._least_answers: dict[str, int] = {}  # bytes of the shortest answer so far to each question that only asks
        self._maker = Maker(presets, engine.top_frequency, lambda: self._waiting.look(), engine.plan)
        self._waiting = Waiting(network, self._maker)
        self.early: deque[tuple[bytes, Source]] = deque()
        """Packets that came before there was an engine; `run` carries them out first."""

    def _all_handlers(self) -> dict[str, Callable[[Values, Source], Iterable[Message] | None]]:
        """Return the handlers of messages that are about the server, not the sound, by address."""
        return {
            "/status": self._status_asked,
            "/version": lambda values, source: [version()],
            "/sync": self._sync,
            "/notify": self._notify,
            **{address: partial(self._answer, answer) for address, (_, answer) in QUESTIONS.items()},
            "/record": self.recording.asked,
            "/dump": self._dump,
            "/quit": self._quit,
            **self.midi.handlers,
        }

    def stop(self) -> None:
        self._running = False

    def close(self) -> None:
        """Make no more objects."""
        self._maker.close()

    def start_files(self) -> None:
        """Begin to record and to log, from the engine's first sample on; until now the files are as they were."""
        for writer in self._open_writers():
            writer.start()

    def run(self) -> None:
        """Serve until stopped."""
        while self.early:
            self._receive(*self.early.popleft())
        due = 0.0
        while self._running:
            self._hear()
            if waited := self._waiting.next():
                self._attempt(waited)
                self._waiting.end(waited.source)
            if time.monotonic() >= due:
                try:
                    self._poll()
                except Exception:  # as below
                    self._print_once(traceback.format_exc())
                due = time.monotonic() + _POLL

    def _hear(self, busy: Source | None = None) -> None:
        """Carry out what arrives, for a turn; amid a bundle of the client `busy` the questions of others alone."""
        arrived = self.network.receive(0.0 if busy or self._waiting.in_a_hurry else _POLL, busy)
        end = time.monotonic() + TURN
        while arrived and self._running:
            self._receive(*arrived)
            if time.monotonic() > end:
                return
            arrived = self.network.receive(0.0, busy)

    def _receive(self, packet: bytes, source: Source) -> None:
        self._subscribers.hear(source)
        self._attempt((packet, source))

    def _attempt(self, arrived: Packet | tuple[bytes, Source]) -> None:
        """Carry out a packet, or let it wait. A fault of the server does not end it."""
        source = arrived.source if isinstance(arrived, Packet) else arrived[1]
        try:
            packet = arrived if isinstance(arrived, Packet) else self._read(*arrived)
            if packet is arrived or not self._waiting.hold(packet):
                self._carry_out(packet)
        except BadPacket as error:
            self._reply(fail("datagram", str(error)), source)
        except Exception as error:
            self._print_once(traceback.format_exc())
            self._reply(fail("datagram", f"a fault of the server: {error!r}"), source)

    def _read(self, data: bytes, source: Source) -> Packet:
        packet = read(data, source)
        refusals = (fail(each.address, str(TooMuch(each.address))) for each in packet.overfull)
        packet.rest.extend(partial(self._reply, refusal, source) for refusal in refusals)
        if self._monitor and self._monitor.on:
            for bundle, _ in packet.bundles:
                for message in bundle.messages:
                    self._monitor.show(message)
        return packet

    def _carry_out(self, packet: Packet) -> None:
        """Carry out a packet bundle by bundle. After a turn the rest waits until others had theirs."""
        if packet.making:
            packet.made, packet.making = {**packet.made, **self._maker.take(packet.making)}, None
        end = time.monotonic() + TURN
        while not packet.done:
            if packet.rest:
                packet.rest.popleft()()
            else:
                self._perform(*packet.bundles[0], packet)
                if packet.making:
                    return
                packet.bundles.popleft()
            if time.monotonic() > end and not packet.done:
                self._waiting.put_off(packet)
                return

    def _perform(self, bundle: Bundle, asked: list[Call], packet: Packet) -> None:
        """Carry out the messages of a bundle about the sound; its replies, and those about the server, come next.

        Where a table of pulses or a measurement is to be made for it, it waits.
        """
        source = packet.source
        try:
            when = time_of(bundle.time, self.engine)
        except Refused as error:
            packet.rest.extend(partial(self._reply, fail(each.address, str(error)), source) for each in bundle.messages)
            return
        scored = [call for call in asked if call.verb is None or call.verb.scored]
        if self.network.is_stranger(source):
            packet.rest.extend(partial(self._reply, _UNLIMITED, source) for call in scored if _unlimits(call))
            scored = [call for call in scored if not _unlimits(call)]
        if scored:  # a question that is answered amid a bundle leaves the session as it is
            pause = every_turn(partial(self._hear, source))
            try:
                replies = self._session.perform_calls(
                    scored, when, source, packet.made, packet.selection, pause, packet.beside
                )
            except NotMade as missing:
                self._waiting.make_beside(packet, missing)
                return
            packet.rest.extend(partial(self._reply, reply, source) for reply in replies)
        for call in scored:
            self._governor.note_request(call.message)
        packet.rest.extend(partial(self._serve, call, packet) for call in asked if call.verb and not call.verb.scored)

    def _serve(self, call: Call, packet: Packet) -> None:
        """Carry out a message that is about the server, not the sound."""
        assert call.verb
        address, source = call.verb.address, packet.source
        least = self._least_answers.get(address)
        if least and not self.network.affords(source, least):  # nor does the question do anything else
            self.network.skip_reply()
            return
        try:
            values = call.verb.parse(call.message.args)
            values.words[call.verb.target] = call.target
            answers = iter(self._handlers[address](values, source) or ())
        except _REFUSALS as error:
            self._reply(fail(call.message.address, str(error)), source)
        else:
            self._go_on(answers, call, packet)

    def _go_on(self, answers: Iterator[Message], call: Call, packet: Packet) -> None:
        """Send the answers to a message as they are made, for a turn; the rest before the packet's other work."""
        assert call.verb
        address, end = call.verb.address, time.monotonic() + TURN
        try:
            answer = next(answers, None)
            while answer:
                size = self._reply(answer, packet.source)
                if address in _PURE:
                    least = self._least_answers[address] = min(size, self._least_answers.get(address, size))
                    if not self.network.affords(packet.source, least):
                        return
                answer = next(answers, None)
                if answer and time.monotonic() > end:
                    packet.rest.appendleft(partial(self._go_on, chain([answer], answers), call, packet))
                    return
        except _REFUSALS as error:
            self._reply(fail(call.message.address, str(error)), packet.source)

    def _answer(self, answer: Answer, values: Values, source: Source) -> Iterable[Message]:
        return answer(self._session, values)

    def _status_asked(self, values: Values, source: Source) -> list[Message]:
        objects = len(self._session.objects)
        own: dict[str, float | str] = {
            "waiting": len(self._waiting),
            "full_scale": self._session.scale.full_scale,
            **self._file_states(),
            "take": self.recording.state,
            "midi": self.midi.state,
            "pages": len(self.web.site.clients) if self.web else 0,
            "reports_dropped": self.teller.dropped + self.engine.stats.trace_lost,
        }
        return [self._status.reply(source, objects, self.network, own)]

    def _sync(self, values: Values, source: Source) -> None:
        self.engine.send([sync(self._sync_count + 1)])
        self._sync_count += 1
        self._syncs[self._sync_count] = int(values.numbers["id"]), source

    def _notify(self, values: Values, source: Source) -> None:
        on = bool(values.numbers["level"])
        if on:
            self._subscribers.add(source, int(values.numbers["level"]), int(values.numbers.get("port", 0)))
        else:
            self._subscribers.remove(source)
        self._reply(Message("/done", ("/notify",)), source)
        for writer in self._open_writers():
            if on and writer.error:
                self._reply(Message("/warning", (writer.error,)), source)

    def _dump(self, values: Values, source: Source) -> None:
        self._monitor = self._monitor or Monitor()  # one for all times: its thread may never end
        self._monitor.on = bool(values.numbers["on"])

    def _quit(self, values: Values, source: Source) -> None:
        if isinstance(source, Remote):
            raise Refused("a page can't end the server")
        self._reply(Message("/done", ("/quit",)), source)
        self.stop()

    def _open_writers(self) -> list[Recorder | Log]:
        return [writer for writer in self._writers.values() if writer]

    def _file_states(self) -> dict[str, str]:
        """Return, for each file, whether it is written: no, yes, or why not any more."""
        return {name: writer.error or "yes" if writer else "no" for name, writer in self._writers.items()}

    def _reply(self, message: Message, to: Source) -> int:
        """Send a reply, where it can be sent; return its size (bytes)."""
        # A text that came in may be too long, or hold characters that can't go out again.
        args = [plain(arg) if isinstance(arg, str) else arg for arg in message.args]
        try:
            return self.network.send(Message(message.address, tuple(args)), self._subscribers.receiver(to))
        except OSError:
            self._subscribers.remove(to)  # the client can't be reached
            return 0

    def _poll(self) -> None:
        if self._log:
            self._log.write()
        for writer in self._open_writers():
            if writer.error and self._print_once(writer.error):
                self._warn(writer.error)
        self.recording.look()
        self.midi.look(self._reply)
        done = self.engine.stats.synced
        for count in [count for count in self._syncs if count <= done]:
            identity, source = self._syncs.pop(count)
            self._reply(Message("/synced", (identity,)), source)
        if (quality := self._governor.decide(time.monotonic())) is not None:
            self._session.perform([Message("/quality", (int(quality),))], NOW)
            load = self.engine.stats.load_now
            self._warn(f"quality is now {int(quality)}, {quality.name.lower()}: the load is {load:.0%}")
        self._release_gone()
        self._subscribers.lapse()
        pause = every_turn(partial(self._hear, _NOBODY))
        for ended in self._session.take_ends():
            self._report_end(ended)
            pause()
        self.on_look(self.teller.look())
        for text, sender in self.network.losses():
            self._reply(fail("datagram", text), sender)
        if hole := self._status.hole():
            told = self.recording.tell_hole(*hole)
            self._print_once(told)  # nobody may listen to warnings, and a recording has no word for it
            self._warn(told)
        for warning in (*self._status.warnings(), *self.network.warnings(), *self.player.look()):
            self._warn(warning)

    def _release_gone(self) -> None:
        """Stop the gestures of web sockets' clients that have left: nobody else holds them."""
        while self.network.left:
            client = self.network.left.pop()
            self._subscribers.remove(client)
            ids = [id for id in self._session.gestures.running() if any(source is client for _, source in id.running)]
            self._session.perform([Message(f"/gesture/{id.name}/stop") for id in ids], NOW)

    def _print_once(self, text: str) -> bool:
        """Print a text on stderr; False if that was done before."""
        if text in self._printed:
            return False
        if len(self._printed) < _MOST_PRINTED:
            self._printed.add(text)
        with suppress(OSError, ValueError):  # nobody may be there to read it
            print(text, file=sys.stderr, flush=True)
        return True

    def _report_end(self, ended: Ended) -> None:
        clients = {self._subscribers.receiver(each): each for each in (ended.source, *self._subscribers)}
        for client in clients.values():
            self._reply(Message("/gesture/end", (ended.id,)), client)
        if ended.end is End.NO_ROOM:
            what = f"{CONTACTS} contacts"
            if modes := self.engine.budget[1]:
                what += f" or {modes} coupled modes"
            if ended.address.endswith("/roll") and self.engine.stats.rolls_active == ROLLS:
                what = f"{ROLLS} rolls"
            text = f"{ended.id}: engine full: {what} in use"
            self._reply(fail(ended.address, text), ended.source)

    def _warn(self, text: str) -> None:
        for subscriber in self._subscribers:
            self._reply(Message("/warning", (text,)), subscriber)
