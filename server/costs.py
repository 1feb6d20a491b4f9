"""The time of a processor that a sound takes where nobody waits for it, and what it is mostly spent on."""

from collections import defaultdict
from collections.abc import Mapping
from time import thread_time

import numpy as np
from numpy.typing import NDArray

from ..dsp.runtime.engine import Engine

_FREE = 0.1
"""s of a processor, beyond its own length, that a sound may take before anybody is warned: its first block may."""


class CostWatch:
    """Computes an engine's sound, and notes what it costs. names: of its objects, by their places in it."""

    def __init__(self, engine: Engine, names: Mapping[int, str]) -> None:
        self._engine = engine
        self._names = names
        self._frames = 0
        self._cost = 0.0
        self._touched: defaultdict[str, float] = defaultdict(float)
        """s of a processor of pieces that took longer than they last, by the object that is touched with most modes."""

    def process(self, frames: int) -> NDArray[np.float32]:
        """Return what Engine.process does."""
        begun = thread_time()
        sound = self._engine.process(frames)
        took = thread_time() - begun
        self._frames += frames
        self._cost += took
        slot = self._engine.most_coupled() if took > frames / self._engine.rate else -1
        if slot >= 0:
            self._touched[self._names.get(slot, "(freed)")] += took
        return sound

    def warning(self) -> str:
        """Return a sentence if the sound took far longer than it lasts, else ""."""
        seconds = self._frames / self._engine.rate
        if self._cost <= seconds + _FREE:
            return ""
        name, took = max(self._touched.items(), key=lambda each: each[1], default=("", 0.0))
        mostly = f", mostly for contacts of {name}" if took > 0.5 * self._cost else ""
        way = "/quality 2 or 3 costs less" if all(self._engine.budget) else "/budget 16 8192 bounds contacts"
        return f"{seconds:.2g} s of sound took {self._cost:.2g} s of a processor{mostly}: {way}"
