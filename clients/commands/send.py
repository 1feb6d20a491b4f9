"""carom send: send one message to a running server and print its replies."""

import argparse
import sys

from .options import add_server, client
from .parser import Command


def _options(parser: argparse.ArgumentParser) -> None:
    add_server(parser)
    parser.add_argument("address", metavar="ADDRESS")
    parser.add_argument("args", nargs="*", default=[], metavar="ARG")


def _run(arguments: argparse.Namespace) -> int:
    from ...server.osc.score import value

    with client(arguments) as server:
        replies = server.ask_all(arguments.address, *map(value, arguments.args))
    for reply in replies:
        print(reply.address, *reply.args, file=sys.stderr if reply.address == "/fail" else sys.stdout)
    return 1 if any(reply.address == "/fail" for reply in replies) else 0


COMMAND = Command(
    "send", "ADDRESS [ARG ...]", "send one message to a running server and print its replies", _options, _run
)
