"""Clients whose packets another thread receives and sends: those of web sockets."""

import socket
from collections import deque
from collections.abc import Callable
from contextlib import suppress


class Remote:
    """A client of another thread. `deliver` gives it a packet, never waits, and returns False where it drops it."""

    def __init__(self, deliver: Callable[[bytes], bool], host: str = "", stranger: bool = False) -> None:
        """Begin. host: where it is; empty: this process. stranger: it is elsewhere, and has shown no token."""
        self.host, self.stranger = host, stranger
        self.queued = False
        """True while it waits for its turn."""
        self.arrived: deque[bytes | None] = deque()
        """Packets that wait to be carried out; None: the client has left."""
        self.gone = False
        self.send = deliver


class Doorway:
    """A doorway at which other threads hand in packets of their clients. `heard` is a socket that can be read when one
    waits."""

    def __init__(self) -> None:
        self.heard, self._bell = socket.socketpair()
        self.heard.setblocking(False)
        self._bell.setblocking(False)
        self._fresh: deque[Remote] = deque()

    def hand_in(self, client: Remote, packet: bytes | None) -> None:
        """Queue a packet, or None when the client leaves; any thread may."""
        client.arrived.append(packet)
        self._fresh.append(client)
        with suppress(OSError):  # full: then it rings already; closed: nobody listens any more
            self._bell.send(b"\0")

    def collect(self) -> list[Remote]:
        """Return the clients that have handed in a packet since the last call."""
        with suppress(BlockingIOError):
            self.heard.recv(4096)
        return [self._fresh.popleft() for _ in range(len(self._fresh))]

    def close(self) -> None:
        """Hear nothing more."""
        self.heard.close()
        self._bell.close()
