"""A web server about nothing in particular, and a page's end of a web socket."""

import asyncio
import http.client
import json
from collections.abc import Callable, Coroutine, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from carom.server.net.network import Network
from carom.server.web.guard import Guard
from carom.server.web.server import WebServer, answering
from carom.server.web.site import Site

NAMES = {"NAME": {"bell": None, "é %41": None}, "ID": {"g1": None}, "preset": ["tom", "bar"]}


class Known:
    """The facts that a server would tell."""

    def names(self) -> dict[str, Any]:
        return NAMES

    def value(self, path: str) -> list[Any] | None:
        return [-3.0] if path == "/object/bell/gain" else None

    def catalogue(self) -> dict[str, Any]:
        return {"objects": []}

    def shape_of(self, name: str) -> dict[str, Any] | None:
        return {"name": name} if name in NAMES["NAME"] else None

    def session(self) -> bytes:
        return b"0.0 /panic\n"


@pytest.fixture
def network() -> Iterator[Network]:
    with closing(Network("127.0.0.1", 0)) as network:
        yield network


@pytest.fixture
def make(network, tmp_path) -> Iterator[Callable[..., WebServer]]:
    """Starts web servers with a page of two files, and ends them."""
    page = tmp_path / "page"
    page.mkdir()
    (page / "index.html").write_text("<title>Carom</title>")
    (page / "main.js").write_text("1;")
    (tmp_path / "secret.js").write_text("secret")
    (page / "key.pem").write_text("secret")
    opened = []

    def start(page: Path | None = page, token: str = "") -> WebServer:
        server = WebServer(Site(Known(), network, 57140, page, Guard(token)), "127.0.0.1", 0)
        opened.append(answering(server))
        opened[-1].__enter__()
        return server

    yield start
    for each in opened:
        each.__exit__(None, None, None)


@pytest.fixture
def web(make) -> WebServer:
    return make()


def ask(port: int, path: str, method: str = "GET", body: bytes | None = None, **headers: str) -> tuple[int, str, bytes]:
    """Return status, kind and content of an answer."""
    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=10)) as connection:
        connection.request(method, path, body, headers)
        response = connection.getresponse()
        return response.status, response.getheader("Content-Type", ""), response.read()


def get(port: int, path: str) -> tuple[int, dict[str, Any]]:
    """Return status and JSON of an answer."""
    status, kind, body = ask(port, path)
    return status, json.loads(body) if kind == "application/json" else {}


def run(work: Coroutine[Any, Any, Any]) -> Any:
    """Run what takes at most 30 s, and return its result."""
    return asyncio.run(asyncio.wait_for(work, 30))
