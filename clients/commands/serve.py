"""carom serve: listen for OSC and play."""

import argparse
import sys
from pathlib import Path

from ...server.osc.wire import DEFAULT_PORT
from .options import RATE, SWITCH, add_contact, add_presets, contact, on_end
from .parser import Command, number, whole


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--port", type=whole, default=DEFAULT_PORT, help="port for UDP and TCP, 0 for any free one (%(default)s)"
    )
    parser.add_argument("--bind", default="127.0.0.1", help="address to listen on (%(default)s: for this machine only)")
    parser.add_argument("--device", help="index or part of a name from `carom devices`; none: paced by the clock")
    parser.add_argument(
        "--latency", type=number, help="seconds from computing a sound to hearing it (the device's lowest)"
    )
    parser.add_argument("--rate", type=whole, default=RATE, help="sampling rate in Hz (%(default)s)")
    parser.add_argument("--block", type=whole, default=0, help="frames per block (0: the device's)")
    parser.add_argument("--record", type=_file, metavar="OUT.wav", help="record the sound")
    parser.add_argument(
        "--oscquery", type=whole, metavar="PORT", help="describe all addresses over HTTP (0: any free port)"
    )
    parser.add_argument("--log", type=_file, metavar="OUT.txt", help="log all events, as a score")
    parser.add_argument(
        "--channels", type=whole, default=2, metavar="N", help="channels, 1 to 64 (%(default)s: left and right)"
    )
    parser.add_argument("--gain", type=number, default=0.0, metavar="DB", help="level of the whole, dB (%(default)g)")
    parser.add_argument("--limiter", default="on", **SWITCH, help="keep within full scale (%(default)s)")
    add_contact(parser)
    add_presets(parser)


def _file(word: str) -> Path:
    if word == "-":
        raise argparse.ArgumentTypeError("-: expected the name of a file, as stdout says where the server listens")
    return Path(word)


def _run(arguments: argparse.Namespace) -> int:
    from ...server.net.reply_budget import local
    from ...server.options import Options
    from ...server.server import serving

    keys = ("port", "bind", "device", "latency", "rate", "block", "record", "log", "oscquery", "channels", "gain")
    chosen = {key: getattr(arguments, key) for key in keys}
    limiter = arguments.limiter == "on"
    options = Options(**chosen, presets=tuple(arguments.presets), contact=contact(arguments), limiter=limiter)
    with serving(options) as server:
        on_end(server.stop)
        host, port = server.address
        if not local(host):
            print(
                f"carom serve: warning: listening on {host}: anyone who can reach this machine can play on it",
                file=sys.stderr,
            )
        print(f"carom listens on {host}:{port}, plays on {server.player.name} at {arguments.rate} Hz", flush=True)
        if server.query:
            print(f"carom describes itself at http://{host}:{server.query.server_port}/ (OSCQuery)", flush=True)
        server.run()
    return 0


COMMAND = Command("serve", "", "listen for OSC and play", _options, _run)
