"""A server that is attacked from hosts of its own, and how others fare meanwhile: what they wait, and what it takes."""

import re
import socket
import ssl
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from carom.server.osc import wire
from carom.server.osc.framing import Slip
from tests.support import Running, serving

from . import Tried, hosts

MEDIAN, WORST, ANSWER = 0.05, 0.5, 0.5
"""s: bounds of a blow's way by datagram, and of an answer over TCP."""
_MOST_MEMORY = 50.0  # MB more than before
_HOST = "127.0.0.1"


@dataclass
class Attacked:
    """A server, and the times (s) that a well-behaved client waited."""

    server: Running
    page: int
    token: str
    """What is asked of the page ends with it."""
    blows: list[float] = field(default_factory=list)
    streams: list[float] = field(default_factory=list)
    pages: list[float] = field(default_factory=list)
    memory: float = 0.0

    @property
    def address(self) -> tuple[str, int]:
        return _HOST, self.server.port

    def measure_blow(self) -> None:
        """Send a blow by datagram from a new port; it is refused, so that its answer says when it had its turn."""
        with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as sock:
            sock.settimeout(5.0)
            begun = time.monotonic()
            sock.sendto(wire.encode("/object/nothing/impact", 1.0), self.address)
            self.blows.append(self._took(begun, lambda: sock.recv(2_000)))

    def measure_stream(self) -> None:
        """Ask over TCP."""
        begun = time.monotonic()

        def ask() -> None:
            with socket.create_connection(self.address, 5.0) as sock:
                sock.sendall(Slip.framed(wire.encode("/version")))
                if not sock.recv(2_000):
                    raise ConnectionError("no answer")

        self.streams.append(self._took(begun, ask))

    def measure_page(self) -> None:
        """Ask over HTTPS."""
        begun = time.monotonic()

        def ask() -> None:
            with socket.create_connection((_HOST, self.page), 5.0) as sock, anybody().wrap_socket(sock) as tls:
                tls.sendall(
                    b"GET /panic" + self.token.encode() + b" HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"
                )
                if b" 200 " not in tls.recv(2_000):
                    raise ConnectionError("no answer")

        self.pages.append(self._took(begun, ask))

    def _took(self, begun: float, ask: Callable[[], object]) -> float:
        """Return how long a question took, but for what the server and who asks waited for a processor that others had;
        60 s where it got no answer."""
        waited, own = self._waits(), _own_wait()
        try:
            ask()
        except OSError as error:
            print(f"no answer after {time.monotonic() - begun:.3f} s: {error!r}", file=sys.stderr)
            return 60.0
        took = time.monotonic() - begun
        server = max((now - waited.get(thread, now) for thread, now in self._waits().items()), default=0.0)
        return max(0.0, took - server - (_own_wait() - own))

    def _waits(self) -> dict[str, float]:
        """Return how long (s) each thread of the server has waited for a processor, where the system tells."""
        found = {}
        for thread in Path(f"/proc/{self.server.process.pid}/task").glob("*/schedstat"):
            with suppress(OSError):  # it has ended
                found[thread.parent.name] = 1e-9 * int(thread.read_text().split()[1])
        return found

    @property
    def resident(self) -> float:
        """Memory (MB) that the server's process takes."""
        text = Path(f"/proc/{self.server.process.pid}/status").read_text()
        return int(text.partition("VmRSS:")[2].split()[0]) / 1e3

    def tried(self, what: str) -> Tried:
        """Return what was tried, and what was worse than promised."""
        faults = tuple(self.faults(what))
        return Tried(fine=len(self.blows) + len(self.streams) + len(self.pages) - len(faults), faults=faults)

    def faults(self, what: str) -> list[str]:
        """Return what was worse than promised."""
        found = []
        if self.server.process.poll() is not None:
            found.append(f"{what}: the server has ended: {self.server.process.returncode}")
            return found
        if self.blows and (statistics.median(self.blows) > MEDIAN or max(self.blows) > WORST):
            found.append(f"{what}: a blow took {statistics.median(self.blows):.3f} s, {max(self.blows):.3f} at worst")
        for name, took in (("OSC over TCP", self.streams), ("the page", self.pages)):
            if took and max(took) > ANSWER:
                found.append(
                    f"{what}: {name} took {max(took):.3f} s of {len(took)}, {statistics.median(took):.3f} mostly"
                )
        if (grown := self.resident - self.memory) > _MOST_MEMORY:
            found.append(f"{what}: {grown:.0f} MB more than before")
        return found

    def begin(self) -> None:
        """Forget what was measured."""
        self.blows, self.streams, self.pages = [], [], []


def _own_wait() -> float:
    """Return how long (s) this thread has waited for a processor, where the system tells."""
    with suppress(OSError):
        return 1e-9 * int(Path("/proc/thread-self/schedstat").read_text().split()[1])
    return 0.0


@cache
def anybody() -> ssl.SSLContext:
    """Return a client's side of TLS that takes any certificate."""
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context


@contextmanager
def attacked() -> Iterator[Attacked]:
    """Yield a server with a page over TLS and a few objects."""
    with tempfile.TemporaryDirectory() as folder:
        bound = () if hosts.attacking is hosts.ON_LOOPBACK else ("--bind", "0.0.0.0")
        options = "--device", "none", "--page", "0", "--tls", *bound
        with serving(Path(folder), *options) as server:
            assert server.process.stdout
            page, token = re.findall(r":(\d+)/(\S*)", server.process.stdout.readline())[0]
            with server.client() as client:
                for n, preset in enumerate(("gong", "church-bell", "steel-plate", "wood-block")):
                    client.ask("/object/new", f"o{n}", preset, timeout=30.0)
            found = Attacked(server, int(page), token)
            for _ in range(5):
                found.measure_blow()
                found.measure_stream()
                found.measure_page()
            found.begin()
            found.memory = found.resident
            yield found
            _, errors = server.quit()
            lines = errors.count("\n")
            assert lines <= 3, f"{lines} lines on stderr: {errors[:2_000]}"
