"""What control surfaces, languages and browsers send to a server, and what they are told."""

import math
import socket
import time

import pytest

from carom.server.osc import wire
from carom.server.osc.addresses import VERBS, calls
from carom.server.osc.framing import UNFRAMED
from carom.server.osc.wire import Message
from tests.server.scene.support import ends, refusal, say, seconds
from tests.support import serving

BARE = sorted(address for address, verb in VERBS.items() if verb.is_bare)


@pytest.mark.parametrize("address", BARE)
def test_every_address_without_arguments_takes_a_button(address):
    sent = address.replace("ID", "a").replace("NAME", "a")
    for pressed in (1, 1.0, True, None):
        (call,) = calls(Message(sent, (pressed,)))
        assert call.verb is VERBS[address] and call.message.args == ()
    for let_go in (0, 0.0, False):
        assert calls(Message(sent, (let_go,))) == []
    for other in (2, 0.5, math.nan, "1", b"", (1,)):
        (call,) = calls(Message(sent, (other,)))
        assert call.message.args == (other,)


def test_a_button_stops_a_gesture_as_it_is_pressed(played):
    say(played, "/object/pane/bounce", 1.0, "id", "ball")
    assert say(played, "/gesture/ball/stop", 0.0) == []
    seconds(played, 0.01)
    assert ends(played) == []
    assert say(played, "/gesture/*/stop", 1.0) == []
    seconds(played, 0.01)
    assert ends(played) == [("ball", None)]


@pytest.mark.parametrize("address", ["/object/new bell2 church-bell", "/object/pane/impact 1.0", "/panic 1"])
def test_arguments_inside_an_address_are_named(played, address):
    first, rest = address.split(" ", 1)
    said = refusal(played, address)
    assert f"arguments inside the address: expected the address {first} alone, and {rest} as its arguments" in said


@pytest.mark.parametrize(
    "array", ["3f0000002c6600003f000000", "000000012c69000000000002", "667265650000000" + "02c73000078000000"]
)
def test_a_blob_that_sclang_makes_of_an_array_is_named(played, array):
    blob = bytes.fromhex(array)
    said = refusal(played, "/object/pane/gains", blob)
    assert f"a blob of {len(blob)} bytes, which SuperCollider makes of an array (send $[, its values, $])" in said
    assert "SuperCollider" not in refusal(played, "/object/pane/gains", b"\0\1\2\3\4")


def told(port, sent, wait=3.0):
    """Return what a server says over TCP of a stream, within a time."""
    with socket.create_connection(("127.0.0.1", port), 5) as sock:
        sock.sendall(sent)
        sock.settimeout(wait)
        try:
            data = sock.recv(4096)
            while data and data.count(b"\xc0") < 2:
                data += sock.recv(4096)
        except TimeoutError:
            return ""
        return " ".join(map(str, wire.parse(data.strip(b"\xc0"))[0].messages[0].args))


@pytest.mark.slow
def test_a_server_answers_what_it_can_not_take_from_outside(tmp_path):
    with serving(tmp_path, "--device", "none") as server, server.client() as client:
        status = wire.encode("/status")
        for stream in (status, wire.encode("/sync", 7), status * 3, wire.encode_bundle(1, [Message("/status")])):
            assert UNFRAMED in told(server.port, stream)
        # A client of SLIP may send the END by itself, a little later.
        with socket.create_connection(("127.0.0.1", server.port), 5) as sock:
            for part in (wire.encode("/sync", 9), b"\xc0"):
                sock.sendall(part)
                time.sleep(0.2)
            time.sleep(0.6)
            sock.sendall(wire.encode("/sync", 10) + b"\xc0")
            sock.settimeout(5)
            data = b""
            while data.count(b"/synced") < 2:
                data += sock.recv(4096)
            assert b"/fail" not in data
        assert client.ask_all("/gesture/x/stop", 0) == [] != client.ask_all("/gesture/x/stop", 1)
        assert client.ask("/version", 1).address == "/version.reply"
