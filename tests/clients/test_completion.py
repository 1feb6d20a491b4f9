"""carom completion: what a shell completes."""

import subprocess
import sys

import pytest

from carom.clients.commands.completion import SHELLS
from tests import needs
from tests.support import CAROM

pytestmark = pytest.mark.slow

ASK = """
source completion.bash
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=()
_shtab_carom carom "${COMP_WORDS[$COMP_CWORD]}" "${COMP_WORDS[$((COMP_CWORD - 1))]}"
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture(scope="module")
def script():
    """The script for bash."""
    return subprocess.run([*CAROM, "completion", "bash"], capture_output=True, text=True, check=True).stdout


@needs.without("bash")
@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("re", ["render"]),
        ("strike mar", ["marimba-bar"]),
        ("strike marimba-bar bar.wav --str", ["--striker"]),
        ("strike marimba-bar bar.wav --striker fing", ["fingernail", "fingertip"]),
        ("render --format ", ["16", "24", "float"]),
        ("render scor", ["score.txt"]),
        ("presets church", ["church-bell"]),
        ("completion z", ["zsh"]),
        ("send /object/NAME/b", ["/object/NAME/bounce"]),
    ],
)
def test_bash_completes(script, tmp_path, monkeypatch, words, found):
    program = tmp_path / "carom"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m carom "$@"\n')
    program.chmod(0o755)
    (tmp_path / "score.txt").write_text("")
    (tmp_path / "completion.bash").write_text(script)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    asked = ["bash", "-c", ASK, "bash", "carom", *words.split(" ")]
    run = subprocess.run(asked, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert run.stdout.split() == found


@pytest.mark.parametrize("shell", SHELLS)
def test_every_shell_gets_a_script_with_every_command(carom_here, shell):
    written = carom_here("completion", shell, check=True).stdout
    assert all(command in written for command in ("render", "strike", "listen", "oscquery"))
