"""What clients of other hosts may not do, and what they may."""

import socket
from contextlib import closing

import pytest

from carom.server.net import reply_budget
from carom.server.net.network import Network
from carom.server.net.remote import Remote
from carom.server.options import Options
from carom.server.osc import wire
from carom.server.osc.framing import Sized
from carom.server.start import serving

pytestmark = pytest.mark.slow

OFF = [("off",), ("0",), (0,), (0.0,), (False,)]


def test_no_stranger_turns_the_limiter_off(monkeypatch):
    """Each is told so, however the message comes; this machine's own clients and the others' other messages pass."""
    told: list[bytes] = []

    def deliver(packet: bytes) -> bool:
        told.append(packet)
        return True

    stranger, guest = Remote(deliver, "192.0.2.1", stranger=True), Remote(deliver, "192.0.2.1")
    with serving(Options(port=0, device="none")) as server:
        for args in OFF:
            for address in ("/limiter", "/lim*"):
                for packet in (wire.encode(address, *args), wire.encode_bundle(1, [wire.Message(address, args)])):
                    server._receive(packet, stranger)
        server._receive(wire.encode("/limiter", "on"), stranger)
        messages = [wire.parse(packet)[0].messages[0] for packet in told]
        assert [message.address for message in messages] == ["/fail"] * 4 * len(OFF)
        assert messages[0].args == (
            "/limiter", "a client of another host can't turn it off: expected one of this machine, or --trust"
        )  # fmt: skip
        server.engine.process(64)
        assert server.engine.limiter
        server._receive(wire.encode("/limiter", "off"), guest)
        server.engine.process(128)
        assert not server.engine.limiter


def test_clients_of_other_hosts_are_strangers(monkeypatch):
    with closing(Network("127.0.0.1", 0)) as net, socket.create_connection(net.address) as sock:
        sock.sendall(Sized.framed(wire.encode("/a")))
        (_, connection) = net.receive(1.0)
        assert not net.is_stranger(connection) and not net.is_stranger(("127.0.0.1", 9))
        assert net.is_stranger(("192.0.2.1", 9)) and not net.is_stranger(None)
        monkeypatch.setattr(reply_budget, "local", lambda host: False)
        assert net.is_stranger(connection)
