"""Who is told of what no message caused."""

import pytest

from carom.server import subscribers
from carom.server.osc.arguments import Refused
from carom.server.subscribers import Subscribers


class Everywhere:
    def reaches(self, source) -> bool:
        return source != ("gone", 1)


def test_a_client_that_has_long_been_silent_makes_room(monkeypatch):
    told = []
    clients = Subscribers(Everywhere(), lambda message, source: told.append(source))
    now = 0.0
    monkeypatch.setattr(subscribers.time, "monotonic", lambda: now)
    for n in range(32):
        clients.add(("host", n))
    with pytest.raises(Refused, match="32 clients"):
        clients.add(("new", 1))
    now = subscribers.LONGEST_SILENCE + 1.0
    clients.hear(("host", 0))
    clients.add(("new", 1))
    assert told == [("host", 1)] and ("new", 1) in clients and ("host", 0) in clients
    clients.remove(("host", 1))
    assert len(list(clients)) == 32


def test_a_client_that_is_gone_makes_room():
    clients = Subscribers(Everywhere(), lambda message, source: None)
    clients.add(("gone", 1))
    for n in range(32):
        clients.add(("host", n))
    assert ("gone", 1) not in clients
