"""What nobody should read: filled with a byte, so that a sound which depends on it has other bits with another byte.

It is the room that is used within a quantum, and the places of what is gone. `filler` of the state says the byte, 0:
none, as in an engine that plays; in the checked build it is 255, by which floats are no numbers and integers -1.
"""

from ...native.jit import kernel, noinline_kernel
from ...native.records import clear_record, fill_bytes
from ...resonator.bank import RESPONSES
from ...resonator.simd import LANES
from ...swarm.record import SWARMS
from .capacity import OBJECTS
from .state import ROLLS, ROWS_OF_SWARM, State
from .striker_state import VOICES

_NEXT = 8  # places on top of a stack: those that are taken first


@noinline_kernel
def fill_unused(state: State) -> None:
    """Fill what the last quantum left in its room; at the beginning, the places that nothing has yet, too."""
    if state.filler == 0:
        return
    if state.position == 0:
        for i in range(len(state.contacts)):
            fill_contact(state, i)
        for i in range(ROLLS - _NEXT, ROLLS):
            fill_roll(state, i)
        for i in range(SWARMS):
            fill_swarm(state, i)
        for i in range(VOICES):
            fill_voice(state, i)
    # A list of an object's rolls goes through contacts that have ended within a quantum.
    free = len(state.contacts) - state.stats.contacts_active
    for i in range(max(free - _NEXT, 0), free):
        fill_contact(state, state.free_contact[i])
    scratch, byte = state.scratch, state.filler
    fill_bytes(scratch.work, byte)
    for g in range(min(state.active + 1, OBJECTS)):
        fill_bytes(scratch.voices[g], byte)
    fill_bytes(scratch.share, byte)
    fill_bytes(scratch.power, byte)
    fill_bytes(scratch.moments, byte)
    fill_bytes(scratch.fine, byte)
    fill_bytes(scratch.observed, byte)
    fill_bytes(scratch.net, byte)
    fill_bytes(scratch.rows, byte)
    fill_bytes(scratch.moving, byte)
    fill_bytes(scratch.drift, byte)
    fill_bytes(scratch.room, byte)
    fill_bytes(scratch.receptance, byte)
    fill_bytes(scratch.drivers, byte)
    fill_bytes(scratch.blows, byte)
    clear_record(scratch.batch)  # blows that were not drawn go through the same loops: they must be numbers
    fill_bytes(scratch.placed, byte)
    fill_bytes(scratch.taps, byte)
    fill_bytes(scratch.group, byte)
    fill_bytes(scratch.striker, byte)
    fill_bytes(scratch.bank, byte)
    fill_bytes(scratch.candidates, byte)
    # Fill what contacts that are solved together need within a sample: their answers to each other stay.
    group = state.scratch.together
    fill_bytes(group.observed, byte)
    fill_bytes(group.moments, byte)
    fill_bytes(group.touches, byte)
    fill_bytes(group.given, byte)
    fill_bytes(group.give, byte)
    fill_bytes(group.negligible, byte)
    fill_bytes(group.give_x, byte)
    fill_bytes(group.give_v, byte)
    fill_bytes(group.linear, byte)
    fill_bytes(group.f, byte)
    fill_bytes(group.end_x, byte)
    fill_bytes(group.end_v, byte)
    fill_bytes(group.ratio, byte)
    fill_bytes(group.gained, byte)
    fill_bytes(group.sought, byte)
    fill_bytes(group.event, byte)
    fill_bytes(group.path, byte)
    if state.coupled_sheets > 0:
        fill_bytes(state.space, byte)


@kernel
def fill_contact(state: State, index: int) -> None:
    """Fill the place of a contact that has ended; it is of no gesture."""
    if state.filler != 0:
        contact = state.contacts[index]
        fill_bytes(contact, state.filler)
        contact.index, contact.gesture, contact.voice = index, 0, -1


@kernel
def fill_roll(state: State, place: int) -> None:
    """Fill the place of a roll, or of what is computed as one, that has ended."""
    if state.filler != 0:
        fill_bytes(state.rolls[place], state.filler)
        fill_bytes(state.blocks[place], state.filler)
        fill_bytes(state.slides[place], state.filler)
        fill_bytes(state.factors[place], state.filler)
        _fill_row(state, place)


@kernel
def fill_swarm(state: State, index: int) -> None:
    """Fill the place of a swarm that has ended."""
    if state.filler != 0:
        fill_bytes(state.swarms[index], state.filler)
        state.swarms[index].used = 0
        for row in range(ROLLS + index * ROWS_OF_SWARM, ROLLS + (index + 1) * ROWS_OF_SWARM):
            _fill_row(state, row)


@kernel
def _fill_row(state: State, row: int) -> None:
    fill_bytes(state.feeds[row], state.filler)
    fill_bytes(state.samples[row], state.filler)
    fill_bytes(state.through[row], state.filler)


@kernel
def fill_voice(state: State, index: int) -> None:
    """Fill the place of a voice that is heard no more."""
    if state.filler != 0:
        fill_bytes(state.voices[index], state.filler)


@kernel
def fill_object(state: State, slot: int) -> None:
    """Fill the place of an object that goes, and the coefficients of its modes. The caller frees it.

    Its serial number is read later, by which its handles are known to be of the past.
    """
    if state.filler != 0:
        obj, bank, byte = state.objects[slot], state.bank, state.filler
        first, last, serial = obj.first, obj.first + obj.size, obj.serial
        fill_bytes(bank.a1[first:last], byte)
        fill_bytes(bank.a2[first:last], byte)
        fill_bytes(bank.response[first // LANES * RESPONSES : last // LANES * RESPONSES], byte)
        fill_bytes(bank.fading_y1[first:last], byte)
        fill_bytes(bank.fading_y2[first:last], byte)
        fill_bytes(bank.fading_a1[first:last], byte)
        fill_bytes(bank.fading_a2[first:last], byte)
        fill_bytes(obj, byte)
        obj.serial, obj.used, obj.awake = serial, 1, 0
