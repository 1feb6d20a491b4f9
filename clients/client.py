"""A Python client: makes objects on a Carom server and plays them, over OSC."""

import select
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import TracebackType

from ..server.osc import wire
from ..server.osc.framing import Sized

_PATIENCE = 5.0  # s that a server may take to take what is sent over TCP


class CommandError(RuntimeError):
    """The server answered /fail, or a message can't be sent; the text says why."""


class Client:
    """A socket to one server: UDP, or TCP, which loses nothing. Floats go as doubles, so that the server's log holds
    what was asked for.

    A method, or with TCP the making of a client, raises ConnectionRefusedError if the host says that nothing listens.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = wire.DEFAULT_PORT, tcp: bool = False) -> None:
        self._server = f"{host}:{port}"
        self._stream = Sized() if tcp else None
        if tcp:
            with _reaching(self._server):
                self._socket = socket.create_connection((host, port), _PATIENCE)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        else:
            self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self._socket.connect((host, port))
        self._bundle: list[wire.Message] | None = None

    def __enter__(self) -> "Client":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._socket.close()

    def send(self, address: str, *args: wire.Argument) -> None:
        """Sends a message, or adds it to the bundle being made; waits for nothing."""
        if self._bundle is None:
            self._transmit(_encoded(address, args))
        else:
            self._bundle.append(wire.Message(address, args))

    @contextmanager
    def bundle(self, at: float | None = None) -> Iterator[None]:
        """What is sent inside goes as one bundle, to happen together at a Unix time (s), or at once."""
        if self._bundle is not None:
            raise RuntimeError("a bundle inside a bundle")
        messages: list[wire.Message] = []
        self._bundle = messages
        try:
            yield
        finally:
            self._bundle = None
        tag = wire.IMMEDIATELY if at is None else wire.time_tag(at)
        self._transmit(wire.encode_bundle(tag, messages, real="d"))

    def ask(self, address: str, *args: wire.Argument, timeout: float = 2.0) -> wire.Message:
        """Sends a message and waits (s) for its reply: /done, ADDRESS.reply or /synced.

        Raises CommandError for /fail, TimeoutError for silence. Replies to earlier messages are dropped.
        """
        self._start_asking(address)
        self.send(address, *args)
        for reply in self.replies(timeout):
            if reply.address == "/fail" and reply.args[:1] == (address,):
                raise CommandError(": ".join(map(str, reply.args)))
            if _answers(reply, address, args):
                return reply
        raise TimeoutError(f"{address}: no reply from {self._server} within {timeout} s")

    def ask_all(self, address: str, *args: wire.Argument, timeout: float = 2.0) -> list[wire.Message]:
        """Sends a message and gathers all replies, /fail too, until (s) the server has carried it out.

        Raises TimeoutError for silence. Replies to earlier messages are dropped.
        """
        self._start_asking(address)
        self.send(address, *args)
        last = wire.Message("/synced", (time.monotonic_ns() % 2**31,))
        if address != "/quit":
            self.send("/sync", *last.args)
        gathered: list[wire.Message] = []
        for reply in self.replies(timeout):
            if reply == last and address != "/quit":
                return gathered
            gathered.append(reply)
            if address == "/quit" and reply.args[:1] == (address,):
                return gathered
        raise TimeoutError(f"{address}: no reply from {self._server} within {timeout} s")

    def _start_asking(self, address: str) -> None:
        if self._bundle is not None:
            raise RuntimeError(f"{address}: nothing answers before its bundle is sent")
        with suppress(ConnectionRefusedError):
            list(self.replies(0.0))

    def replies(self, seconds: float) -> Iterator[wire.Message]:
        """What the server sends, as it comes, for so long."""
        deadline = time.monotonic() + seconds
        while select.select([self._socket], [], [], max(0.0, deadline - time.monotonic()))[0]:
            with _reaching(self._server):
                data = self._socket.recv(wire.MAX_DATAGRAM)
            if self._stream and not data:
                raise ConnectionResetError(f"{self._server} has closed the connection")
            for packet in self._stream.packets(data) if self._stream else [data]:
                for bundle in wire.parse(packet):
                    yield from bundle.messages

    def _transmit(self, packet: bytes) -> None:
        with _reaching(self._server):
            self._socket.sendall(self._stream.framed(packet) if self._stream else packet)

    def new(self, name: str, preset: str, **keys: wire.Argument) -> None:
        """Makes an object and waits until it is there; keys override the preset's."""
        self.ask("/object/new", name, preset, *_flat(keys))

    def impact(self, name: str, velocity: float, position: float | None = None, **keys: wire.Argument) -> None:
        """Strikes an object, or all that a pattern matches: velocity in m/s, position 0..1 along its path."""
        self._gesture(name, "impact", velocity, position, keys)

    def bounce(self, name: str, height: float, position: float | None = None, **keys: wire.Argument) -> None:
        """Drops a striker on an object from a height (m), on which it bounces until it rests."""
        self._gesture(name, "bounce", height, position, keys)

    def roll(self, name: str, speed: float, position: float | None = None, **keys: wire.Argument) -> None:
        """Rolls a ball over an object at a speed (m/s), or steers the roll of that `id` (else NAME's); 0 ends it."""
        self._gesture(name, "roll", speed, position, keys)

    def press(self, name: str, force: float, position: float | None = None, **keys: wire.Argument) -> None:
        """Lays a striker on an object and presses with a force (N), until the gesture of that `id` is stopped."""
        self._gesture(name, "press", force, position, keys)

    def gesture(self, id: str, what: str, *value: float) -> None:
        """Steers the running gestures of an id or a pattern: its speed, force, gain, ...; `stop` takes no value."""
        self.send(f"/gesture/{id}/{what}", *value)

    def damp(self, name: str, amount: float) -> None:
        """Lays a hand on an object: 0 none, 1 the firmest."""
        self.send(f"/object/{name}/damp", amount)

    def free(self, name: str) -> None:
        """Removes an object once it is silent."""
        self.send(f"/object/{name}/free")

    def _gesture(
        self, name: str, what: str, value: float, position: float | None, keys: dict[str, wire.Argument]
    ) -> None:
        where = () if position is None else (position,)
        self.send(f"/object/{name}/{what}", value, *where, *_flat(keys))

    def status(self) -> wire.Message:
        """The server's counts, loads and rates: its /status.reply."""
        return self.ask("/status")


@contextmanager
def _reaching(server: str) -> Iterator[None]:
    """A ConnectionRefusedError inside names the server."""
    try:
        yield
    except ConnectionRefusedError as error:
        raise ConnectionRefusedError(f"nothing listens at {server}: expected a running `carom serve`") from error


def _encoded(address: str, args: tuple[wire.Argument, ...]) -> bytes:
    try:
        return wire.encode(address, *args, real="d")
    except ValueError as error:
        raise CommandError(str(error)) from None


def _answers(reply: wire.Message, address: str, args: tuple[wire.Argument, ...]) -> bool:
    if address == "/sync":
        return reply == wire.Message("/synced", args)
    return reply.address == f"{address}.reply" or (reply.address == "/done" and reply.args[:1] == (address,))


def _flat(keys: dict[str, wire.Argument]) -> list[wire.Argument]:
    return [part for pair in keys.items() for part in pair]
