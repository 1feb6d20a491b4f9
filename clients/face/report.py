"""What an engine did that a listener might want to know: limiting, contacts left out, faults."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from .dsp.runtime.engine import Engine

_COUNTERS = {
    "contacts": "impacts",
    "contacts_dropped": "contacts_dropped",
    "steps_held": "held",
    "late": "late",
    "faults": "faults",
}
"""The engine's counter behind each count of a report."""


@dataclass(frozen=True)
class Report:
    """What happened while a sound was computed.

    limited: spans (start, end) in s of the sound in which the limiter turned it down, to 1,024 frames (64 with stems);
    limited_db: by how much at most, dB; limited_objects: for each object its share (0 to 1) of the energy then.
    contacts: how many began, or were left out; contacts_dropped: left out, as too many went on at once;
    steps_held: steps of contacts solved with the modes that took the force as constant, to save time.
    late: events that came after their time; faults: times that an object was silenced as its sound was not finite.
    compiled: whether this process compiled the engine (it loads it where it was compiled before).
    warnings: other things to know, such as that the sound ends though something would go on for ever.
    """

    limited: tuple[tuple[float, float], ...] = ()
    limited_db: float = 0.0
    limited_objects: dict[str, float] = field(default_factory=dict)
    contacts: int = 0
    contacts_dropped: int = 0
    steps_held: int = 0
    late: int = 0
    faults: int = 0
    compiled: bool = False
    warnings: tuple[str, ...] = ()

    def __str__(self) -> str:
        """A line for each thing that can be heard, "nothing to report" where there is none."""
        lines = list(self.warnings)
        if self.limited:
            seconds = sum(end - start for start, end in self.limited)
            objects = sorted(self.limited_objects, key=self.limited_objects.__getitem__, reverse=True)
            culprit = f", mostly {objects[0]}" if objects else ""
            lines.append(
                f"the limiter turned {seconds:.3g} s down{culprit}, from {self.limited[0][0]:.3g} s on, "
                f"by {self.limited_db:.3g} dB at most: lower some gain"
            )
        if self.contacts_dropped:
            lines.append(f"{self.contacts_dropped} contacts were left out: too many at once")
        if self.late:
            lines.append(f"{self.late} events came after their time")
        if self.faults:
            lines.append(f"{self.faults} times an object was silenced because its sound was not finite")
        return "\n".join(lines) or "nothing to report"


class Meter:
    """Watches an engine while it computes, from the making of the meter on."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._counts = self._counted()
        self._seen = engine.position
        self._limited = engine.stats.limited
        self._lowest = 1.0
        self._spans: list[tuple[int, int]] = []
        engine.take_limit_lowest()

    def _counted(self) -> dict[str, int]:
        stats = self._engine.stats
        return {name: getattr(stats, counter) for name, counter in _COUNTERS.items()}

    def look(self) -> None:
        """Take notice of all that was computed since the last look."""
        start, self._seen = self._seen, self._engine.position
        limited = self._engine.stats.limited
        if limited == self._limited:
            return
        self._limited = limited
        self._lowest = min(self._lowest, self._engine.take_limit_lowest())
        if self._spans and self._spans[-1][1] == start:
            start = self._spans.pop()[0]
        self._spans.append((start, self._seen))

    def report(self, start: int, end: int, limited_objects: dict[str, float], warnings: Sequence[str] = ()) -> Report:
        """What happened to a sound that begins and ends at these samples."""
        rate = self._engine.rate
        counts = self._counted()
        spans = [(max(first, start), min(last, end)) for first, last in self._spans]
        return Report(
            limited=tuple(((first - start) / rate, (last - start) / rate) for first, last in spans),
            limited_db=20.0 * math.log10(1.0 / self._lowest),
            limited_objects=limited_objects,
            compiled=self._engine.compiled,
            warnings=tuple(warnings),
            **{name: counts[name] - before for name, before in self._counts.items()},
        )
