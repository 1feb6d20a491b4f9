"""The beginning of gestures: a striker gets a place among the contacts, and the values of its command."""

import math

import numpy as np

from ...contact.loss import loss_of
from ...native.jit import kernel
from ...native.records import field, set_field
from ...rolling.body import begin_roll
from ...rolling.surface import begin_surface
from ..bodies.objects import place
from ..bodies.striker_modes import prepare
from ..contacts.contact_list import append_contact, report_end, schedule_contact
from ..contacts.coupled_rolls import couple_roll
from ..contacts.slides import begin_slide
from ..contacts.spins import begin_spin
from ..memory.commands import (
    IN_BOUNCE,
    IN_PRESS,
    IN_ROLL,
    IN_SLIDE,
    IN_SPIN,
    IN_STRIKE,
    KIND_BOUNCE,
    KIND_IMPACT,
    KIND_PRESS,
    KIND_ROLL,
    KIND_SLIDE,
    KIND_SPIN,
)
from ..memory.quality import coarseness_of
from ..memory.state import CLOSED, END_JOINED, END_NO_ROOM, END_RESTED, ROLLING
from .steering import steer_existing

_SLOWEST = 1e-12  # m/s: a slower striker moves nothing, and its square may underflow


@kernel
def _take(target, record, places):
    """Copy what a record says of the parameters that can be steered."""
    for i in range(len(places)):
        if places[i] >= 0:
            set_field(target, i, field(record, places[i]))


@kernel
def start_gesture(state, obj, event):
    """Take a striker into an object's list, to touch it at its time; a roll or slide that goes on is steered."""
    rolls = event.kind == KIND_ROLL or event.kind == KIND_SLIDE
    speed = _speed_of(event)
    stats = state.stats
    full = stats.contacts_active == len(state.contacts) or (rolls and stats.rolls_active == len(state.rolls))
    if rolls and steer_existing(state, event):
        report_end(state, event.gesture, END_JOINED)
    elif speed < _SLOWEST:
        report_end(state, event.gesture, END_RESTED)
    elif full:
        stats.impacts += 1
        stats.contacts_dropped += 1
        report_end(state, event.gesture, END_NO_ROOM)
    else:
        index = state.free_contact[len(state.contacts) - 1 - stats.contacts_active]
        stats.contacts_active += 1
        state.last_command[index] = 0 if event.kind == KIND_IMPACT else state.queue.carried_out
        contact = state.contacts[index]
        _describe(state, contact, event)
        if rolls:
            _begin_rolling(state, contact, event)
        schedule_contact(state, contact)
        append_contact(state, obj, index)


@kernel
def _speed_of(event):
    """Return the speed (m/s) at which a striker comes; for a spin its duration (s). A gesture of 0 does nothing."""
    if event.kind == KIND_ROLL:
        return event.roll.speed
    if event.kind == KIND_SLIDE:
        return max(event.slide.speed, event.slide.sweep)
    return event.spin.duration if event.kind == KIND_SPIN else event.strike.velocity


@kernel
def _describe(state, contact, event):
    """Make a contact what a command says."""
    strike = event.strike
    contact.kind = event.kind
    contact.gesture = event.gesture
    contact.command = event.number
    contact.v_in = strike.velocity
    contact.m, contact.k, contact.mu, contact.a = strike.mass, strike.stiffness, strike.dissipation, strike.exponent
    contact.w = 0.0
    if strike.restitution > 0.0:
        contact.w, contact.mu = loss_of(strike.restitution), 0.0
    _choose_points(state, contact, event)
    contact.touching = 0
    contact.until = contact.gone_at = math.inf
    contact.origin = event.time
    contact.elapsed = 0.0
    contact.spin = 0.0
    contact.push = contact.push_target = 0.0
    contact.solver = CLOSED
    contact.unsettled = contact.solved = contact.has_weight = 0
    contact.forces[:] = 0.0
    contact.level = strike.gesture_level
    _choose_sound(state, contact, strike)
    target = contact.target
    for i in range(len(IN_STRIKE)):
        set_field(target, i, 0.0)
    _take(target, strike, IN_STRIKE)
    target.gain *= contact.level
    if event.kind == KIND_BOUNCE:
        _take(target, event.bounce, IN_BOUNCE)
        contact.random = np.uint64(event.bounce.seed)
        contact.elapsed = event.bounce.delay
        contact.has_weight = int(event.bounce.weight)
        contact.push = contact.push_target = contact.m * target.gravity
    elif event.kind == KIND_ROLL:
        _take(target, event.roll, IN_ROLL)
    elif event.kind == KIND_SLIDE:
        _take(target, event.slide, IN_SLIDE)
    elif event.kind == KIND_SPIN:
        _take(target, event.spin, IN_SPIN)
    elif event.kind == KIND_PRESS:
        _take(target, event.press, IN_PRESS)
        contact.push_target = target.force
        target.gain = 1.0  # a hand that is softer is one that presses less
    contact.now = contact.target
    if event.kind == KIND_SPIN:
        begin_spin(contact, event.spin)


@kernel
def _choose_sound(state, contact, strike):
    """Say which striker's modes sound with a contact, if it has any, and have them ready."""
    contact.sound = contact.voice = -1
    contact.spot = np.uint64(0)
    if strike.sound_serial > 0.0:
        contact.sound, contact.sound_serial = int(strike.sound), int(strike.sound_serial)
        striker = state.strikers[contact.sound]
        state.stats.strikers_cut += striker.serial != contact.sound_serial
        if striker.prepared == 0 and striker.serial == contact.sound_serial:
            prepare(striker, state.rate)


@kernel
def _choose_points(state, contact, event):
    """Say which object is touched, and which one touches it, if one does."""
    touched, other = contact.point[0], contact.point[1]
    touched.slot, touched.serial = event.slot, event.serial
    other.slot, other.serial = event.by_slot, event.by_serial
    partner = state.objects[other.slot]
    if partner.used == 1 and partner.serial == other.serial and partner.dying == 0:
        place(other, event.strike.by_position, partner.rows)
    else:
        other.slot = -1  # it was told to go, or there never was one: its mass strikes alone


@kernel
def _begin_rolling(state, contact, event):
    """Give a rolling or sliding striker its body and its surface."""
    slides = event.kind == KIND_SLIDE
    stats = state.stats
    contact.roll = state.free_roll[len(state.rolls) - 1 - stats.rolls_active]
    stats.rolls_active += 1
    contact.solver = ROLLING
    contact.touching = 1
    state.contact_count += 1
    contact.number = state.contact_count
    contact.travel = event.slide.travel if slides else event.roll.travel
    contact.rolled = contact.rolls = 0.0
    roll = state.rolls[contact.roll]
    profile = event.surface
    begin_surface(
        roll.path.surface, profile.roughness, profile.correlation, profile.slope, profile.ripple, profile.wavelength,
        np.int64(event.slide.seed if slides else event.roll.seed),
    )  # fmt: skip
    roll.target = contact.target
    if slides:
        state.slides[contact.roll].press = np.int64(event.slide.press)
        begin_slide(state, contact)
    corners = 0.0 if slides else event.roll.corners
    begin_roll(roll, 0, contact.k, contact.mu, contact.a, corners, coarseness_of(state))
    couple_roll(state, contact)
