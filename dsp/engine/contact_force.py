"""What a contact does in a sample: its force by the solver it was given, into the modes of what it touches."""

import math

from ..contact.closed_form import advance, begin
from ..contact.coupled import apart_for, begin_coupled, respond_with, step_coupled
from ..contact.coupled_step import HELD
from ..contact.sampled import follow, start
from ..native.jit import kernel
from ..numerics.legendre import FINE, MOMENTS, add_held
from ..resonator.bank import LANES, RESPONSES, inject, inject_fine, observe, receptance
from .objects import highest_of, place, reach_of, sigma_of
from .quality import modes_for, room_for_coupling
from .solver_choice import needs_coupling, tolerance_of
from .state import Solver

_CLOSED, _SAMPLED, _COUPLED = int(Solver.CLOSED), int(Solver.SAMPLED), int(Solver.COUPLED)

_STEPS = 4  # of a coupled contact in a sample, on average; beyond, the force is held for each sample
_BURST = 256  # that it may need at once
_BY_ITSELF = 32  # modes that cost as much as a contact does by itself
_TOO_STRONG = 1e3  # times its momentum that a sampled method may give in a step: it has failed, and would deafen
_PATIENCE = 3.0  # exact durations for which a sampled contact is followed: it might never end


@kernel
def meet(state, contact, pressed):
    """Begin to touch; where `pressed`, the striker's push acts on it meanwhile. False if there is no room for it."""
    state.impacts += 1
    contact.touching = 1
    place(contact.body[0], contact.position, state.objects[contact.body[0].slot].rows)
    choose_modes(state, contact)
    begin(contact.pulse, contact.v_in, contact.m, contact.k, contact.mu, contact.a, state.rate)
    coupled = needs_coupling(state, contact) or pressed
    if coupled and not _has_room(state, contact):
        state.contacts_dropped += 1
        return False
    if coupled:
        contact.solver = _COUPLED
        contact.unsettled = 1
        contact.debt = 0
        begin_coupled(
            contact.coupled, contact.v_in, contact.m, contact.k, contact.mu, contact.a, contact.push,
            contact.fraction, state.rate, tolerance_of(state),
        )  # fmt: skip
        state.coupled += 1
        state.coupled_modes += contact.modes
    elif state.contact_method > 0:
        # A sampled contact can't begin between samples.
        contact.solver = _SAMPLED
        contact.oversampling = state.contact_oversampling
        contact.fraction = 0.0
        contact.steps = int(_PATIENCE * contact.pulse.duration * contact.oversampling) + 20
        m = contact.pulse.momentum / contact.v_in  # the effective mass
        start(
            contact.sampled, state.contact_method - 1, state.contact_correction,
            contact.v_in, m, contact.k, contact.mu, contact.a,
        )  # fmt: skip
    else:
        contact.solver = _CLOSED
    return True


@kernel
def _has_room(state, contact):
    """May a contact be coupled to the modes that it touches?"""
    contact.modes = _BY_ITSELF
    for side in range(2):
        if contact.body[side].slot >= 0:
            contact.modes += contact.body[side].modes
    return state.coupled_modes == 0 or state.coupled_modes + contact.modes <= room_for_coupling(state)


@kernel
def choose_modes(state, contact):
    """Choose the modes that a contact acts on; true if they are others than before."""
    changed = False
    for side in range(2):
        body = contact.body[side]
        if body.slot >= 0:
            modes = modes_for(state, state.objects[body.slot], contact.kind)
            changed |= modes != body.modes
            body.modes = modes
    return changed


@kernel
def let_modes_go(state, contact):
    """A contact that was coupled is over."""
    if contact.solver == _COUPLED:
        state.coupled_modes -= contact.modes
        contact.solver = _CLOSED


@kernel
def act(state, contact, age):
    """Give the modes the force of a contact over the sample at whose end it is as old as `age`.

    False where a closed or sampled contact ends.
    """
    lasts = True
    if contact.solver == _COUPLED:
        _look(state, contact)
        held, contacts, steps = contact.coupled.held, contact.coupled.contacts, contact.coupled.steps
        contact.coupled.tolerance = HELD if contact.debt > _BURST else tolerance_of(state)
        step_coupled(contact.coupled, state.observed, state.fine)
        state.held += contact.coupled.held - held
        contact.debt = max(contact.debt + contact.coupled.steps - steps - _STEPS, 0)
        if contacts > 0:
            state.recontacts += contact.coupled.contacts - contacts
        for n in range(FINE):
            state.fine[n] *= contact.gain
    elif contact.solver == _SAMPLED:
        lasts = _step_sampled(state, contact)
    else:
        advance(contact.pulse, min(age, contact.pulse.duration), age - 1.0, state.moments)
        lasts = age < contact.pulse.duration  # a duration that is not a number has no end
    if contact.solver != _COUPLED:
        for n in range(MOMENTS):
            state.moments[n] *= contact.gain
    for side in range(2):
        body = contact.body[side]
        if body.slot < 0:
            continue
        obj = state.objects[body.slot]
        obj.live = max(obj.live, body.modes)
        obj.driven = max(obj.driven, body.modes)
        first = obj.first
        last = first + body.modes
        response = state.response[first // LANES * RESPONSES : last // LANES * RESPONSES]
        shape = state.shape[obj.table : obj.table + obj.rows * obj.size]
        y1 = state.y1[first:last]
        y2 = state.y2[first:last]
        if contact.solver == _COUPLED:
            inject_fine(y1, y2, response, shape, obj.size, body.row, body.weights, state.fine)
        else:
            inject(y1, y2, response, shape, obj.size, body.row, body.weights, state.moments)
    return lasts


@kernel
def _look(state, contact):
    """Have `observed` say how the points that are touched move by themselves; tell the contact how they give way.

    A contact with a gain sees all as loud as if it had none.
    """
    for n in range(FINE):
        state.observed[n] = state.given[n] = 0.0
    for side in range(2):
        body = contact.body[side]
        if body.slot < 0:
            continue
        obj = state.objects[body.slot]
        first = obj.first
        last = first + body.modes
        response = state.response[first // LANES * RESPONSES : last // LANES * RESPONSES]
        shape = state.shape[obj.table : obj.table + obj.rows * obj.size]
        a1 = state.a1[first:last]
        a2 = state.a2[first:last]
        if contact.unsettled == 1:
            receptance(a1, a2, response, shape, obj.size, body.row, body.weights, state.work, state.fine)
            for n in range(FINE):
                state.given[n] += state.fine[n]
            _weigh(state, contact, side, obj)
        if obj.live > 0:
            y1 = state.y1[first:last]
            y2 = state.y2[first:last]
            observe(y1, y2, a1, a2, response, shape, obj.size, body.row, body.weights, state.work, state.fine)
            for n in range(FINE):
                state.observed[n] += state.fine[n] / contact.gain
    if contact.unsettled == 1:
        respond_with(contact.coupled, state.given)
        contact.unsettled = 0


@kernel
def _weigh(state, contact, side, obj):
    """Put the static output for a push of 1 N into `lean`; the shapes are where `receptance` has left them."""
    left = right = 0.0
    for i in range(contact.body[side].modes):
        frequency = state.frequency[obj.first + i] * obj.tune
        if 0.0 < frequency <= highest_of(state):
            omega = 2.0 * math.pi * frequency
            sigma = sigma_of(state, obj, i)
            heard = state.work[i] * state.weight[obj.first + i] * omega / (omega * omega + sigma * sigma)
            left += heard
            right += heard * state.balance[obj.first + i]
    contact.lean[side, 0] = left
    contact.lean[side, 1] = right


@kernel
def flight(state, contact):
    """Samples for which a coupled striker that has left surely touches nothing; infinity if it never comes back."""
    distance = speed = 0.0
    for side in range(2):
        body = contact.body[side]
        if body.slot >= 0 and state.objects[body.slot].live > 0:
            far, fast = reach_of(state, state.objects[body.slot], body)
            distance += far / contact.gain
            speed += fast / contact.gain
    contact.reach = distance
    return apart_for(contact.coupled, distance, speed)


@kernel
def _step_sampled(state, contact):
    """Moments of a sampled contact over a sample: what its steps give, each held for the step. True while it lasts."""
    sampled = contact.sampled
    for n in range(MOMENTS):
        state.moments[n] = 0.0
    for i in range(contact.oversampling):
        before = sampled.v
        lasts = follow(sampled, 1.0 / (state.rate * contact.oversampling))
        given = sampled.m * (before - sampled.v)
        if not abs(given) < _TOO_STRONG * sampled.m * contact.v_in:
            return False  # the method has failed: what it gave so far stays
        add_held(given, i / contact.oversampling, (i + 1) / contact.oversampling, state.moments)
        contact.steps -= 1
        if not lasts or contact.steps <= 0:
            return False
    return True
