"""A contact's force: the solver that it gets, and what its force does to the modes, sample by sample.

Every solver begins with `begin_contact`. A closed one goes on in `apply_contact_force`; coupled ones are solved
before (contact_groups.py).
"""

import math

from ...contact.closed_form import advance_pulse
from ...contact.coupled import ContactLaw, begin_coupled, respond_with
from ...contact.law import compression_at
from ...native.jit import kernel, noinline_kernel
from ...numerics.legendre import FINE, KEPT, MOMENTS
from ...resonator.bank import inject, inject_fine, inject_kept, observe, receptance, transfer_receptance
from ..bodies.bends import find_static
from ..bodies.glide import tighten
from ..bodies.objects import modes_of, point_of
from ..bodies.sensing import push_sensed
from ..bodies.strikers import begin_striker, drive_striker
from ..bodies.surface import put
from ..memory.quality import modes_for
from ..memory.records import Contact
from ..memory.state import COUPLING, State
from ..output.fade import note_force
from .contact_list import take_room_again
from .coupled_rolls import put_on_line, share_driven
from .room import find_coupled_room, has_room_for
from .solver_choice import choose_solver, find_speed, soften_pulse, tolerance_of
from .trace import trace_blow, trace_snap, trace_touches


@noinline_kernel
def begin_contact(state: State, contact: Contact, pushed: bool) -> bool:
    """Begin to touch; where `pushed`, the striker's push acts meanwhile. False if there is no room for it."""
    touch(state, contact)
    tighten(state, contact)
    if contact.impulse > 0.0:
        find_speed(state, contact)
    if contact.w > 0.0:
        contact.mu = contact.w / max(contact.v_in, _resting_speed(contact))
    has_room = pushed or has_room_for(state, contact)
    solver, mass_ratio, seen_mass_ratio = choose_solver(state, contact, has_room)
    if solver != COUPLING:
        soften_pulse(state, contact, mass_ratio, seen_mass_ratio)
    if pushed:
        solver = COUPLING
    if solver != COUPLING:
        # Stop a contact from acting on modes that nobody hears: it has its force already.
        for side in range(2):
            point = contact.point[side]
            if point.slot >= 0:
                point.modes = min(point.modes, state.objects[point.slot].unheard)
    if solver == COUPLING and not find_coupled_room(state, contact):
        return False
    contact.solver = solver
    if solver == COUPLING:
        couple(state, contact)
    begin_striker(state, contact)
    if contact.voice >= 0 and state.voices[contact.voice].snap > 0.0:
        trace_snap(state, contact, state.voices[contact.voice])
    return True


@kernel
def touch(state: State, contact: Contact) -> None:
    """Begin a contact: give it a number, and find where it acts."""
    state.stats.impacts += 1
    state.contact_count += 1
    contact.number = state.contact_count
    contact.touching = 1
    contact.forces[:] = 0.0
    put(state, state.objects[contact.point[0].slot], contact, contact.now.position)
    update_mode_count(state, contact)


@kernel
def _resting_speed(contact: Contact) -> float:
    """Return the speed (m/s) of a striker that rocks on its contact under what pushes it: sqrt(F x/m), k x^a = F.

    A restitution is that of blows. Slower ones, near rest, get the dissipation of this speed.
    """
    push = contact.push_target
    return math.sqrt(push / contact.m * compression_at(push, contact.k, contact.a)) if push > 0.0 else 0.0


@kernel
def couple(state: State, contact: Contact) -> None:
    """Begin a contact that is solved together with the modes."""
    contact.unsettled = 1
    contact.debt = 0
    contact.told = 1
    law = ContactLaw(contact.m, contact.k, contact.mu, contact.a)
    begin_coupled(
        contact.coupled, contact.v_in, law, contact.push, contact.fraction, state.rate, tolerance_of(state, contact)
    )
    contact.coupled.w = contact.w
    contact.coupled.slowest = _resting_speed(contact)
    state.stats.coupled += 1
    state.stats.coupled_modes += contact.modes


@kernel
def update_mode_count(state: State, contact: Contact) -> bool:
    """Choose the modes that a contact acts on; true if they are others than before."""
    changed = False
    for side in range(2):
        point = contact.point[side]
        if point.slot >= 0:
            modes = modes_for(state, state.objects[point.slot], contact)
            changed |= modes != point.modes
            point.modes = modes
    return changed


@noinline_kernel
def apply_contact_force(state: State, contact: Contact, frame: int) -> bool:
    """Give the modes the force of a contact over the sample that ends at a frame of the quantum; those of a coupled
    contact have it already, but a slide's.

    False where a contact of closed form ends.
    """
    scratch = state.scratch
    sample = state.position + frame - 1
    age = sample + 1 - contact.start - contact.fraction
    lasts = True
    if contact.solver == COUPLING:
        contact.solved = 0
        if contact.travel > 0.0:  # friction has put it amid the quantum, or the rows of its ringing elsewhere
            put_on_line(state, contact, frame, scratch.drift)
        for n in range(FINE):
            scratch.fine[n] = contact.moments[n]
        trace_touches(state, contact, sample)
        note_force(contact.forces, scratch.fine[0] * state.rate)
        gain = gain_of(state, contact)
        for n in range(FINE):
            scratch.fine[n] *= gain
        impulse = scratch.fine[0]
    else:
        advance_pulse(contact.pulse, min(age, contact.pulse.duration), age - 1.0, scratch.moments)
        lasts = age < contact.pulse.duration  # a duration that is not a number has no end
        begin = contact.start + contact.fraction
        trace_blow(state, contact, sample, begin, begin + contact.pulse.duration)
        note_force(contact.forces, scratch.moments[0] * state.rate)
        for n in range(MOMENTS):
            scratch.moments[n] *= contact.now.gain
        impulse = scratch.moments[0]
    if contact.sound >= 0 and impulse != 0.0:
        drive_striker(state, contact)
    if contact.solver != COUPLING or contact.trait.slips == 1:
        drive(state, contact)
    return lasts


@kernel
def gain_of(state: State, contact: Contact) -> float:
    """Return the factor on the force that the modes get: the gesture's gain, and the share that drives them."""
    return contact.now.gain * share_driven(state, contact)


@kernel
def drive(state: State, contact: Contact) -> None:
    """Inject a contact's force over the sample, whose moments are in `scratch`, into the modes that it touches."""
    for side in range(2):
        if contact.point[side].slot >= 0:
            # Inject a contact's force over the sample into the modes of an object at its point.
            point = contact.point[side]
            obj = state.objects[point.slot]
            obj.live = max(obj.live, point.modes)
            obj.driven_modes = max(obj.driven_modes, point.modes)
            obj.driven_gain = max(obj.driven_gain, contact.now.gain)
            modes, where = modes_of(state, obj, 0, point.modes), point_of(state, obj, point)
            if obj.sensors > 0:
                first = state.scratch.fine[0] if contact.solver == COUPLING else state.scratch.moments[0]
                push_sensed(state, obj, where, point.modes, first)
            if contact.solver == COUPLING:
                # How many moments of a force say all of it, FINE or KEPT: one that is a quadratic over the sample has
                # no more, and a striker that flies none.
                kept = beyond = False
                for n in range(KEPT):
                    kept |= state.scratch.fine[n] != 0.0
                for n in range(KEPT, FINE):
                    beyond |= state.scratch.fine[n] != 0.0
                count = FINE if beyond else KEPT if kept else 0
                if count > KEPT:
                    inject_fine(modes, where, state.scratch.fine)
                elif count > 0:
                    inject_kept(modes, where, state.scratch.fine)
            else:
                inject(modes, where, state.scratch.moments)


@kernel
def observe_points(state: State, contact: Contact) -> None:
    """Find how the points that are touched would move without the contact; give it their receptance where that is new.

    A contact with a gain sees a motion that is as large as if it had none.
    """
    scratch = state.scratch
    take_room_again(state, contact)
    for n in range(FINE):
        scratch.observed[n] = scratch.receptance[n] = 0.0
    for side in range(2):
        point = contact.point[side]
        if point.slot < 0:
            continue
        obj = state.objects[point.slot]
        modes, where = modes_of(state, obj, 0, point.modes), point_of(state, obj, point)
        if contact.unsettled == 1:
            receptance(modes, where, scratch.work, scratch.fine)
            for n in range(FINE):
                scratch.receptance[n] += scratch.fine[n]
            if contact.trait.held == 1 or contact.trait.falls == 1:  # others have no push
                find_static(state, contact, side, obj, point.modes)
        if obj.live > 0:
            observe(modes, where, scratch.work, scratch.fine)
            scale = 1.0 / contact.now.gain
            for n in range(FINE):
                scratch.observed[n] += scale * scratch.fine[n]
    if contact.unsettled == 1:
        respond_with(contact.coupled, scratch.receptance)
        contact.unsettled = 0
        state.settled_count += 1
        contact.settled = state.settled_count


@kernel
def find_transfer(state: State, contact: Contact, other: Contact) -> None:
    """Find how the points of a contact answer the force of another one, in `scratch.receptance`: on all objects that
    both touch."""
    scratch = state.scratch
    for n in range(FINE):
        scratch.receptance[n] = 0.0
    for side in range(2):
        for other_side in range(2):
            point, struck = contact.point[side], other.point[other_side]
            if point.slot >= 0 and point.slot == struck.slot:
                obj = state.objects[point.slot]
                modes = modes_of(state, obj, 0, min(point.modes, struck.modes))
                transfer_receptance(
                    modes, point_of(state, obj, struck), point_of(state, obj, point), scratch.work, scratch.fine
                )
                for n in range(FINE):
                    scratch.receptance[n] += scratch.fine[n]
