"""The commands that a command line loads."""

import subprocess
import sys
from pathlib import Path

import pytest

from carom.clients import cli


def test_each_command_has_its_name() -> None:
    """A command's file, and the name by which it is asked for, are the same."""
    assert [each.name for each in cli.commands()] == list(cli.NAMES)


@pytest.mark.slow
def test_a_command_loads_no_other() -> None:
    """A line that names a command loads neither the others nor the bridge to simulators, nor what writes OSC."""
    code = "import sys, carom.clients.cli as c; c.main(['strike', 'no-such', 'out.wav']); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert "carom.clients.commands.strike" in loaded and "carom.server.scene.session" in loaded
    assert not {f"carom.clients.commands.{name}" for name in cli.NAMES if name != "strike"} & loaded
    assert not {"webbrowser", "pythonosc", "carom.server.bridge.wire"} & loaded


@pytest.mark.slow
def test_a_strike_loads_what_it_needs(tmp_path: Path) -> None:
    """A strike on listed modes loads no other shape, no library of sound files, and nothing for errors alone."""
    code = "import sys, carom.clients.cli as c; c.main(['strike', 'church-bell', sys.argv[1]]); print(*sys.modules)"
    for _ in range(2):  # the first one makes the modes, and keeps them
        done = subprocess.run(
            [sys.executable, "-c", code, tmp_path / "bell.wav"], capture_output=True, text=True, check=True
        )
    loaded = set(done.stdout.split())
    assert "carom.dsp.bodies.listed" in loaded
    assert not {f"carom.dsp.bodies.{name}" for name in ("bar", "disc", "plate", "ring", "sphere", "string")} & loaded
    assert not {"scipy", "soundfile", "threadpoolctl", "logging", "difflib", "numba", "llvmlite"} & loaded
    assert (
        not {"carom.dsp.contact.closed_form", "carom.dsp.swarm.tables", "carom.dsp.bodies.similar", "numpy.polynomial"}
        & loaded
    )
