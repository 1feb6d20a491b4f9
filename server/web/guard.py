"""Admission to the web server: no other site's scripts, and from elsewhere only whoever has the token."""

import re
import secrets
import socket
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from ipaddress import ip_address
from urllib.parse import urlsplit

from multidict import CIMultiDictProxy
from yarl import URL

COOKIE = "carom-token"
"""Keeps the token of an address that was opened once."""
_KEPT = re.compile(rf"(?:^|;) *{COOKIE}=([\w-]*)", re.ASCII)


@dataclass(frozen=True)
class Guard:
    """The checks of a request. `token`: what an address must hold; empty where only this machine can ask.

    `also`: names besides this machine's own that a request may call it by.
    """

    token: str = ""
    also: Iterable[str] = ()
    _names: frozenset[str] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        host = socket.gethostname().lower()
        own = {"localhost", host, f"{host.partition('.')[0]}.local", *(name.lower() for name in self.also)}
        object.__setattr__(self, "_names", frozenset(own))

    def refusal(self, headers: CIMultiDictProxy[str], url: URL) -> str:
        """Return why a request is refused; empty if it is not. url: its path and query, whatever host it names."""
        hosts = headers.getall("Host", [])
        if len(hosts) != 1 or not self._is_ours(hosts[0]):
            return "another site's name: expected this server's own address"
        # An Origin is a scheme and what a Host is, or "null".
        if any(origin.partition("//")[2].lower() != hosts[0].lower() for origin in headers.getall("Origin", [])):
            return "another site's script: expected the page of this server"
        if self.token and not self._has_token(headers, url):
            return "the token is missing or wrong: open the address that the server printed at its start"
        return ""

    def _is_ours(self, host: str) -> bool:
        """True if a Host is this server: an address, localhost, or this machine's name, alone or in `.local`.

        A page of another site that makes its own name lead here (DNS rebinding) gets no answer.
        """
        name = ""
        with suppress(ValueError):
            name = (urlsplit(f"//{host}").hostname or "").lower()
        if name in self._names:
            return True
        with suppress(ValueError):
            return bool(ip_address(name))
        return False

    def _has_token(self, headers: CIMultiDictProxy[str], url: URL) -> bool:
        kept = _KEPT.search(headers.get("Cookie", ""))  # among cookies of any form, which others of this host have left
        given = url.query.get("token") or (kept[1] if kept else "")
        return secrets.compare_digest(given.encode(errors="replace"), self.token.encode())


def new_token() -> str:
    """Return a token that nobody guesses."""
    return secrets.token_urlsafe(12)
