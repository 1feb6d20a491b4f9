"""Datagrams: all that fit the queue come whole, in order and at once, and the rest are counted."""

import random
import sys
import threading
import time
from collections import Counter

import pytest

from carom.dsp.native.atomics import publish
from carom.server.net.udp import CAPACITY, RECEIVE_BUFFER
from tests import needs
from tests.server.net.sockets import A, send_in_time, taken, udp

pytestmark = pytest.mark.slow


def test_datagrams_beyond_the_queue_are_counted_and_their_sender_told(net, stack):
    """One address takes a third of the room; then another of its host a ninth, and one of another host 5 / 27."""
    large = bytes(60_000)
    room = CAPACITY // 60_024
    senders = udp(stack, "127.0.0.1"), udp(stack, "127.0.0.1"), udp(stack, "127.0.0.2")
    for sender in senders:
        send_in_time(sender, [large] * (room // 3 + 8), net)
    got = Counter(source for _, source in taken(net))
    for sender, share in zip(senders, (1 / 3, 1 / 9, 5 / 27), strict=True):
        assert abs(got[sender.getsockname()] - share * room) < 3
    dropped = net.counts["dropped"]
    assert got.total() + dropped == 3 * (room // 3 + 8)
    assert net.losses() == [(f"{dropped} datagrams dropped: the queue was full", senders[2].getsockname())]
    assert net.losses() == [] and f"{dropped} datagrams dropped" in net.warnings()[0]
    for sender in senders:
        send_in_time(sender, [large] * (room // 9), net)
        assert len(taken(net)) == room // 9


def test_a_client_that_waits_leaves_room_for_all_others_of_its_host(net, stack):
    """Whatever it sends meanwhile: it may wait for an object to be made."""
    waits = udp(stack, "127.0.0.1")
    waits.sendto(A, net.address)
    assert net.receive(1.0) == (A, waits.getsockname())
    net.pause(waits.getsockname())
    for _ in range(4):
        send_in_time(waits, [bytes(60_000)] * 60, net)
        assert taken(net) == []
    others = [udp(stack) for _ in range(50)]
    for each in others:
        send_in_time(each, [A] * 20, net)
    assert [packet for packet, _ in taken(net)] == [A] * 1_000


def test_datagrams_of_all_sizes_come_whole_and_in_order(net, stack):
    """The datagrams go round and round the ring."""
    chance = random.Random(5)
    one = udp(stack)
    for _ in range(12):
        sent = [chance.randbytes(chance.choice([0, 1, 7, 8, 9, 100, 5_000, 65_507])) for _ in range(100)]
        got = []
        for start in range(0, len(sent), 10):
            send_in_time(one, sent[start : start + 10], net)
            got += [packet for packet, _ in taken(net, 0.01)]
        assert got == sent
    assert net.counts["dropped"] == 0


def test_datagrams_that_the_system_drops_are_counted(net, stack):
    """More than its buffer holds, while nobody empties that."""
    if sys.platform != "linux":
        needs.skip("the system does not tell what it drops", "Linux does")
    publish(net._intake._stopped, 1)
    net._intake._thread.join()
    one = udp(stack)
    for _ in range(600):
        one.sendto(bytes(60_000), net.address)
    (line,) = net.warnings()
    assert "receive buffer is too small" in line and net.warnings() == []
    assert 400 < net.counts["dropped_by_system"] < 600


def test_a_burst_of_ten_thousand_waits_while_nobody_looks(net, stack):
    if net.receive_buffer < RECEIVE_BUFFER:
        needs.receive_buffer()
    one = udp(stack)
    for _ in range(10_000):
        one.sendto(A, net.address)
    time.sleep(0.5)
    assert len(taken(net)) == 10_000 and not any(net.counts.values())


def test_arriving_datagram_wakes_the_one_who_waits(net, stack):
    one = udp(stack)
    waits = []
    for _ in range(50):
        timer = threading.Timer(0.01, one.sendto, (A, net.address))
        timer.start()
        started = time.monotonic()
        assert net.receive(5.0)
        waits.append(time.monotonic() - started)
        timer.join()
    assert max(waits) < 1.0
    before = time.thread_time()
    assert net.receive(0.3) is None and time.thread_time() - before < 0.1  # and nobody else
