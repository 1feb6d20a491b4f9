"""Blocks of many engines on several threads."""

from threading import Thread

import numpy as np
from numpy.typing import NDArray

from ..native.atomics import observe, publish_at
from .engine import Engine
from .entry import callback
from .jobs import ADDED, COUNTS, ENDED, JOB, WORKING, finish, work

_BYTES = 4  # of a sample


class Batch:
    """Blocks of engines that threads compute while Python goes on; each engine has one block at a time in it.

    most: how many blocks may wait; `add` finishes them first where there is one more. threads: how many compute blocks,
    beside the one that calls `finish`.
    """

    def __init__(self, most: int, threads: int) -> None:
        self._shared = _Shared(most)
        self._most, self._wanted = most, threads
        self._threads: list[Thread] = []
        self._publish, self._added_at = publish_at.brief, self._shared.counts[ADDED:].ctypes.data
        self._finished = 0
        self._room, self._room_at, self._used = np.empty(0, np.float32), 0, 0

    def add(self, engine: Engine, frames: int) -> NDArray[np.float32]:
        """Queue the next frames of an engine; return float32 (frames, channels), which is filled once `finish` was
        called."""
        shared, channels = self._shared, engine.width
        added = int(shared.counts[ADDED])
        if added - self._finished >= self._most:
            self.finish()
        if shared.counts[WORKING] < self._wanted:
            self._begin()
        begin, self._used = self._used, self._used + frames * channels
        if self._used > len(self._room):
            self._make_room(frames * channels)
            begin = 0
        out = self._room[begin : self._used].reshape(frames, channels)
        shared.held.append((engine, out))
        shared.jobs[added % self._most] = engine.pointer, self._room_at + _BYTES * begin, frames, channels
        self._publish(self._added_at, added + 1)
        return out

    def _make_room(self, size: int) -> None:
        """Make room for as many blocks of a size (samples) as may wait, of which the first is used."""
        room = np.empty(self._most * size, np.float32)
        at = room.ctypes.data
        self._room, self._room_at, self._used = room, at, size  # at once: an interrupt comes before or after it

    def _begin(self) -> None:
        """Start as many threads as there may be: they end where nothing comes for a while."""
        self._threads = [each for each in self._threads if each.is_alive()]
        for _ in range(self._wanted - len(self._threads)):
            self._threads.append(Thread(target=self._shared.work, name="carom-batch", daemon=True))
            self._threads[-1].start()

    def finish(self) -> None:
        """Wait until all blocks are there, and compute those that no thread has begun."""
        finish(*self._shared.arguments)
        self._finished = observe(self._shared.counts[ADDED:])
        self._shared.held.clear()

    def close(self) -> None:
        """Finish, and end the threads."""
        self.finish()
        self._wanted = 0
        self._shared.counts[ENDED] = 1
        for each in self._threads:
            if each.is_alive():
                each.join()


class _Shared:
    """The memory that threads read and write; it stays as long as one of them works."""

    def __init__(self, most: int) -> None:
        self.jobs, self.counts, self.times = np.zeros(most, JOB), np.zeros(COUNTS, np.int64), np.zeros(3)
        self.held: list[tuple[Engine, NDArray[np.float32]]] = []
        counts, jobs, times = (each.ctypes.data for each in (self.counts, self.jobs, self.times))
        self.arguments = counts, jobs, most, callback.address, times

    def work(self) -> None:
        """Do jobs until there has been none for a while."""
        work(*self.arguments)
