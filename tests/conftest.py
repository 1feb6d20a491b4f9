"""Fixtures: the command line, rendering, JACK, a server that plays on no device."""

import atexit
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from carom.clients.cli import main
from carom.server.osc.score import read
from tests import needs
from tests.needs import ROOT
from tests.support import CAROM, Jack, Render, Running, render_lines, serving

# The first example may compile a function, and another process may run: no example has a time limit.
# Hypothesis keeps the examples that failed in the checkout, if it may.
_WRITABLE = os.access(ROOT, os.W_OK)
settings.register_profile("carom", deadline=None, **({} if _WRITABLE else {"database": None}))
settings.load_profile("carom")

# In the background of a shell interrupts are ignored, which the processes that tests start would inherit.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Hundreds of processes start; one that renders a blow takes 1.1 s of CPU without bytecode, 0.3 s with it, and pytest
# rewrites each file of tests, which takes 10 s. Where bytecode may not be written beside the sources, it is kept beside
# what pytest keeps, and workers of pytest-xdist inherit the place; what Matplotlib keeps at home, and would complain
# of, is kept for this run.
_own = tempfile.mkdtemp(prefix="carom-tests-")
atexit.register(shutil.rmtree, _own, ignore_errors=True)
if "PYTHONPYCACHEPREFIX" not in os.environ and (sys.dont_write_bytecode or not _WRITABLE):
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False
    sys.pycache_prefix = str(ROOT / ".pytest_cache" / "bytecode") if _WRITABLE else f"{_own}/bytecode"
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix
if not os.access(os.path.expanduser("~"), os.W_OK):
    os.environ.setdefault("MPLCONFIGDIR", f"{_own}/matplotlib")


REAL_TIME = {"jack", "play", "serving", "server", "time"}
"""Fixtures and names in a test's module that say that it waits for a clock."""


PROCESSOR = (
    "clients/export/test_carried.py",
    "documents/test_sounds.py",
    "dsp/bodies",
    "dsp/fitting",
    "dsp/mesh",
    "dsp/spectral",
    "presets/test_losses.py",
    "presets/test_loudness.py",
    "presets/test_making.py",
    "presets/test_sound.py",
    "presets/test_stored.py",
    "presets/test_tables.py",
)
"""Tests of what BLAS, LAPACK and FFT compute, and of sounds that depend on it."""

PLACE = (
    "clients/test_cli.py",
    "clients/test_completion.py",
    "clients/test_strike.py",
    "dsp/native",
    "server/audio",
    "server/files/test_log.py",
    "server/midi",
    "server/test_server.py",
    "test_habits.py",
    "test_house.py",
    "test_readme.py",
)
"""Tests that start programs, write files, look at the checkout, or ask the system for rights."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what other machines can tell. Try a test again that fails in real time, up to twice: a busy machine may have
    been late."""
    folder = Path(__file__).parent
    for item in items:
        assert isinstance(item, pytest.Function)
        name = item.path.relative_to(folder).as_posix()
        for mark, places in (("processor", PROCESSOR), ("place", PLACE)):
            if name.startswith(places):
                item.add_marker(mark)
        if REAL_TIME & {*vars(item.module), *item.fixturenames}:
            item.add_marker(pytest.mark.flaky(reruns=2, reruns_delay=2))


PROGRESS = re.compile(r"^carom \w+: .* after \d+ s\n", re.M)
"""What a command says every 5 s, as it may have to on a busy machine."""


@pytest.fixture
def carom(tmp_path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run the command line in an empty folder."""

    def run(*args: object, check: bool = False) -> subprocess.CompletedProcess[str]:
        words = [*CAROM, *map(str, args)]
        done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=check)
        done.stderr = PROGRESS.sub("", done.stderr)
        return done

    return run


@pytest.fixture
def carom_here(tmp_path, monkeypatch, capsys) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run the command line in an empty folder in this process, which has loaded what a new one takes a second for."""
    monkeypatch.chdir(tmp_path)

    def run(*args: object, check: bool = False) -> subprocess.CompletedProcess[str]:
        capsys.readouterr()
        try:
            code = main([*map(str, args)])
        except SystemExit as ended:
            code = int(ended.code or 0)
        done = subprocess.CompletedProcess(args, code, *capsys.readouterr())
        if check:
            done.check_returncode()
        return done

    return run


@pytest.fixture
def render_text(tmp_path) -> Render:
    """Render the text of a score to an array."""

    def render(text: str, **options) -> np.ndarray:
        path = tmp_path / "score.txt"
        path.write_text(text)
        return render_lines(read(path), **options)

    return render


@pytest.fixture
def jack(monkeypatch) -> Iterator[Jack]:
    """A JACK server to be started, that clients find."""
    needs.program("jackd")
    needs.module("jack")
    server = Jack(f"carom-test-{os.getpid()}")
    monkeypatch.setenv("JACK_DEFAULT_SERVER", server.name)
    monkeypatch.setenv("JACK_NO_START_SERVER", "1")
    try:
        yield server
    finally:
        server.stop()


@pytest.fixture
def server(tmp_path) -> Iterator[Running]:
    """A server that plays by the clock, on no device."""
    with serving(tmp_path, "--device", "none") as running:
        yield running
