"""Replies that found no room where they were to be read: of this machine's sockets Linux counts what they lose.

A datagram that is sent is not known to arrive. Of other hosts, and on other systems, nobody can say.
"""

from collections import OrderedDict
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

_MOST = 1_024  # receivers that are looked after, the last ones that got a reply
_PLACE, _DROPS = 1, 12  # columns of the tables: an address and a port in hexadecimal; datagrams that found no room


class Unread:
    """A count of datagrams that receivers on this machine lost since they got their first reply."""

    def __init__(self, tables: tuple[Path, ...] = (Path("/proc/net/udp"), Path("/proc/net/udp6"))) -> None:
        self._tables = tables
        self._lost: OrderedDict[int, int] = OrderedDict()  # by port
        self._count, self._sent = 0, False

    def send_to(self, port: int) -> None:
        """Note that a reply goes to a port of this machine, where it is lost at once or not at all."""
        self._sent = True
        self._lost[port] = self._lost.pop(port, 0)
        if len(self._lost) > _MOST:
            self._lost.popitem(last=False)

    def count(self) -> int:
        """Look at the receivers, and return how many datagrams all of them lost."""
        sockets, self._sent = self._sockets() if self._sent else (), False
        for port, lost in sockets:
            if port in self._lost:
                self._count += max(lost - self._lost[port], 0)
                self._lost[port] = lost
        return self._count

    def _sockets(self) -> Iterator[tuple[int, int]]:
        """Yield the port of each socket for datagrams, and how many it lost."""
        for table in self._tables:
            with suppress(OSError):
                for line in table.read_text(encoding="ascii").splitlines()[1:]:
                    columns = line.split()
                    yield int(columns[_PLACE].rpartition(":")[2], 16), int(columns[_DROPS])
