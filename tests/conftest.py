"""What tests share: rendering scores, a server in a process of its own."""

import re
import subprocess
import sys
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
