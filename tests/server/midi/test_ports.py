"""MIDI as a process hears it: bytes of a cable in, sound and a log out."""

import os
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np
import pytest
import soundfile

from carom import Client
from carom.server.osc.score import read
from tests import needs
from tests.server.support import counted
from tests.support import render_lines, serving

needs.module("mido")

from carom.server.midi.ports import Ports  # noqa: E402
from carom.server.options import ServeError  # noqa: E402

ROOT = Path(__file__).parents[3]


@pytest.fixture
def cable(tmp_path):
    """The environment of a server whose MIDI is a pipe, and the pipe's name."""
    pipe = tmp_path / "cable"
    os.mkfifo(pipe)
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    env = {"MIDO_BACKEND": "tests.server.midi.fake_backend", "CAROM_CABLE": str(pipe), "PYTHONPATH": path}
    return os.environ | env, pipe


def until(holds, seconds=15.0):
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.slow
def test_a_session_by_midi_is_logged_as_what_it_became_and_renders_to_its_bits(tmp_path, cable):
    env, pipe = cable
    options = ("--device", "none", "--midi", "fake keys", "--record", "out.wav", "--log", "log.txt")
    with serving(tmp_path, *options, env=env) as server:
        with server.client() as client, pipe.open("wb", buffering=0) as keys:
            client.ask("/object/new", "bar", "marimba-bar", timeout=20.0)
            assert counted(client.status())["midi"] == "Fake Keys MIDI 1 20:0"
            client.send("/notify", 1)
            client.ask("/midi/learn", "/object/bar*/gain")
            for note in (60, 64, 67):
                keys.write(bytes([0x90, note, 90]))
                time.sleep(0.1)
            keys.write(bytes([0xB0, 7, 80, 0xB0, 7, 120, 0xB0, 64, 0]))  # learns 7; the pedal is up
            keys.write(bytes([0x80, 60, 0, 0x80, 64, 0]))
            assert [each.args for each in client.replies(1.0) if each.address == "/midi/learnt"] == [
                ("/object/bar*/gain", "7", 0)
            ]
            until(lambda: counted(client.status())["impacts"] >= 3)
            assert client.errors() == [] and client.warnings() == []
        assert server.quit() == (0, "")
    lines = read(tmp_path / "log.txt")
    said = [(line.message.address, *line.message.args) for line in lines]
    addresses = [each[0] for each in said]
    assert addresses.count("/object/bar.64/impact") == 1 and "/object/bar/note" not in addresses
    assert ("/object/bar.60/damp", 1.0) in said and ("/object/bar.67/damp", 1.0) not in said
    assert [each for each in said if each[0] == "/object/bar.67/gain"][-1][2:] == ("over", 0.03)
    recorded, _ = soundfile.read(tmp_path / "out.wav", dtype="float32")
    assert recorded.any()
    np.testing.assert_array_equal(render_lines(lines, seconds=len(recorded) / 48_000), recorded)


@pytest.mark.slow
def test_an_input_that_is_pulled_out_is_opened_again(tmp_path, cable):
    env, pipe = cable
    with serving(tmp_path, "--device", "none", "--midi", "0", env=env) as server, server.client() as client:
        client.ask("/object/new", "bar", "marimba-bar", timeout=20.0)
        client.ask("/notify", 1)
        with pipe.open("wb", buffering=0) as keys:
            keys.write(bytes([0x90, 60, 90]))
        pipe.unlink()
        until(lambda: counted(client.status())["midi"] == "no")
        os.mkfifo(pipe)
        until(lambda: counted(client.status())["midi"] != "no")
        with pipe.open("wb", buffering=0) as keys:
            keys.write(bytes([0x90, 62, 90]))
            until(lambda: counted(client.status())["impacts"] >= 2)
        assert [text.split()[-1] for text in client.warnings()] == ["disappeared", "back"]


@pytest.mark.slow
def test_an_input_that_is_not_there_is_told_with_those_that_are(cable, carom, monkeypatch):
    env, pipe = cable
    for name in ("MIDO_BACKEND", "CAROM_CABLE", "PYTHONPATH"):
        monkeypatch.setenv(name, env[name])
    words = "serve", "--device", "none", "--port", "0", "--midi"
    run = carom(*words, "Piano")
    assert run.returncode == 1 and run.stderr.count("\n") == 1
    assert "midi = Piano: expected one of Fake Keys MIDI 1 20:0, virtual" in run.stderr
    pipe.unlink()
    assert "midi = 3: expected one of virtual" in carom(*words, "3").stderr


@pytest.mark.parametrize("wanted", ["virtual", "0", "Piano"])
def test_a_system_without_a_sequencer_is_told_in_one_line_with_what_to_do(capfd, monkeypatch, wanted):
    monkeypatch.delenv("MIDO_BACKEND", raising=False)
    monkeypatch.setattr("carom.server.midi.ports._SEQUENCER", "/nowhere/seq")
    monkeypatch.setattr("carom.server.midi.ports.find_spec", bool)
    monkeypatch.setattr("sys.platform", "linux")
    with pytest.raises(ServeError, match=r"no /nowhere/seq: expected ALSA's sequencer .*modprobe.*UNIX_JACK"):
        Ports([wanted], print)
    assert capfd.readouterr() == ("", "")


def test_a_python_for_which_rtmidi_has_no_wheel_is_told_what_brings_it(monkeypatch):
    monkeypatch.delenv("MIDO_BACKEND", raising=False)
    monkeypatch.setattr("carom.server.midi.ports.find_spec", lambda _: None)
    with pytest.raises(ServeError, match=r"^midi: python-rtmidi is missing: pip install .*libasound2-dev"):
        Ports(["virtual"], print)


@pytest.mark.slow
def test_the_example_for_midi_plays(tmp_path, cable):
    env, pipe = cable
    env["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), env["PATH"]])
    with closing(socket.socket(type=socket.SOCK_DGRAM)) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = ["sh", str(ROOT / "clients" / "examples" / "shell" / "midi.sh"), "fake keys", str(port), "--device", "none"]
    with (
        subprocess.Popen(words, env=env, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as script,
        ExitStack() as stack,
    ):
        stack.callback(script.terminate)
        said = [script.stdout.readline() for _ in range(6)]
        assert said[0].startswith(f"carom listens on 127.0.0.1:{port}") and said[-1].startswith("/done /midi/learn")
        with Client(port=port) as client, pipe.open("wb", buffering=0) as keys:
            keys.write(bytes([0x90, 59, 90, 0x90, 60, 90, 0xB0, 74, 0, 0xB0, 74, 127]))
            until(lambda: {"marimba.59", "bell.60"} <= set(client.ask("/objects").args))
            until(lambda: counted(client.status())["impacts"] == 2)
            assert client.ask("/midi/controls").args[2:] == (
                "74", 0, "/object/*/decay", pytest.approx(0.1), 2.0,
            )  # fmt: skip
            client.send("/quit")
        assert script.wait(10) == 0


@pytest.mark.slow
def test_rtmidi_hears_jack(tmp_path, jack):
    """The note comes through the library that users have, and JACK's MIDI: the only one of the system's that needs no
    hardware."""
    needs.module("rtmidi")
    import jack as library

    jack.start(256)
    waiting: list[bytes] = []
    client = library.Client("keys", no_start_server=True)
    out = client.midi_outports.register("out")

    @client.set_process_callback
    def process(frames: int) -> None:
        out.clear_buffer()
        while waiting:
            out.write_midi_event(0, waiting.pop(0))

    env = os.environ | {"MIDO_BACKEND": "mido.backends.rtmidi/UNIX_JACK"}
    with client, serving(tmp_path, "--device", "none", "--midi", "keys", env=env) as server, server.client() as player:
        player.ask("/object/new", "bar", "marimba-bar", timeout=20.0)
        for note in (60, 64):
            waiting.append(bytes([0x90, note, 90]))
        until(lambda: counted(player.status())["impacts"] == 2)
        assert {"bar.60", "bar.64"} <= set(player.ask("/objects").args)
