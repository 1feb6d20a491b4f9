"""carom page: start a server, and open its page in the browser."""

from __future__ import annotations

import argparse
import sys
import webbrowser
from typing import TYPE_CHECKING

from .parser import Command
from .serve import PAGE_PORT, add_options, serve

if TYPE_CHECKING:
    from ...server.server import Server


def _options(parser: argparse.ArgumentParser) -> None:
    add_options(parser)
    parser.set_defaults(page=PAGE_PORT)
    parser.add_argument("--no-browser", action="store_true", help="print the address of the page, but open no browser")


def _run(arguments: argparse.Namespace) -> int:
    from ...server.audio.portaudio import AudioError

    def show(server: Server) -> None:
        if not arguments.no_browser and server.web:
            webbrowser.open(server.web.address)

    try:
        return serve(arguments, show)
    except AudioError as error:
        if arguments.device is not None:
            raise
        print(f"carom page: the page plays the sound: {error}", file=sys.stderr)
    arguments.device = "page"
    return serve(arguments, show)


COMMAND = Command("page", "", "start a server, and open its page in the browser", _options, _run)
