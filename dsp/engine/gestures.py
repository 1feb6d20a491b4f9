"""Strikers come and go: they are taken into an object's list of contacts, and out of it, and their ends are told."""

import math

import numpy as np

from ..native.atomics import store_release
from ..native.jit import kernel
from ..rolling.body import begin_roll
from ..rolling.surface import begin_surface
from .contact_force import let_modes_go
from .objects import place
from .quality import coarseness_of
from .state import ENDED, Command, End, Solver
from .steering import joined

_SLOWEST = 1e-12  # m/s: a slower striker moves nothing, and its square may underflow

_IMPACT, _BOUNCE, _ROLL, _PRESS = int(Command.IMPACT), int(Command.BOUNCE), int(Command.ROLL), int(Command.PRESS)
_ROLLING = int(Solver.ROLLING)
_RESTED, _NO_ROOM, _GONE, _JOINED = int(End.RESTED), int(End.NO_ROOM), int(End.GONE), int(End.JOINED)


@kernel
def receive(state, obj, event):
    """Take a striker into an object's list, to touch it at its time; a roll that is under way is steered."""
    serial = int(event.values[7])
    rolls = event.kind == _ROLL
    full = state.contacts_active == len(state.contacts) or (rolls and state.rolls_active == len(state.rolls))
    if rolls and joined(state, event):
        tell_end(state, serial, _JOINED)
    elif event.values[0] < _SLOWEST:
        tell_end(state, serial, _RESTED)
    elif full:
        state.impacts += 1
        state.contacts_dropped += 1
        tell_end(state, serial, _NO_ROOM)
    else:
        index = state.free_contact[len(state.contacts) - 1 - state.contacts_active]
        state.contacts_active += 1
        state.called[index] = 0 if event.kind == _IMPACT else event.order + 1
        contact = state.contacts[index]
        _describe(state, contact, event)
        if rolls:
            _begin_rolling(state, contact, event.values)
        wait(state, contact)
        contact.next = -1
        if obj.contact < 0:
            obj.contact = index
        else:
            last = obj.contact
            while state.contacts[last].next >= 0:
                last = state.contacts[last].next
            state.contacts[last].next = index


@kernel
def _describe(state, contact, event):
    """Make a contact what a command says."""
    values = event.values
    contact.kind = event.kind
    contact.touching = 0
    contact.v_in, contact.position = values[0], values[1]
    contact.m, contact.k, contact.mu, contact.a = values[2], values[3], values[4], values[5]
    contact.gain = contact.loudness = values[6]
    contact.moved_to = contact.position
    contact.serial = int(values[7])
    contact.body[0].slot = event.slot
    contact.body[0].serial = event.serial
    contact.body[1].slot = int(values[8])
    contact.body[1].serial = int(values[9])
    partner = state.objects[contact.body[1].slot]
    if partner.used == 1 and partner.serial == contact.body[1].serial and partner.dying == 0:
        place(contact.body[1], values[10], partner.rows)
    else:
        contact.body[1].slot = -1  # told to go, if there ever was one: its mass strikes alone
    contact.until = contact.gone_at = math.inf
    contact.origin = event.time
    contact.elapsed = 0.0
    contact.gravity = contact.irregularity = contact.spin = 0.0
    contact.push = contact.pushed_to = 0.0
    contact.solver = contact.unsettled = contact.weighty = 0
    if event.kind == _BOUNCE:
        contact.gravity, contact.irregularity = values[11], values[12]
        contact.random = np.uint64(values[13])
        contact.elapsed = values[14]
        contact.weighty = int(values[15])
        contact.push = contact.pushed_to = contact.m * contact.gravity
    elif event.kind == _PRESS:
        contact.pushed_to = values[11]
        contact.gain = contact.loudness = 1.0  # a hand that is softer is one that presses less


@kernel
def _begin_rolling(state, contact, values):
    contact.roll = state.free_roll[len(state.rolls) - 1 - state.rolls_active]
    state.rolls_active += 1
    contact.solver = _ROLLING
    contact.touching = 1
    contact.path = values[22]
    contact.rolled = 0.0
    roll = state.rolls[contact.roll]
    begin_surface(roll.path.surface, values[13], values[14], values[15], values[16], values[17], np.int64(values[18]))
    begin_roll(
        roll, 0, values[12], contact.m, contact.k, contact.mu, contact.a, values[0], values[11], values[19], values[20],
        values[24], values[21], coarseness_of(state),
    )  # fmt: skip


@kernel
def wait(state, contact):
    """Have a contact begin when its flight is over."""
    time = contact.origin + contact.elapsed * state.rate
    contact.start = math.floor(time)
    contact.fraction = time - contact.start


@kernel
def tell_end(state, serial, end):
    """Report what became of a gesture, if it was given a number."""
    if serial == 0:
        return
    count = state.ended_count[0]
    state.ended[count % ENDED, 0] = serial
    state.ended[count % ENDED, 1] = end
    store_release(state.ended_count, 0, count + 1)


@kernel
def drop(state, obj, before, index):
    """Take a contact out of its object's list and give its place back."""
    contact = state.contacts[index]
    if before < 0:
        obj.contact = contact.next
    else:
        state.contacts[before].next = contact.next
    contact.serial = 0
    state.called[index] = 0
    let_modes_go(state, contact)
    state.contacts_active -= 1
    state.free_contact[len(state.contacts) - 1 - state.contacts_active] = index
    if contact.kind == _ROLL:
        state.rolls_active -= 1
        state.free_roll[len(state.rolls) - 1 - state.rolls_active] = contact.roll


@kernel
def drop_all(state, obj):
    """End every gesture on an object at once."""
    while obj.contact >= 0:
        contact = state.contacts[obj.contact]
        tell_end(state, contact.serial, _GONE)
        drop(state, obj, -1, obj.contact)
