"""OSCQuery: the address space as JSON over HTTP, for programs that look up what they can play.

By Vidvox's proposal (github.com/Vidvox/OSCQueryProposal): GET of an address answers with it and all below it, `?TYPE`
and the like with one attribute, `?HOST_INFO` with the port for OSC. All comes from the registry that checks messages.
The proposal has no word for keys: they stand in the description, with their ranges. Values can't be asked for: messages
only ever set them.
"""

import json
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from ipaddress import ip_address
from typing import Any
from urllib.parse import unquote, urlsplit

from ...dsp.schema import Parameter as Number
from .addresses import VERBS
from .arguments import Either, Parameter, Verb

_MOST_CLIENTS = 8
_TIMEOUT = 2.0  # s without a byte
_TURN = 0.1  # s that a client waits for a place before the oldest loses its own

_REST = 3.0  # times as long as an answer took to make, the next one waits

_GIVEN = ("FULL_PATH", "CONTENTS", "DESCRIPTION", "TYPE", "ACCESS", "RANGE", "UNIT", "OVERLOADS")
_NOT_GIVEN = ("VALUE", "TAGS", "CLIPMODE", "EXTENDED_TYPE", "CRITICAL")
_UNITS = {"m/s": "speed.m/s", "dB": "gain.db"}  # the proposal's words, where it has one

Names = Mapping[str, Collection[str]]
"""The choices for a word: objects for `NAME` in an address, gestures for `ID`, presets for the argument `preset`."""

_ADDRESSES = tuple((tuple(address.split("/")[1:]), verb) for address, verb in VERBS.items())


def node(path: str, names: Names) -> dict[str, Any] | None:
    """The JSON object of an address and of all below it; None where there is nothing."""
    given = path.split("/")[1:] if path != "/" else []
    contents: dict[str, Any] = {}
    for parts, verb in _ADDRESSES:
        if not _leads(given, parts, names):
            continue
        if len(parts) == len(given):
            return {"FULL_PATH": path, "DESCRIPTION": _description(verb), **_arguments(verb, names)}
        following = parts[len(given)]
        for name in names.get(following, ()) if following.isupper() else (following,):
            if name not in contents and (below := node(f"{path.rstrip('/')}/{name}", names)):
                contents[name] = below
    if path == "/" or contents:
        return {"FULL_PATH": path, "ACCESS": 0, "CONTENTS": contents}
    return None


def _leads(given: list[str], parts: tuple[str, ...], names: Names) -> bool:
    return len(given) <= len(parts) and all(
        part in names.get(known, ()) if known.isupper() else part == known
        for part, known in zip(given, parts, strict=False)
    )


def _description(verb: Verb) -> str:
    keys = f"; keys: {', '.join(map(str, verb.keys))}" if verb.keys else ""
    return f"{verb.help}: {verb.usage()}{keys}"


def _arguments(verb: Verb, names: Names) -> dict[str, Any]:
    """The arguments of a method: the shortest list, and as overloads the longer ones with optional arguments."""
    least = max(len(verb.required), 1)
    arguments = (*verb.required, *verb.optional, *((verb.many.number,) if verb.many else ()))
    if not arguments:
        return {"ACCESS": 2, "TYPE": "", "RANGE": []}
    lists = [_values(arguments[:count], names) for count in range(least, len(arguments) + 1)]
    return {"ACCESS": 2, **lists[0], **({"OVERLOADS": lists[1:]} if lists[1:] else {})}


def _values(arguments: tuple[Parameter, ...], names: Names) -> dict[str, Any]:
    units = [_UNITS.get(a.unit, a.unit) or None if isinstance(a, Number) else None for a in arguments]
    return {
        "TYPE": "".join("f" if isinstance(a, Number) else "s" for a in arguments),
        "RANGE": [_range(a, names) for a in arguments],
        **({"UNIT": units} if any(units) else {}),
    }


def _range(argument: Parameter, names: Names) -> dict[str, Any] | None:
    if isinstance(argument, Number):
        return {"MIN": argument.low, "MAX": argument.high}
    if isinstance(argument, Either):
        return {"VALS": list(argument.words)}
    return {"VALS": list(names[argument.name])} if argument.name in names else None


class OscQuery(ThreadingHTTPServer):
    """Answers for a server of OSC on `osc_port`; `names` is called anew for each question."""

    daemon_threads = True
    block_on_close = False
    request_queue_size = 32

    def __init__(self, host: str, port: int, osc_port: int, names: Callable[[], Names]) -> None:
        """Listen on a port, 0 being any that is free; OSError if it can't be."""
        super().__init__((host, port), _Handler)
        self.osc_port = osc_port
        self.names = names
        self._clients: deque[socket.socket] = deque()
        self.turn = threading.Lock()
        self._places = threading.BoundedSemaphore(_MOST_CLIENTS)

    def process_request(self, request: Any, client_address: Any) -> None:
        if not self._places.acquire(timeout=_TURN):
            # The oldest client loses its place, so that nobody can occupy them all.
            with suppress(IndexError, OSError):
                self._clients[0].shutdown(socket.SHUT_RDWR)
            self._places.acquire()
        self._clients.append(request)
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        self._clients.remove(request)
        self._places.release()
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore a client that leaves in the middle of an answer."""


class _Handler(BaseHTTPRequestHandler):
    server: OscQuery
    timeout = _TIMEOUT
    server_version = "Carom"
    sys_version = ""

    def do_GET(self) -> None:
        path, _, attribute = self.path.partition("?")
        if not (self._is_ours(self.headers.get("Host")) and self._is_ours(self.headers.get("Origin"))):
            self.send_error(HTTPStatus.FORBIDDEN, "another site's name: expected this server's own address")
            return
        if not path.startswith("/"):
            self.send_error(HTTPStatus.BAD_REQUEST, "expected an address that begins with /")
            return
        if attribute == "HOST_INFO":
            self._answer(self._host_info())
        elif attribute and attribute not in (*_GIVEN, *_NOT_GIVEN):
            self.send_error(HTTPStatus.BAD_REQUEST, "no such attribute")
        elif (found := self._node(unquote(path).rstrip("/") or "/")) is None:
            self.send_error(HTTPStatus.NOT_FOUND, "no such address")
        elif not attribute:
            self._answer(found)
        elif attribute in found:
            self._answer({attribute: found[attribute]})
        else:
            self.send_response(HTTPStatus.NO_CONTENT)
            self.end_headers()

    def _is_ours(self, given: str | None) -> bool:
        """Whether a Host or an Origin is this server: an address, localhost, or this machine's name; or is not given.

        A page of another site that makes its own name lead here (DNS rebinding) is told nothing.
        """
        if not given:
            return True
        name = urlsplit(given if "//" in given else f"//{given}").hostname or ""
        if name in ("localhost", socket.gethostname().lower()) or name.endswith(".local"):
            return True
        with suppress(ValueError):
            return bool(ip_address(name))
        return False

    def _node(self, path: str) -> dict[str, Any] | None:
        """The node of an address. One at a time, with pauses: the sound's messages need Python's lock too."""
        with self.server.turn:
            start = time.perf_counter()
            found = node(path, self.server.names())
            time.sleep(_REST * (time.perf_counter() - start))
        return found

    def _host_info(self) -> dict[str, Any]:
        return {
            "NAME": "Carom",
            "OSC_IP": self.connection.getsockname()[0],
            "OSC_PORT": self.server.osc_port,
            "OSC_TRANSPORT": "UDP",
            "EXTENSIONS": {name: name in _GIVEN for name in (*_GIVEN[4:], *_NOT_GIVEN)},
        }

    def _answer(self, content: dict[str, Any]) -> None:
        body = json.dumps(content).encode()
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:
        """Write no log of questions."""


@contextmanager
def answering(query: OscQuery) -> Iterator[None]:
    """Answer questions, in threads of its own, while inside."""
    thread = threading.Thread(target=query.serve_forever, args=(0.1,), name="carom-oscquery", daemon=True)
    thread.start()
    try:
        yield
    finally:
        query.shutdown()
        thread.join()
        query.server_close()
