"""The beginning of gestures: a striker gets a place among the contacts, and the values of its command."""

import math

import numpy as np

from ...contact.law import speed_of_impulse
from ...contact.loss import loss_of
from ...native.jit import kernel
from ...native.records import field, set_field
from ...native.typed import View
from ...rolling.body import begin_roll
from ...rolling.surface import begin_surface
from ...schema import GESTURES
from ...schema_records import VALUES
from ..bodies.objects import place
from ..bodies.striker_modes import prepare
from ..bodies.surface import direct, put_at
from ..contacts.contact_list import (
    append_contact,
    free_place,
    refuse_gesture,
    schedule_contact,
    take_contact,
    take_roll,
)
from ..contacts.coupled_rolls import couple_roll
from ..contacts.gesture_kernels import begin_gesture
from ..contacts.room import find_room
from ..contacts.slides import begin_slide
from ..contacts.swarms import begin_swarm
from ..memory.commands import IN_VALUES, Event
from ..memory.quality import coarseness_of
from ..memory.state import CLOSED, COVERING, END_JOINED, END_NO_ROOM, END_RESTED, ROLLING, STAYS, Object, State
from .steering import steer_existing

_SLOWEST = 1e-12  # m/s: a slower striker moves nothing, and its square may underflow
_SIZES = np.array(
    [
        (VALUES.names or ()).index("velocity" if each.falls or each.held else each.argument.name)
        for each in GESTURES.values()
    ]
)
"""The place in VALUES of what says whether a gesture does anything: its argument, or the velocity that it comes to."""


@kernel
def start_gesture(state: State, obj: Object, event: Event) -> None:
    """Take a striker into an object's list, to touch it at its time; a roll or slide that goes on is steered."""
    trait = state.traits[event.what]
    stats, values = state.stats, event.values
    # What moves nothing is over; a striker of an impulse J has less than J/m.
    fastest = max(field(values, _SIZES[event.what]), values.sweep, values.impulse / values.mass)
    tables = trait.swarms == 0 or values.pulses > 0.0
    if trait.along == 1 and steer_existing(state, event):
        refuse_gesture(state, event, END_JOINED)
    elif fastest < _SLOWEST and trait.swarms == 0:
        refuse_gesture(state, event, END_RESTED)
    elif stats.contacts_active == len(state.contacts) or not tables:
        stats.impacts += 1
        stats.contacts_dropped += 1
        refuse_gesture(state, event, END_NO_ROOM)
    else:
        index = take_contact(state)
        state.last_command[index] = 0 if trait.single == 1 else state.queue.carried_out
        contact = state.contacts[index]
        # Make a contact what a command says.
        contact.kind = event.what
        contact.trait = state.traits[event.what]
        contact.gesture = event.gesture
        contact.command = event.number
        contact.v_in, contact.impulse = values.velocity, values.impulse
        contact.m = contact.trait.meets * values.mass
        contact.k, contact.mu, contact.a = values.stiffness, values.dissipation, values.exponent
        if values.restitution > 0.0:
            contact.w, contact.mu = loss_of(values.restitution), 0.0
        if contact.impulse > 0.0:
            contact.v_in = speed_of_impulse(contact.impulse, contact.m, contact.mu, values.restitution)
        # Say which object is touched, and which one touches it, if one does.
        touched, other = contact.point[0], contact.point[1]
        touched.slot, touched.serial = event.slot, event.serial
        touched.on_surface = int(values.on_surface)
        _point_along(contact.direction[0], values.direction_x, values.direction_y, values.direction_z)
        _point_along(contact.direction[1], values.by_direction_x, values.by_direction_y, values.by_direction_z)
        other.slot, other.serial = event.by_slot, event.by_serial
        partner = state.objects[other.slot]
        if partner.used == 1 and partner.serial == other.serial and partner.leaving == STAYS:
            other.on_surface = int(values.by_on_surface)
            if other.on_surface == 1 and partner.faces > 0:
                put_at(state, partner, other, values.by_x, values.by_y, values.by_z)
                direct(state, partner, contact, 1)
            else:
                place(other, values.by_position, partner)
        else:
            other.slot = -1  # it was told to go, or there never was one: its mass strikes alone
        contact.until = contact.gone_at = math.inf
        contact.origin = event.time
        contact.elapsed = values.delay
        contact.random = np.uint64(values.seed)
        contact.roll = -1
        contact.solver = CLOSED
        # Say which striker's modes sound with a contact, if it has any, and have them ready.
        contact.sound = contact.voice = -1
        if values.sound_serial > 0.0:
            contact.sound, contact.sound_serial = int(values.sound), int(values.sound_serial)
            striker = state.strikers[contact.sound]
            state.stats.strikers_cut += striker.serial != contact.sound_serial
            if striker.prepared == 0 and striker.serial == contact.sound_serial:
                prepare(striker, state.rate)
        for i in range(len(IN_VALUES)):
            set_field(contact.target, i, field(values, IN_VALUES[i]))
        contact.level = values.level
        contact.target.gain *= values.level
        # Set the force that pushes a striker on: its weight, or a hand, which is laid on.
        target = contact.target
        contact.has_weight = int(values.weight)
        if contact.trait.falls == 1:
            contact.push = contact.push_target = contact.m * target.gravity
        elif contact.trait.rests == 1:
            target.gain = 1.0
        elif contact.trait.held == 1:
            contact.push_target = target.force
            target.gain = 1.0  # a hand that is softer is one that presses less
        contact.now = contact.target
        if contact.k == 0.0 and (trait.rests == 1 or trait.held == 1):
            # Lay on what covers an area, and has no spring; its force comes gradually.
            contact.solver = COVERING
            contact.v_in = contact.now.load = contact.now.force = 0.0
        if not find_room(state, index):
            stats.impacts += 1
            free_place(state, index)
            refuse_gesture(state, event, END_NO_ROOM)
            return
        if trait.along == 1:
            # Give a striker that moves along a surface its body and its surface.
            contact.roll = take_roll(state)
            stats.rolls_active += 1
            contact.solver = ROLLING
            contact.touching = 1
            state.contact_count += 1
            contact.number = state.contact_count
            contact.travel = values.travel
            roll = state.rolls[contact.roll]
            begin_surface(roll.path.surface, event.surface, int(values.seed))
            roll.target = contact.target
            if contact.trait.slips == 1:
                state.slides[contact.roll].press = int(values.press)
                begin_slide(state, contact)
            begin_roll(roll, 0, contact.k, contact.mu, contact.a, values.corners, coarseness_of(state))
            couple_roll(state, contact)
        if trait.swarms > 0:
            begin_swarm(state, contact, event)
        begin_gesture(contact.kind, state, contact, event)
        schedule_contact(state, contact)
        append_contact(state, obj, index)


@kernel
def _point_along(way: View[float], x: float, y: float, z: float) -> None:
    """Make a vector, of zeros, one of length 1, or leave it."""
    most = max(abs(x), abs(y), abs(z))
    if most > 0.0:
        x, y, z = x / most, y / most, z / most  # whose squares are no 0
        length = math.sqrt(x * x + y * y + z * z)
        way[0], way[1], way[2] = x / length, y / length, z / length
