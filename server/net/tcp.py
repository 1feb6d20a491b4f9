"""OSC over TCP: a listener on the server's port, and clients that each speak SLIP or sized packets."""

import math
import socket
import sys
import time
from collections import deque
from collections.abc import Iterator
from contextlib import suppress

from ..osc.framing import UNFRAMED, Broken, Framing, Slip, framing

_PIECE = 1 << 14  # bytes read at a time: as packets, short ones take up to 20 times that in memory
_MOST_WAITING = 1 << 18  # bytes of replies kept for a client that reads slowly
_PATIENCE = 0.5  # s: within it the END of a first packet comes
_BACKLOG = 4_096  # connections that wait to be accepted; the system may allow fewer


class Connection:
    """A client: packets cut from its stream, and replies kept until it takes them. No method blocks."""

    def __init__(self, sock: socket.socket, host: str = "") -> None:
        """Begin with a socket that a host has connected. OSError if it is gone already."""
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        _keep_alive(sock)
        self.socket, self.host = sock, host
        self.queued = False
        """True while it waits for its turn."""
        self.arrived: deque[bytes | None] = deque()
        """Packets that wait to be carried out; None: the end of the stream."""
        self.heard_at = time.monotonic()
        """Time at which the client last sent something, or connected."""
        self.over = False
        """True once its stream has ended."""
        self.wrong: str | None = None
        """Reason for which the server ended the stream, or None."""
        self.cut = ""
        """Words about a packet amid which the stream ended; empty if there is none."""
        self.deaf = False
        """True once it takes no more replies, as a client that closed its socket; the system has what it sent."""
        self._framing: Framing | None = None
        self.patience_ends = math.inf
        """Time at which the END of its first packet should have come."""
        self._unsent = bytearray()

    def packets(self) -> Iterator[bytes]:
        """Yield the packets that have arrived, up to the stream's end or first fault. OSError when the client is
        gone."""
        try:
            data = self.socket.recv(_PIECE)
        except BlockingIOError:
            return
        self.heard_at = time.monotonic()
        if not data:
            if self._framing and self._framing.rest:
                self.cut = f"it ended amid a packet, {len(self._framing.rest)} bytes: expected {self._framing.last}"
            self.over = True
            return
        try:
            if self._framing is None:
                self._framing, self.patience_ends = framing(data[0]), self.heard_at + _PATIENCE
            yield from self._framing.packets(data)
        except Broken as error:
            self.wrong = str(error)
            self.over = True

    @property
    def is_unended(self) -> bool:
        """True while no END has come, of a stream that seems to have them."""
        return isinstance(self._framing, Slip) and not (self._framing.ended or self.over)

    def is_unframed(self) -> bool:
        """True if what it sent is packets without framing: then its stream is over."""
        if not isinstance(self._framing, Slip) or not self._framing.is_unframed:
            return False
        self.wrong, self.over = UNFRAMED, True
        return True

    def close(self) -> None:
        """Close the socket."""
        # If data is left unread, the system drops replies that are still on their way.
        with suppress(OSError):
            for _ in range(_MOST_WAITING // _PIECE):
                if not self.socket.recv(_PIECE):
                    break
        self.socket.close()

    def send(self, packet: bytes) -> bool:
        """Send a packet as soon as the client takes it; return False, and drops it, if too much waits already."""
        packet = (self._framing or Slip).framed(packet)
        if len(self._unsent) + len(packet) > _MOST_WAITING:
            return False
        self._unsent += packet
        self.flush()
        return True

    def flush(self) -> None:
        """Send as much as the client takes now. OSError when it is gone."""
        try:
            while self._unsent:
                del self._unsent[: self.socket.send(self._unsent)]
        except BlockingIOError:
            pass

    def deafen(self) -> None:
        """Forget the replies that it did not take, and take none from now on."""
        self.deaf = True
        self._unsent.clear()

    @property
    def has_spoken(self) -> bool:
        """True if it has sent anything."""
        return self._framing is not None

    @property
    def waiting(self) -> bool:
        """True if replies wait for the client to take them."""
        return bool(self._unsent)


def _keep_alive(sock: socket.socket) -> None:
    """Make the system ask a silent client whether it is still there; one that is not is gone within a minute."""
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for option, value in (("TCP_KEEPIDLE", 20), ("TCP_KEEPINTVL", 10), ("TCP_KEEPCNT", 3)):  # s, s, questions
        if hasattr(socket, option):
            sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens for clients. OSError if the port is taken."""
    sock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        # Connections of an earlier server linger for a minute and hold the port. On Windows they do not, and there the
        # option has another meaning: that two may listen at once.
        if sys.platform != "win32":
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        sock.bind((host, port))
        sock.listen(_BACKLOG)
        sock.setblocking(False)
    except OSError:
        sock.close()
        raise
    return sock


def turn_away(sock: socket.socket, farewell: bytes) -> None:
    """Send a newcomer for whom there is no place a packet, and close: fast, as thousands may come."""
    with suppress(OSError):
        sock.setblocking(False)
        sock.send(Slip.framed(farewell))
        sock.recv(_PIECE)  # what is left unread would drop the reply on its way
    sock.close()
