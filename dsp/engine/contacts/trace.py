"""A record of contacts as they are played, for whoever asks: the impulse of each in every sample."""

from ...native.atomics import load_acquire, store_release
from ...native.jit import kernel
from ...native.typed import View2D
from ..memory.records import Contact
from ..memory.state import QUANTUM, TRACED, State
from .coupled_rolls import position_of


@kernel
def trace_blow(state: State, contact: Contact, sample: int, begin: float, end: float, impulse: float) -> None:
    """Keep the impulse (N s) that a blow gave between a sample and the next.

    begin, end: samples, when it began and ended.
    """
    met = contact.now.position, contact.v_in, contact.v_in
    _trace(state, contact, sample, max(begin, float(sample)), min(end, sample + 1.0), impulse, met)


@kernel
def trace_touches(state: State, contact: Contact, sample: int, impulse: float) -> None:
    """Keep what a coupled striker gave between a sample and the next: each touch is a contact, but those of a roll,
    which together gave the `impulse` (N s)."""
    if contact.trait.rolls == 1:
        _trace_moving(state, contact, sample, impulse)
        return
    coupled = contact.coupled
    for i in range(coupled.touched):
        touch = coupled.touches[i]
        if touch.number > contact.told:
            contact.told = touch.number
            state.contact_count += 1
            contact.number = state.contact_count
        met = contact.now.position, touch.speed, touch.velocity
        _trace(state, contact, sample, sample + touch.begin, sample + touch.end, touch.impulse, met)


@kernel
def trace_roll(state: State, contact: Contact, feed: View2D[float]) -> None:
    """Keep the impulses of a roll, beyond its weight, or of a slide over a quantum."""
    for n in range(QUANTUM):
        _trace_moving(state, contact, state.position + n - 1, feed[n, 0])


@kernel
def _trace_moving(state: State, contact: Contact, sample: int, impulse: float) -> None:
    """Keep the impulse of a body that rolls or slides between a sample and the next."""
    met = position_of(contact, 0), contact.now.speed, 0.0
    _trace(state, contact, sample, float(sample), sample + 1.0, impulse, met)


@kernel
def _trace(
    state: State,
    contact: Contact,
    sample: int,
    begin: float,
    end: float,
    impulse: float,
    met: tuple[float, float, float],
) -> None:
    """Keep an impulse (N s) that was given in a sample, between two times, if there is one and Python keeps up.

    met: where on the object, how fast striker and object met, and the striker's velocity then.
    """
    trace = state.trace
    if trace.on == 0 or impulse == 0.0:
        return
    written = trace.written[0]
    if written - load_acquire(trace.read, 0) >= TRACED:
        state.stats.trace_lost += 1
        return
    entry = trace.entries[written % TRACED]
    entry.command = contact.command
    entry.gesture = contact.gesture
    entry.contact = contact.number
    entry.slot = contact.point[0].slot
    entry.position, entry.speed, entry.velocity = met
    entry.sample = sample
    entry.begin = begin
    entry.end = end
    entry.impulse = impulse
    store_release(trace.written, 0, written + 1)
