"""Other programs play the live server: oscsend, Pure Data, SuperCollider."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import soundfile

from tests import needs
from tests.server.support import counted, onsets
from tests.support import Running, serving

pytestmark = pytest.mark.slow

EXAMPLES = Path(__file__).parents[2] / "clients" / "examples"


def client_programs() -> list[tuple[str, list[str]]]:
    return [
        ("oscsend", ["sh", str(EXAMPLES / "shell" / "strike.sh"), "PORT"]),
        ("pd", ["pd", "-nogui", "-noaudio", "-send", "port PORT", str(EXAMPLES / "puredata" / "strike.pd")]),
        ("sclang", ["sclang", str(EXAMPLES / "supercollider" / "strike.scd"), "PORT"]),
    ]


@pytest.mark.parametrize(("program", "words"), client_programs(), ids=lambda v: v if isinstance(v, str) else "")
def test_other_programs_strike(tmp_path, program, words):
    needs.program(program)
    # sclang brings a browser for its help, which needs a screen and refuses to be root.
    env = os.environ | {"QT_QPA_PLATFORM": "offscreen", "QTWEBENGINE_DISABLE_SANDBOX": "1", "HOME": str(tmp_path)}
    with serving(tmp_path, "--device", "none", "--record", "out.wav") as server:
        words = [word.replace("PORT", str(server.port)) for word in words]
        subprocess.run(words, env=env, check=True, timeout=60, capture_output=True)
        time.sleep(0.5)
        with server.client() as client:
            status = client.status()
        assert server.quit()[0] == 0
    assert counted(status)["impacts"] >= 1
    assert onsets(tmp_path / "out.wav") >= 1


PD_HAND = """#N canvas 0 0 400 300 12;
#X obj 20 20 loadbang;
#X obj 20 50 delay 800;
#X msg 20 80 0.5;
#X obj 20 110 s speed;
#X obj 120 50 delay 1300;
#X msg 120 80 0.02;
#X obj 220 50 delay 2000;
#X msg 220 80 \\; pd quit;
#X connect 0 0 1 0;
#X connect 1 0 2 0;
#X connect 2 0 3 0;
#X connect 0 0 4 0;
#X connect 4 0 5 0;
#X connect 5 0 3 0;
#X connect 0 0 6 0;
#X connect 6 0 7 0;
"""


def test_a_slider_in_pd_rolls_a_marble(tmp_path):
    needs.program("pd")
    (tmp_path / "hand.pd").write_text(PD_HAND)
    with serving(tmp_path, "--device", "none", "--record", "out.wav") as server:
        words = ["pd", "-nogui", "-noaudio", "-send", f"port {server.port}", str(EXAMPLES / "puredata" / "roll.pd")]
        subprocess.run([*words, "hand.pd"], cwd=tmp_path, check=True, timeout=30, capture_output=True)
        with server.client() as client:
            client.roll("pane", 0.0)
        assert server.quit()[0] == 0
    level = np.abs(soundfile.read(tmp_path / "out.wav")[0]).max(axis=1)
    start = int(np.argmax(level > 1e-3))
    fast, slow = level[start : start + 19_200].std(), level[start + 36_000 : start + 48_000].std()
    assert fast > 3 * slow > 0  # steered, not started anew


PD_NOTE = """#N canvas 0 0 400 300 12;
#X obj 20 20 loadbang;
#X obj 20 50 delay 800;
#X msg 20 80 57 90;
#X obj 20 110 s note;
#X obj 220 50 delay 2000;
#X msg 220 80 \\; pd quit;
#X connect 0 0 1 0;
#X connect 1 0 2 0;
#X connect 2 0 3 0;
#X connect 0 0 4 0;
#X connect 4 0 5 0;
"""


@pytest.mark.parametrize(
    ("words", "notes"),
    [
        (("pd", "-nogui", "-noaudio", "-send", "port PORT", EXAMPLES / "puredata" / "notes.pd", "note.pd"), 1),
        (("sclang", EXAMPLES / "supercollider" / "notes.scd", "PORT", "exit"), 8),
        ((sys.executable, EXAMPLES / "python" / "notes.py", "PORT"), 9),
    ],
    ids=["pd", "sclang", "python"],
)
def test_other_programs_play_notes(tmp_path, server: Running, words, notes):
    """The notes are as many as they are, each on a copy of the bar, and none is refused."""
    if words[0] in needs.PROGRAMS:
        needs.program(words[0])
    (tmp_path / "note.pd").write_text(PD_NOTE)
    env = os.environ | {"QT_QPA_PLATFORM": "offscreen", "QTWEBENGINE_DISABLE_SANDBOX": "1", "HOME": str(tmp_path)}
    words = [str(word).replace("PORT", str(server.port)) for word in words]
    with server.client() as client:
        client.new("first", "marimba-bar")  # on a busy machine that takes longer than the programs wait
        client.ask("/notify", 2)
        subprocess.run(words, cwd=tmp_path, env=env, check=True, timeout=60, capture_output=True)
        told = list(client.replies(0.5))
        assert counted(client.status())["impacts"] == notes
    added = [reply.args[0] for reply in told if reply.address == "/object.added"]
    assert len(added) == len(set(added)) > 1 and {name.split(".")[0] for name in added} <= {"bar", "tuned-bar", "first"}


SCLANG_TCP = """(fork {
    var n = NetAddr("127.0.0.1", PORT);
    n.connect;
    n.sendMsg("/object/new", "a", "wood-block");
    0.2.wait;
    n.sendBundle(0.1, ["/object/a/impact", 1.0]);
    1.wait;
    0.exit;
})"""


@pytest.mark.parametrize("program", ["oscsend", "sclang"])
def test_other_programs_strike_over_tcp(tmp_path, server: Running, program):
    needs.program(program)
    (tmp_path / "strike.scd").write_text(SCLANG_TCP.replace("PORT", str(server.port)))
    send = ["oscsend", f"osc.tcp://localhost:{server.port}"]
    commands = {
        "oscsend": [[*send, "/object/new", "ss", "a", "wood-block"], [*send, "/object/a/impact", "f", "1"]],
        "sclang": [["sclang", "strike.scd"]],
    }
    env = os.environ | {"QT_QPA_PLATFORM": "offscreen", "QTWEBENGINE_DISABLE_SANDBOX": "1", "HOME": str(tmp_path)}
    for words in commands[program]:
        subprocess.run(words, cwd=tmp_path, env=env, check=True, timeout=60, capture_output=True)
    until = time.monotonic() + 10.0
    with server.client() as client:
        while time.monotonic() < until and not counted(client.status())["impacts"]:
            time.sleep(0.02)
        assert counted(client.status())["impacts"] == 1
