"""The contacts of an object: a linked list of places in state.contacts, and what ends with them."""

import math

import numpy as np

from ...native.atomics import fence, store_release
from ...native.jit import kernel
from ...native.records import clear_record, fill_bytes
from ...numerics.random import STEP, mixed
from ..memory.commands import Event
from ..memory.filling import fill_roll, fill_swarm
from ..memory.records import Contact
from ..memory.state import CLOSED, COUPLING, COVERING, END_GONE, ENDED, FADING, UNWEIGHED, Object, State

KEPT_ASIDE = 2
"""`aside` of a contact whose striker has left, and is kept for a while."""


@kernel
def append_contact(state: State, obj: Object, index: int) -> None:
    """Put a contact into an object's list, behind all that act: at its end are those whose strikers have left, and are
    kept for a while."""
    before, after = -1, obj.contact
    while acts(state, after):
        before, after = after, state.contacts[after].next
    state.contacts[index].next = after
    if before < 0:
        obj.contact = index
    else:
        state.contacts[before].next = index


@kernel
def acts(state: State, index: int) -> bool:
    """True if there is a contact at an index of a list, and not only those from there on whose strikers are kept."""
    return index >= 0 and state.contacts[index].aside != KEPT_ASIDE


@kernel
def take_out(state: State, obj: Object, before: int, index: int) -> None:
    """Take a contact, which follows `before` (-1: the first), out of its object's list."""
    if before < 0:
        obj.contact = state.contacts[index].next
    else:
        state.contacts[before].next = state.contacts[index].next


@kernel
def share_object(contact: Contact, other: Contact) -> bool:
    """True if two contacts touch the same object."""
    shared = False
    for side in range(2):
        slot = contact.point[side].slot
        shared |= slot >= 0 and (slot == other.point[0].slot or slot == other.point[1].slot)
    return shared


@kernel
def schedule_contact(state: State, contact: Contact) -> None:
    """Schedule a contact for when its flight is over."""
    time = contact.origin + contact.elapsed * state.rate
    contact.start = math.floor(time)
    contact.fraction = time - contact.start


@kernel
def next_random(contact: Contact) -> float:
    """Return the next number of a contact's own sequence, in [0, 1)."""
    contact.random += STEP
    z = mixed(contact.random)
    return np.float64(z >> np.uint64(11)) * 2.0**-53


@kernel
def release_modes(state: State, contact: Contact) -> None:
    """Give back the room of a contact that was coupled to modes."""
    if contact.solver == COUPLING:
        give_room_back(state, contact)
        contact.aside = 0
        contact.solver = CLOSED


@kernel
def give_room_back(state: State, contact: Contact) -> None:
    """Take a coupled contact out of the budget while its striker flies."""
    if contact.aside == 0:
        state.stats.coupled_modes -= contact.modes
        contact.aside = 1


@kernel
def take_room_again(state: State, contact: Contact) -> None:
    """Count a coupled contact whose striker comes back in the budget again, even if there is no room."""
    if contact.aside > 0:
        state.stats.coupled_modes += contact.modes
        contact.aside = 0


@kernel
def places_left(state: State) -> int:
    """Return the places for what is computed as a roll is that nothing has."""
    return len(state.rolls) - state.stats.rolls_active - state.rests_placed


@kernel
def take_contact(state: State) -> int:
    """Take a place among the contacts, one of which is free; all that the contact there holds is its own place."""
    stats = state.stats
    index = state.free_contact[len(state.contacts) - 1 - stats.contacts_active]
    stats.contacts_active += 1
    clear_record(state.contacts[index])
    state.contacts[index].index = index
    state.last_command[index] = 0
    state.heard[index] = UNWEIGHED
    return index


@kernel
def free_place(state: State, index: int) -> None:
    """Give a place among the contacts back, which is in no list."""
    state.fading -= state.heard[index] == FADING
    state.heard[index] = FADING
    state.contacts[index].gesture = 0
    state.last_command[index] = 0
    stats = state.stats
    stats.contacts_active -= 1
    state.free_contact[len(state.contacts) - 1 - stats.contacts_active] = index


@kernel
def take_roll(state: State) -> int:
    """Take a place for what is computed as a roll, one of which is free; it holds nothing of what had it before. Whose
    it is is to be counted."""
    place = state.free_roll[places_left(state) - 1]
    clear_record(state.rolls[place])
    clear_record(state.blocks[place])
    clear_record(state.slides[place])
    clear_row(state, place)
    state.sampled[place] = -1
    state.factors_of[place] = 0
    return place


@kernel
def clear_row(state: State, row: int) -> None:
    """Forget the force that a roll, or a swarm at a place, gave."""
    fill_bytes(state.feeds[row], 0)
    fill_bytes(state.samples[row], 0)
    for side in range(2):
        clear_record(state.through[row, side])


@kernel
def give_place_back(state: State, contact: Contact) -> None:
    """Take the place of a roll away from a rest or a press, if it has one."""
    if contact.roll >= 0:
        state.rests_placed -= 1
        state.free_roll[places_left(state) - 1] = contact.roll
        fill_roll(state, contact.roll)
        contact.roll = -1


@kernel
def report_end(state: State, gesture: int, end: int) -> None:
    """Report what became of a gesture, if it was given a number."""
    if gesture == 0:
        return
    ends = state.ends
    written = ends.written[0]
    fence()  # Python sees that this place may be written over before it is
    ends.entries[written % ENDED, 0] = gesture
    ends.entries[written % ENDED, 1] = end
    store_release(ends.written, 0, written + 1)


@kernel
def refuse_gesture(state: State, event: Event, end: int) -> None:
    """Report what became of a gesture that never begins."""
    report_end(state, event.gesture, end)
    if event.values.pulses > 0.0:
        leave_table(state, int(event.values.pulses) - 1)


@kernel
def leave_table(state: State, number: int) -> None:
    """Tell Python that a swarm needs its table of pulses no more."""
    left = state.pulses.left
    store_release(left, number, left[number] + 1)


@kernel
def end_contact(state: State, obj: Object, before: int, index: int) -> None:
    """Take a contact, which follows `before` (-1: the first), out of its object's list and free its place."""
    contact = state.contacts[index]
    take_out(state, obj, before, index)
    at = obj.contact
    while contact.trait.held == 1 and at >= 0:  # what covers beside a press goes with it
        other = state.contacts[at]
        other.until = 0.0 if other.solver == COVERING and other.gesture == contact.gesture else other.until
        at = other.next
    if contact.solver == COVERING:
        for i in range(obj.first, obj.first + obj.size):
            state.bank.held[i] = 0.0
        obj.stale_modes = obj.size
    free_means(state, contact)
    free_place(state, index)


@kernel
def free_means(state: State, contact: Contact) -> None:
    """Give back all that a contact has but its own place."""
    release_modes(state, contact)
    # Leave a contact's voice to itself: no force is to come, and another may take the row of those that came.
    if contact.voice >= 0:
        state.voices[contact.voice].contact = state.voices[contact.voice].roll = -1
        contact.voice = -1
    if contact.trait.along == 1:
        state.stats.rolls_active -= 1
        state.free_roll[places_left(state) - 1] = contact.roll
        fill_roll(state, contact.roll)
    elif contact.trait.swarms > 0:
        swarm = state.swarms[contact.swarm]
        swarm.used = 0
        leave_table(state, swarm.table)
        fill_swarm(state, contact.swarm)
    else:
        give_place_back(state, contact)


@kernel
def end_contacts(state: State, obj: Object) -> None:
    """End every gesture on an object at once."""
    while obj.contact >= 0:
        report_end(state, state.contacts[obj.contact].gesture, END_GONE)
        end_contact(state, obj, -1, obj.contact)


@kernel
def is_running(state: State, gesture: int) -> bool:
    """True if there is anything of a gesture to be steered."""
    found = False
    for i in range(len(state.contacts)):
        found |= state.contacts[i].gesture == gesture
    return found
