"""Limits on replies: the sender of a datagram may be forged, so that the reply hits somebody else."""

import time
from collections.abc import Sequence
from functools import lru_cache
from ipaddress import IPv4Network, IPv6Network, ip_address

Nets = Sequence[IPv4Network | IPv6Network]

FACTOR = 3
"""A host gets at most so many times the bytes that it sent, as of a server of QUIC (RFC 9000, 8.1)."""
_MOST = 1 << 20  # bytes that a host may have saved
_HOSTS = 1_024  # remembered; all others share what they sent
_FORGOTTEN = 60.0  # s of silence after which a host is
_OTHERS = ""


class Allowance:
    """The bytes that each host may be sent, but for this one and those of networks that are trusted."""

    def __init__(self, trusted: Nets = ()) -> None:
        self._trusted = trusted
        self._saved: dict[str, float] = {_OTHERS: 0.0}  # bytes
        self._heard: dict[str, float] = {}  # s; the host that was silent for longest comes first

    def trusts(self, host: str) -> bool:
        """True if a host is this machine, or of a network that is trusted."""
        return local(host) or any(_in(host, net) for net in self._trusted)

    def hear(self, host: str, size: int) -> None:
        """Note that a host has sent so many bytes."""
        if self.trusts(host):
            return
        now = time.monotonic()
        while self._heard and now - next(iter(self._heard.values())) > _FORGOTTEN:
            silent = next(iter(self._heard))
            del self._heard[silent], self._saved[silent]
        known = self._heard.pop(host, None) is not None or len(self._heard) < _HOSTS
        if known:
            self._heard[host] = now
        account = host if known else _OTHERS
        self._saved[account] = min(_MOST, self._saved.get(account, 0.0) + FACTOR * size)

    def take(self, host: str, size: int) -> bool:
        """Spend so many bytes of a reply to a host; return False if there are fewer left."""
        if self.trusts(host):
            return True
        account = host if host in self._saved else _OTHERS
        if size > self._saved[account]:
            return False
        self._saved[account] -= size
        return True


@lru_cache(maxsize=64)
def local(host: str) -> bool:
    """True if a host is this machine's loopback, which others cannot reach."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


@lru_cache(maxsize=1_024)
def _in(host: str, net: IPv4Network | IPv6Network) -> bool:
    """True if a host is of a network."""
    try:
        return ip_address(host) in net
    except ValueError:
        return False
