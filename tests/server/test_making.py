"""Objects are made beside the rest: nobody else waits, and what a client sends keeps its order."""

import socket
import struct
import time

import numpy as np
import pytest
import soundfile

from carom.clients.client import Client
from carom.server.osc import wire
from carom.server.osc.score import read
from carom.server.osc.wire import Message
from tests.server.support import counted
from tests.support import render_lines, serving

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with serving(tmp_path_factory.mktemp("making"), "--device", "none") as server:
        yield server


def slow(name: str, seed: int) -> Message:
    """Return a message that asks for an object that takes some 0.1 s to make: no two of these are alike."""
    return Message("/object/new", (name, "cymbal", "radius", 0.2 + 0.0001 * seed))


@pytest.mark.parametrize("tcp", [False, True])
def test_other_clients_are_answered_while_objects_are_made(server, tcp):
    with Client(port=server.port, tcp=tcp) as maker, server.client() as other:
        other.new("near", "wood-block")
        for n in range(10):
            maker.send(*_words(slow(f"slow{n}", 20 * tcp + n)))
        maker.send("/sync", 7)
        answers, impacts = [], counted(other.status())["impacts"]
        while True:
            started = time.monotonic()
            other.impact("near", 0.1)
            status = other.status()
            answers.append(time.monotonic() - started)
            if status.args[3] >= 11:
                break
            time.sleep(0.002)
        answers.sort()
        assert len(answers) > 20 and answers[len(answers) // 2] < 0.02 and answers[len(answers) * 19 // 20] < 0.1
        assert any(reply == Message("/synced", (7,)) for reply in maker.replies(2.0))
        other.ask("/sync", 1)
        time.sleep(0.1)
        assert counted(other.status())["impacts"] == impacts + len(answers) and other.errors() == []
        other.send("/object/*/free", 1)
        other.ask("/sync", 2)
        time.sleep(0.2)


@pytest.mark.parametrize("swarm", [("rain", 300.0), ("shake", 20.0)], ids=lambda swarm: swarm[0])
def test_tables_of_pulses_are_made_beside(server, swarm):
    # Drops have a table, and each exponent of a contact law; one takes most of a second.
    with Client(port=server.port) as player, server.client() as other:
        action, amount = swarm
        player.new("board", "wood-board")
        player.ask("/sync", 1)
        player.send(f"/object/board/{action}", amount, *(() if action == "rain" else ("exponent", 2.1)))
        player.send("/sync", 2)
        answers, begun = [], time.monotonic()
        while not any(reply == Message("/synced", (2,)) for reply in player.replies(0.001)):
            started = time.monotonic()
            other.status()
            answers.append(time.monotonic() - started)
            assert started - begun < 60.0
        assert sorted(answers)[len(answers) * 19 // 20] < 0.1 and player.errors() == []
        player.send("/object/board/free", 1)
        player.ask("/sync", 3)


def test_a_bundle_that_waits_for_tables_is_carried_out_once(server):
    with Client(port=server.port) as player:
        player.new("shelf", "wood-board")
        player.ask("/sync", 1)
        before = counted(player.status())["impacts"]
        with player.bundle():
            player.send("/object/shelf/impact", 0.1)
            for exponent in (1.23, 3.21):
                player.send("/object/shelf/shake", 0.01, "exponent", exponent)
        player.ask("/sync", 2, timeout=60.0)
        time.sleep(0.1)
        assert counted(player.status())["impacts"] == before + 1 and player.errors() == []


def _words(message: Message) -> tuple:
    return message.address, *message.args


@pytest.mark.parametrize("tcp", [False, True])
def test_messages_of_a_client_keep_their_order(server, tcp):
    with Client(port=server.port, tcp=tcp) as client:
        for n in range(3):
            client.send(*_words(slow("a", 100 + 20 * tcp + n)))
            client.impact("a", 1.0, id=f"strike{n}")
            client.send("/object/a/roll", 0.5, "striker", "glass-marble", "surface", "glass", "id", "marble")
            client.gesture("marble", "speed", 0.4)
            client.send("/object/*/gain", -6)
            client.send("/object/a/free", 1)
        assert client.ask("/sync", 3) == Message("/synced", (3,))
        assert client.errors() == []


def test_a_script_of_messages_each_from_a_client_of_its_own(server):
    """Each message comes as oscsend's: what names an object in the making, or a gesture on it, waits for it; the rest
    does not."""
    lines = [
        slow("x", 200), Message("/object/x/roll", (0.5, "striker", "glass-marble", "id", "ball")),
        Message("/gesture/ball/speed", (0.3,)), Message("/object/*/gain", (-3,)), Message("/object/[w-z]/pan", (0.3,)),
        Message("/object/new", ("y", "wood-block")), Message("/object/y/impact", (0.1, "by", "x")),
        Message("/object/x/free", (1,)), slow("x", 201), Message("/object/x/impact", (1.0,)),
    ]  # fmt: skip
    answers = []
    for line in lines:
        sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        sock.settimeout(0.05)
        sock.sendto(wire.encode(line.address, *line.args), ("127.0.0.1", server.port))
        answers.append(sock)
    time.sleep(1.0)
    replies = []
    for sock in answers:
        try:
            while True:
                replies += [each for bundle in wire.parse(sock.recv(65_536)) for each in bundle.messages]
        except TimeoutError:
            sock.close()
    assert [reply for reply in replies if reply.address not in ("/done", "/gesture/end", "/warning")] == []
    assert sum(reply.address == "/done" for reply in replies) == 3


def test_errors_of_new_objects_are_told(server):
    with server.client() as client:
        client.send("/object/new", "b", "cymbal", "radius", -1.0)
        client.send("/object/new", "b", "cymbals")
        client.send("/object/new", "b/c", "cymbal", "radius", 0.19)
        client.send("/object/new")
        client.ask("/sync", 4)
        reasons = [str(error) for error in client.errors()]
    assert [reason.split(":")[1].split()[0] for reason in reasons] == ["radius", "no", "name", "name"]


def test_a_copy_for_a_note_is_of_its_own_object_however_many_a_packet_makes(server):
    """Each bundle of a packet makes an object, or plays a note on the first one."""
    bundles = [[Message("/object/new", ("bar", "marimba-bar"))]]
    for n in range(20):
        bundles.append([Message("/object/new", (f"wood{n}.{i}", "wood-block")) for i in range(5)])
        bundles.append([Message("/object/bar/note", (60 + n, 64))])
    parts = [wire.encode_bundle(1, messages) for messages in bundles]
    packet = b"#bundle\0" + struct.pack(">Q", 1) + b"".join(struct.pack(">i", len(part)) + part for part in parts)
    with server.client() as client, socket.create_connection(("127.0.0.1", server.port)) as sock:
        sock.sendall(struct.pack(">i", len(packet)) + packet)
        for _ in range(100):
            pairs = [each for reply in client.ask_all("/objects") for each in reply.args[2:]]
            presets = dict(zip(pairs[::2], pairs[1::2], strict=True))
            if "bar.79" in presets:
                break
            time.sleep(0.05)
        assert {presets[f"bar.{60 + n}"] for n in range(20)} == {"marimba-bar"}
        client.send("/object/*/free", 1)
        client.ask("/sync", 5)
        time.sleep(0.2)


def test_an_object_in_the_making_does_not_hold_up_the_end(tmp_path):
    """The log is not spoilt either."""
    with serving(tmp_path, "--device", "none", "--record", "out.wav", "--log", "log.txt") as server:
        with server.client() as client, server.client() as other:
            other.new("a", "wood-block")
            client.ask(*_words(slow("first", 299)), timeout=30.0)  # a first time takes longer
            for n in range(30):
                client.send(*_words(slow(f"s{n}", 300 + n)))
                client.impact(f"s{n}", 1.0)
                other.impact("a", 1.0)
                time.sleep(0.02)
            for n in range(100):
                client.send(*_words(slow(f"t{n}", 400 + n)))
            started = time.monotonic()
            other.ask("/quit")
        assert server.process.wait(5) == 0 and time.monotonic() - started < 2.0
    recorded, rate = soundfile.read(tmp_path / "out.wav", dtype="float32")
    lines = read(tmp_path / "log.txt")
    assert 1 < sum(line.message.address == "/object/new" for line in lines) < 132
    np.testing.assert_array_equal(render_lines(lines, seconds=len(recorded) / rate), recorded)
