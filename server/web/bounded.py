"""HTTP connections, bounded: how many there are, and how long one may take to ask."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from typing import Any

from aiohttp import web

MOST_CONNECTIONS = 128
_SPEAKING = 10.0  # s for a request to be sent, and between requests
_LOOK = 1.0  # s


class _Refused(asyncio.Protocol):
    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        transport.close()


class BoundedServer(web.Server):
    """aiohttp's server, which closes connections that are open and ask for nothing: after a while, and at once where a
    new one needs the place, the one that was quiet for longest. New ones are closed where all are being answered.

    aiohttp bounds headers, bodies and frames; it waits for ever for the end of a request's head.
    """

    def __init__(self, handler: Callable[[web.BaseRequest], Awaitable[web.StreamResponse]], **settings: Any) -> None:
        super().__init__(self._attend, **settings)
        self._answer = handler
        self._quiet_since: dict[Any, float] = {}  # by protocol, those that no request is being answered on
        self._watching: asyncio.Task[None] | None = None

    def __call__(self) -> Any:
        if len(self.connections) >= MOST_CONNECTIONS and not self._make_room():
            return _Refused()
        self._watching = self._watching or asyncio.ensure_future(self._watch())
        protocol = super().__call__()
        self._quiet_since[protocol] = time.monotonic()
        return protocol

    def connection_lost(self, handler: Any, exc: BaseException | None = None) -> None:
        """Forget a connection."""
        self._quiet_since.pop(handler, None)
        super().connection_lost(handler, exc)

    def _make_room(self) -> bool:
        """Close the connection that was quiet for longest; False if none is quiet."""
        quiet = next((each for each in self._quiet_since if each.transport), None)
        if quiet is None:
            return False
        del self._quiet_since[quiet]
        quiet.transport.abort()
        return True

    async def _attend(self, request: web.BaseRequest) -> web.StreamResponse:
        self._quiet_since.pop(request.protocol, None)
        try:
            return await self._answer(request)
        except (asyncio.CancelledError, ConnectionError, web.HTTPException):
            raise
        except Exception:  # a fault of the server must not end the connection, nor go unseen
            logging.getLogger(__name__).exception("a fault of the server")
            return web.Response(status=500, text="a fault of the server\n")
        finally:
            self._quiet_since[request.protocol] = time.monotonic()

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(_LOOK)
            late = time.monotonic() - _SPEAKING
            for protocol, since in list(self._quiet_since.items()):
                if since < late:
                    del self._quiet_since[protocol]
                    if protocol.transport:
                        protocol.transport.abort()

    async def end(self) -> None:
        """Stop watching."""
        if self._watching:
            self._watching.cancel()
