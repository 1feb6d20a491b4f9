"""What tests share: rendering scores, a server in a process of its own."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from carom.clients.client import Client
from carom.dsp.host import Engine
from carom.server.presets import Presets
from carom.server.render import Options, blocks
from carom.server.score import Line, read

CAROM = (sys.executable, "-m", "carom.clients")

Render = Callable[..., np.ndarray]


@pytest.fixture
def carom(tmp_path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run the command line in an empty folder."""

    def run(*args: object, check: bool = False) -> subprocess.CompletedProcess[str]:
        words = [*CAROM, *map(str, args)]
        return subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=check)

    return run


@pytest.fixture
def render_text(tmp_path) -> Render:
    """Render the text of a score to an array."""

    def render(text: str, **options) -> np.ndarray:
        path = tmp_path / "score.txt"
        path.write_text(text)
        return render_lines(read(path), **options)

    return render


def render_lines(lines: list[Line], **options) -> np.ndarray:
    """The sound of a score, float32 (frames, 2)."""
    chosen = Options(**options)
    return np.concatenate(list(blocks(lines, Engine(chosen.rate), Presets(), chosen)))


@dataclass
class Jack:
    """A JACK server without hardware, under a name of its own."""

    name: str
    process: subprocess.Popen[bytes] | None = None

    def start(self, frames: int, rate: int = 48_000) -> None:
        """Start it, with blocks of some frames, and wait until it is there."""
        import jack

        words = ["jackd", "-r", "-n", self.name, "-d", "dummy", "-r", str(rate), "-p", str(frames)]
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
        self.process.kill()  # its place in JACK's registry is free once it is started again
        self.process.wait()

    def stop(self) -> None:
        if self.process:
            self.process.send_signal(signal.SIGCONT)
            self.process.terminate()
            self.process.wait(timeout=10)
            self.process = None


@pytest.fixture
def jack(monkeypatch) -> Iterator[Jack]:
    """A JACK server to be started, that clients find."""
    pytest.importorskip("jack", reason="JACK's library is not installed", exc_type=OSError)
    if not shutil.which("jackd"):
        pytest.skip("jackd is not installed")
    server = Jack(f"carom-test-{os.getpid()}")
    monkeypatch.setenv("JACK_DEFAULT_SERVER", server.name)
    monkeypatch.setenv("JACK_NO_START_SERVER", "1")
    try:
        yield server
    finally:
        server.stop()


@dataclass
class Running:
    """A server in a process of its own."""

    process: subprocess.Popen[str]
    port: int

    def client(self) -> Client:
        return Client(port=self.port)

    def quit(self) -> tuple[int, str]:
        """End it; returns its exit code and what it said on stderr."""
        with self.client() as client:
            client.ask("/quit")
        _, errors = self.process.communicate(timeout=30)
        return self.process.returncode, errors


@contextmanager
def serving(folder: Path, *args: object, env: dict[str, str] | None = None) -> Iterator[Running]:
    """A server on a free port, ready to be played."""
    words = [*CAROM, "serve", "--port", "0", *map(str, args)]
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


@pytest.fixture
def server(tmp_path) -> Iterator[Running]:
    """A server that plays by the clock, on no device."""
    with serving(tmp_path, "--device", "none") as running:
        yield running
