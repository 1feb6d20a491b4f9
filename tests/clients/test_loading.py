"""The commands that a command line loads."""

import subprocess
import sys

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
