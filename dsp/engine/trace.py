"""A record of contacts as they are played, for whoever asks: the impulse of each in every sample."""

from ..native.atomics import load_acquire, store_release
from ..native.jit import kernel
from .commands import KIND_ROLL, KIND_SLIDE
from .coupled_rolls import position_of
from .state import QUANTUM, TRACED


@kernel
def trace_sample(state, contact, sample, begin, end, impulse):
    """Keep the impulse (N s) that a contact gave between a sample and the next, if it gave one and Python keeps up.

    begin, end: samples, when the contact began and ended.
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
    moves = contact.kind == KIND_ROLL or contact.kind == KIND_SLIDE
    entry.position = position_of(contact, 0) if moves else contact.now.position
    entry.speed = contact.now.speed if moves else contact.v_in
    entry.sample = sample
    entry.begin = max(begin, float(sample))
    entry.end = min(end, sample + 1.0)
    entry.impulse = impulse
    store_release(trace.written, 0, written + 1)


@kernel
def trace_roll(state, contact, feed):
    """Keep the impulses of a roll, beyond its weight, over a quantum."""
    for n in range(QUANTUM):
        sample = state.position + n - 1
        trace_sample(state, contact, sample, float(sample), sample + 1.0, feed[n, 0])
