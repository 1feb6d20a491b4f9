"""Rolls and slides that go by samples: their forces over a quantum are computed together (rolling/abreast.py), once all
objects have been brought to it."""

from ...native.jit import kernel, noinline_kernel
from ...numerics.legendre import KEPT
from ...rolling.abreast import step_abreast
from ...rolling.abreast_record import ABREAST
from ...rolling.body import goes_abreast
from ..bodies.strikers import roll_striker
from ..memory.state import BEHIND, LEAD, QUANTUM, State
from .rolls import begin_of, feed_of, move_on, register_roll
from .trace import trace_roll

_BEFORE = BEHIND + LEAD  # frames of a force that are known before a quantum's


@kernel
def waits_for_others(state: State, index: int) -> bool:
    """True if a contact's force is computed with those of others, once these are brought to this quantum."""
    contact, abreast = state.contacts[index], state.scratch.abreast
    origin = begin_of(state, contact, _BEFORE)
    if not goes_abreast(state.rolls[contact.roll], origin, state.rate):
        return False
    if abreast.count == ABREAST:
        roll_abreast(state)
    k = abreast.count
    abreast.contact[k], abreast.roll[k], abreast.origin[k] = index, contact.roll, origin
    abreast.count += 1
    return True


@noinline_kernel
def roll_abreast(state: State) -> None:
    """Compute the forces of those that wait, and hand them on."""
    abreast = state.scratch.abreast
    if abreast.count == 0:
        return
    step_abreast(abreast, state.rolls, state.rate)
    for k in range(abreast.count):
        index = abreast.contact[k]
        # Take the force of number k of those that went together.
        contact = state.contacts[index]
        feed = state.feeds[contact.roll]
        move_on(state, contact, _BEFORE)
        for n in range(QUANTUM):
            row = feed[_BEFORE + n]
            row[0], row[1] = abreast.first[n, k], abreast.tilt[n, k]
            for i in range(2, KEPT):
                row[i] = 0.0
        hand_on(state, index, abreast.met[k])
    abreast.count = 0


@noinline_kernel
def hand_on(state: State, index: int, met: int) -> None:
    """Hand a rolling or sliding body's force over a quantum on to what it drives; it met the surface so many times."""
    contact = state.contacts[index]
    roll, feed = state.rolls[contact.roll], feed_of(state, contact)
    if contact.trait.rolls == 1:
        ahead = roll.t - (state.position - 1 + QUANTUM - contact.origin) / state.rate
        contact.rolled += contact.rolls
        contact.rolls = roll.s - roll.modulated_speed * ahead - contact.rolled
    state.stats.impacts += met
    trace_roll(state, contact, feed, (0, QUANTUM), 1)
    for n in range(len(contact.forces)):
        contact.forces[n] = feed[QUANTUM - 1 - n, 0] * state.rate
    if roll.ended == 0:
        register_roll(state, index)
        roll_striker(state, contact)
