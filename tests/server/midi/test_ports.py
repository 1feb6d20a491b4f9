"""MIDI as a process hears it: bytes of a cable in, sound and a log out."""

import os
import time
from pathlib import Path

import numpy as np
import pytest
import soundfile

from carom.server.osc.score import read
from tests.server.support import counted
from tests.support import render_lines, serving

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


@pytest.mark.slow
def test_rtmidi_hears_jack(tmp_path, jack):
    """The note comes through the library that users have, and JACK's MIDI: the only one of the system's that needs no
    hardware."""
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
