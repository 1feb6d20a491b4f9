"""Replies to other hosts are rationed."""

import pytest

from carom.server.net import reply_budget
from carom.server.osc.wire import Message
from tests.server.net.sockets import udp


def test_answers_elsewhere_are_rationed(monkeypatch):
    now = 100.0
    monkeypatch.setattr(reply_budget.time, "monotonic", lambda: now)
    rations = reply_budget.Allowance()
    assert sum(rations.take("192.0.2.1") for _ in range(5000)) == 1000
    assert rations.take("192.0.2.2") and not rations.take("192.0.2.1")
    now += 0.5
    assert sum(rations.take("192.0.2.1") for _ in range(100)) == 50
    assert all(rations.take(host) for host in ["127.0.0.1", "::1"] for _ in range(5000))
    answered = 0
    for _ in range(1000):  # who asks faster than it may be answered is answered at that rate
        now += 0.001
        answered += rations.take("192.0.2.1")
    assert 99 <= answered <= 101
    for n in range(5000):
        rations.take(f"10.0.{n // 256}.{n % 256}")
        assert n % 500 or not rations.take("192.0.2.1")  # not forgotten for others' sake
    assert len(rations._budgets) <= 1024
    now += 1e4
    for host in ("192.0.2.1", "192.0.2.3"):  # however long it was silent, and however many others there are
        assert sum(rations.take(host) for _ in range(5000)) == 1000


def test_a_host_elsewhere_gets_no_more_than_its_ration(net, stack, monkeypatch):
    monkeypatch.setattr(reply_budget, "local", lambda host: False)
    one = udp(stack)
    one.bind(("127.0.0.1", 0))
    for _ in range(3_000):
        net.send(Message("/a"), one.getsockname())
    assert 1_000 < net.counts["replies_dropped"] <= 2_000
    assert "replies dropped" in net.warnings()[0]


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
