"""The start of a live server: its network, files, device and web server, and their end."""

import errno
import gc
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ..dsp.native.system import clock_ns
from ..dsp.runtime.engine import Engine
from ..dsp.runtime.memory import touch
from ..presets import Presets
from .audio.supervisor import Player
from .audio.tap import Queue, Tap
from .compiling import wait_for_code
from .files.log import Log
from .files.recorder import Recorder
from .files.takes import Takes
from .net.network import Network
from .options import Options
from .ready import require_ready
from .server import Server

if TYPE_CHECKING:
    from .midi.ports import Ports
    from .web.server import WebServer

_SWITCH = 0.0005  # s that a thread may keep Python's lock while another one wants it


@contextmanager
def serving(options: Options) -> Iterator[Server]:
    """Yield a server ready to `run`. OSError, AudioError, ServeError or PresetError say why it can't start."""
    with ExitStack() as last, ExitStack() as stack:
        with _named(options.bind, options.port, "--port"):
            network = stack.enter_context(closing(Network(options.bind, options.port, options.trusted)))
        presets = Presets(options.presets)
        require_ready(options)
        early = wait_for_code(network)
        engine = options.engine()
        files = stack.enter_context(ExitStack())  # which end after the tap has handed on the last sound
        tap = None
        if options.page is not None or options.recordings is not None:
            tap = stack.enter_context(closing(Tap(engine)))
        recorder = _recorder(engine, options.record, tap, options.said) if options.record else None
        if recorder:
            files.callback(recorder.close)
        path = options.log
        if path is None and options.page is not None:
            path = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="carom-"))) / "session.txt"
        log = Log(engine, path, options.head) if path else None
        if log:
            stack.callback(log.close)
        player = Player(engine, options.device, options.block, options.latency)
        # The files end with the last sound, and before PortAudio is asked to: that may fail, and take its time.
        last.callback(player.close)
        stack.callback(player.rest)
        server = stack.enter_context(closing(Server(network, engine, player, presets, recorder, log, options.scale)))
        # Web clients, datagrams and the making of objects have threads of their own, which keep each other waiting.
        stack.callback(sys.setswitchinterval, sys.getswitchinterval())
        sys.setswitchinterval(_SWITCH)
        server.early.extend(early)
        if options.recordings is not None and tap:
            takes = server.recording.takes = Takes(engine, tap, options.recordings, options.quota, options.said)
            files.callback(takes.close)
        server.start_files()  # not before all else is well: older ones would be lost
        if options.web is not None:
            server.web = _start_web(options, server, tap, stack)
        if options.midi:
            server.midi.ports = stack.enter_context(closing(_midi_ports(options, server)))
        _warm_up(engine)
        # Not before it listens: that is 6,000 pages.
        threading.Thread(
            target=touch, args=(engine.state[0], options.modes, options.objects), name="carom-touch", daemon=True
        ).start()
        yield server


def _recorder(engine: Engine, path: Path, tap: Tap | None, comment: str) -> Recorder:
    if tap is None:
        return Recorder(engine, path, comment=comment)
    queue = Queue(engine.width)
    recorder = Recorder(engine, path, queue.take, comment=comment)
    tap.add(queue)
    return recorder


def _midi_ports(options: Options, server: Server) -> "Ports":
    from .midi.ports import Ports

    return Ports(options.midi, server.midi.hear)


def _start_web(options: Options, server: Server, tap: Tap | None, stack: ExitStack) -> "WebServer":
    from .web.server import answering
    from .web.start import Web, web_server

    assert options.web is not None
    web, listening = web_server(
        Web(options.bind, options.web, options.page, options.certificate, options.tls), server.known, server.network
    )
    if tap:
        web.hear(server.engine, tap)
    with _named(options.bind, options.web, "--oscquery" if options.page is None else "--page"):
        stack.enter_context(answering(web))
    server.on_look = listening.look
    return web


def _warm_up(engine: Engine) -> None:
    """Load what the first client would wait for, and have objects that stay for good not looked at for garbage."""
    engine.send([])
    engine.stamp(clock_ns())
    gc.freeze()
    gc.collect()


@contextmanager
def _named(host: str, port: int, option: str) -> Iterator[None]:
    """Name the port in an OSError inside, and the option that chooses another one where it is taken."""
    try:
        yield
    except OSError as error:
        text = f"port {port} on {host}"
        if error.errno != errno.EADDRINUSE:
            raise OSError(f"{text}: {error.strerror or error}") from error
        free = f"{option} 0 takes any free one"
        raise OSError(f"{text} is in use, perhaps by a Carom that runs already: {free}") from None
