"""Common code of the tests: rendering scores, a JACK server without hardware, a server in a process of its own."""

import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from carom.clients.client import Client
from carom.presets.library import Presets
from carom.server.osc.score import Line
from carom.server.render import Options, blocks

CAROM = (sys.executable, "-m", "carom")


Render = Callable[..., np.ndarray]

LIMITED = """
import os, resource, sys
sys.dont_write_bytecode, os.environ["PYTHONDONTWRITEBYTECODE"] = True, "1"  # here, and in the processes that it starts
from carom.clients.cli import main
from carom.dsp.runtime.engine import prepare
prepare()
size = int(sys.argv.pop(1))
resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
sys.exit(main())
"""


def limited(size: int) -> tuple[str, ...]:
    """Return words that begin Carom's command line, in a process whose files end after so many bytes, as on a full
    disk; it cuts neither bytecode nor machine code that others would find."""
    return sys.executable, "-c", LIMITED, str(size)


def render_lines(lines: list[Line], presets: Presets | None = None, **options) -> np.ndarray:
    """Render a score: its sound, float32 (frames, channels)."""
    chosen = Options(**options)
    return np.concatenate(list(blocks(lines, chosen.engine(lines), presets or Presets(), chosen)))


@dataclass
class Jack:
    """A JACK server without hardware, under a name of its own."""

    name: str
    process: subprocess.Popen[bytes] | None = None

    def start(self, frames: int, rate: int = 48_000, channels: int = 2) -> None:
        """Start it, with blocks of some frames, and wait until it is there."""
        import jack

        words = ["jackd", "-r", "-n", self.name, "-d", "dummy", "-r", str(rate), "-p", str(frames)]
        words += ["-P", str(channels)]
        self.process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 10
        while True:
            try:
                return jack.Client("carom-waits", no_start_server=True).close()
            except jack.JackOpenError:
                assert time.monotonic() < deadline, "jackd does not start"
                time.sleep(0.1)

    def kill(self) -> None:
        """End it without its taking leave of anyone."""
        assert self.process
        self.process.kill()
        self.process.wait()

    def stop(self) -> None:
        """End it. One that was killed is started once more: else it would keep one of JACK's eight places for good."""
        if self.process:
            if self.process.poll() is not None:
                self.start(256)
            self.process.send_signal(signal.SIGCONT)
            self.process.terminate()
            self.process.wait(timeout=10)
            self.process = None


@dataclass
class Running:
    """A server in a process of its own."""

    process: subprocess.Popen[str]
    port: int

    def client(self) -> Client:
        return Client(port=self.port)

    def quit(self) -> tuple[int, str]:
        """End it; return its exit code and what it said on stderr."""
        with self.client() as client:
            client.ask("/quit")
        _, errors = self.process.communicate(timeout=30)
        return self.process.returncode, errors


@contextmanager
def serving(
    folder: Path, *args: object, env: dict[str, str] | None = None, carom: Sequence[str] = CAROM
) -> Iterator[Running]:
    """Yield a server on a free port, ready to be played. carom: the words that begin its command line."""
    words = [*carom, "serve", "--port", "0", *map(str, args)]
    pipe = subprocess.PIPE
    process = subprocess.Popen(words, cwd=folder, stdout=pipe, stderr=pipe, text=True, env=env)
    try:
        assert process.stdout and process.stderr
        ready = process.stdout.readline()
        match = re.search(r"listens on \S+:(\d+)", ready)
        assert match, process.stderr.read()
        yield Running(process, int(match[1]))
    finally:
        process.kill()
        process.communicate()


def answer_times(other: Client, busy: Client) -> list[float]:
    """Ask /status for one client until another one's /sync, sent before, is answered; return how long each took, s."""
    busy.send("/sync", 1)
    times, begun = [], time.monotonic()
    while time.monotonic() - begun < 60:
        asked = time.monotonic()
        assert other.ask("/status", timeout=30.0)
        times.append(time.monotonic() - asked)
        if any(reply.address == "/synced" for reply in busy.replies(0.002)):
            return times
    raise TimeoutError("/sync: no reply within 60 s")
