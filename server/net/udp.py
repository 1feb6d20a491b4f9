"""Datagrams, read by a compiled thread that waits for no Python, however long that is busy.

The system's own buffer holds as few as 500 short datagrams, 2 ms of a burst, and an object takes 0.1 s to make. Where
the thread may run in real time, a burst is safe on a busy machine, too.
"""

import os
import secrets
import socket
import struct
import sys
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from ctypes import c_int64, c_void_p
from typing import Annotated

import numpy as np

from ...dsp.native.atomics import confirm, fence, load_acquire, observe, publish, store_release
from ...dsp.native.jit import c_function, carray, external, kernel
from ...dsp.native.typed import Record, View, dtype_of, i32
from .tcp import listen

CAPACITY = 1 << 22
"""Bytes of datagrams that can wait to be carried out, each with 24 of its own. An address may take as much as its host
leaves free of what is left for that: a third where no other sends, some 17,000 short ones; a fifth where another of its
host does. So there is room for a newcomer of this host, and of others."""

RECEIVE_BUFFER = 1 << 22
"""Bytes asked of the system for datagrams that the reading thread has not taken yet; the system may give less."""

_TRIES = 16  # ports that may be free for UDP and not for TCP
_LOOK = 0.05  # s between looks at whether to go on
_HEAD = 3  # words before a datagram: its size, and two of the address that it came from
_LARGEST = _HEAD + (1 << 16) // 8  # words
_WORDS = CAPACITY // 8
_GROUPS = 4_096  # of senders: a host, and each address of it, has one of its own unless none near its place is free
_PROBES = 16  # places of groups that a sender may have
_OF_HOST = 16  # bits of a group
_SENDER = (1 << 48) - 1
_AT_ONCE = 1_024  # datagrams that are taken at once: some 2 ms


# The ring's words hold datagrams one after another; one begins where the largest would fit before the end, else at 0.
class Box(Record):
    """Datagrams as they come in."""

    written: Annotated[View[int], 1]  # words ever
    read: Annotated[View[int], 1]
    stopped: Annotated[View[int], 1]
    dropped: Annotated[View[int], 1]  # datagrams
    loser: Annotated[View[int], 2]  # address that the last of them came from
    owner: Annotated[View[int], _GROUPS]  # the sender that a group began with
    held: Annotated[View[int], _GROUPS]  # words that came in, ever, from each group
    done: Annotated[View[int], _GROUPS + 1]  # those that are carried out or dropped, and their sum
    key: int  # of the hash of senders, that nobody outside knows
    descriptor: int
    bell: int
    length: Annotated[View[i32], 2]
    fresh: Annotated[View[int], _LARGEST]
    ring: Annotated[View[int], _WORDS]


_BOX = dtype_of(Box)
_ENTRY = struct.Struct("=ii2x2s4s8x")  # size and groups, and of the sockaddr_in port and host

_WINDOWS = sys.platform == "win32"
_receive: Callable[[int, int, int, int, int], int] = external(
    "carom_receive", c_int64, c_int64, c_void_p, c_int64, c_void_p, c_void_p
)
_send: Callable[[int, int, int], None] = external("carom_send", None, c_int64, c_void_p, c_int64)


def _after(position: int, size: int) -> int:
    """Return where the next datagram begins, after one of `size` bytes."""
    position += _HEAD + (size + 7) // 8
    rest = _WORDS - position % _WORDS
    return position + rest if rest < _LARGEST else position


_beyond = kernel(_after)


def _words(size: int) -> int:
    """Return the words that a datagram takes."""
    return _HEAD + (size + 7) // 8


_words_of = kernel(_words)


@kernel
def _group(box: Box, sender: int) -> int:
    """Return the group of a sender (48 bits: a port, or 0, and a host): its own, else one that is free, else one that
    it shares."""
    first = sender * box.key >> 40  # the product wraps
    free = -1
    for k in range(_PROBES):
        group = (first + k) & (_GROUPS - 1)
        if box.owner[group] == sender:
            return group
        if free < 0 and box.held[group] == load_acquire(box.done, group):
            free = group
    if free < 0:
        return first & (_GROUPS - 1)
    box.owner[free] = sender
    return free


@c_function(None, c_void_p)
def drain(address: int) -> None:
    """Move datagrams into the ring until stopped, and count those that find no room there. address: of a _BOX."""
    box: Box = carray(address, (1,), _BOX)[0]
    fresh, ring = box.fresh, box.ring
    start = fresh.ctypes.data
    written = load_acquire(box.written, 0)
    total = 0
    while load_acquire(box.stopped, 0) == 0:
        box.length[0] = 16
        size = _receive(box.descriptor, start + 8 * _HEAD, 1 << 16, start + 8, box.length.ctypes.data)
        if size < 0:  # nothing came for a while
            continue
        words = _words_of(size)
        of_host, own = _group(box, fresh[1] >> 32 << 16 & _SENDER), _group(box, fresh[1] >> 16 & _SENDER)
        free = _WORDS - _LARGEST - total + load_acquire(box.done, _GROUPS)
        free -= box.held[of_host] - load_acquire(box.done, of_host)
        mine = box.held[own] - load_acquire(box.done, own)
        if mine + words > free or written - load_acquire(box.read, 0) > _WORDS - _LARGEST:
            box.loser[0], box.loser[1] = fresh[1], fresh[2]
            store_release(box.dropped, 0, box.dropped[0] + 1)
            continue
        box.held[of_host] += words
        box.held[own] += words
        total += words
        fresh[0] = size | (of_host | own << _OF_HOST) << 32
        at = written % _WORDS
        for i in range(words):
            ring[at + i] = fresh[i]
        before = written
        written = _beyond(written, size)
        store_release(box.written, 0, written)
        # The reader may have found nothing a moment before. Each of the two writes what it has done, and then looks at
        # what the other has: without a fence in both either look could come first, and the bell would not be rung.
        fence()
        if load_acquire(box.read, 0) == before:
            _send(box.bell, start, 1)


class Caller:
    """An address that datagrams wait from: `arrived`. Each came at a time (s), and takes room of groups of senders, as
    Intake names them: a sender's group may change."""

    __slots__ = ("address", "arrived", "came", "queued", "since")

    def __init__(self, address: tuple[str, int]) -> None:
        self.address = address
        self.arrived: deque[bytes | None] = deque()
        self.came: deque[tuple[float, int]] = deque()
        self.since = 0.0  # s: when what was before them was done
        self.queued = False

    @property
    def host(self) -> str:
        """The address without the port."""
        return self.address[0]


class Intake:
    """The datagrams that arrive at a bound UDP socket. `close` it before the socket.

    `heard` is a socket that can be read when a datagram has arrived where none waited; `hush` reads it.
    """

    def __init__(self, udp: socket.socket) -> None:
        self._box = np.zeros(1, _BOX)
        record = self._box[0]
        self._written, self._read = record["written"], record["read"]
        self._stopped, self._dropped, self._loser = record["stopped"], record["dropped"], record["loser"]
        self._done = record["done"]
        record["key"] = secrets.randbits(62) | 1
        self._ring = memoryview(record["ring"]).cast("B")
        self.heard, self._bell = socket.socketpair()
        self.heard.setblocking(False)
        self._bell.setblocking(False)
        record["descriptor"], record["bell"] = udp.fileno(), self._bell.fileno()
        # Python's own time-outs would make the socket non-blocking.
        wait = struct.pack("L", round(1e3 * _LOOK)) if _WINDOWS else struct.pack("ll", 0, round(1e6 * _LOOK))
        udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, wait)
        # Functions that ctypes calls run without the GIL.
        address = self._box.ctypes.data
        self._thread = threading.Thread(target=drain, args=(address,), name="carom-intake", daemon=True)
        self._thread.start()
        if hasattr(os, "sched_setscheduler") and self._thread.native_id:
            lowest = os.sched_param(os.sched_get_priority_min(os.SCHED_FIFO))
            with suppress(OSError):
                os.sched_setscheduler(self._thread.native_id, os.SCHED_FIFO, lowest)

    def hush(self) -> None:
        """Empty `heard`. Call it before `take`, so that no datagram goes unnoticed."""
        with suppress(BlockingIOError):
            self.heard.recv(64)

    def ring(self) -> None:
        """Make `heard` readable; any thread may."""
        with suppress(OSError):  # it is readable already, or closed
            self._bell.send(b"\0")

    def take(self) -> list[tuple[bytes, tuple[str, int], int]]:
        """Return the datagrams that have arrived, but no more than 1,024: each with its sender's address and groups.

        They take room until `end` is called for each.
        """
        taken: list[tuple[bytes, tuple[str, int], int]] = []
        read = int(self._read[0])
        while len(taken) < _AT_ONCE and read != (written := confirm(self._written)):
            while read != written and len(taken) < _AT_ONCE:
                at = 8 * (read % _WORDS)
                size, groups, port, host = _ENTRY.unpack_from(self._ring, at)
                start = at + 8 * _HEAD
                taken.append((bytes(self._ring[start : start + size]), _address(port, host), groups))
                read = _after(read, size)
            publish(self._read, read)
        return taken

    @property
    def waits(self) -> bool:
        """True if a datagram has arrived that was not taken."""
        return int(self._read[0]) != confirm(self._written)

    def end(self, groups: int, size: int) -> None:
        """Give back the room of a datagram of a size (bytes) and its groups: it is carried out, or dropped."""
        for each in (groups & (1 << _OF_HOST) - 1, groups >> _OF_HOST, _GROUPS):
            self._done[each] += _words(size)

    @property
    def dropped(self) -> int:
        """Number of datagrams that found no room."""
        return int(observe(self._dropped))

    @property
    def loser(self) -> tuple[str, int]:
        """The sender's address of the last datagram that found no room."""
        *_, port, host = _ENTRY.unpack(bytes(8) + self._loser.tobytes())
        return _address(port, host)

    def close(self) -> None:
        """Stop reading."""
        publish(self._stopped, 1)
        self._thread.join()
        self.heard.close()
        self._bell.close()


def _address(port: bytes, host: bytes) -> tuple[str, int]:
    return socket.inet_ntoa(host), int.from_bytes(port, "big")


def dropped_by_system(udp: socket.socket) -> int:
    """Return the datagrams that found no room in the system's buffer, where the system counts them (Linux)."""
    memory_info, drops = 55, 8  # SO_MEMINFO, and where in its nine uint32 the drops stand
    if sys.platform != "linux":
        return 0
    with suppress(OSError):
        return int.from_bytes(udp.getsockopt(socket.SOL_SOCKET, memory_info, 36)[4 * drops :], sys.byteorder)
    return 0


def bound(host: str, port: int) -> tuple[socket.socket, socket.socket]:
    """Return a UDP socket and a TCP listener on the same port, 0 being any free one. OSError if that fails."""
    for attempt in range(_TRIES):
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
            udp.bind((host, port))
            return udp, listen(host, udp.getsockname()[1])
        except OSError:
            udp.close()
            if port or attempt == _TRIES - 1:
                raise
    raise AssertionError
