"""HTTP connections, bounded from the moment they are accepted: how many there are, and how long one may take to ask.

aiohttp bounds headers, bodies and frames; it waits for ever for the end of a request's head. asyncio reports a
connection over TLS only after its handshake, for which it takes memory and a ms, and tries a failed accept again all
the time, with a traceback. So connections are accepted here, and get to asyncio once they have sent something.
"""

import asyncio
import gc
import logging
import socket
import ssl
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

from aiohttp import web

from ..net.places import PAUSE, Complaint, NoDescriptorError, Places, accepted, most_places
from ..net.rotation import Rotation
from ..net.tcp import listen

MOST_CONNECTIONS, MOST_OF_HOST = 128, 96
_SHARE = 2 / 3  # of the descriptors
_HANDSHAKE = 5.0  # s for the first byte, and over TLS for the handshake
_SPEAKING = 10.0  # s for a request to be sent, and between requests
_LOOK = 0.25  # s
_MOST_FAILED = 100  # handshakes that may fail before what they took, some 100 kB each in circles, is given back


class _Visitor:
    """A connection: its socket until it has sent something, then the task that opens it, then its protocol."""

    def __init__(self, sock: socket.socket, host: str) -> None:
        self.socket, self.host = sock, host
        self.opening: asyncio.Task[None] | None = None
        self.protocol: Any = None
        self.quiet_since = time.monotonic()

    def abort(self, loop: asyncio.AbstractEventLoop) -> None:
        """Close it at once, however far it is."""
        if self.protocol and self.protocol.transport:
            self.protocol.transport.abort()
        elif self.opening:
            self.opening.cancel()
        else:
            loop.remove_reader(self.socket)
            self.socket.close()


class BoundedServer(web.Server):
    """aiohttp's server, which closes connections that are open and ask for nothing: after a while, and at once where a
    new one needs the place. New ones are closed where there is no place for them. `end` it."""

    def __init__(
        self, handler: Callable[[web.BaseRequest], Awaitable[web.StreamResponse]], tls: ssl.SSLContext | None = None,
        **settings: Any,
    ) -> None:  # fmt: skip
        super().__init__(self._attend, **settings)
        self._answer = handler
        self._tls = tls
        most = most_places(MOST_CONNECTIONS, _SHARE)
        self._places: Places[_Visitor] = Places(most, min(MOST_OF_HOST, most - most // 4))
        self._visitors: dict[Any, _Visitor] = {}  # by protocol
        self._spoken: Rotation[_Visitor] = Rotation()  # those that wait to be opened
        self._failed = 0  # handshakes
        self._complaint = Complaint()
        self._listener: socket.socket | None = None
        self._watching: asyncio.Task[None] | None = None

    def listen(self, host: str, port: int) -> int:
        """Listen on a host and a port; return the port. OSError if it is taken."""
        self._listener = listen(host, port)
        self._loop.add_reader(self._listener, self._accept)
        self._watching = asyncio.ensure_future(self._watch())
        return int(self._listener.getsockname()[1])

    def _accept(self) -> None:
        assert self._listener
        try:
            for sock, host in accepted(self._listener, self._complaint, "HTTP"):
                self._admit(_Visitor(sock, host))
        except NoDescriptorError:
            self._loop.remove_reader(self._listener)
            self._loop.call_later(PAUSE, self._accept_again)

    def _accept_again(self) -> None:
        if self._listener:
            self._loop.add_reader(self._listener, self._accept)

    def _admit(self, visitor: _Visitor) -> None:
        if not self._places.is_free(visitor.host):
            other = self._places.who_makes_way(visitor.host)
            if other is None:
                visitor.socket.close()
                return
            self._drop(other)
        self._places.come(visitor, visitor.host)
        visitor.socket.setblocking(False)
        self._loop.add_reader(visitor.socket, self._hear, visitor)

    def _hear(self, visitor: _Visitor) -> None:
        """Have a connection that has sent something wait to be opened. A handshake takes a ms: hosts take turns."""
        self._loop.remove_reader(visitor.socket)
        if not self._spoken:
            self._loop.call_soon(self._open)
        self._spoken.add(visitor.host, visitor)

    def _open(self) -> None:
        """Hand the connection whose turn it is to asyncio, and look at all others before the next."""
        visitor = self._spoken.take()
        if self._spoken:
            self._loop.call_soon(self._open)
        if visitor is None or visitor not in self._places:
            return  # it had to make way
        try:
            has_spoken = visitor.socket.recv(1, socket.MSG_PEEK)
        except OSError:
            has_spoken = b""
        if has_spoken:
            visitor.opening = asyncio.ensure_future(self._shake_hands(visitor))
        else:
            visitor.socket.close()
            self._places.leave(visitor)

    async def _shake_hands(self, visitor: _Visitor) -> None:
        left = max(0.1, visitor.quiet_since + _HANDSHAKE - time.monotonic())
        made: Any = self()
        self._visitors[made] = visitor
        try:
            await self._loop.connect_accepted_socket(
                lambda: made, visitor.socket, ssl=self._tls, ssl_handshake_timeout=left if self._tls else None
            )
            visitor.protocol = made
            visitor.quiet_since = time.monotonic()
        except (OSError, asyncio.CancelledError):  # ssl.SSLError and TimeoutError are such
            self._failed += 1
            self._visitors.pop(made, None)  # of a handshake that fails no connection is lost
            self._places.leave(visitor)
            visitor.socket.close()
        finally:
            visitor.opening = None
        if visitor not in self._places and visitor.protocol and visitor.protocol.transport:
            visitor.protocol.transport.abort()  # it had to make way in the last moment

    def connection_lost(self, handler: Any, exc: BaseException | None = None) -> None:
        """Forget a connection."""
        if visitor := self._visitors.pop(handler, None):
            self._places.leave(visitor)
        super().connection_lost(handler, exc)

    def _drop(self, visitor: _Visitor) -> None:
        self._places.leave(visitor)
        visitor.abort(self._loop)

    async def _attend(self, request: web.BaseRequest) -> web.StreamResponse:
        visitor = self._visitors.get(request.protocol)
        if visitor:
            self._places.rouse(visitor)
        try:
            return await self._answer(request)
        except (asyncio.CancelledError, ConnectionError, web.HTTPException):
            raise
        except Exception:  # a fault of the server must not end the connection, nor go unseen
            logging.getLogger(__name__).exception("a fault of the server")
            return web.Response(status=500, text="a fault of the server\n")
        finally:
            if visitor:
                self._places.hush(visitor)
                visitor.quiet_since = time.monotonic()

    async def _watch(self) -> None:
        """Close those that have been quiet for too long."""
        while True:
            await asyncio.sleep(_LOOK)
            now = time.monotonic()
            for visitor in self._places.quiet():
                if now - visitor.quiet_since > (_SPEAKING if visitor.protocol else _HANDSHAKE):
                    self._drop(visitor)
            if self._failed > _MOST_FAILED:
                self._failed = 0
                gc.collect()

    async def end(self) -> None:
        """Listen no more, and let those go that have not requested anything."""
        if self._watching:
            self._watching.cancel()
        if self._listener:
            self._loop.remove_reader(self._listener)
            self._listener.close()
            self._listener = None
        for visitor in self._places.quiet():
            if not visitor.protocol:
                opening = visitor.opening
                self._drop(visitor)
                if opening:
                    with suppress(asyncio.CancelledError):
                        await opening
