"""Replies by datagram that nobody reads in time: those that Linux counts, on this machine."""

import select
import socket
import sys
from pathlib import Path

import pytest

from carom.server.net.unread import Unread
from carom.server.osc.wire import Message
from tests.server.net.sockets import A, taken, udp

HEAD = "  sl  local_address rem_address st tx_queue rx_queue tr tm->when retrnsmt uid timeout inode ref pointer drops\n"


def row(port: int, drops: int) -> str:
    return f" 12: 0100007F:{port:04X} 00000000:0000 07 00000000:00000000 00:00000000 00000000 0 0 471 2 0000 {drops}\n"


@pytest.mark.skipif(sys.platform != "linux", reason="Linux alone counts what sockets lose")
def test_replies_and_what_was_lost_of_them_add_up(net, stack):
    slow = udp(stack)
    slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 14)
    slow.sendto(A, net.address)
    ((_, receiver),) = taken(net)
    for number in range(400):
        net.send(Message("/synced", (number,)), receiver)
    read = 0
    while select.select([slow], [], [], 0.1)[0]:
        slow.recv(1_024)
        read += 1
    assert 0 < read < 300 and read + net.counts["replies_dropped"] == 400
    assert any(f"{400 - read} replies dropped" in line for line in net.warnings()) and net.warnings() == []


def test_receivers_are_counted_since_they_got_a_reply(tmp_path: Path):
    """Others are not, and a socket that takes a port anew begins at 0."""
    table = tmp_path / "udp"
    unread = Unread((table, tmp_path / "missing"))
    assert unread.count() == 0
    counts = []
    for mine, others in ((0, 5), (3, 9), (3, 9), (10, 9), (0, 9), (2, 9)):
        table.write_text(HEAD + row(57_120, mine) + row(57_121, others))
        unread.send_to(57_120)
        counts.append(unread.count())
        assert unread.count() == counts[-1]
    assert counts == [0, 3, 3, 10, 10, 12]
