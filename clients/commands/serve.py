"""carom serve: start a server that plays OSC messages."""

from __future__ import annotations

import argparse
import ctypes
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from ...server.osc.wire import DEFAULT_PORT
from ..actions import CommandError
from .ending import end_within
from .options import RATE, SWITCH, add_bank, add_full_scale, add_presets, on_end
from .parser import Command, number, size, whole

if TYPE_CHECKING:
    from ...server.server import Server
    from ...server.web.server import WebServer

PAGE_PORT = 57141
"""Port of the page, where no other is given."""
PAGE = Path(__file__).parents[1] / "page"
"""The page's files."""

_KEPT = (
    "port", "bind", "device", "latency", "rate", "block", "record", "log", "channels", "gain", "modes", "objects",
    "sensors", "bank", "recordings", "quota", "full_scale",
)  # fmt: skip
"""The options that the server takes as they are given."""

_LONGEST_END = 10.0  # s, whatever the threads do: a server that is well takes less than 2

_TRIM_THRESHOLD, _MMAP_THRESHOLD, _ARENA_MAX = -1, -3, -8
"""Parameters of mallopt(3)."""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--port", type=whole, default=DEFAULT_PORT, help="port for UDP and TCP; 0: any free one (%(default)s)"
    )
    parser.add_argument("--bind", default="127.0.0.1", help="address to listen on (%(default)s: for this machine only)")
    text = "network whose hosts get all answers over UDP, such as 192.168.1.0/24"
    parser.add_argument("--trust", action="append", default=[], metavar="NET", help=text)
    parser.add_argument(
        "--device",
        help="sound device, by number or part of its name; none: no sound; page: in browsers only (the system's)",
    )
    parser.add_argument(
        "--latency", type=number, help="time from computing a sound to hearing it, s (the device's lowest)"
    )
    parser.add_argument("--rate", type=whole, default=RATE, help="sampling rate in Hz (%(default)s)")
    parser.add_argument("--block", type=whole, default=0, help="frames per block (the device's)")
    _add_files_and_midi(parser)
    parser.add_argument(
        "--page", type=whole, nargs="?", const=PAGE_PORT, metavar="PORT",
        help=f"serve a page to play on, and OSCQuery, at this port; 0: any free one ({PAGE_PORT})",
    )  # fmt: skip
    parser.add_argument("--tls", action="store_true", help="serve the page over https, with a new certificate")
    parser.add_argument(
        "--certificate",
        type=Path,
        metavar="FILE.pem",
        help="serve the page over https, with the certificate and key in this file",
    )
    parser.add_argument(
        "--oscquery",
        type=whole,
        metavar="PORT",
        help="port of OSCQuery, which describes all addresses; 0: any free one",
    )
    parser.add_argument(
        "--channels", type=whole, default=2, metavar="N", help="number of channels, 1 to 64 (%(default)s)"
    )
    parser.add_argument(
        "--sensors", type=whole, default=0, metavar="N",
        help="number of channels for sensors, after those of the sound (%(default)s)",
    )  # fmt: skip
    parser.add_argument("--gain", type=number, default=0.0, metavar="DB", help="level of everything, dB (%(default)g)")
    parser.add_argument(
        "--limiter", default="on", **SWITCH, help="limiter, which keeps the sound within full scale (%(default)s)"
    )
    parser.add_argument(
        "--headroom", default="on", **SWITCH, help="slow automatic gain before the limiter (%(default)s)"
    )
    parser.add_argument(
        "--modes", type=whole, default=131_072, metavar="N", help="largest number of modes, up to 1310720 (%(default)s)"
    )
    parser.add_argument(
        "--objects", type=whole, default=512, metavar="N", help="largest number of objects, up to 16384 (%(default)s)"
    )
    add_full_scale(parser, 4.0, "%(default)g")
    add_bank(parser, "float64", "%(default)s")
    add_presets(parser)


def _add_files_and_midi(parser: argparse.ArgumentParser) -> None:
    """Add the options of what is written, and of MIDI."""
    parser.add_argument("--record", type=_file, metavar="OUT.wav", help="file to record the sound to")
    parser.add_argument("--log", type=_file, metavar="OUT.txt", help="file to log all messages to, as a score")
    parser.add_argument(
        "--recordings", type=Path, metavar="DIR", help="folder for recordings that clients make by /record"
    )
    parser.add_argument(
        "--quota", type=size, default="10GB", metavar="SIZE",
        help="largest total size of the files in the folder of --recordings (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--midi", action="append", default=[], metavar="PORT",
        help="MIDI input, by number or part of its name; virtual: an input to connect to; may be repeated",
    )  # fmt: skip


def _file(word: str) -> Path:
    if word == "-":
        raise argparse.ArgumentTypeError("-: expected the name of a file, as stdout says where the server listens")
    return Path(word)


def serve(arguments: argparse.Namespace, on_start: Callable[[Server], object]) -> int:
    """Serve as the options say; `on_start` gets the server once it listens."""
    from ...server.net.reply_budget import local
    from ...server.options import Options
    from ...server.start import serving

    _keep_memory_together()
    if arguments.page is not None and arguments.oscquery is not None:
        raise CommandError("page, oscquery: expected one of the two, as the page's port answers OSCQuery, too")
    if (arguments.tls or arguments.certificate) and arguments.page is None:
        raise CommandError("tls, certificate: expected with --page, as nothing else goes over https")
    options = Options(
        **{key: getattr(arguments, key) for key in _KEPT},
        web=arguments.oscquery if arguments.page is None else arguments.page,
        page=None if arguments.page is None else PAGE,
        tls=arguments.tls,
        certificate=arguments.certificate,
        presets=tuple(arguments.presets),
        midi=tuple(arguments.midi),
        trust=tuple(arguments.trust),
        limiter=arguments.limiter == "on",
        headroom=arguments.headroom == "on",
    )
    ends = end_within(_LONGEST_END, arguments.command)
    with serving(options) as server:
        on_end(server.stop)
        host, port = server.address
        if not local(host):
            print(
                f"carom {arguments.command}: warning: listening on {host}: anyone who can reach this machine can play "
                "on it" + " by OSC" * (options.page is not None),
                file=sys.stderr,
            )
        print(f"carom listens on {host}:{port}, plays on {server.player.name} at {arguments.rate} Hz", flush=True)
        if server.web:
            _announce(server.web, options.page is not None)
        on_start(server)
        server.run()
        ends()
    return 0


def _keep_memory_together() -> None:
    """Make the GNU C library take memory from one heap for all threads, and give back what is free at its end.

    By itself it opens a heap for each thread, and raises the size from which on an array is a map of its own: in hours
    of mixed traffic the heaps of the threads that make objects grow to twice what is used.
    """
    with suppress(AttributeError, OSError, TypeError):  # other libraries have no such function
        for parameter, value in ((_ARENA_MAX, 1), (_MMAP_THRESHOLD, 1 << 18), (_TRIM_THRESHOLD, 1 << 20)):
            ctypes.CDLL(None).mallopt(parameter, value)


def _announce(web: WebServer, has_page: bool) -> None:
    """Say where the web server is; for a page that others can reach, show its address as a QR code, too."""
    from ...server.net.reply_budget import local

    if not has_page:
        print(f"carom describes itself at {web.address} (OSCQuery)", flush=True)
        return
    print(f"carom has its page at {web.address} (and OSCQuery)", flush=True)
    if not local(web.host) and sys.stdout.isatty():
        import segno

        segno.make(web.address).terminal(compact=True)


def _run(arguments: argparse.Namespace) -> int:
    return serve(arguments, lambda server: None)


COMMAND = Command("serve", "", "start a server that plays OSC messages", add_options, _run)
