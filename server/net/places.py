"""Places for connections: so many in all, and so many for each host. Whoever says nothing makes way for a newcomer."""

import errno
import socket
import sys
import time
from collections.abc import Hashable, Iterator
from contextlib import suppress
from typing import Generic, TypeVar

Holder = TypeVar("Holder", bound=Hashable)

PAUSE = 0.5  # s without accepting, where the system has no descriptor or memory left
_OUT = {errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM}
_RESERVE = 96  # descriptors kept for files, devices and what else the server opens
_FEWEST = 8
_ACCEPTING = 0.005  # s for which connections are accepted at once
_QUIET = 60.0  # s between two lines of the same complaint


def most_places(wanted: int, share: float) -> int:
    """Return how many connections may be held: as many as wanted, but no more than a share of the descriptors that this
    process may have beyond a reserve."""
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return wanted
    limit = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if limit == resource.RLIM_INFINITY:
        return wanted
    return max(_FEWEST, min(wanted, int(share * (limit - _RESERVE))))


class Places(Generic[Holder]):
    """The holders of places. A newcomer who finds none takes that of another one, or is refused.

    It is one who is quiet, and has been for longest: of the newcomer's host where that has all that it may, else of the
    host that has the most. Where no host with at least two places more than the newcomer's has a quiet one, such a host
    gives up the oldest. So a host finds a place, whatever others do, as long as there are fewer hosts than places.
    """

    def __init__(self, most: int, most_of_host: int) -> None:
        """Begin empty, with so many places in all, and for each host."""
        self.most, self.most_of_host = most, most_of_host
        self._quiet: dict[str, dict[Holder, None]] = {}
        self._busy: dict[str, dict[Holder, None]] = {}
        self._hosts: dict[Holder, str] = {}

    def __len__(self) -> int:
        return len(self._hosts)

    def __contains__(self, holder: Holder) -> bool:
        return holder in self._hosts

    def come(self, holder: Holder, host: str) -> None:
        """Give a place to a holder, who is quiet at first."""
        self._hosts[holder] = host
        self._quiet.setdefault(host, {})[holder] = None

    def hush(self, holder: Holder) -> None:
        """Note that a holder is quiet from now on."""
        self._move(holder, self._busy, self._quiet)

    def rouse(self, holder: Holder) -> None:
        """Note that a holder is quiet no longer."""
        self._move(holder, self._quiet, self._busy)

    def _move(self, holder: Holder, away: dict[str, dict[Holder, None]], to: dict[str, dict[Holder, None]]) -> None:
        host = self._hosts.get(holder)
        if host is not None and holder in away.get(host, {}):
            self._drop(away, host, holder)
            to.setdefault(host, {})[holder] = None

    def leave(self, holder: Holder) -> None:
        """Take a holder's place back, if it has one."""
        host = self._hosts.pop(holder, None)
        if host is not None:
            self._drop(self._quiet, host, holder)
            self._drop(self._busy, host, holder)

    @staticmethod
    def _drop(places: dict[str, dict[Holder, None]], host: str, holder: Holder) -> None:
        holders = places.get(host, {})
        holders.pop(holder, None)
        if not holders:
            places.pop(host, None)

    def quiet(self) -> list[Holder]:
        """Return those that are quiet."""
        return [holder for holders in self._quiet.values() for holder in holders]

    def is_free(self, host: str) -> bool:
        """True if a newcomer of a host finds a place that nobody has."""
        return len(self) < self.most and self._count(host) < self.most_of_host

    def limit_of(self, host: str) -> int:
        """Return the number of places that a newcomer of a host finds taken: all, or all that its host may have."""
        return self.most_of_host if self._count(host) >= self.most_of_host else self.most

    def who_makes_way(self, host: str) -> Holder | None:
        """Return the holder whose place a newcomer of a host takes, where none is free; None: nobody's."""
        mine = self._count(host)
        if mine >= self.most_of_host:
            return next(iter(self._quiet.get(host, ())), None)
        quiet = max(self._quiet, key=self._count, default=None)
        busy = max(self._busy, key=self._count, default=None)
        if busy is not None and self._count(busy) > mine + 1 and (quiet is None or self._count(quiet) <= mine + 1):
            return next(iter(self._busy[busy]))
        return next(iter(self._quiet[quiet])) if quiet is not None and self._count(quiet) >= mine else None

    def _count(self, host: str) -> int:
        return len(self._quiet.get(host, ())) + len(self._busy.get(host, ()))


class Complaint:
    """A complaint on stderr, a line a minute at most."""

    def __init__(self) -> None:
        self._due = 0.0

    def say(self, text: str) -> None:
        """Print a line, unless one was printed within the last minute."""
        now = time.monotonic()
        if now >= self._due:
            self._due = now + _QUIET
            with suppress(OSError, ValueError):  # nobody may be there to read it
                print(f"carom: {text}", file=sys.stderr, flush=True)


class NoDescriptorError(Exception):
    """The system has nothing left for another connection, so that it is of no use to try again before PAUSE."""


def accepted(listener: socket.socket, complaint: Complaint, where: str) -> Iterator[tuple[socket.socket, str]]:
    """Yield those that want to connect, and their hosts, as many as take a short time.

    NoDescriptorError, after a complaint, where the system has nothing left for them; where: what they connect to.
    """
    end = time.monotonic() + _ACCEPTING
    while time.monotonic() < end:
        try:
            sock, (host, _) = listener.accept()
        except BlockingIOError:
            return
        except OSError as error:
            if error.errno in _OUT:
                complaint.say(f"{where}: no new connection: {error.strerror}")
                raise NoDescriptorError from error
            continue  # it is gone already
        yield sock, host
