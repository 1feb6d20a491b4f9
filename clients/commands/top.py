"""carom top: show the state of a running server, live."""

import argparse

from .options import add_server, client
from .parser import Command


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--once", action="store_true", help="show the state once, then exit")
    add_server(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ..top import top

    with client(arguments) as server:
        top(server, arguments.once)
    return 0


COMMAND = Command("top", "", "show the state of a running server, live", _options, _run)
