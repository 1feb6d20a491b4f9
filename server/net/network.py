"""The way in and out: UDP and TCP on one port, web sockets, bounded queues of what arrived, replies that never wait.

A thread of its own reads datagrams (udp.py). The server's thread does the rest, between packets.
"""

import selectors
import socket
import sys
import time
from collections import Counter, deque
from contextlib import suppress
from functools import lru_cache

from ..osc.wire import Message, encode
from .remote import Doorway, Remote
from .reply_budget import Allowance, Nets
from .tcp import Connection, listen
from .udp import Intake

MOST_CONNECTIONS = 32

LONGEST_SILENCE = 45.0
"""s after which a client that sends nothing may lose its place to another one."""

RECEIVE_BUFFER = 1 << 22
"""Bytes asked of the system for datagrams that the reading thread has not taken yet; the system may give less."""

_NEVER_WAIT = getattr(socket, "MSG_DONTWAIT", 0)
_LINGER = 1.0  # s
_TRIES = 16  # ports that may be free for UDP and not for TCP

Source = tuple[str, int] | Connection | Remote
"""Source of a packet, to which replies go: a UDP address, a TCP client or a web socket's client."""


class Network:
    """The UDP socket and the TCP listener of a port, and the TCP clients. `close` it."""

    def __init__(self, host: str, port: int, trusted: Nets = ()) -> None:
        """Listen on a port, 0 for any free one. OSError if that fails. trusted: other hosts that get all replies."""
        self._replies_dropped = 0
        self._warned: Counter[str] = Counter()
        self._told = 0  # datagrams dropped, whose sender was told
        self._refused = 0  # datagrams that were taken, and had to be dropped
        self._refused_from: tuple[str, int] | None = None
        self._woken = False
        self._turns: deque[Connection | Remote] = deque()  # clients with packets that wait, each once
        self.left: list[Remote] = []
        """Web sockets' clients that have left, until somebody takes note."""
        self._stream_next = False  # datagrams and streams take turns
        self._connections: set[Connection] = set()
        self._paused: set[Connection | Remote] = set()
        self._lingering: dict[Connection, float] = {}  # their stream has ended: when replies to them end too
        self._allowance = Allowance(trusted)
        self._udp, self._listener = _bound(host, port)
        self.doorway = Doorway()
        self._intake = Intake(self._udp)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._intake.heard, selectors.EVENT_READ)
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._selector.register(self.doorway.heard, selectors.EVENT_READ)

    @property
    def address(self) -> tuple[str, int]:
        """Address at which it listens: host and port."""
        host, port = self._udp.getsockname()[:2]
        return str(host), int(port)

    @property
    def receive_buffer(self) -> int:
        """Size (bytes) of the system's buffer for datagrams that were not read yet."""
        size = self._udp.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
        return size // 2 if sys.platform == "linux" else size  # Linux doubles it for its own needs

    @property
    def connections(self) -> int:
        """Number of TCP clients that are connected and may still send."""
        return len(self._connections) - len(self._lingering)

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of datagrams that found no room here or in the system's buffer, and of replies that were dropped."""
        return {
            "dropped": self._intake.dropped + self._refused,
            "dropped_by_system": _dropped_by_system(self._udp),
            "replies_dropped": self._replies_dropped,
        }

    def receive(self, timeout: float, streams_only: bool = False) -> tuple[bytes, Source] | None:
        """Receive the next packet and its source, or None if none arrives within `timeout` seconds, or before `wake`.

        streams_only: leave datagrams where they are.
        """
        deadline = time.monotonic() + timeout
        wait = 0.0
        while True:
            self._gather(wait)
            if arrived := self._from_streams() if streams_only else self._next():
                return arrived
            wait = deadline - time.monotonic()
            if wait <= 0.0 or self._woken:
                self._woken = False
                return None

    def _next(self) -> tuple[bytes, Source] | None:
        self._stream_next = not self._stream_next
        if self._stream_next:
            return self._from_streams() or self._datagram()
        return self._datagram() or self._from_streams()

    def _datagram(self) -> tuple[bytes, Source] | None:
        """Return the next datagram, for which its sender may get replies."""
        arrived = self._intake.take()
        if arrived:
            self._allowance.hear(arrived[1][0], len(arrived[0]))
        return arrived

    def _from_streams(self) -> tuple[bytes, Source] | None:
        """Return a packet of the client whose turn it is: clients take turns, however much each has sent."""
        while self._turns:
            connection = self._turns.popleft()
            if connection in self._paused or not connection.arrived:
                continue
            packet = connection.arrived.popleft()
            if connection.arrived:
                self._turns.append(connection)
            elif connection in self._connections:
                self._watch(connection)
            if packet is not None:
                return packet, connection
            if isinstance(connection, Remote):
                connection.gone = True
                self.left.append(connection)
            else:
                self._part(connection)
        return None

    def wake(self) -> None:
        """Wake `receive`, which returns if nothing arrives before; any thread may ask for it."""
        self._woken = True
        self._intake.ring()

    def pause(self, source: Source) -> None:
        """Return no packet of a stream's client until `resume`: it waits, and loses nothing."""
        if isinstance(source, Connection | Remote):
            self._paused.add(source)

    def resume(self, source: Source) -> None:
        """Take back `pause`."""
        if isinstance(source, Connection | Remote) and source in self._paused:
            self._paused.remove(source)
            if source.arrived and source not in self._turns:
                self._turns.append(source)

    def drop(self, source: Source) -> None:
        """Count a datagram that was received, and is not carried out."""
        if isinstance(source, tuple):
            self._refused += 1
            self._refused_from = source

    def send(self, message: Message, to: Source) -> None:
        """Send a reply, or count it as dropped; OSError if its receiver is gone."""
        packet = _encoded(message)
        if not self.reaches(to):
            raise ConnectionResetError("the client has left")
        if isinstance(to, Connection):
            try:
                sent = to.send(packet)
            except OSError:
                self._deafen(to)
                raise
            self._watch(to)
        elif isinstance(to, Remote):
            sent = to.send(packet)
        elif sent := self._allowance.take(to[0], len(packet)):
            try:
                self._udp.sendto(packet, _NEVER_WAIT, to)
            except BlockingIOError:
                sent = False
        self._replies_dropped += not sent

    def reaches(self, source: Source) -> bool:
        """True if a source can still be answered, as far as is known."""
        if isinstance(source, Remote):
            return not source.gone
        return not isinstance(source, Connection) or (source in self._connections and not source.deaf)

    def forgets(self, source: Source) -> bool:
        """True if a source is told nothing more once it is silent: one that may have been forged."""
        return isinstance(source, tuple) and not self._allowance.trusts(source[0])

    def dropped(self) -> tuple[int, tuple[str, int]] | None:
        """Return how many datagrams found no room since the last call, and who sent the last one; None if none was
        lost."""
        new = self.counts["dropped"] - self._told
        self._told += new
        loser, self._refused_from = self._refused_from or self._intake.loser, None
        return (new, loser) if new else None

    def warnings(self) -> list[str]:
        """Return the texts about what was dropped since the last call."""
        new = Counter(self.counts) - self._warned
        self._warned += new
        texts = {
            "dropped": "{} datagrams dropped: the queue was full",
            "dropped_by_system": "{} datagrams lost: the system's receive buffer is too small, see `carom doctor`",
            "replies_dropped": "{} replies dropped: a client reads too slowly, or is on another host: see --trust",
        }
        return [texts[name].format(count) for name, count in new.items()]

    def close(self) -> None:
        """Disconnect all clients and close the sockets."""
        for connection in tuple(self._connections):
            self._leave(connection)
        self._selector.close()
        self._intake.close()
        self.doorway.close()
        self._udp.close()
        self._listener.close()

    def _gather(self, timeout: float) -> None:
        """Queue the packets that have arrived."""
        for connection in [each for each, until in self._lingering.items() if until <= time.monotonic()]:
            self._leave(connection)
        for key, events in self._selector.select(timeout):
            if key.fileobj is self._intake.heard:
                self._intake.hush()
            elif key.fileobj is self._listener:
                self._accept()
            elif key.fileobj is self.doorway.heard:
                self._turns += [each for each in dict.fromkeys(self.doorway.collect()) if each not in self._turns]
            else:
                self._attend(key.data, events)

    def _accept(self) -> None:
        with suppress(OSError):  # the client has left already
            connection = Connection(self._listener.accept()[0])
            self._connections.add(connection)
            self._watch(connection)
            if len(self._connections) > MOST_CONNECTIONS:
                self._make_room()
            if len(self._connections) > MOST_CONNECTIONS:
                connection.wrong = f"{MOST_CONNECTIONS} clients are connected already: expected one to leave first"
                self._part(connection)

    def _make_room(self) -> None:
        """Disconnect a client whose stream has ended, or the one that has been silent for longest, if for long."""
        if self._lingering:
            self._leave(next(iter(self._lingering)))
            return
        silent = min(self._connections, key=lambda connection: connection.heard_at)
        if time.monotonic() - silent.heard_at > LONGEST_SILENCE:
            silent.wrong = f"silent for {LONGEST_SILENCE:g} s, and another client needs the place"
            self._part(silent)

    def _attend(self, connection: Connection, events: int) -> None:
        if events & selectors.EVENT_WRITE:
            try:
                connection.flush()
            except OSError:
                self._deafen(connection)
        if connection not in self._connections:
            return
        try:
            if events & selectors.EVENT_READ:
                for packet in connection.packets():
                    self._enqueue(packet, connection)
                if connection.over:
                    self._enqueue(None, connection)
            self._watch(connection)
        except OSError:
            self._leave(connection)

    def _enqueue(self, packet: bytes | None, connection: Connection) -> None:
        if not connection.arrived:
            self._turns.append(connection)
        connection.arrived.append(packet)

    def _watch(self, connection: Connection) -> None:
        """Watch a client for reading once all that it sent is carried out, and for writing while replies wait.

        TCP makes it wait meanwhile, and loses nothing.
        """
        reads = not (connection.over or connection.arrived)
        wanted = selectors.EVENT_READ * reads | selectors.EVENT_WRITE * connection.waiting
        key = self._selector.get_map().get(connection.socket)
        if key and not wanted:
            self._selector.unregister(connection.socket)
        elif key and key.events != wanted:
            self._selector.modify(connection.socket, wanted, connection)
        elif wanted and not key:
            self._selector.register(connection.socket, wanted, connection)

    def _part(self, connection: Connection) -> None:
        """Disconnect a client whose stream has ended, after all its packets were carried out."""
        if not connection.wrong and self.reaches(connection):
            self._lingering[connection] = time.monotonic() + _LINGER  # it may still read replies
        reason = connection.wrong or connection.cut
        if reason and self.reaches(connection):
            with suppress(OSError):
                self.send(Message("/fail", ("stream", reason)), connection)
        if connection in self._lingering:
            return
        self._leave(connection)

    def _deafen(self, connection: Connection) -> None:
        """Send nothing more to a client that takes nothing more; what it sent before is carried out."""
        connection.deafen()
        if connection in self._lingering:
            self._leave(connection)
        else:
            self._watch(connection)

    def _leave(self, connection: Connection) -> None:
        if connection in self._connections:
            self._connections.remove(connection)
            self._lingering.pop(connection, None)
            with suppress(KeyError):
                self._selector.unregister(connection.socket)
            connection.close()


def _encoded(message: Message) -> bytes:
    texts = tuple(arg for arg in message.args if isinstance(arg, str))
    return (_encoded_texts if texts == message.args else encode)(message.address, *message.args)


@lru_cache(maxsize=16)  # of equal messages in a bundle each is refused with the same words
def _encoded_texts(address: str, *texts: str) -> bytes:
    return encode(address, *texts)


def _bound(host: str, port: int) -> tuple[socket.socket, socket.socket]:
    """Return A UDP socket and a TCP listener on the same port."""
    for attempt in range(_TRIES):
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
            udp.bind((host, port))
            return udp, listen(host, udp.getsockname()[1])
        except OSError:
            udp.close()
            if port or attempt == _TRIES - 1:
                raise
    raise AssertionError


def _dropped_by_system(udp: socket.socket) -> int:
    """Return the datagrams that found no room in the system's buffer, where the system tells (Linux)."""
    memory_info, drops = 55, 8  # SO_MEMINFO, and where in its nine uint32 the drops stand
    if sys.platform != "linux":
        return 0
    with suppress(OSError):
        return int.from_bytes(udp.getsockopt(socket.SOL_SOCKET, memory_info, 36)[4 * drops :], sys.byteorder)
    return 0
