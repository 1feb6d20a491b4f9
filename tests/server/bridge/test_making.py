"""Bodies of a simulation are made beside the rest, as objects are."""

import socket
import time
from contextlib import ExitStack, suppress

import pytest
import soundfile

from carom.server.osc import wire
from carom.server.osc.score import read
from carom.server.osc.wire import Message
from tests.support import answer_times, render_lines, serving

pytestmark = pytest.mark.slow

PLATE = ("plate", "wood", 3.0, 2.0)  # takes some 0.1 s and more


def test_other_clients_are_answered_while_plates_and_a_sphere_are_made(tmp_path):
    with serving(tmp_path, "--device", "none") as server, server.client() as maker, server.client() as other:
        maker.send("/world/body", "a", "sphere", "plastic", 10)  # it froze the server for good
        for n in range(20):
            maker.send("/world/body", f"plate{n}", *PLATE, 0.004 + 1e-5 * n)
        answers = answer_times(other, maker)
        assert not maker.errors() and other.ask("/status").args[3] == 21
        assert len(answers) > 20 and sorted(answers)[len(answers) * 9 // 10] < 0.1
        assert server.quit() == (0, "")


def test_messages_to_a_simulation_wait_for_its_bodies_whoever_sends_them(tmp_path):
    """Each message is sent as by a script: from a client of its own. The log renders to what was recorded."""
    lines = [
        Message("/world/body", ("floor", *PLATE, 0.01, "held", 1)),
        Message("/world/body", ("ball", "sphere", "rubber", 0.05)),
        Message("/world/pair", ("floor", "ball", "restitution", 0.6)),
        Message("/world/step", (0.0,)),
        Message("/world/pose", ("ball", 0, 0, 0.05, 1, 0, 0, 0, 0, 0, -1)),
        Message("/world/touch", ("floor", "ball", 0, 0, 0, 0, 0, 1, "approach", 1.0, "depth", 0.002)),
        Message("/world/step", (0.02,)),
    ]
    with (
        ExitStack() as closed,
        serving(tmp_path, "--device", "none", "--record", "out.wav", "--log", "log.txt") as server,
    ):
        senders = [closed.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in lines]
        for sender, line in zip(senders, lines, strict=True):
            sender.setblocking(False)
            sender.sendto(wire.encode(line.address, *line.args), ("127.0.0.1", server.port))
        with server.client() as client:
            while client.ask("/status", timeout=30.0).args[3] < 2:
                time.sleep(0.02)
            time.sleep(0.5)
        answers = []
        for sender in senders:
            with suppress(BlockingIOError):
                while True:
                    answers.append(sender.recv(65_536))
        assert len(answers) == 2 and all(answer.startswith(b"/done") for answer in answers)
        assert server.quit() == (0, "")
    logged = [line.message.address for line in read(tmp_path / "log.txt")]
    assert "/object/floor/impact" in logged
    recorded, rate = soundfile.read(tmp_path / "out.wav", dtype="float32")
    sound = render_lines(read(tmp_path / "log.txt"), seconds=len(recorded) / rate)
    assert (sound == recorded).all() and abs(sound).max() > 1e-4
