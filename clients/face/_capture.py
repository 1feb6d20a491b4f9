"""A sound as it is computed, piece by piece, with what is kept beside it."""

import numpy as np
from numpy.typing import NDArray

from .clients.contacts import assemble
from .clients.performer import Performer
from .dsp.engine.memory.state import QUANTUM, TRACE
from .report import Meter
from .server.render import PIECE
from .sound import Sensed, Sound


class Capture:
    """Gathers the pieces of a sound that begins at the sample `start`; it has reached the sample `end`.

    A piece ends with a `step` (frames) at the latest.
    """

    def __init__(self, performer: Performer, start: int) -> None:
        self._performer = performer
        self._start = self.end = start
        self._pieces: list[NDArray[np.float32]] = []
        self._stems: dict[str, list[tuple[int, NDArray[np.float64]]]] = {}
        self._traces: list[NDArray[np.void]] = []
        self._meter = Meter(performer.engine, performer.slots)
        self.warnings: list[str] = []
        self.peak = 0.0
        """The largest magnitude of a sample."""
        self.step = QUANTUM if performer.stems else PIECE

    def room(self) -> int:
        """Return the frames that the next piece may have."""
        return self.step - self.end % self.step

    def add(self, piece: NDArray[np.float32]) -> None:
        """Take a piece, float32 (frames, channels), that was computed just now."""
        first = self.end
        self._pieces.append(piece)
        heard = piece[:, : self._performer.engine.channels]
        self.peak = max(self.peak, float(np.abs(heard).max(initial=0.0)))
        self.end += len(piece)
        self._meter.look()
        if self._performer.stems:
            for name, part in self._performer.stem_pieces(first % QUANTUM, len(piece)).items():
                self._stems.setdefault(name, []).append((first - self._start, part))
        if self._performer.contacts:
            self._traces.append(self._performer.traced(self.end))

    def sound(self) -> Sound:
        """Return the whole, up to now."""
        rate = round(self._performer.engine.rate)
        contacts = None
        if self._performer.contacts:
            trace = np.concatenate([np.empty(0, TRACE), *filter(len, self._traces)])
            contacts = assemble(trace, rate, self._start, self._performer.striking)
        engine, mounted = self._performer.engine, self._performer.scene.sensors.channels
        whole = np.concatenate([np.empty((0, engine.width), np.float32), *map(self._widened, self._pieces)])
        return Sound(
            samples=whole[:, : engine.channels].copy() if mounted else whole,
            sensors={
                name: Sensed(whole[:, engine.channels + n].copy(), each.unit, each.full)
                for n, (name, each) in sorted(mounted.items())
            },
            rate=rate,
            start=self._start / rate,
            report=self._meter.report(self._start, self.end, self._warnings()),
            stems={name: self._stem(pieces) for name, pieces in self._stems.items()} if self._performer.stems else None,
            contacts=contacts,
            scale=self._performer.scene.scale,
        )

    def _widened(self, piece: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return a piece with all channels that there are now: sensors that came later were silent."""
        missing = self._performer.engine.width - piece.shape[1]
        return np.pad(piece, ((0, 0), (0, missing))) if missing else piece

    def _warnings(self) -> list[str]:
        """Return the warnings since the last sound."""
        said = [*self.warnings, *self._performer.warnings]
        self._performer.warnings.clear()
        return said

    def _stem(self, pieces: list[tuple[int, NDArray[np.float64]]]) -> NDArray[np.float32]:
        stem = np.zeros((self.end - self._start, self._performer.engine.channels), np.float32)
        for first, piece in pieces:
            stem[first : first + len(piece)] = piece
        return stem
