"""Turns: hosts, the clients of each, and questions that yield; and what is kept of what waits."""

import time

import pytest

from carom.server.net import network
from carom.server.net.places import Places, most_places
from carom.server.net.rotation import Rotation
from carom.server.osc import wire
from carom.server.osc.urgency import Urgency, urgency
from tests import needs
from tests.server.net.sockets import A, send_in_time, taken, udp

STATUS = wire.encode("/status")


@pytest.mark.slow
def test_a_blow_of_another_host_comes_at_once_amid_a_flood_and_each_sender_s_packets_stay_in_order(net, stack):
    flood, other = udp(stack, "127.0.0.2"), udp(stack, "127.0.0.1")
    send_in_time(flood, [STATUS, A] * 1_000, net)
    other.sendto(A, net.address)
    other.sendto(STATUS, net.address)
    time.sleep(0.1)
    got = taken(net, 0.0)
    places = [place for place, (_, source) in enumerate(got) if source == other.getsockname()]
    assert len(got) == 2_002 and places[0] < 4 and places[1] < 12
    assert [packet for packet, source in got if source == other.getsockname()] == [A, STATUS]
    assert [packet for packet, source in got if source != other.getsockname()] == [STATUS, A] * 1_000


@pytest.mark.slow
def test_ports_of_a_host_take_turns_and_have_those_of_one_host_together(net, stack):
    ports, other = [udp(stack, "127.0.0.2") for _ in range(20)], udp(stack)
    for each in (*ports, other):
        send_in_time(each, [A] * 20, net)
    time.sleep(0.1)
    got = [source[0] for _, source in taken(net, 0.0)]
    assert len(got) == 420 and 18 <= got[:40].count("127.0.0.1") <= 20


@pytest.mark.slow
def test_however_much_a_host_sends_another_finds_room(net, stack):
    """And however many ports it has."""
    flood = [udp(stack, "127.0.0.2") for _ in range(200)]
    for n in range(10_000):
        flood[n % 200].sendto(bytes(1_000), net.address)
        if n % 4 == 3:
            time.sleep(0.0001)
    other = udp(stack)
    send_in_time(other, [A] * 1_000, net)
    time.sleep(0.1)
    got: list[str] = []
    deadline = time.monotonic() + 30.0
    while sum(net.counts.values()) + len(got) < 11_000 and time.monotonic() < deadline:
        got += [source[0] for _, source in taken(net, 0.1)]
    assert (
        got.count("127.0.0.1") == 1_000
        and net.counts["dropped"] > 1_000
        and sum(net.counts.values()) + len(got) == 11_000
    )


def test_long_packets_of_a_host_that_is_held_wait_and_nothing_else_does(net, stack):
    long = wire.encode("/long", "a" * 2_000)
    ports, other = [udp(stack, "127.0.0.2") for _ in range(3)], udp(stack, "127.0.0.1")
    net.hold("127.0.0.2")
    for each in (*ports, other):
        for packet in (A, long, A):
            each.sendto(packet, net.address)
    time.sleep(0.05)
    got = taken(net, 0.05)
    assert [packet for packet, source in got if source == other.getsockname()] == [A, long, A]
    assert [packet for packet, source in got if source != other.getsockname()] == [A] * 3
    net.release("127.0.0.2")
    got = taken(net, 0.05)
    assert all([packet for packet, source in got if source == each.getsockname()] == [long, A] for each in ports)


def test_a_question_that_waited_for_too_long_is_dropped_counted_and_told_and_nothing_else_is(net, stack, monkeypatch):
    monkeypatch.setattr(network, "PATIENCE", 0.1)
    one = udp(stack, "127.0.0.1")
    for each in (STATUS, STATUS, A, STATUS, wire.encode("/sync", 1), STATUS):
        one.sendto(each, net.address)
    time.sleep(0.05)
    net._gather(0.0)
    time.sleep(0.15)
    assert [packet for packet, _ in taken(net, 0.05)] == [A, STATUS, wire.encode("/sync", 1), STATUS]
    assert net.counts["outdated"] == 2
    assert net.losses() == [("2 questions dropped: they had waited for 2 s", one.getsockname())]
    assert net.losses() == [] and "2 questions dropped" in net.warnings()[0]


def test_a_question_may_wait_for_as_long_as_its_client_is_paused(net, stack, monkeypatch):
    monkeypatch.setattr(network, "PATIENCE", 0.1)
    one = udp(stack)
    one.sendto(A, net.address)
    one.sendto(STATUS, net.address)
    first = net.receive(1.0)
    assert first
    net.pause(first[1])
    assert net.receive(0.2) is None
    net.resume(first[1])
    assert net.receive(1.0) == (STATUS, first[1])


@pytest.mark.parametrize(
    ("packet", "kind"),
    [
        (wire.encode("/status"), Urgency.QUESTION | Urgency.ASIDE),
        (wire.encode("/presets", "objects"), Urgency.QUESTION | Urgency.ASIDE),
        (wire.encode("/object/*/get", 4096), Urgency.QUESTION),
        (wire.encode("/objects"), Urgency.QUESTION),
        (wire.encode("/sync", 1), Urgency.ASIDE),
        (wire.encode("/object/a/impact", 1.0), Urgency.COMMAND),
        (wire.encode("/quit"), Urgency.COMMAND),
        (wire.encode_bundle(1, [wire.Message("/status"), wire.Message("/objects")]), Urgency.QUESTION),
        (wire.encode_bundle(1, [wire.Message("/status"), wire.Message("/panic")]), Urgency.COMMAND),
        (b"/status", Urgency.COMMAND),
        (b"", Urgency.COMMAND),
    ],
)
def test_urgency_of_a_packet_follows_from_its_messages(packet, kind):
    assert urgency(packet) == kind


def test_a_rotation_takes_each_host_in_turn_and_leaves_out_one_client():
    rotation: Rotation[str] = Rotation()
    for host, client in (("a", "a1"), ("a", "a2"), ("b", "b1"), ("a", "a3")):
        rotation.add(host, client)
    assert [rotation.take(but="a1") for _ in range(4)] == ["a2", "b1", "a3", None]
    assert rotation.take() == "a1" and rotation.take() is None and not rotation


def test_places_go_to_hosts_that_have_fewer_and_from_those_that_are_quiet():
    places: Places[str] = Places(6, 4)
    for n in range(4):
        assert places.is_free("a")
        places.come(f"a{n}", "a")
        places.rouse(f"a{n}")
    assert not places.is_free("a") and places.who_makes_way("a") is None
    places.hush("a2")
    assert places.who_makes_way("a") == "a2"
    places.rouse("a2")
    for n in range(2):
        places.come(f"b{n}", "b")
        places.rouse(f"b{n}")
    assert not places.is_free("c") and places.who_makes_way("c") == "a0"
    places.leave("a0")
    places.come("c0", "c")
    assert places.who_makes_way("b") is None and places.who_makes_way("d") == "a1"


def test_places_are_no_more_than_descriptors_allow(monkeypatch):
    resource = needs.module("resource")
    for limit, most in ((1_024, 64), (256, 53), (100, 8), (resource.RLIM_INFINITY, 64)):
        monkeypatch.setattr(resource, "getrlimit", lambda kind, limit=limit: (limit, limit))
        assert most_places(64, 1 / 3) == most
