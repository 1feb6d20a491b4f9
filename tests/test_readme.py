"""What the README says runs, and its tables are the program's own."""

import os
import re
import shutil
import socket
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest
import soundfile

from carom.presets.library import Presets
from carom.server.osc.addresses import table
from carom.server.osc.wire import DEFAULT_PORT

pytestmark = pytest.mark.slow

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def blocks(*languages: str) -> list[tuple[str, str]]:
    found = re.findall(r"^```(\w+)\n(.*?)^```", README, re.MULTILINE | re.DOTALL)
    return [(language, text) for language, text in found if language in languages]


def test_the_address_table_is_the_programs():
    assert table() in README


def with_port(text: str, port: int) -> str:
    """What the README says, to a port that is free, as the default may not be."""
    for said, meant in (
        (str(DEFAULT_PORT), str(port)),
        ("carom serve", f"carom serve --port {port}"),
        ("carom send", f"carom send --port {port}"),
        ("carom play", f"carom play --port {port}"),
        ("carom top", f"carom top --port {port}"),
        ("Client()", f"Client(port={port})"),
    ):
        text = text.replace(said, meant)
    return text


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        return sock.getsockname()[1]


def test_the_tour_runs(tmp_path):
    """The score, every command and every Python example, in the order they stand, as a user types them."""
    if not shutil.which("oscsend"):
        pytest.skip("oscsend is not installed")
    carom = tmp_path / "carom"
    carom.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m carom "$@"\n')
    carom.chmod(0o755)
    env = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}"}
    port = free_port()
    with ExitStack() as stack:
        for language, text in blocks("score", "sh", "python"):
            text = with_port(text, port)
            if language == "score":
                (tmp_path / "strike.txt").write_text(text)
            elif language == "python":
                subprocess.run([sys.executable, "-c", text], cwd=tmp_path, env=env, check=True, timeout=60)
            else:
                for line in text.splitlines():
                    if line.endswith("&"):
                        words = line.rstrip("& ").split()
                        server = stack.enter_context(
                            subprocess.Popen(words, cwd=tmp_path, env=env, stdout=subprocess.PIPE)
                        )
                        stack.callback(server.kill)
                        assert server.stdout and b"listens" in server.stdout.readline()
                    else:
                        subprocess.run(line, shell=True, cwd=tmp_path, env=env, check=True, timeout=60)
        assert server.wait(timeout=10) == 0
    assert soundfile.info(tmp_path / "session.wav").duration > 3
    assert soundfile.info(tmp_path / "strike.wav").duration > 2 and (tmp_path / "strike.png").exists()


def test_the_preset_it_shows_is_one(tmp_path):
    ((_, text),) = blocks("toml")
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "mine.toml").write_text(text)
    presets = Presets([tmp_path])
    assert len(presets.object("mine").modes(20_000).frequency) > 3
    kinds = ("objects", "strikers", "materials", "surfaces")
    counted = re.search(r"(\d+) objects over .*?(\d+) strikers, (\d+) materials, (\d+) surfaces", README, re.DOTALL)
    assert counted and [int(n) for n in counted.groups()] == [
        len(presets.names(kind)) - (kind == "objects") for kind in kinds
    ]


def test_the_sclang_it_shows_plays(tmp_path):
    if not shutil.which("sclang"):
        pytest.skip("sclang is not installed")
    from tests.support import serving

    ((_, text),) = blocks("supercollider")
    with serving(tmp_path, "--device", "none") as server:
        script = tmp_path / "readme.scd"
        script.write_text(f"({text.replace('57140', str(server.port))} fork {{ 1.wait; 0.exit }};)")
        env = os.environ | {"QT_QPA_PLATFORM": "offscreen", "QTWEBENGINE_DISABLE_SANDBOX": "1", "HOME": str(tmp_path)}
        subprocess.run(["sclang", str(script)], env=env, check=True, timeout=60, capture_output=True)
        with server.client() as client:
            status = client.status().args
        assert dict(zip(status[9::2], status[10::2], strict=True))["impacts"] == 1
