"""Blocks of many engines on several threads."""

from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from ..native.atomics import publish_at
from .callback import callback
from .engine import Engine
from .jobs import ADDED, COUNTS, JOB, finish, work


class Batch:
    """Blocks of engines that threads compute while Python goes on; each engine has one block at a time in it.

    most: blocks until `finish`; one more has the others finished. threads: in addition to the one that calls `finish`.
    """

    def __init__(self, most: int, threads: int) -> None:
        self._jobs, self._counts, self._times = np.zeros(most, JOB), np.zeros(COUNTS, np.int64), np.zeros(3)
        self._publish, self._at = publish_at.bare, self._counts[ADDED:].ctypes.data
        counts, jobs, times = (each.ctypes.data for each in (self._counts, self._jobs, self._times))
        self._arguments = counts, jobs, most, callback.address, times
        self._threads, self._pool = threads, ThreadPoolExecutor(max(threads, 1), "carom-batch")
        self._running: list[Future[None]] = []
        self._added = self._finished = 0

    def add(self, engine: Engine, frames: int) -> NDArray[np.float32]:
        """Have the next frames of an engine computed: float32 (frames, channels), which `finish` has filled."""
        if self._added - self._finished == len(self._jobs):
            self.finish()
        if self._added == self._finished:
            self._begin()
        out = np.empty((frames, engine.channels), np.float32)
        self._jobs[self._added % len(self._jobs)] = engine.pointer, out.ctypes.data, frames, engine.channels
        self._added += 1
        self._publish(self._at, self._added)
        return out

    def _begin(self) -> None:
        """Have as many threads work as there may be."""
        self._running = [each for each in self._running if not each.done()]
        for _ in range(self._threads - len(self._running)):
            self._running.append(self._pool.submit(work, *self._arguments))

    def finish(self) -> None:
        """Wait until all blocks are there, and compute those that no thread has begun."""
        finish(*self._arguments)
        self._finished = self._added

    def close(self) -> None:
        """End the threads."""
        self.finish()
        self._pool.shutdown()
