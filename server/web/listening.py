"""News for OSCQuery's clients: paths that come and go, and values that they listen to."""

from collections.abc import Callable, Iterable
from typing import Any

from ..osc.wire import encode
from .socket import SocketClient

Value = Callable[[str], list[Any] | None]


class Listening:
    """Notifies the clients of web sockets. `look` often, in the server's thread."""

    def __init__(self, clients: Iterable[SocketClient], value: Value) -> None:
        self._clients = clients
        self._value = value
        self._there: dict[str, None] = {}
        self._told: dict[SocketClient, dict[str, list[Any] | None]] = {}

    def look(self, there: Iterable[str]) -> None:
        """Report what is new, with the names of the objects that are there."""
        names = dict.fromkeys(there)
        clients = tuple(self._clients)
        for name in (name for name in self._there if name not in names):
            for client in clients:
                client.tell("PATH_REMOVED", f"/object/{name}")
        for name in (name for name in names if name not in self._there):
            for client in clients:
                client.tell("PATH_ADDED", f"/object/{name}")
        self._there = names
        self._told = {client: self._tell_values(client) for client in clients if client.listens}

    def _tell_values(self, client: SocketClient) -> dict[str, list[Any] | None]:
        before = self._told.get(client, {})
        now = {path: self._value(path) for path in tuple(client.listens)}
        for path, value in now.items():
            if value is not None and before.get(path) != value:
                client.send(encode(path, *value))
        return now
