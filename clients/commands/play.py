"""carom play: send a score to a running server, each line at its time."""

from __future__ import annotations

import argparse
import sys
import time

from ..client import Client
from .options import SCORE, add_server, client
from .parser import Command
from .progress import Work, shown_progress


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("score", metavar="SCORE", help=SCORE)
    add_server(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ..streams import read_score

    lines = sorted(read_score(arguments.score), key=lambda line: line.time)
    failed = 0
    with client(arguments) as server:
        server.ask("/version")
        start = time.time() + 0.5
        last = lines[-1].time if lines else 0.0
        with shown_progress(
            Work("play", "{desc} {bar} {n:.0f} of {total:.0f} s", "s of the score"), arguments.score, last
        ) as show:
            for line in lines:
                # Up to a second ahead: enough for the server to be in time, little to lose if it goes.
                while (wait := start + line.time - time.time() - 1.0) > 0:
                    failed += _print_failures(server, min(wait, 0.1))
                    show(completed=time.time() - start)
                server.send(line.message.address, *line.message.args, at=start + line.time)
            failed += _print_failures(server, max(0.0, start + last - time.time()) + 0.2)
    return 1 if failed else 0


def _print_failures(server: Client, seconds: float) -> int:
    failures = [reply for reply in server.replies(seconds) if reply.address == "/fail"]
    for reply in failures:
        print(*reply.args, file=sys.stderr)
    return len(failures)


COMMAND = Command("play", "SCORE", "send a score to a running server, each line at its time", _options, _run)
