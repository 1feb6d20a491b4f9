"""Datagrams: all that fit the queue come whole, in order and at once, and the rest are counted."""

import random
import sys
import threading
import time

import pytest

from carom.dsp.native.atomics import publish
from carom.server.net.udp import CAPACITY, RECEIVE_BUFFER
from tests import needs
from tests.server.net.sockets import A, send_in_time, taken, udp

pytestmark = pytest.mark.slow


def test_datagrams_beyond_the_queue_are_counted_and_their_sender_told(net, stack):
    large = bytes(60_000)
    fitting = CAPACITY // 60_024 // 2
    first, second = udp(stack), udp(stack)
    send_in_time(first, [large] * (fitting - 8), net)
    send_in_time(second, [large] * 40, net)
    got = taken(net)
    dropped = net.counts["dropped"]
    assert fitting - 2 <= len(got) <= fitting and len(got) + dropped == fitting + 32
    assert net.losses() == [
        (f"{dropped} datagrams dropped: the queue was full", ("127.0.0.1", second.getsockname()[1]))
    ]
    assert net.losses() == [] and f"{dropped} datagrams dropped" in net.warnings()[0]
    second.sendto(A, net.address)
    assert [packet for packet, _ in taken(net)] == [A]


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


def test_what_the_system_drops_is_counted(net, stack):
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


def test_what_arrives_wakes_who_waits(net, stack):
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
