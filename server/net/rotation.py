"""Turns of the clients that have sent something: hosts take turns, and so do the clients of each host.

A host is an address, whatever the port. By the port alone, one machine could take as many turns as it has ports. Behind
one address (NAT, a loopback) its clients share its turns. Whoever forges many addresses takes a turn for each.
"""

from collections import OrderedDict, deque
from typing import Generic, TypeVar

Client = TypeVar("Client")


class Rotation(Generic[Client]):
    """Clients that wait for their turns, each of a host."""

    def __init__(self) -> None:
        self._hosts: OrderedDict[str, deque[Client]] = OrderedDict()  # whose turn it is comes first

    def __bool__(self) -> bool:
        return bool(self._hosts)

    def add(self, host: str, client: Client) -> None:
        """Put a client last among those of its host."""
        self._hosts.setdefault(host, deque()).append(client)

    def take(self, but: object = None) -> Client | None:
        """Take out the client whose turn it is, other than `but`; None where there is none."""
        for _ in range(len(self._hosts)):
            host, clients = self._hosts.popitem(last=False)
            if clients[0] is but:
                clients.rotate(-1)
            client = None if clients[0] is but else clients.popleft()
            if clients:
                self._hosts[host] = clients
            if client is not None:
                return client
        return None
