"""The ramps that run or wait: values that reach another one in a given time."""

from ...native.jit import kernel
from .capacity import RAMPS
from .commands import Event
from .state import State


@kernel
def takes_time(state: State, event: Event, place: int, serial: int) -> bool:
    """Start the ramp that an event brings; return False if its value counts at once. In either case the event ends the
    ramps on its parameter, of a contact, an object or the whole, that were requested before."""
    ramp = event.ramp
    if ramp.after == 0.0:  # else it is a later point of those that have just come
        drop_ramps(state, event.kind, event.parameter, place, serial)
    if ramp.after + ramp.over == 0.0:
        return False
    if state.ramps.count == RAMPS:
        state.stats.ramps_dropped += 1
        return False
    new = state.ramps.entries[state.ramps.count]
    state.ramps.count += 1
    new.kind, new.parameter, new.place, new.serial = event.kind, event.parameter, place, serial
    new.begun = 0
    new.begin = event.time + ramp.after * state.rate
    new.end = new.begin + ramp.over * state.rate
    new.first, new.last, new.curve = 0.0, event.value, ramp.curve
    return True


@kernel
def drop_ramps(state: State, kind: int, parameter: int, place: int, serial: int) -> None:
    """End the ramps on a parameter: it stays as it is."""
    kept = 0
    for i in range(state.ramps.count):
        ramp = state.ramps.entries[i]
        same = ramp.kind == kind and ramp.parameter == parameter and ramp.place == place and ramp.serial == serial
        if not same:
            keep_ramp(state, kept, i)
            kept += 1
    state.ramps.count = kept


@kernel
def keep_ramp(state: State, kept: int, i: int) -> None:
    """Move ramp i up, behind those that are kept: they stay in the order in which they came."""
    if kept < i:
        state.ramps.entries[kept] = state.ramps.entries[i]
