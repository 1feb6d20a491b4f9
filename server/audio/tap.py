"""The sound as it is computed, handed on: to pages that hear it, and to recorders."""

import threading
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...dsp.runtime.engine import Engine

PERIOD = 0.01  # s between looks
_SOON = 0.0025  # s between them while somebody listens

Sound = NDArray[np.float32]
Sink = Callable[[int, Sound], object]
"""Takes the number of the first sample, and float32 (frames, channels); true if it wants more as soon as there is."""


class Tap:
    """Reads all that an engine computes, from its first sample on, in a thread of its own; `close` it.

    A sink is called in that thread, and must not wait.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._sinks: list[Sink] = []
        self._hurries = False
        self._stop = threading.Event()
        engine.record()
        self._thread = threading.Thread(target=self._run, name="carom-tap", daemon=True)
        self._thread.start()

    def add(self, sink: Sink) -> None:
        """Call a sink with all sound from here on."""
        self._sinks.append(sink)

    def remove(self, sink: Sink) -> None:
        """Call a sink no more."""
        self._sinks.remove(sink)

    def _run(self) -> None:
        while not self._stop.wait(_SOON if self._hurries else PERIOD):
            self._look()

    def _look(self) -> None:
        for first, sound in self._engine.recorded_parts():
            self._hurries = any([sink(first, sound) for sink in tuple(self._sinks)])

    def close(self) -> None:
        """Hand on what is left, and end."""
        self._stop.set()
        self._thread.join()
        self._look()


class Queue:
    """A sink that keeps the sound until it is taken."""

    def __init__(self, channels: int) -> None:
        self._empty: Sound = np.empty((0, channels), np.float32)
        self._blocks: list[Sound] = []

    def __call__(self, first: int, sound: Sound) -> None:
        self._blocks.append(sound)

    def take(self) -> Sound:
        """Return all sound since the last call."""
        blocks, self._blocks = self._blocks, []
        return np.concatenate([self._empty, *blocks])


class Part:
    """A sink that keeps a part of the sound until it is taken: from the engine's present sample on.

    Frames that the tap has lost are silence there: so the part is as long as the time.
    """

    def __init__(self, engine: Engine, tap: Tap, most: int) -> None:
        """Begin a part that ends by itself after `most` frames."""
        self._engine, self._tap = engine, tap
        self._lock = threading.Lock()
        self._kept = Queue(engine.width)
        self._next = -1
        tap.add(self)
        with self._lock:
            self.first = self._next = engine.left
            """The number of its first sample."""
            self.end = self.first + most
            """Number of the sample after its last."""

    def stop(self) -> int:
        """End it at the engine's present sample; return that."""
        with self._lock:
            self.end = min(self.end, max(self._next, self._engine.left))
            return self.end

    def __call__(self, first: int, sound: Sound) -> None:
        with self._lock:
            begin, end = max(first, self._next), min(first + len(sound), self.end)
            if self._next < 0 or begin >= end:
                return
            if begin > self._next:
                self._kept(self._next, np.zeros((begin - self._next, sound.shape[1]), np.float32))
            self._kept(begin, sound[begin - first : end - first])
            self._next = end

    @property
    def is_whole(self) -> bool:
        """True if all of it has come."""
        return self._next >= self.end

    def take(self) -> Sound:
        """Return its sound since the last call."""
        with self._lock:
            return self._kept.take()

    def close(self) -> None:
        """Keep no more."""
        self._tap.remove(self)
