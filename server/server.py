"""The live server: OSC in over UDP and TCP, replies out, sound on a device."""

import gc
import sys
import time
import traceback
from collections.abc import Collection, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from ..dsp.contact.sampled import METHODS
from ..dsp.engine.state import CONTACTS, COUPLED_MODES, Command, End
from ..dsp.native.system import clock_ns
from ..dsp.runtime.arena import EngineFull
from ..dsp.runtime.engine import NOW, Engine
from ..presets.library import Presets
from .audio.supervisor import Player
from .files.log import Log
from .files.recorder import Recorder
from .governor import Governor
from .monitor import Dump
from .net.network import Network, Source
from .osc.addresses import VERBS, Refused, spelled
from .osc.oscquery import OscQuery, answering
from .osc.wire import DEFAULT_PORT, IMMEDIATELY, Argument, BadPacket, Bundle, Message, parse, unix_ns
from .render import HIGHEST_RATE, LOWEST_RATE
from .scene.gesture_ids import Ended
from .scene.scene import Scene, fail
from .status import Status, version

_POLL = 0.02  # s between looks at the engine
_LONGEST_TEXT = 1_000  # characters of a reply
_MOST_SUBSCRIBERS = 32
_LONGEST_LATENCY = 2.0  # s
_SAME_MOMENT = 2_000  # ns
_FURTHEST_AHEAD = 3600.0  # s that a time tag may lie in the future; how late it is counts up to that
_MOST_COMPLAINTS = 1_000  # that are remembered, so that none is repeated


class ServeError(ValueError):
    """A server that can't be; the text says why."""


@dataclass(frozen=True)
class Options:
    """How to serve: port (0: any free one) and address, device (None: the default), latency to ask it for in s
    (None: its lowest), rate in Hz, block in frames (0: the device's), files to record the sound and to log the events
    to, folders of presets, the arguments of a /contact to begin with, a port for
    OSCQuery (None: none, 0: any free one)."""

    port: int = DEFAULT_PORT
    bind: str = "127.0.0.1"
    device: str | None = None
    latency: float | None = None
    rate: int = 48_000
    block: int = 0
    record: Path | None = None
    log: Path | None = None
    presets: tuple[Path, ...] = ()
    contact: tuple[Argument, ...] = ()
    oscquery: int | None = None

    def __post_init__(self) -> None:
        for name, value, low, high in (
            ("port", self.port, 0, 65_535),
            ("rate", self.rate, LOWEST_RATE, HIGHEST_RATE),
            ("block", self.block, 0, 65_536),
            ("oscquery", self.oscquery or 0, 0, 65_535),
        ):
            if not low <= value <= high:
                raise ServeError(f"{name} = {value}: expected {low} to {high}")
        if self.latency is not None and not 0 <= self.latency <= _LONGEST_LATENCY:
            raise ServeError(f"latency = {self.latency:g}: expected 0 to {_LONGEST_LATENCY:g} s")


class Server:
    """A scene that listens. `run` serves until /quit or `stop`."""

    def __init__(
        self,
        network: Network,
        engine: Engine,
        player: Player,
        presets: Presets,
        recorder: Recorder | None = None,
        log: Log | None = None,
    ) -> None:
        self.player = player
        self.engine = engine
        self.address = network.address
        self._network = network
        self._scene = Scene(engine, presets)
        self._status = Status(engine, player)
        self._governor = Governor(engine)
        self._subscribers: set[Source] = set()
        self._syncs: dict[int, tuple[int, Source]] = {}
        self._sync_count = 0
        self._dump: Dump | None = None
        self._running = True
        self._log = log
        if log:
            self._scene.on_sent = log.expect
        self._keepers: dict[str, Recorder | Log | None] = {"recording": recorder, "logging": log}
        self._told: set[str] = set()
        self.query: OscQuery | None = None

    def stop(self) -> None:
        self._running = False

    def start_files(self) -> None:
        """Begin to record and to log, from the engine's first sample on, in files that so far are as they were."""
        for keeper in self._files():
            keeper.start()

    def choose_contact(self, args: tuple[Argument, ...]) -> None:
        """Solve contacts as /contact with these arguments asks; ServeError says why not."""
        for reply in self._scene.perform([Message("/contact", args)], NOW):
            raise ServeError(": ".join(map(str, reply.args)))

    def names(self) -> dict[str, Collection[str]]:
        """What may stand for a word of the address space now; any thread may ask."""
        return {
            "NAME": dict.fromkeys(self._scene.objects),
            "ID": {id.name: None for id in self._scene.gestures.known() if id.started},
            "preset": self._scene.presets.names("objects"),
            "method": ("closed", *METHODS),
        }

    def run(self) -> None:
        """Serve until told to stop."""
        due = 0.0
        while self._running:
            arrived = self._network.receive(_POLL)
            if arrived:
                self._receive(*arrived)
            if time.monotonic() >= due:
                try:
                    self._poll()
                except Exception:  # as below
                    self._complain(traceback.format_exc())
                due = time.monotonic() + _POLL

    def _receive(self, packet: bytes, source: Source) -> None:
        try:
            self._answer(packet, source)
        except Exception as error:  # a fault of ours must not end the show
            self._complain(traceback.format_exc())
            self._reply(fail("datagram", f"a fault of the server: {error!r}"), source)

    def _answer(self, packet: bytes, source: Source) -> None:
        try:
            bundles = parse(packet)
        except BadPacket as error:
            self._reply(fail("datagram", str(error)), source)
            return
        for bundle in bundles:
            if self._dump and self._dump.on:
                for message in bundle.messages:
                    self._dump.show(message)
            self._perform(bundle, source)

    def _perform(self, bundle: Bundle, source: Source) -> None:
        try:
            when = self._time(bundle.time)
        except Refused as error:
            for message in bundle.messages:
                self._reply(fail(message.address, str(error)), source)
            return
        about_server: list[Message] = []
        sounding: list[Message] = []
        for message in chain.from_iterable(map(spelled, bundle.messages)):
            verb = VERBS.get(message.address)
            if message.address != "/fail":  # two servers would answer each other's for ever
                (sounding if verb is None or verb.scored else about_server).append(message)
        for reply in self._scene.perform(sounding, when, source):
            self._reply(reply, source)
        for message in sounding:
            self._governor.heed(message)
        for message in about_server:
            try:
                self._serve(message, source)
            except (Refused, EngineFull) as error:
                self._reply(fail(message.address, str(error)), source)

    def _time(self, time_tag: int) -> float:
        """When a time tag's sound is to be heard, for the engine; NOW for 0 and 1."""
        if time_tag <= IMMEDIATELY:
            return NOW
        wall, clock = _clocks()
        ahead = unix_ns(time_tag) - wall
        if ahead > _FURTHEST_AHEAD * 1e9:
            raise Refused(f"time tag: {ahead / 1e9:.0f} s ahead; expected at most {_FURTHEST_AHEAD:.0f} s")
        ahead = max(ahead, -round(_FURTHEST_AHEAD * 1e9))  # a clock that was never set says nothing of how late
        # From here on the wall clock may be set without moving what waits.
        return self.engine.stamp(max(1, clock + ahead))

    def _serve(self, message: Message, source: Source) -> None:
        """Carry out a message that is about the server, not the sound."""
        values = VERBS[message.address].parse(message.args).numbers
        match message.address:
            case "/status":
                self._reply(self._status.reply(len(self._scene.objects), self._network, self._keeping()), source)
            case "/version":
                self._reply(version(), source)
            case "/sync":
                self._sync(int(values["id"]), source)
            case "/notify":
                self._notify(bool(values["on"]), source)
            case "/dump":
                self._dump = self._dump or Dump()  # one for all times: its thread may never end
                self._dump.on = bool(values["on"])
            case "/quit":
                self._reply(Message("/done", ("/quit",)), source)
                self.stop()

    def _files(self) -> list[Recorder | Log]:
        return [keeper for keeper in self._keepers.values() if keeper]

    def _keeping(self) -> dict[str, str]:
        """What becomes of the files that are written: no, yes, or why not any more."""
        return {name: keeper.error or "yes" if keeper else "no" for name, keeper in self._keepers.items()}

    def _sync(self, identity: int, source: Source) -> None:
        self.engine.send([(NOW, Command.SYNC, None, (float(self._sync_count + 1),))])
        self._sync_count += 1
        self._syncs[self._sync_count] = identity, source

    def _notify(self, on: bool, source: Source) -> None:
        self._subscribers = set(filter(self._network.reaches, self._subscribers))
        if not on:
            self._subscribers.discard(source)
        elif len(self._subscribers) >= _MOST_SUBSCRIBERS and source not in self._subscribers:
            raise Refused(f"{_MOST_SUBSCRIBERS} clients are notified already: expected one of them to leave first")
        else:
            self._subscribers.add(source)
        self._reply(Message("/done", ("/notify",)), source)
        for keeper in self._files():
            if on and keeper.error:
                self._reply(Message("/warning", (keeper.error,)), source)

    def _reply(self, message: Message, to: Source) -> None:
        # What came in may be long, and need not be text that can go out again.
        args = [_plain(arg) if isinstance(arg, str) else arg for arg in message.args]
        try:
            self._network.send(Message(message.address, tuple(args)), to)
        except OSError:
            # It asked from where it can't be answered: its loss, and nobody else's.
            self._subscribers.discard(to)

    def _poll(self) -> None:
        if self._log:
            self._log.write()
        for keeper in self._files():
            if keeper.error and self._complain(keeper.error):
                self._warn(keeper.error)
        done = self.engine.counter("synced")
        for count in [count for count in self._syncs if count <= done]:
            identity, source = self._syncs.pop(count)
            self._reply(Message("/synced", (identity,)), source)
        if (quality := self._governor.decide(time.monotonic())) is not None:
            self._scene.perform([Message("/quality", (int(quality),))], NOW)
            load = self.engine.counter("load_now")
            self._warn(f"quality is now {int(quality)}, {quality.name.lower()}: the load is {load:.0%}")
        for ended in self._scene.take_ends():
            self._tell_end(ended)
        if lost := self._network.dropped():
            count, sender = lost
            text = f"{count} were left out: they came faster than they could be carried out"
            self._reply(fail("datagram", text), sender)
        names = {obj.handle.slot: name for name, obj in self._scene.objects.items()}
        for warning in (*self._status.warnings(names), *self._network.warnings(), *self.player.look()):
            self._warn(warning)

    def _complain(self, text: str) -> bool:
        """Tell whoever started the server, once; false if that was done before."""
        if text in self._told:
            return False
        if len(self._told) < _MOST_COMPLAINTS:
            self._told.add(text)
        with suppress(OSError, ValueError):  # they may have left
            print(text, file=sys.stderr, flush=True)
        return True

    def _tell_end(self, ended: Ended) -> None:
        asked: set[Source] = {ended.source} | self._subscribers
        for client in asked:
            self._reply(Message("/gesture/end", (ended.id,)), client)
        if ended.end is End.NO_ROOM:
            text = f"{ended.id}: no room, {CONTACTS} contacts go on already, or {COUPLED_MODES} modes are touched"
            self._reply(fail(ended.address, text), ended.source)

    def _warn(self, text: str) -> None:
        for subscriber in tuple(self._subscribers):
            self._reply(Message("/warning", (text,)), subscriber)


def _clocks() -> tuple[int, int]:
    """The wall clock and the engine's, in ns, read at the same moment: as near as a few attempts come."""
    attempts = []
    for _ in range(4):
        before, wall, after = clock_ns(), time.time_ns(), clock_ns()
        attempts.append((after - before, wall, (before + after) // 2))
        if after - before < _SAME_MOMENT:
            break
    return min(attempts)[1:]


def _plain(text: str) -> str:
    """Text that can be sent and shown anywhere: short, and without control characters."""
    short = text if len(text) <= _LONGEST_TEXT else text[: _LONGEST_TEXT - 3] + "..."
    return "".join(c if c.isprintable() else "?" for c in short)


@contextmanager
def serving(options: Options) -> Iterator[Server]:
    """A server ready to `run`. OSError, AudioError or PresetError say why it can't be."""
    with ExitStack() as last, ExitStack() as stack:
        with _named(options.bind, options.port):
            network = stack.enter_context(closing(Network(options.bind, options.port)))
        presets = Presets(options.presets)
        engine = Engine(options.rate)
        recorder = Recorder(engine, options.record) if options.record else None
        if recorder:
            stack.callback(recorder.close)
        log = Log(engine, options.log) if options.log else None
        if log:
            stack.callback(log.close)
        player = Player(engine, options.device, options.block, options.latency)
        # The files end with the last sound, and before PortAudio is asked to: that may fail, and take its time.
        last.callback(player.close)
        stack.callback(player.rest)
        server = Server(network, engine, player, presets, recorder, log)
        if options.contact:
            server.choose_contact(options.contact)
        server.start_files()  # not before all else is well: older ones would be lost
        if options.oscquery is not None:
            with _named(options.bind, options.oscquery):
                server.query = OscQuery(options.bind, options.oscquery, server.address[1], server.names)
            stack.enter_context(answering(server.query))
        _warm_up(engine)
        yield server


def _warm_up(engine: Engine) -> None:
    """Do now what would hold up the first who asks for something, by some 70 ms each."""
    engine.send([])  # compiles what hands commands over
    engine.stamp(clock_ns())  # and what tells the time
    gc.freeze()  # what is here for good need not be looked through for garbage again and again,
    gc.collect()  # nor count when it is decided whether there is enough new to look through


@contextmanager
def _named(host: str, port: int) -> Iterator[None]:
    """An OSError inside names the port."""
    try:
        yield
    except OSError as error:
        raise OSError(f"port {port} on {host}: {error.strerror or error}") from error
