"""Every counter and measurement of the engine, declared once."""

import dataclasses
from dataclasses import dataclass


def _counter(help: str, unit: str = "") -> int:
    return dataclasses.field(default=0, metadata={"help": help, "unit": unit})


def _measure(help: str, unit: str = "") -> float:
    return dataclasses.field(default=0.0, metadata={"help": help, "unit": unit})


@dataclass(eq=False)
class Stats:
    """The engine's counters and measurements. Counters only rise; `metadata` of each field holds its meaning and
    unit."""

    impacts: int = _counter("contacts that began, or were left out")
    contacts_dropped: int = _counter("contacts left out for lack of capacity")
    coupled: int = _counter("contacts that were coupled to the modes")
    recontacts: int = _counter("times that an object caught up with the striker that had left it")
    held: int = _counter("coupled contacts' steps with the force kept constant")
    over_budget: int = _counter("samples and contacts that exceeded `/budget`")
    late: int = _counter("events that came after their time and were played at once")
    faults: int = _counter("times that an object was silenced because its sound was not finite")
    limited: int = _counter("frames in which the limiter turned the sound down", "frames")
    strikers_cut: int = _counter("strikers whose sound was cut short or left out, for lack of capacity")
    ramps_dropped: int = _counter("changes that were made at once, for lack of capacity")
    nonlinear_dropped: int = _counter("times that a plate's modes were not coupled, for lack of capacity")
    tap_lost: int = _counter("frames missing in the recording", "frames")
    notes_lost: int = _counter("events missing in the log")
    trace_lost: int = _counter("samples missing in the record of contacts", "samples")
    underflows: int = _counter("dropouts of the device")
    holes: int = _counter("times that the process or its device was stopped")
    hole_at: int = _counter("frame before which it last was", "frames")
    overruns: int = _counter("callbacks that took longer than the sound they made")
    callbacks: int = _counter("callbacks")
    synced: int = _counter("number of the last sync that was carried out")
    contacts_active: int = _counter("contacts that are in progress or wait")
    rolls_active: int = _counter("bodies that roll or slide")
    coupled_modes: int = _counter("modes that are coupled to contacts")
    nonlinear_active: int = _counter("plates whose modes are coupled")
    live_modes: int = _counter("modes that ring")
    sounding: int = _counter("objects that sound")
    sounded: int = _counter("end of the last quantum in which an object sounded", "samples")
    limit_lowest: float = _measure("lowest gain of the limiter since it was last requested")
    headroom: float = _measure("present gain of the automatic level ahead of the limiter; 1: it does nothing")
    load: float = _measure("share of the available time that the callback takes, over a second")
    load_now: float = _measure("the same over a tenth of a second")
    load_peak: float = _measure("the highest share, falling slowly")
    loudest_dropped: float = _measure(
        "weighted mean square of the loudest contact left out since it was last requested"
    )
    late_last: float = _measure("delay of the last late event", "s")
    hole_last: float = _measure("time for which it last was", "s")
    late_worst: float = _measure("greatest delay of a late event", "s")
    latency_measured: float = _measure("time from callback to sound, as the device reports it", "s")
