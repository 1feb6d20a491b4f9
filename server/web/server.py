"""The web server: an event loop in a thread of its own, with aiohttp's HTTP and web sockets.

aiohttp is the one well-kept package that has both HTTP/1.1 and web sockets, with bounds on heads, bodies and frames,
and with heartbeats; `websockets` has no HTTP but the handshake, and uvicorn would bring a second package for each.
"""

import asyncio
import logging
import socket
import ssl
import threading
from collections.abc import Coroutine, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np
from aiohttp import web
from numpy.typing import NDArray

from ...dsp.runtime.engine import Engine
from ..audio.tap import Tap
from ..net.places import Complaint
from .bounded import BoundedServer
from .site import Site
from .socket import sound_packet

_LONGEST_HEAD = 8_190  # bytes of a line, and of a header
_KEEPALIVE = 8.0  # s
_NOBODY = logging.Logger("nobody", logging.CRITICAL + 1)  # for what aiohttp says of requests that are none
_PATIENCE = 3.0  # s for the loop to begin, and to end


class WebServer:
    """Serves a site on a host and a port, 0 being any that is free, from `start` until `close`."""

    def __init__(self, site: Site, host: str, port: int, tls: ssl.SSLContext | None = None) -> None:
        self.site = site
        self.host, self.port = host, port
        self.scheme = "https" if tls else "http"
        self._tls = tls
        self._loop = asyncio.SelectorEventLoop()  # on Windows the usual one has no readers
        complaint = Complaint()
        self._loop.set_exception_handler(lambda loop, told: complaint.say(f"a fault of the web server: {_fault(told)}"))
        self._runner: web.ServerRunner | None = None
        self._thread = threading.Thread(target=self._run, name="carom-web", daemon=True)

    def start(self) -> None:
        """Listen. OSError if the port is taken."""
        self._thread.start()
        self._do(self._open())

    @property
    def address(self) -> str:
        """The address to open, with the token where one is needed."""
        host = _own_address() if self.host in ("0.0.0.0", "") else self.host
        token = f"?token={self.site.guard.token}" if self.site.guard.token else ""
        return f"{self.scheme}://{host}:{self.port}/{token}"

    def hear(self, engine: Engine, tap: Tap) -> None:
        """Send the sound to the clients that want to hear it."""
        rate, channels = round(engine.rate), engine.channels

        def hand_on(first: int, sound: NDArray[np.float32]) -> bool:
            heard = any(client.sound_on for client in tuple(self.site.clients))
            if heard:
                left = np.nan_to_num(np.clip(sound[:, :channels], -1.0, 1.0))  # a device plays it there
                packet = sound_packet(first, rate, channels, left.astype("<f4", copy=False).tobytes())
                self._loop.call_soon_threadsafe(self.site.play, packet, len(sound) / rate)
            return heard

        tap.add(hand_on)

    async def _open(self) -> None:
        self._server = BoundedServer(
            self.site.answer, self._tls, keepalive_timeout=_KEEPALIVE, max_line_size=_LONGEST_HEAD,
            max_field_size=_LONGEST_HEAD, access_log=None, logger=_NOBODY, lingering_time=1.0,
        )  # fmt: skip
        self._runner = web.ServerRunner(self._server, shutdown_timeout=1.0)
        await self._runner.setup()
        self.port = self._server.listen(self.host, self.port)

    async def _close(self) -> None:
        await self._server.end()
        for client in tuple(self.site.clients):
            await client.close()
        if self._runner:
            await self._runner.cleanup()

    def _do(self, work: Coroutine[Any, Any, None]) -> None:
        asyncio.run_coroutine_threadsafe(work, self._loop).result(_PATIENCE)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_forever()

    def close(self) -> None:
        """Notify all clients that it ends, and end."""
        if self._runner:
            with suppress(TimeoutError):  # a client may not take leave
                self._do(self._close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(_PATIENCE)
        if not self._thread.is_alive():
            self._loop.close()


def _fault(told: dict[str, Any]) -> str:
    """Return what asyncio reports of a fault, in a line."""
    return " ".join(f"{told.get('message', '')} {told.get('exception', '')!r}".split())


def _own_address() -> str:
    """Return the address by which other machines reach this one, as far as the system's routes show."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # sends nothing
        except OSError:
            return "127.0.0.1"
        return str(probe.getsockname()[0])


@contextmanager
def answering(server: WebServer) -> Iterator[None]:
    """Serve while inside."""
    try:
        server.start()
        yield
    finally:
        server.close()
