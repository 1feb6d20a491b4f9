"""Limits on replies: the sender of a datagram may be forged, so that the reply hits somebody else."""

from collections import OrderedDict
from collections.abc import Sequence
from functools import lru_cache
from ipaddress import IPv4Network, IPv6Network, ip_address

Nets = Sequence[IPv4Network | IPv6Network]

FACTOR = 3
"""A host gets at most so many times the bytes that it sent, as of a server of QUIC (RFC 9000, 8.1)."""
_FRAGMENT, _FRAME = 1_480, 66
"""Bytes of a packet's load at most, and of its heads and gaps on Ethernet (8 + 14 + 20 + 8 + 4 + 12). Of what is sent
they count, of what was received they don't: so the factor holds however it is measured."""
_MOST = 4_096  # bytes that a host may have saved: else a forged one's could come all at once
_HOSTS = 1_024  # remembered: those that were heard last


class Allowance:
    """The bytes that each host may be sent, but for this one and those of networks that are trusted."""

    def __init__(self, trusted: Nets = ()) -> None:
        self._trusted = trusted
        self._saved: OrderedDict[str, int] = OrderedDict()  # bytes; the host that was silent for longest comes first

    def trusts(self, host: str) -> bool:
        """True if a host is this machine, or of a network that is trusted."""
        return local(host) or any(_in(host, net) for net in self._trusted)

    def hear(self, host: str, size: int) -> None:
        """Note that a host has sent so many bytes."""
        if self.trusts(host):
            return
        self._saved[host] = min(_MOST, self._saved.pop(host, 0) + FACTOR * size)
        if len(self._saved) > _HOSTS:
            self._saved.popitem(last=False)

    def has(self, host: str, size: int) -> bool:
        """True if a host may be sent a reply of so many bytes."""
        return self.trusts(host) or self._saved.get(host, 0) >= _cost(size)

    def take(self, host: str, size: int) -> bool:
        """Spend so many bytes of a reply to a host; return False if there are fewer left."""
        if not self.has(host, size):
            return False
        if host in self._saved:
            self._saved[host] -= _cost(size)
        return True


def _cost(size: int) -> int:
    """Return the bytes that a reply of a size takes on its way."""
    return size + _FRAME * -(-(size + 8) // _FRAGMENT)


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
