"""Replies to other hosts are rationed."""

from ipaddress import ip_network

import pytest

from carom.server.net import reply_budget
from carom.server.osc.wire import Message
from tests.server.net.sockets import udp


def sent(rations: reply_budget.Allowance, host: str, size: int) -> int:
    """Return how many replies of a size (bytes) a host is sent of ten thousand."""
    return sum(rations.take(host, size) for _ in range(10_000))


@pytest.mark.parametrize("size", [1, 20, 100, 1_500, 65_507])
@pytest.mark.parametrize("heard", [8, 24, 1_400, 24_016, 65_507])
def test_a_host_elsewhere_gets_three_times_the_bytes_it_sent_with_heads_and_gaps(size, heard):
    """On Ethernet a datagram takes 66 bytes more, and 58 for each further fragment of 1,480 bytes."""
    rations = reply_budget.Allowance()
    assert not rations.take("192.0.2.1", 1)
    rations.hear("192.0.2.1", heard)
    wire = size + 66 + 58 * ((size + 8 - 1) // 1_480)
    assert sent(rations, "192.0.2.1", size) * wire <= 3 * heard
    assert all(rations.take(host, 1 << 20) for host in ["127.0.0.1", "::1"] for _ in range(100))


def test_allowance_that_a_host_saves_is_little():
    """However much was sent in its name, and for however long: a forged one's could come all at once."""
    rations = reply_budget.Allowance()
    for _ in range(10_000):
        rations.hear("192.0.2.1", 65_507)
    assert sent(rations, "192.0.2.1", 100) * 166 <= 4_096


@pytest.mark.slow
def test_each_of_many_hosts_gets_three_times_what_itself_sent():
    """Of ten thousand those that were heard last are remembered; one that is forgotten begins anew, with nothing."""
    rations = reply_budget.Allowance()
    rations.hear("192.0.2.1", 100)
    hosts = [f"10.0.{n // 256}.{n % 256}" for n in range(10_000)]
    for host in hosts:
        rations.hear(host, 100)
    assert len(rations._saved) <= 1_024
    assert not rations.has("192.0.2.1", 1) and not rations.has("192.0.2.9", 1)
    found = [sum(rations.take(host, 34) for _ in range(20)) for host in hosts]
    assert set(found) == {0, 3} and found[-1024:] == [3] * 1_024
    rations.hear("192.0.2.1", 100)
    assert rations.has("192.0.2.1", 234) and not rations.has("192.0.2.1", 235)


def test_a_network_that_is_trusted_is_told_all(monkeypatch):
    rations = reply_budget.Allowance([ip_network("192.0.2.0/24")])
    assert rations.take("192.0.2.7", 1 << 20) and not rations.take("192.0.3.7", 1)
    assert rations.trusts("127.0.0.1") and not rations.trusts("somewhere")


def test_no_question_from_elsewhere_is_answered_by_more_than_three_times_its_bytes(net, stack, monkeypatch):
    monkeypatch.setattr(reply_budget, "local", lambda host: False)
    one = udp(stack)
    one.bind(("127.0.0.1", 0))
    for _ in range(20):
        one.sendto(b"/object/*/get\0\0\0,i\0\0\0\0\x10\0", net.address)
        assert net.receive(2.0)
    for _ in range(1_000):
        net.send(Message("/a", ("0123456789",)), one.getsockname())
    assert net.counts["replies_dropped"] == 1_000 - 20 * 24 * 3 // (20 + 66)
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
def test_loopback_hosts_are_local(host, is_local):
    assert reply_budget.local(host) is is_local
