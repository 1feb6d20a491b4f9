"""carom listen: print a running server's warnings and the ends of gestures, as they come."""

import argparse
import math
import time
from collections.abc import Iterator
from contextlib import suppress

from ...server.osc.wire import Message
from ..client import Client
from .options import add_server, client
from .parser import Command, number

_PERIOD = 2.0  # s after which the server is asked again, so that one that has gone, or is new, is noticed
_PATIENCE = 2 * _PERIOD + 1.0  # s without an answer


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seconds", type=number, default=math.inf, help="time to listen, s (until interrupted)")
    add_server(parser)


def _run(arguments: argparse.Namespace) -> int:
    warnings = 0
    with client(arguments) as server:
        try:
            for message in _heard(server, arguments.seconds):
                print(message.address, *message.args, flush=True)
                warnings += message.address == "/warning"
        finally:
            with suppress(ConnectionError):
                server.send("/notify", 0)
    found = f"{warnings} warnings" if warnings else "all was well"
    print(f"{found} for {arguments.seconds:g} s")
    return 0


def _heard(server: Client, seconds: float) -> Iterator[Message]:
    """Yield the messages that a server sends to those that it notifies. TimeoutError if it does not answer any more,
    ConnectionError if it has ended."""
    server.ask("/notify", 1)
    try:
        yield from _notified(server, seconds)
    except ConnectionRefusedError:
        raise ConnectionResetError("the server has ended") from None


def _notified(server: Client, seconds: float) -> Iterator[Message]:
    """Yield the server's messages for so long, with the subscription renewed again and again."""
    answered = time.monotonic()
    end = answered + seconds
    while (now := time.monotonic()) < end:
        for message in server.replies(min(_PERIOD, end - now)):
            if message == Message("/done", ("/notify",)):
                answered = time.monotonic()
            else:
                yield message
        if time.monotonic() > answered + _PATIENCE:
            raise TimeoutError("the server does not answer any more")
        server.send("/notify", 1)


COMMAND = Command("listen", "", "print a running server's warnings, and which gestures end", _options, _run)
