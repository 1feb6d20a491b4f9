"""The start and the end of the live server, and its errors if it can't start."""

import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
import soundfile

from tests import needs
from tests.support import CAROM, Running, serving

pytestmark = pytest.mark.slow


def failing(folder: Path, *args: str, env: dict[str, str] | None = None) -> str:
    """Return the one line that a `serve` says which can't start, before it exits with 1."""
    run = subprocess.run([*CAROM, "serve", *args], cwd=folder, env=env, capture_output=True, text=True, timeout=60)
    assert run.returncode == 1 and run.stdout == "" and run.stderr.count("\n") == 1
    return run.stderr


def test_wrong_options_are_told(tmp_path):
    none = ("--port", "0", "--device", "none")
    assert "no/such/out.wav: No such file or directory" in failing(tmp_path, *none, "--record", "no/such/out.wav")
    assert "/dev/full: Invalid argument" in failing(tmp_path, *none, "--record", "/dev/full")
    assert "/dev/full: Invalid argument" in failing(tmp_path, *none, "--log", "/dev/full")
    assert "out.flac: expected a name that ends in .wav" in failing(tmp_path, *none, "--record", "out.flac")
    same = failing(tmp_path, *none, "--record", "same", "--log", "same")
    assert "same: is being written already" in same and not (tmp_path / "same").exists()
    assert "latency = 3: expected 0 to 2 s" in failing(tmp_path, *none, "--latency", "3")
    assert "no/presets: expected a folder" in failing(tmp_path, *none, "--presets", "no/presets")
    assert "rate = 1: expected" in failing(tmp_path, *none, "--rate", "1")
    assert "port = 70000: expected" in failing(tmp_path, "--port", "70000", "--device", "none")


def test_a_server_that_can_not_be_leaves_recordings_alone(tmp_path):
    (tmp_path / "old.wav").write_bytes(b"an earlier session")
    for wrong in (("--presets", "none"), ("--device", "no-such-device")):
        args = ("--port", "0", "--device", "none", "--record", "old.wav", *wrong)
        failing(tmp_path, *args)
        failing(tmp_path, *args[:4], "--record", "new.wav", *wrong)
    assert (tmp_path / "old.wav").read_bytes() == b"an earlier session" and not (tmp_path / "new.wav").exists()


def test_no_portaudio_is_told(tmp_path):
    # A sounddevice that finds no library, as on a machine without PortAudio.
    (tmp_path / "sounddevice.py").write_text("raise OSError('PortAudio library not found')\n")
    env = os.environ | {"PYTHONPATH": str(tmp_path)}
    assert "PortAudio library not found: install PortAudio" in failing(tmp_path, "--port", "0", env=env)
    with serving(tmp_path, "--device", "none", env=env) as running:
        assert running.quit()[0] == 0


def test_an_unknown_device_is_told(tmp_path):
    needs.module("sounddevice")
    assert "device no-such-device" in failing(tmp_path, "--port", "0", "--device", "no-such-device")


def test_a_second_server_says_so(tmp_path, server: Running):
    assert f"port {server.port} on 127.0.0.1 is in use, perhaps by a Carom that runs already: --port 0" in failing(
        tmp_path, "--port", str(server.port)
    )
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as taken:  # by another program, for TCP alone
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        assert f"port {port} on 127.0.0.1 is in use, perhaps by a Carom that runs already: --port 0" in failing(
            tmp_path, "--port", port
        )
    with server.client() as client:
        assert client.status().args[0] == 1


def test_listening_to_others_is_warned_of(tmp_path):
    with serving(tmp_path, "--device", "none", "--bind", "0.0.0.0") as server:
        code, errors = server.quit()
    assert (
        code == 0
        and "carom serve: warning: listening on 0.0.0.0: anyone who can reach" in errors
        and errors.count("\n") == 1
    )


def test_server_starts_within_seconds(tmp_path):
    with serving(tmp_path, "--device", "none"):  # so that the compiled code is there
        pass
    started = time.monotonic()
    with serving(tmp_path, "--device", "none"):
        assert time.monotonic() - started < 5.0  # on a machine that does other things too; `make bench` has the figure


def test_python_m_works():
    run = subprocess.run([sys.executable, "-m", "carom", "--version"], capture_output=True, text=True)
    assert run.stdout.startswith("carom ")


def test_signals_end_it_well(tmp_path):
    with serving(tmp_path, "--device", "none", "--record", "out.wav") as server:
        time.sleep(0.3)
        server.process.terminate()
        assert server.process.wait(timeout=10) == 0
    assert soundfile.info(tmp_path / "out.wav").frames > 4800
