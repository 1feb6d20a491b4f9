"""A report of a sound for its listener: limiting, contacts left out, faults."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from .dsp.runtime.engine import Engine
from .server.limiting import LimiterWatch, Limiting
from .server.options import OVER_BUDGET

_COUNTERS = {
    "contacts": ("impacts", "recontacts"),
    "contacts_dropped": ("contacts_dropped",),
    "strikers_cut": ("strikers_cut",),
    "nonlinear_dropped": ("nonlinear_dropped",),
    "steps_held": ("held",),
    "over_budget": ("over_budget",),
    "late": ("late",),
    "faults": ("faults",),
}
"""The engine's counters that each count of a report adds up."""


@dataclass(frozen=True)
class Report:
    """The events that a listener may want to know of a sound.

    limited: spans (start, end) in s of the sound in which the limiter turned it down, to 1,024 frames (64 with stems);
    limited_db: by how much at most, dB; limited_objects: for each object its share (0 to 1) of the energy then.
    normalized_db: by how much the sound was brought to the peak that was asked for (None: it was not).
    contacts: how many began, or were left out; contacts_dropped: left out, as too many went on at once;
    strikers_cut: strikers whose own sound was cut short or left out, as too many sounded;
    nonlinear_dropped: blows that left a plate linear, as the modes of too many plates were coupled;
    steps_held: steps of contacts solved with the modes that took the force as constant; over_budget: samples in which
    they did as `/budget` granted no more steps.
    late: events that came after their time; faults: times that an object was silenced as its sound was not finite.
    compiled: whether this process compiled the engine (it loads it where it was compiled before).
    warnings: other things to know, such as that the sound ends though something would go on for ever.
    """

    limited: tuple[tuple[float, float], ...] = ()
    limited_db: float = 0.0
    limited_objects: dict[str, float] = field(default_factory=dict)
    normalized_db: float | None = None
    contacts: int = 0
    contacts_dropped: int = 0
    strikers_cut: int = 0
    nonlinear_dropped: int = 0
    steps_held: int = 0
    over_budget: int = 0
    late: int = 0
    faults: int = 0
    compiled: bool = False
    warnings: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return a line for each thing that can be heard, "nothing to report" where there is none."""
        lines = list(self.warnings)
        if self.limited:
            lines.append(Limiting(self.limited, self.limited_db, self.limited_objects).said())
        if self.normalized_db is not None:
            lines.append(f"normalized by {self.normalized_db:+.3g} dB")
        if self.contacts_dropped:
            lines.append(f"{self.contacts_dropped} contacts were left out: too many at once")
        if self.over_budget:
            lines.append(OVER_BUDGET.format(self.over_budget))
        if self.strikers_cut:
            lines.append(f"the strikers of {self.strikers_cut} blows were cut short: too many sounded")
        if self.nonlinear_dropped:
            lines.append(f"{self.nonlinear_dropped} blows left a plate linear: too many plates were coupled")
        if self.late:
            lines.append(f"{self.late} messages came late")
        if self.faults:
            lines.append(f"objects were silenced {self.faults} times: their sound was not finite")
        return "\n".join(lines) or "nothing to report"


class Meter:
    """Watches an engine while it computes, from the making of the meter on."""

    def __init__(self, engine: Engine, names: Callable[[], Mapping[int, str]]) -> None:
        """Begin to watch an engine. names: of the objects, by their places in the engine."""
        self._engine = engine
        self._counts = self._counted()
        self._watch = LimiterWatch(engine, names)

    def _counted(self) -> dict[str, int]:
        stats = self._engine.stats
        return {name: sum(getattr(stats, each) for each in counters) for name, counters in _COUNTERS.items()}

    def look(self) -> None:
        """Take notice of all that was computed since the last look."""
        self._watch.look()

    def report(self, start: int, end: int, warnings: Sequence[str] = ()) -> Report:
        """Return the report of a sound that begins and ends at these samples."""
        counts = self._counted()
        limiting = self._watch.take().within(start / self._engine.rate, end / self._engine.rate)
        return Report(
            limited=limiting.spans,
            limited_db=limiting.db,
            limited_objects=limiting.objects,
            compiled=self._engine.code.origin == "compiled",
            warnings=tuple(warnings),
            **{name: counts[name] - before for name, before in self._counts.items()},
        )
