"""The command line: carom serve, render, play, send, chart, devices, presets, doctor.

What a command needs is imported when it runs, so that `carom send` does not wait for a compiler to load.
"""

import argparse
import os
import signal
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from threading import Event

from ..server.osc.wire import DEFAULT_PORT
from .actions import CommandError
from .client import Client

_RATE = 48_000

Command = Callable[[argparse.Namespace], int]


def main(argv: list[str] | None = None) -> int:
    """Run a command; returns the exit code: 0 done, 1 failed (one line on stderr says why), 2 wrong usage."""
    arguments = _parser().parse_args(argv)
    try:
        code: int = arguments.run(arguments)
        return code
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        # The reader of the output has left. Without this, Python complains once more as it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (CommandError, OSError, RuntimeError, ValueError) as error:
        if not _expected(error):
            raise
        print(f"carom {arguments.command}: {_plain(error)}", file=sys.stderr)
        return 1


def _expected(error: Exception) -> bool:
    """Whether an error is Carom's own or the system's. Others are bugs, and keep their traceback."""
    return isinstance(error, OSError) or type(error).__module__.startswith("carom.")


def _plain(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return str(error)


def _parser() -> argparse.ArgumentParser:
    text = "Hear bodies hit, bounce and roll: play them over OSC, or render a score."
    parser = argparse.ArgumentParser(prog="carom", description=text)
    parser.add_argument("--version", action="version", version=f"carom {version('carom')}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    def command(name: str, run: Command, text: str) -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        sub.set_defaults(run=run)
        return sub

    _serve_options(command("serve", _serve, "listen for OSC and play"))
    _render_options(command("render", _render, "turn a score into a sound file"))

    sub = command("play", _play, "send a score to a running server, in time")
    sub.add_argument("score", type=Path)
    _add_server(sub)

    sub = command("send", _send, "send one message to a running server and print its replies")
    _add_server(sub)
    sub.add_argument("address")
    sub.add_argument("args", nargs="*", metavar="ARG")

    sub = command("top", _top, "show the state of a running server, live")
    sub.add_argument("--once", action="store_true", help="print it once")
    _add_server(sub)

    sub = command("chart", _chart, "measure speed against accuracy on this machine, and draw it")
    sub.add_argument("folder", type=Path, help="for tables (CSV) and figures (SVG, PNG); made if missing")
    sub.add_argument("--quick", action="store_true", help="a coarse study")

    command("devices", _devices, "list the devices that can play")

    sub = command("presets", _presets, "list the presets, or show one")
    sub.add_argument("name", nargs="?")
    _add_presets(sub)

    command("doctor", _doctor, "check what this machine lacks, and say what to do about it")
    return parser


def _serve_options(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "--port", type=int, default=DEFAULT_PORT, help="port for UDP and TCP, 0 for any free one (%(default)s)"
    )
    sub.add_argument("--bind", default="127.0.0.1", help="address to listen on (%(default)s: for this machine only)")
    sub.add_argument("--device", help="index or part of a name from `carom devices`; none: paced by the clock")
    sub.add_argument("--latency", type=float, help="seconds from computing a sound to hearing it (the device's lowest)")
    sub.add_argument("--rate", type=int, default=_RATE, help="sampling rate in Hz (%(default)s)")
    sub.add_argument("--block", type=int, default=0, help="frames per block (0: the device's)")
    sub.add_argument("--record", type=Path, metavar="OUT.wav", help="record the sound")
    sub.add_argument("--oscquery", type=int, metavar="PORT", help="describe all addresses over HTTP (0: any free port)")
    sub.add_argument("--log", type=Path, metavar="OUT.txt", help="log all events, as a score")
    _add_contact(sub)
    _add_presets(sub)


def _render_options(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("score", type=Path)
    sub.add_argument("out", type=Path, help="sound file; the name ends in .wav or .flac")
    sub.add_argument("--rate", type=int, default=_RATE, help="sampling rate in Hz (%(default)s)")
    sub.add_argument("--block", type=int, default=4096, help="frames per block (%(default)s); changes no sound")
    sub.add_argument("--format", choices=["16", "24", "float"], help="sample format (WAV: float, FLAC: 24)")
    sub.add_argument("--seconds", type=float, help="length of the sound (until silence)")
    sub.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the wave and spectrogram of both channels")
    _add_contact(sub)
    _add_presets(sub)


def _add_contact(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--contact", metavar="METHOD", help="solver of contacts: closed (the default), am1, verlet, ...")
    sub.add_argument("--correction", help="correction of a sampled METHOD: none, hybrid, release, both, ...")
    sub.add_argument("--oversampling", type=int, metavar="N", help="steps per sample of a sampled METHOD")


def _contact(arguments: argparse.Namespace) -> tuple[str | int, ...]:
    """The arguments of the /contact that the options ask for; none without options."""
    keys = {"correction": arguments.correction, "oversampling": arguments.oversampling}
    given = [part for key, value in keys.items() if value is not None for part in (key, value)]
    return (
        ("closed" if arguments.contact is None else arguments.contact, *given)
        if given or arguments.contact is not None
        else ()
    )


def _add_presets(sub: argparse.ArgumentParser) -> None:
    text = "folder of your own presets: objects/, strikers/, materials/, surfaces/; may be given more than once"
    sub.add_argument("--presets", type=Path, action="append", default=[], metavar="DIR", help=text)


def _add_server(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--host", default="127.0.0.1", help="the server's name or address (%(default)s)")
    sub.add_argument("--port", type=_port, default=DEFAULT_PORT, help="the server's port (%(default)s)")
    sub.add_argument("--tcp", action="store_true", help="use TCP, which loses nothing, instead of UDP")


def _port(word: str) -> int:
    if word.isdecimal() and 0 < int(word) < 65_536:
        return int(word)
    raise argparse.ArgumentTypeError(f"{word}: expected 1 to 65535")


def _serve(arguments: argparse.Namespace) -> int:
    from ..server.net.reply_budget import local
    from ..server.server import Options, serving

    keys = ("port", "bind", "device", "latency", "rate", "block", "record", "log", "oscquery")
    chosen = {key: getattr(arguments, key) for key in keys}
    options = Options(**chosen, presets=tuple(arguments.presets), contact=_contact(arguments))
    with serving(options) as server:
        signal.signal(signal.SIGTERM, lambda *_: server.stop())
        signal.signal(signal.SIGINT, lambda *_: server.stop())
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


def _render(arguments: argparse.Namespace) -> int:
    from rich.console import Console
    from rich.progress import Progress, TextColumn, TimeElapsedColumn

    from ..presets import Presets
    from ..server.osc.score import read
    from ..server.render import Options, render

    options = Options(arguments.rate, arguments.block, arguments.format, arguments.seconds, _contact(arguments))
    score = read(arguments.score)
    presets = Presets(arguments.presets)
    if arguments.plot:
        from .plot import plotter

        plot = plotter(arguments.plot)
    columns = (TextColumn("{task.description}"), TextColumn("{task.completed:.1f} s of sound"), TimeElapsedColumn())
    terminal = Console(stderr=True)
    with Progress(*columns, console=terminal, disable=not terminal.is_terminal, transient=True) as bar:
        task = bar.add_task(arguments.out.name, total=arguments.seconds)

        # An exception that a signal raises may be lost inside a library's callback: so the signal only sets a flag.
        interrupted = Event()
        for stop in (signal.SIGINT, signal.SIGTERM):
            signal.signal(stop, lambda *_: interrupted.set())

        def progress(seconds: float) -> None:
            bar.update(task, completed=seconds)
            if interrupted.is_set():
                raise KeyboardInterrupt

        warnings: list[str] = []
        engine = render(score, arguments.out, presets, options, progress, warnings.append)
    for name, text in (
        ("limited", "the limiter turned down {} frames: lower some gain"),
        ("contacts_dropped", "{} contacts were dropped: too many at once"),
        ("faults", "objects were silenced {} times, because their sound was not finite"),
    ):
        if count := getattr(engine.stats, name):
            warnings.append(text.format(count))
    for warning in warnings:
        print(f"carom render: {warning}", file=sys.stderr)
    if arguments.plot:
        plot(arguments.out)
    return 0


def _play(arguments: argparse.Namespace) -> int:
    from ..server.osc.score import read

    lines = sorted(read(arguments.score), key=lambda line: line.time)
    failed = 0
    with Client(arguments.host, arguments.port, arguments.tcp) as client:
        client.ask("/version")
        start = time.time() + 0.5
        for line in lines:
            # Up to a second ahead: enough for the server to be in time, little to lose if it goes.
            while (wait := start + line.time - time.time() - 1.0) > 0:
                failed += _print_failures(client, min(wait, 0.1))
            client.send(line.message.address, *line.message.args, at=start + line.time)
        last = lines[-1].time if lines else 0.0
        failed += _print_failures(client, max(0.0, start + last - time.time()) + 0.2)
    return 1 if failed else 0


def _print_failures(client: Client, seconds: float) -> int:
    failures = [reply for reply in client.replies(seconds) if reply.address == "/fail"]
    for reply in failures:
        print(*reply.args, file=sys.stderr)
    return len(failures)


def _send(arguments: argparse.Namespace) -> int:
    from ..server.osc.score import value

    with Client(arguments.host, arguments.port, arguments.tcp) as client:
        replies = client.ask_all(arguments.address, *map(value, arguments.args))
    for reply in replies:
        print(reply.address, *reply.args, file=sys.stderr if reply.address == "/fail" else sys.stdout)
    return 1 if any(reply.address == "/fail" for reply in replies) else 0


def _top(arguments: argparse.Namespace) -> int:
    from .top import top

    with Client(arguments.host, arguments.port, arguments.tcp) as client:
        top(client, arguments.once)
    return 0


def _chart(arguments: argparse.Namespace) -> int:
    from rich.console import Console
    from rich.progress import Progress

    from .chart.run import FULL, QUICK, chart

    terminal = Console(stderr=True)
    with Progress(console=terminal, disable=not terminal.is_terminal, transient=True) as bar:
        task = bar.add_task("", total=1.0)
        for what, done in chart(arguments.folder, QUICK if arguments.quick else FULL):
            bar.update(task, description=what, completed=done)
    return 0


def _devices(_: argparse.Namespace) -> int:
    from ..server.audio.portaudio import devices

    for device in devices():
        mark = "*" if device["default"] else " "
        what = f"{device['channels']} channels, {device['default_samplerate']:.0f} Hz"
        print(f"{mark}{device['index']:3d}  {device['name']} ({device['hostapi']}), {what}")
    return 0


def _presets(arguments: argparse.Namespace) -> int:
    from ..presets import KINDS, Presets

    presets = Presets(arguments.presets)
    if arguments.name is None:
        for kind in KINDS:
            print(f"{kind}:")
            for name in presets.names(kind):
                print(f"  {name:20s} {presets.description(kind, name)}")
        return 0
    kinds = [kind for kind in KINDS if arguments.name in presets.names(kind)]
    for kind in kinds or ["objects"]:
        path = presets.path(kind, arguments.name)
        print(f"# {kind}/{path.name}")
        print(path.read_text(encoding="utf-8"))
    return 0


def _doctor(_: argparse.Namespace) -> int:
    from .doctor import examine

    broken = False
    for well, what, remedy in examine():
        broken |= well is False
        print({True: "ok   ", None: "lack ", False: "FAIL "}[well], what)
        if remedy:
            print("      ", remedy)
    return 1 if broken else 0
