"""The way in and out: UDP and TCP on one port, a bounded queue of what has arrived, replies that never wait.

One thread does it all. It empties the system's buffers before it looks at the next packet, so that a burst waits here,
where it is counted, and not there, where it is lost.
"""

import selectors
import socket
import sys
import time
from collections import Counter, deque
from contextlib import suppress

from .allowance import Allowance
from .osc import MAX_DATAGRAM, Message, encode
from .tcp import Connection, listen

MOST_DATAGRAMS = 16_384
"""Datagrams that can wait to be carried out."""
MOST_BYTES = 1 << 24
"""Bytes of such."""
MOST_CONNECTIONS = 32

RECEIVE_BUFFER = 1 << 22
"""Bytes asked of the system for datagrams that come while one is carried out: some 10,000. It gives what it permits."""

_AT_ONCE = 1_024  # datagrams read before one is carried out, so that a flood can't keep all from being so
_TOLD = 64  # sources that are told at a time what they lost
_TRIES = 16  # ports that may be free for UDP and not for TCP

Source = tuple[str, int] | Connection
"""Where a packet came from and its replies go: a UDP address or a TCP client."""


class Network:
    """The sockets of a port, and the clients of one of them. `close` it."""

    def __init__(self, host: str, port: int) -> None:
        """Listen on a port, 0 being any that is free; OSError if it can't be."""
        self.counts = Counter(dropped=0, dropped_by_system=0, replies_dropped=0)
        """What was left out: datagrams for want of room here, or in the system's buffer, and replies."""
        self._warned = Counter(self.counts)
        self._dropped_of: Counter[tuple[str, int]] = Counter()
        self._queue: deque[tuple[bytes | None, Source]] = deque()  # None: the end of a stream
        self._datagrams = 0
        self._bytes = 0
        self._connections: set[Connection] = set()
        self._allowance = Allowance()
        self._selector = selectors.DefaultSelector()
        self._udp, self._listener = _bound(host, port)
        self._selector.register(self._udp, selectors.EVENT_READ)
        self._selector.register(self._listener, selectors.EVENT_READ)

    @property
    def address(self) -> tuple[str, int]:
        """Where it listens: host and port."""
        return self._udp.getsockname()[:2]

    @property
    def receive_buffer(self) -> int:
        """Bytes that the system keeps of datagrams that were not read yet."""
        size = self._udp.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
        return size // 2 if sys.platform == "linux" else size  # Linux counts its own needs in

    @property
    def connections(self) -> int:
        """TCP clients that are there."""
        return len(self._connections)

    def receive(self, timeout: float) -> tuple[bytes, Source] | None:
        """The next packet and its source, or None if none comes for so long (s)."""
        deadline = time.monotonic() + timeout
        while True:
            self._gather(0.0 if self._queue else max(0.0, deadline - time.monotonic()))
            while self._queue:
                packet, source = self._dequeue()
                if packet is not None:
                    return packet, source
            if time.monotonic() >= deadline:
                return None

    def _dequeue(self) -> tuple[bytes | None, Source]:
        packet, source = self._queue.popleft()
        if not isinstance(source, Connection):
            self._datagrams -= 1
            self._bytes -= len(packet or b"")
            return packet, source
        source.queued -= 1
        if packet is None:
            self._part(source)
        return packet, source

    def send(self, message: Message, to: Source) -> None:
        """Send a reply, or count it as dropped; OSError if its receiver is gone."""
        packet = encode(message.address, *message.args)
        if isinstance(to, Connection):
            if not self.reaches(to):
                raise ConnectionResetError("the client has left")
            try:
                sent = to.send(packet)
            except OSError:
                self._leave(to)
                raise
            self._watch(to)
        elif sent := self._allowance.take(to[0]):
            try:
                self._udp.sendto(packet, to)
            except BlockingIOError:
                sent = False
        self.counts["replies_dropped"] += not sent

    def reaches(self, source: Source) -> bool:
        """Can it be answered still, as far as is known?"""
        return not isinstance(source, Connection) or source in self._connections

    def dropped(self) -> list[tuple[tuple[str, int], int]]:
        """Who lost how many datagrams for want of room here, since the last call."""
        told = list(self._dropped_of.items())
        self._dropped_of.clear()
        return told

    def warnings(self) -> list[str]:
        """What was left out since the last call, a line each."""
        self.counts["dropped_by_system"] = _dropped_by_system(self._udp)
        lines = []
        for name, text in (
            ("dropped", "{} datagrams left out: they came faster than they could be carried out"),
            ("dropped_by_system", "{} datagrams lost: the system's receive buffer is too small, see carom doctor"),
            ("replies_dropped", "{} replies left out: they were not taken, or too many for a host elsewhere"),
        ):
            if more := self.counts[name] - self._warned[name]:
                lines.append(text.format(more))
        self._warned = Counter(self.counts)
        return lines

    def close(self) -> None:
        for connection in tuple(self._connections):
            self._leave(connection)
        self._selector.close()
        self._udp.close()
        self._listener.close()

    def _gather(self, timeout: float) -> None:
        """Take what has arrived off the system's hands."""
        for key, events in self._selector.select(timeout):
            if key.fileobj is self._udp:
                self._read_datagrams()
            elif key.fileobj is self._listener:
                self._accept()
            else:
                self._attend(key.data, events)

    def _read_datagrams(self) -> None:
        for _ in range(_AT_ONCE):
            try:
                packet, source = self._udp.recvfrom(MAX_DATAGRAM)
            except BlockingIOError:
                break
            except ConnectionError:
                continue  # a client is gone that was sent a reply
            if self._datagrams < MOST_DATAGRAMS and self._bytes < MOST_BYTES:
                self._queue.append((packet, source))
                self._datagrams += 1
                self._bytes += len(packet)
            else:
                self.counts["dropped"] += 1
                if source in self._dropped_of or len(self._dropped_of) < _TOLD:
                    self._dropped_of[source] += 1

    def _accept(self) -> None:
        with suppress(OSError):  # it has left already
            connection = Connection(self._listener.accept()[0])
            self._connections.add(connection)
            self._watch(connection)
            if len(self._connections) > MOST_CONNECTIONS:
                connection.wrong = f"{MOST_CONNECTIONS} clients are connected already: expected one to leave first"
                self._part(connection)

    def _attend(self, connection: Connection, events: int) -> None:
        try:
            if events & selectors.EVENT_WRITE:
                connection.flush()
            # TCP makes a client wait, and loses nothing: none is given more room than for what it sent at one time.
            if events & selectors.EVENT_READ and not connection.queued:
                for packet in connection.packets():
                    self._enqueue(packet, connection)
                if connection.over:
                    self._enqueue(None, connection)
            self._watch(connection)
        except OSError:
            self._leave(connection)

    def _enqueue(self, packet: bytes | None, connection: Connection) -> None:
        self._queue.append((packet, connection))
        connection.queued += 1

    def _watch(self, connection: Connection) -> None:
        """Have the selector tell what matters of a client now."""
        wanted = selectors.EVENT_READ * (not connection.over) | selectors.EVENT_WRITE * connection.waiting
        key = self._selector.get_map().get(connection.socket)
        if key and not wanted:
            self._selector.unregister(connection.socket)
        elif key and key.events != wanted:
            self._selector.modify(connection.socket, wanted, connection)
        elif wanted and not key:
            self._selector.register(connection.socket, wanted, connection)

    def _part(self, connection: Connection) -> None:
        """Let a client go whose stream has ended, now that all in it was carried out."""
        if connection.wrong and self.reaches(connection):
            with suppress(OSError):
                self.send(Message("/fail", ("stream", connection.wrong)), connection)
        self._leave(connection)

    def _leave(self, connection: Connection) -> None:
        if connection in self._connections:
            self._connections.remove(connection)
            with suppress(KeyError):
                self._selector.unregister(connection.socket)
            connection.close()


def _bound(host: str, port: int) -> tuple[socket.socket, socket.socket]:
    """A UDP socket and a TCP listener on the same port."""
    for attempt in range(_TRIES):
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
            udp.setblocking(False)
            udp.bind((host, port))
            return udp, listen(host, udp.getsockname()[1])
        except OSError:
            udp.close()
            if port or attempt == _TRIES - 1:
                raise
    raise AssertionError


def _dropped_by_system(udp: socket.socket) -> int:
    """Datagrams that found no room in the system's buffer, where it tells (Linux)."""
    memory_info, drops = 55, 8  # SO_MEMINFO, and where in its nine uint32 the drops stand
    if sys.platform != "linux":
        return 0
    with suppress(OSError):
        return int.from_bytes(udp.getsockopt(socket.SOL_SOCKET, memory_info, 36)[4 * drops :], sys.byteorder)
    return 0
