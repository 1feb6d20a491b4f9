"""OSC over TCP: a listener on the server's port, and clients that each speak SLIP or sized packets."""

import socket
import sys
from collections.abc import Iterator
from contextlib import suppress

from ..osc.framing import Broken, Framing, Slip, framing

_PIECE = 1 << 16  # bytes read at a time
_MOST_WAITING = 1 << 20  # bytes of replies kept for a client that reads slowly


class Connection:
    """A client: packets cut from its stream, and replies kept until it takes them. Nothing here waits."""

    def __init__(self, sock: socket.socket) -> None:
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket = sock
        self.queued = 0
        """Packets of its that wait to be carried out."""
        self.over = False
        """Is its stream at an end?"""
        self.wrong: str | None = None
        """What ended the stream, if it was not the client."""
        self._framing: Framing | None = None
        self._unsent = bytearray()

    def packets(self) -> Iterator[bytes]:
        """What has arrived, up to the end of the stream or of its sense; OSError when the client is gone."""
        try:
            data = self.socket.recv(_PIECE)
        except BlockingIOError:
            return
        if not data:
            self.over = True
            return
        try:
            if self._framing is None:
                self._framing = framing(data[0])
            yield from self._framing.packets(data)
        except Broken as error:
            self.wrong = str(error)
            self.over = True

    def close(self) -> None:
        # What is left unread when a socket is closed would make the system take back what was sent on it.
        with suppress(OSError):
            for _ in range(_MOST_WAITING // _PIECE):
                if not self.socket.recv(_PIECE):
                    break
        self.socket.close()

    def send(self, packet: bytes) -> bool:
        """Send a packet, as soon as the client takes it; False if it takes too little, and this is left out."""
        packet = (self._framing or Slip).framed(packet)
        if len(self._unsent) + len(packet) > _MOST_WAITING:
            return False
        self._unsent += packet
        self.flush()
        return True

    def flush(self) -> None:
        """Send what the client takes now; OSError when it is gone."""
        try:
            while self._unsent:
                del self._unsent[: self.socket.send(self._unsent)]
        except BlockingIOError:
            pass

    @property
    def waiting(self) -> bool:
        """Are there replies that the client has not taken?"""
        return bool(self._unsent)


def listen(host: str, port: int) -> socket.socket:
    """A socket that awaits clients; OSError where the port is taken."""
    sock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        # Connections of a server before this one linger for a minute and hold its port. Windows has no such need, and
        # means another thing by the word: that two may listen at once.
        if sys.platform != "win32":
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        sock.bind((host, port))
        sock.listen()
        sock.setblocking(False)
    except OSError:
        sock.close()
        raise
    return sock
