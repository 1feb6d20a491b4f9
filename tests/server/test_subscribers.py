"""Subscribers, who are told of what no message caused."""

import pytest

from carom.server import subscribers
from carom.server.osc.arguments import Refused
from carom.server.subscribers import Subscribers


class Everywhere:
    def reaches(self, source) -> bool:
        return source != ("gone", 1)

    def forgets(self, source) -> bool:
        return source[0] == "elsewhere"


def test_a_client_that_has_long_been_silent_makes_room(monkeypatch):
    told = []
    clients = Subscribers(Everywhere(), lambda message, source: told.append(source))
    now = 0.0
    monkeypatch.setattr(subscribers.time, "monotonic", lambda: now)
    for n in range(32):
        clients.add(("new" if n < 15 else "host", n))
    with pytest.raises(Refused, match="32 clients"):
        clients.add(("host", 99))
    now = subscribers.LONGEST_SILENCE + 1.0
    clients.hear(("new", 0))
    clients.add(("host", 99))
    assert told == [("new", 1)] and ("host", 99) in clients and ("new", 0) in clients
    clients.remove(("new", 1))
    assert len(list(clients)) == 32


def test_no_host_takes_all_places():
    """A newcomer's host gets as many as the one that has the most, but for one; it loses who was silent for longest."""
    clients = Subscribers(Everywhere(), lambda message, source: None)
    for n in range(32):
        clients.add(("host", n))
    for n in range(16):
        clients.add(("new", n))
    assert list(clients) == [*(("host", n) for n in range(16, 32)), *(("new", n) for n in range(16))]
    with pytest.raises(Refused, match="32 clients"):
        clients.add(("new", 16))
    clients.add(("third", 0))
    assert len(list(clients)) == 32


def test_a_client_that_is_gone_makes_room():
    clients = Subscribers(Everywhere(), lambda message, source: None)
    clients.add(("gone", 1))
    for n in range(32):
        clients.add(("host", n))
    assert ("gone", 1) not in clients


def test_a_client_that_subscribes_again_is_told_once():
    clients = Subscribers(Everywhere(), lambda message, source: None)
    clients.add(("host", 5), level=1)
    clients.add(("host", 5), level=3)
    assert list(clients) == clients.of(3) == [("host", 5)]


@pytest.mark.parametrize("again", [("host", 6), ("host", 9000)])
def test_a_client_that_names_one_port_for_its_answers_subscribes_once_from_whichever_port_it_sends(again):
    clients = Subscribers(Everywhere(), lambda message, source: None)
    clients.add(("host", 5), port=9000)
    clients.add(("other", 5), port=9000)
    clients.add(again, port=9000 if again != ("host", 9000) else 0)
    assert list(clients) == [("other", 5), again]
    assert [clients.receiver(each) for each in clients] == [("other", 9000), ("host", 9000)]


def test_a_client_elsewhere_that_is_silent_for_a_minute_is_told_no_more(monkeypatch):
    clients = Subscribers(Everywhere(), lambda message, source: None)
    now = 0.0
    monkeypatch.setattr(subscribers.time, "monotonic", lambda: now)
    for source in (("elsewhere", 1), ("elsewhere", 2), ("host", 1)):
        clients.add(source, 3)
    now = 50.0
    clients.hear(("elsewhere", 2))
    now = 61.0
    clients.lapse()
    assert set(clients) == {("elsewhere", 2), ("host", 1)}
    now = 111.0
    clients.lapse()
    assert list(clients) == [("host", 1)]
