"""A report of a sound for its listener: limiting, contacts left out, faults."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from .dsp.runtime.engine import Engine
from .dsp.runtime.meter import SILENCE
from .server.limiting import LimiterWatch, Limiting
from .server.options import loss_of

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
    """The events that a listener may want to know of a sound. `str(report)` is a line for each.

    Attributes
    ----------
    limited : tuple of (start, end)
        Spans in s in which the limiter turned the sound down.
    limited_db : float
        Largest reduction, dB.
    limited_objects : dict of float
        Share (0 to 1) of each object in the energy of these spans.
    normalized_db : float or None
        Change of level that brought the sound to its peak, dB.
    contacts : int
        Number of contacts.
    contacts_dropped : int
        Contacts left out, for lack of capacity: those that would be heard least.
    loudest_dropped : float
        Momentary loudness of the loudest of these, as an estimate, LUFS.
    strikers_cut : int
        Strikers whose own sound was cut short or left out, for lack of capacity.
    nonlinear_dropped : int
        Blows that left a plate linear, for lack of capacity.
    steps_held : int
        Steps of contacts in which the force was held.
    over_budget : int
        Samples and contacts that exceeded `/budget`.
    late : int
        Messages that came after their time.
    faults : int
        Times that an object was silenced, as its sound was not finite.
    compiled : bool
        Whether this process compiled the engine.
    warnings : tuple of str
        Other things to know.
    """

    limited: tuple[tuple[float, float], ...] = ()
    limited_db: float = 0.0
    limited_objects: dict[str, float] = field(default_factory=dict)
    normalized_db: float | None = None
    contacts: int = 0
    contacts_dropped: int = 0
    loudest_dropped: float = SILENCE
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
        for name in ("contacts_dropped", "over_budget", "strikers_cut", "nonlinear_dropped", "late", "faults"):
            if count := getattr(self, name):
                lines.append(loss_of(name, count, self.loudest_dropped))
        return "\n".join(lines) or "nothing to report"


class Meter:
    """Watches an engine while it computes, from the making of the meter on."""

    def __init__(self, engine: Engine, names: Callable[[], Mapping[int, str]]) -> None:
        """Begin to watch an engine. names: of the objects, by their places in the engine."""
        self._engine = engine
        self._counts = self._counted()
        engine.take_loudest_dropped()
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
            loudest_dropped=self._engine.take_loudest_dropped(),
            compiled=self._engine.code.origin == "compiled",
            warnings=tuple(warnings),
            **{name: counts[name] - before for name, before in self._counts.items()},
        )
