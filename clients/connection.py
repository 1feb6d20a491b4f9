"""A socket to a Carom server, UDP or TCP: packets out, messages in."""

import select
import socket
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from ..server.osc import wire
from ..server.osc.framing import Framing, Sized, framing

_PATIENCE = 5.0  # s that a server may take to accept what is sent over TCP


class Connection:
    """A socket to one server. ConnectionRefusedError, here and later, if the host says that nothing listens."""

    def __init__(self, host: str, port: int, tcp: bool) -> None:
        self.server = f"{host}:{port}"
        self.on_compiling: Callable[[float, float], object] = lambda share, seconds: None
        """Function called while a server compiles its engine: with the share that is done, and the seconds that are
        left."""
        self._tcp = tcp
        self._stream: Framing | None = None  # of the server, which answers as it is spoken to, once it was
        self._ended = ""  # reason for which a TCP server ends the stream
        self._inbox: deque[wire.Message] = deque()  # read from the socket, but not requested yet
        if tcp:
            with self._reaching(), self._finding():
                self._socket = socket.create_connection((host, port), _PATIENCE)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        else:
            self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            try:
                with self._finding():
                    self._socket.connect((host, port))
            except OSError:
                self._socket.close()
                raise

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def transmit(self, packet: bytes) -> None:
        """Send a packet; over TCP, wait until the system has taken it."""
        with self._reaching():
            try:
                self._socket.sendall(Sized.framed(packet) if self._tcp else packet)
            except (BrokenPipeError, ConnectionResetError):
                while self._receive(0.0):  # its last messages, up to the end, which raises
                    pass
                raise

    def messages(self, seconds: float) -> Iterator[wire.Message]:
        """Yield the messages that arrive within some seconds, as they come. One that is not taken stays for the next
        call.

        Raises ConnectionResetError when a TCP server closes the connection.
        """
        deadline = time.monotonic() + seconds
        while self._inbox or self._receive(max(0.0, deadline - time.monotonic())):
            while self._inbox:
                message = self._inbox.popleft()
                if message.address == "/compiling":
                    deadline = time.monotonic() + seconds
                    share, left = (float(each) if isinstance(each, int | float) else 0.0 for each in message.args)
                    self.on_compiling(share, left)
                else:
                    yield message

    def _receive(self, seconds: float) -> bool:
        """Read the socket once; return False if nothing arrives within some seconds."""
        if not select.select([self._socket], [], [], seconds)[0]:
            return False
        with self._reaching():
            try:
                data = self._socket.recv(wire.MAX_DATAGRAM)
            except ConnectionResetError:
                if not self._tcp:
                    raise
                data = b""
        for packet in self._packets(data) if self._tcp else [data]:
            for message in (each for bundle in wire.parse(packet) for each in bundle.messages):
                if self._tcp and message.address == "/fail" and message.args[:1] == ("stream",):
                    self._ended = ": " + " ".join(map(str, message.args[1:]))
                else:
                    self._inbox.append(message)
        return True

    def _packets(self, data: bytes) -> Iterable[bytes]:
        """Return the packets of a TCP server that are whole once `data` has come."""
        if not data:
            raise ConnectionResetError(f"{self.server} has closed the connection{self._ended}")
        self._stream = self._stream or framing(data[0])
        return self._stream.packets(data)

    @contextmanager
    def _finding(self) -> Iterator[None]:
        """Name the server in a gaierror inside, as for a host that has no address."""
        try:
            yield
        except socket.gaierror as error:
            raise socket.gaierror(error.errno, error.strerror, self.server) from error

    @contextmanager
    def _reaching(self) -> Iterator[None]:
        """Name the server in a ConnectionRefusedError inside."""
        try:
            yield
        except ConnectionRefusedError as error:
            raise ConnectionRefusedError(
                f"nothing listens at {self.server}: expected a running `carom serve`"
            ) from error
