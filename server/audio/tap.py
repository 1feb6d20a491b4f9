"""The sound as it is computed, handed on: to pages that hear it, to a recorder, to meters."""

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
        self._peaks = np.zeros(engine.channels, np.float32)
        self._read = 0
        self._hurries = False
        self._stop = threading.Event()
        engine.record()
        self._thread = threading.Thread(target=self._run, name="carom-tap", daemon=True)
        self._thread.start()

    def add(self, sink: Sink) -> None:
        """Call a sink with all sound from here on."""
        self._sinks.append(sink)

    def peaks(self) -> list[float]:
        """The highest amplitude in each channel since the last call."""
        peaks, self._peaks = self._peaks, np.zeros_like(self._peaks)
        return [float(peak) for peak in peaks]

    def _run(self) -> None:
        while not self._stop.wait(_SOON if self._hurries else PERIOD):
            self._look()

    def _look(self) -> None:
        sound = self._engine.recorded()
        if not len(sound):
            return
        first = self._read + self._engine.stats.tap_lost
        self._read += len(sound)
        self._peaks = np.maximum(self._peaks, np.abs(sound).max(axis=0))
        self._hurries = any([sink(first, sound) for sink in self._sinks])

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
        """All sound since the last call."""
        blocks, self._blocks = self._blocks, []
        return np.concatenate([self._empty, *blocks])
