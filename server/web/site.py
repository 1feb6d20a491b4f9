"""The answers of the web server: OSCQuery's for addresses, the page's files, the page's own questions."""

import asyncio
import json
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import unquote

from aiohttp import web

from ..net.network import Network
from ..net.places import Places
from ..osc.oscquery import ATTRIBUTES, Names, host_info, text
from ..osc.score import ScoreError
from .guard import COOKIE, Guard
from .scores import LARGEST_SCORE, MOST_SCORES, play_score, read_score
from .socket import MOST_CLIENTS, MOST_OF_HOST, SocketClient, opened

PAGE = "/page/"
_MOST_BODIES = 8  # scores that come in at once
_CHUNK = 1 << 16  # characters of a long answer that are made at once
_REST = 3.0  # times as long as such a chunk took to make, the next one waits
_PATIENCE = 10.0  # s for a client to take one
_KINDS = {
    ".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml", ".png": "image/png",
    ".webmanifest": "application/manifest+json",
}  # fmt: skip
_SAFE = {
    "Content-Security-Policy": "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' data: blob:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache",
}


class Known(Protocol):
    """The facts of the server that the site serves; any thread may ask."""

    def names(self) -> Names: ...

    def value(self, path: str) -> list[Any] | None: ...

    def catalogue(self) -> Mapping[str, Any]: ...

    def shape_of(self, name: str) -> Mapping[str, Any] | None: ...

    def session(self) -> bytes | None: ...


@dataclass
class Site:
    """A site about a server that listens for OSC on `osc_port`. page: the folder of the page's files, None: no page."""

    known: Known
    network: Network
    osc_port: int
    page: Path | None = None
    guard: Guard = field(default_factory=Guard)
    clients: set[SocketClient] = field(default_factory=set)

    def __post_init__(self) -> None:
        self._turn, self._reading = asyncio.Lock(), asyncio.Lock()
        self._bodies = asyncio.Semaphore(_MOST_BODIES)
        self._places: Places[SocketClient] = Places(MOST_CLIENTS, MOST_OF_HOST)
        self._plays: dict[SocketClient, tuple[asyncio.Task[None], int]] = {}  # each with its score's bytes

    def play(self, packet: bytes, seconds: float) -> None:
        """Give every client a block of sound."""
        for client in self.clients:
            client.play(packet, seconds)

    async def answer(self, request: web.BaseRequest) -> web.StreamResponse:
        """Answer a request."""
        if refusal := self.guard.refusal(request.headers, request.rel_url):
            return _refused(403, refusal)
        if request.headers.get("Upgrade", "").lower() == "websocket":
            return await self._talk(request)
        path = unquote(request.raw_path.partition("?")[0])
        if request.method == "POST" and path == f"{PAGE}score":
            return await self._score(request)
        if request.method not in ("GET", "HEAD"):
            return _refused(405, f"{request.method}: expected GET")
        if not path.startswith("/"):
            return _refused(400, "expected an address that begins with /")
        attribute = next((key for key in request.query if key != "token"), "")
        if self.page and path == "/" and not attribute and "text/html" in request.headers.get("Accept", ""):
            return self._file("index.html")
        if self.page and path.startswith(PAGE):
            return await self._of_page(path.removeprefix(PAGE))
        return await self._node(request, path.rstrip("/") or "/", attribute)

    def _file(self, name: str) -> web.StreamResponse:
        """Answer with a file of the page. No name leads out of its folder: only those that are in it are known."""
        assert self.page
        files = {each.name: each for each in self.page.iterdir() if each.suffix in _KINDS}
        if name not in files:
            return _refused(404, "no such file")
        response = web.Response(
            body=files[name].read_bytes(), content_type=_KINDS[files[name].suffix], charset=None, headers=_SAFE
        )
        if self.guard.token and name == "index.html":
            response.set_cookie(COOKIE, self.guard.token, httponly=True, samesite="Strict", max_age=86_400)
        return response

    async def _of_page(self, name: str) -> web.StreamResponse:
        work: Callable[[], Any]
        if name == "catalogue.json":
            work = self.known.catalogue
        elif name.startswith("object/"):
            work = partial(self.known.shape_of, name.removeprefix("object/"))
        elif name == "session.txt":
            work = self.known.session
        else:
            return self._file(name)
        async with self._turn:
            found = await asyncio.to_thread(work)
        if found is None:
            return _refused(404, "no such object")
        if isinstance(found, bytes):
            given = {**_SAFE, "Content-Disposition": f"attachment; filename=carom-{time.strftime('%Y%m%d-%H%M%S')}.txt"}
            return web.Response(body=found, content_type="text/plain", charset="utf-8", headers=given)
        return _json(found)

    async def _node(self, request: web.BaseRequest, path: str, attribute: str) -> web.StreamResponse:
        """Answer a query of OSCQuery."""
        if attribute == "HOST_INFO":
            return _json(host_info(self.osc_port))
        if attribute and attribute not in ATTRIBUTES:
            return _refused(400, "no such attribute")
        pieces = text(path, await asyncio.to_thread(self.known.names), self.known.value, attribute)
        if pieces is None:
            return _refused(404, "no such address")
        chunk, more = await self._next(pieces)
        if not more:
            return _given(chunk) if chunk else web.Response(status=204)
        response = web.StreamResponse(headers={**_SAFE, "Content-Type": "application/json"})
        await response.prepare(request)
        while chunk and request.method != "HEAD":
            await asyncio.wait_for(response.write(chunk), _PATIENCE)
            chunk, _ = await self._next(pieces)
        return response

    async def _next(self, pieces: Iterator[str]) -> tuple[bytes, bool]:
        """Return the next of an answer's pieces together, and whether there may be more.

        One answer at a time, with pauses: the sound's messages need Python's lock too.
        """
        async with self._turn:
            start, taken, length = time.perf_counter(), [], 0
            for piece in pieces:
                taken.append(piece)
                length += len(piece)
                if length > _CHUNK:
                    break
            chunk = "".join(taken).encode()
            await asyncio.sleep(_REST * (time.perf_counter() - start))
        return chunk, length > _CHUNK

    async def _talk(self, request: web.BaseRequest) -> web.StreamResponse:
        host = request.remote or ""
        if not self._places.is_free(host):
            other = self._places.who_makes_way(host)
            if other is None:
                most = self._places.limit_of(host)
                return _refused(503, f"{most} web sockets are open already: expected a page to be closed first")
            self._places.leave(other)
            other.abort()
        stranger = not self.guard.token and self.network.is_stranger((host, 0))
        socket = await opened(request)
        client = SocketClient(socket, self.network, host, stranger, request.transport)
        self.clients.add(client)
        self._places.come(client, host)
        self._places.rouse(client)
        try:
            await client.serve()
        finally:
            self.clients.discard(client)
            self._places.leave(client)
            self._end_score(client)
        return socket

    def _end_score(self, client: SocketClient) -> None:
        if play := self._plays.pop(client, None):
            play[0].cancel()

    async def _score(self, request: web.BaseRequest) -> web.StreamResponse:
        """Play the score that a page sends, until the page goes or sends another one."""
        client = next((each for each in self.clients if each.name == request.query.get("client")), None)
        if client is None:
            return _refused(409, "no such page: expected one that is connected")
        if (request.content_length or 0) > LARGEST_SCORE:
            return _refused(413, f"{request.content_length} bytes: expected at most {LARGEST_SCORE}")
        try:
            async with self._bodies:
                data = await asyncio.wait_for(request.read(), _PATIENCE)
            async with self._reading:
                played = sum(size for each, (play, size) in self._plays.items() if each != client and not play.done())
                if played + len(data) > MOST_SCORES:
                    return _refused(503, f"scores of {played} bytes are being played: expected others to end first")
                lines = await asyncio.to_thread(read_score, data)
                self._end_score(client)
                if lines and client in self.clients:  # it may have left meanwhile
                    play = asyncio.ensure_future(play_score(lines, client, self.network))
                    self._plays[client] = play, len(data)
        except asyncio.TimeoutError:
            return _refused(408, f"a score that took longer than {_PATIENCE:g} s to come")
        except web.HTTPRequestEntityTooLarge:
            return _refused(413, f"a score that is too large: expected at most {LARGEST_SCORE} bytes")
        except ScoreError as error:
            return _refused(400, str(error))
        return _json({"messages": len(lines), "seconds": lines[-1].time if lines else 0.0})


def _json(content: object) -> web.Response:
    return _given(json.dumps(content).encode())


def _given(body: bytes) -> web.Response:
    """Answer in JSON."""
    return web.Response(body=body, content_type="application/json", headers=_SAFE)


def _refused(status: int, text: str) -> web.Response:
    return web.Response(status=status, text=text + "\n", headers=_SAFE)
