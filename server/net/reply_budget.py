"""Limits on replies: the sender of a datagram may be forged, so that the reply hits somebody else."""

import time
from collections import OrderedDict
from functools import lru_cache
from ipaddress import ip_address

_BURST = 1_000  # replies
_RATE = 100.0  # replies per second
_HOSTS = 1_024  # remembered


class Allowance:
    """A budget of replies for each host but this one: nobody elsewhere can send in its name."""

    def __init__(self) -> None:
        self._budgets: OrderedDict[str, tuple[float, float]] = OrderedDict()  # replies left, and when that was (s)

    def take(self, host: str) -> bool:
        """Spend one reply to a host; returns False if it has none left."""
        if local(host):
            return True
        now = time.monotonic()
        left, then = self._budgets.pop(host, (float(_BURST), now))
        left = min(_BURST, left + _RATE * (now - then))
        self._budgets[host] = max(left - 1.0, 0.0) if left >= 1.0 else left, now
        if len(self._budgets) > _HOSTS:
            self._budgets.popitem(last=False)
        return left >= 1.0


@lru_cache(maxsize=64)
def local(host: str) -> bool:
    """Whether a host is this machine's loopback, which others cannot reach."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
