"""Replies to other hosts are rationed."""

from ipaddress import ip_network

import pytest

from carom.server.net import reply_budget
from carom.server.osc.wire import Message
from tests.server.net.sockets import udp


def test_a_host_elsewhere_gets_three_times_the_bytes_it_sent(monkeypatch):
    now = 100.0
    monkeypatch.setattr(reply_budget.time, "monotonic", lambda: now)
    rations = reply_budget.Allowance()
    assert not rations.take("192.0.2.1", 1)
    rations.hear("192.0.2.1", 20)
    assert sum(rations.take("192.0.2.1", 10) for _ in range(100)) == 6
    rations.hear("192.0.2.1", 1 << 30)
    assert sum(rations.take("192.0.2.1", 1 << 10) for _ in range(5000)) == 1 << 10  # it saves a MB at most
    assert all(rations.take(host, 1 << 20) for host in ["127.0.0.1", "::1"] for _ in range(5000))


@pytest.mark.slow
def test_hosts_that_are_too_many_share_what_they_sent_and_take_nothing_from_those_that_were_first(monkeypatch):
    now = 100.0
    monkeypatch.setattr(reply_budget.time, "monotonic", lambda: now)
    rations = reply_budget.Allowance()
    rations.hear("192.0.2.1", 20)
    hosts = [f"10.0.{n // 256}.{n % 256}" for n in range(5000)]
    for host in hosts:
        rations.hear(host, 10)
    assert len(rations._saved) <= 1025
    assert sum(rations.take("192.0.2.1", 10) for _ in range(100)) == 6
    sent = sum(rations.take(host, 10) for _ in range(20) for host in hosts)
    assert sent == 3 * 5000 and not rations.take("192.0.2.9", 1)
    now += 61.0
    rations.hear("192.0.2.2", 10)  # has a place of its own, now that the others were silent
    assert len(rations._saved) == 2 and rations.take("192.0.2.2", 30)


def test_a_network_that_is_trusted_is_told_all(monkeypatch):
    rations = reply_budget.Allowance([ip_network("192.0.2.0/24")])
    assert rations.take("192.0.2.7", 1 << 20) and not rations.take("192.0.3.7", 1)
    assert rations.trusts("127.0.0.1") and not rations.trusts("somewhere")


def test_no_question_from_elsewhere_is_answered_by_more_than_three_times_its_bytes(net, stack, monkeypatch):
    monkeypatch.setattr(reply_budget, "local", lambda host: False)
    one = udp(stack)
    one.bind(("127.0.0.1", 0))
    one.sendto(b"/object/*/get\0\0\0,i\0\0\0\0\x10\0", net.address)
    assert net.receive(2.0)
    for _ in range(1_000):
        net.send(Message("/a", ("0123456789",)), one.getsockname())
    assert net.counts["replies_dropped"] == 997  # of 20 bytes each
    assert "--trust" in net.warnings()[0]


@pytest.mark.parametrize(
    ("host", "is_local"),
    [
        ("127.0.0.1", True),
        ("127.1.2.3", True),
        ("localhost", True),
        ("0.0.0.0", False),
        ("10.0.0.1", False),
        ("", False),
    ],
)
def test_what_is_local(host, is_local):
    assert reply_budget.local(host) is is_local
