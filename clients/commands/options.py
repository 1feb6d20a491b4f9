"""The options that several commands share."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...server.osc.wire import DEFAULT_PORT, MOST_PORT
from .parser import one_of, pascals

if TYPE_CHECKING:
    from ..client import Client

RATE = 48_000
"""Hz, where no other rate is given."""


SCORE = "score, text or binary, or the name of one of Carom's own; -: stdin"
"""The help of an argument that is a score."""


SWITCH: dict[str, Any] = {"choices": ("on", "off"), "type": one_of("on", "off")}
"""The settings of an option that is on or off; `switch` reads it."""


def switch(word: str | None) -> bool | None:
    """True if an option is on; None if it is not given."""
    return None if word is None else word == "on"


def no_options(parser: argparse.ArgumentParser) -> None:
    """Add no option."""


def add_bank(parser: argparse.ArgumentParser, default: str | None, otherwise: str) -> None:
    """Add the option for what the spectral bank keeps its modes in; otherwise: what it is where none is given."""
    text = f"number format of freely ringing modes: float64, or float32 for speed ({otherwise})"
    parser.add_argument("--bank", default=default, metavar="FORM", help=text)


def add_full_scale(parser: argparse.ArgumentParser, default: float | None = None, otherwise: str = "4") -> None:
    """Add the option for the pressure of full scale; otherwise: what it is where none is given."""
    text = f"pressure of full scale for objects of level 0, such as 2 or 2Pa ({otherwise})"
    parser.add_argument("--full-scale", type=pascals, default=default, metavar="PA", help=text)


def add_presets(parser: argparse.ArgumentParser) -> None:
    """Add the option for folders of presets."""
    text = "folder of your own presets, with objects/, strikers/, materials/, surfaces/ in it"
    parser.add_argument("--presets", type=Path, action="append", default=[], metavar="DIR", help=text)


def add_server(parser: argparse.ArgumentParser) -> None:
    """Add the options that say where the server is; `client` reads them."""
    parser.add_argument("--host", default="127.0.0.1", help="name or address of the server (%(default)s)")
    parser.add_argument("--port", type=_port, default=DEFAULT_PORT, help="port of the server (%(default)s)")
    parser.add_argument("--tcp", action="store_true", help="TCP, which loses nothing; always used for other hosts")


def client(arguments: argparse.Namespace) -> Client:
    """Return a client of the server that the options name."""
    from ...server.net.reply_budget import local
    from ..client import Client

    found = Client(arguments.host, arguments.port, arguments.tcp or not local(arguments.host))
    found.tell_compiling(_show_compiling)
    return found


def _show_compiling(share: float, seconds: float) -> None:
    print(f"the server compiles its engine: {share:.0%}, about {seconds:.0f} s left", file=sys.stderr, flush=True)


def _port(word: str) -> int:
    if word.isdecimal() and 0 < int(word) <= MOST_PORT:
        return int(word)
    raise argparse.ArgumentTypeError(f"{word}: expected 1 to {MOST_PORT}")


ENDING = "SIGTERM", "SIGINT", "SIGHUP", "SIGQUIT", "SIGXCPU"
"""The signals by which the system asks a program to end."""


def on_end(act: Callable[[], object]) -> None:
    """Act when the system asks this program to end."""
    import signal  # slow to load

    for name in ENDING:
        if hasattr(signal, name):  # Windows has but two
            signal.signal(getattr(signal, name), lambda *_: act())
