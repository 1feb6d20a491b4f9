"""The limiter's work: when it turns the sound down, by how much, and because of which objects."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from ..dsp.runtime.engine import Engine

_MOST_NAMED = 3
_LEAST_NAMED = 0.01  # of the energy


@dataclass(frozen=True)
class Limiting:
    """The limiter's work: spans (s, from and to) in which it turned the sound down, by how many dB at most, and for
    each object its share (0 to 1) of the energy in them, the largest first."""

    spans: tuple[tuple[float, float], ...] = ()
    db: float = 0.0
    objects: dict[str, float] = field(default_factory=dict)

    def within(self, start: float, end: float) -> "Limiting":
        """Return the same for a sound that begins and ends at these times (s)."""
        cut = ((max(first, start) - start, min(last, end) - start) for first, last in self.spans)
        return replace(self, spans=tuple(span for span in cut if span[0] < span[1]))

    def said(self) -> str:
        """Return what it did as a sentence; empty if it did nothing."""
        if not self.spans:
            return ""
        seconds = sum(last - first for first, last in self.spans)
        loudest = list(self.objects.items())[:_MOST_NAMED]
        named = [f"{name} ({share:.0%})" for name, share in loudest if share >= _LEAST_NAMED]
        culprits = ", ".join(named) or "many objects"
        return (
            f"too loud: {culprits}; the limiter took up to {self.db:.2g} dB for {seconds:.2g} s, "
            f"from {self.spans[0][0]:.2f} s on: lower a gain"
        )


class LimiterWatch:
    """Watches an engine's limiter. Names: of its objects, by their places in it."""

    def __init__(
        self, engine: Engine, names: Callable[[], Mapping[int, str]], take_lowest: Callable[[], float] | None = None
    ) -> None:
        """Begin to watch. take_lowest: returns the limiter's lowest gain since the last call, if the engine is not
        asked itself."""
        self._engine = engine
        self._names = names
        self._take_lowest = take_lowest or engine.take_limit_lowest
        self._seen = engine.left
        self._limited = engine.stats.limited
        self._take_lowest()
        engine.limited_energy()
        self._begin()

    def _begin(self) -> None:
        self._lowest = 1.0
        self._spans: list[tuple[int, int]] = []
        self._energies: dict[str, float] = {}

    def look(self) -> bool:
        """Take notice of all that was computed since the last look; true if any of it was turned down."""
        start, self._seen = self._seen, self._engine.left
        limited = self._engine.stats.limited
        if limited == self._limited:
            return False
        self._limited = limited
        self._lowest = min(self._lowest, self._take_lowest())
        if self._spans and self._spans[-1][1] == start:
            start = self._spans.pop()[0]
        self._spans.append((start, self._seen))
        energy, names = self._engine.limited_energy(), self._names()
        for slot in energy.nonzero()[0].tolist():
            name = names.get(slot, "(freed)")
            self._energies[name] = self._energies.get(name, 0.0) + float(energy[slot])
        return True

    def take(self) -> Limiting:
        """Return its work since the last call, as far as it was looked at."""
        total = sum(self._energies.values())
        shares = sorted(((name, each / total) for name, each in self._energies.items()), key=lambda each: -each[1])
        rate = self._engine.rate
        spans = tuple((first / rate, last / rate) for first, last in self._spans)
        done = Limiting(spans, -20.0 * math.log10(self._lowest), dict(shares))
        self._begin()
        return done
