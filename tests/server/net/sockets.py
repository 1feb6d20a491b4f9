"""Sockets that talk to a network, and what they and it have got."""

import select
import socket
import sys
import time
from collections.abc import Iterable
from contextlib import ExitStack

from carom.server.net.network import Network, Source
from carom.server.osc import wire
from carom.server.osc.framing import Sized, Slip
from carom.server.osc.wire import Message
from tests import needs

A = wire.encode("/a", 1)


def require_hosts(host: str) -> None:
    """Skip a test that needs another address of this machine than 127.0.0.1, where it has no other."""
    if host != "127.0.0.1" and sys.platform != "linux":
        needs.skip("127.0.0.2 is no address of this machine", "Linux has all of 127.0.0.0/8")


def client(net: Network, stack: ExitStack, host: str = "127.0.0.1") -> socket.socket:
    require_hosts(host)
    return stack.enter_context(socket.create_connection(net.address, 2, (host, 0)))


def udp(stack: ExitStack, host: str = "") -> socket.socket:
    sock = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
    if host:
        require_hosts(host)
        sock.bind((host, 0))
    return sock


def taken(net: Network, seconds: float = 0.2) -> list[tuple[bytes, Source]]:
    """Return all that comes until nothing has for so long."""
    packets = []
    while arrived := net.receive(seconds):
        packets.append(arrived)
    return packets


def replies(sock: socket.socket, framing: Sized | Slip) -> list[Message]:
    """Return the messages that a client has got, up to silence or the end."""
    messages = []
    while select.select([sock], [], [], 0.2)[0] and (data := sock.recv(1 << 16)):
        messages += [bundle.messages[0] for packet in framing.packets(data) for bundle in wire.parse(packet)]
    return messages


def ended(sock: socket.socket) -> bool:
    try:
        return sock.recv(1) == b""
    except ConnectionResetError:
        return True


def send_in_time(sock: socket.socket, packets: Iterable[bytes], net: Network) -> None:
    """Send packets not so fast that the system would lose any, on any machine."""
    for number, packet in enumerate(packets):
        sock.sendto(packet, net.address)
        if number % 4 == 3:
            time.sleep(0.001)
