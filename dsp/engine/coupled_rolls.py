"""Rolls that feel what they roll on.

On an object that gives way a roll is coupled to its modes, as a blow is (rolling/coupled_roll.py): to all of them where
they are few or the accuracy is high, else to reduced ones (reduced_modes.py), which cost the same whatever the object.
Its contact swings at omega_c = sqrt(a g/x_e) about x_e, the compression at rest; modes that are slower give way, those
that are faster hardly move meanwhile. So sum m phi^2/(1 + (omega/omega_c)^2) tells by how much the object is lighter
than rigid.
"""

import math

import numpy as np

from ..contact.coupled import respond_with, step_coupled
from ..native.jit import kernel, noinline_kernel
from ..numerics.legendre import KEPT
from ..resonator.bank import inject_fine, observe, receptance, ring
from ..rolling.coupled_roll import begin_coupled_roll, lead_coupled_roll
from .objects import is_felt, place, shape_at
from .quality import room_for_coupling
from .reduced_modes import place_reduced, reduce_modes, reduced_of, touched_of
from .reduced_record import MOST
from .solver_choice import choose_tolerance, count_steps, tolerance_of
from .state import COUPLING, QUANTUM

GIVING = np.array([0.03, 0.01, 0.003, 0.0])
"""By accuracy: that sum, above which a roll feels the modes."""

_FINE_LEVEL = 2  # of the accuracies, from which on a roll feels all modes
_SHARE = 0.5  # of the room for coupled modes that rolls leave to others at least
_PLACES = 5  # along the path of a body that moves over its object, at which is looked
_PLACED = 16  # frames after which one that feels all modes acts at another place


@noinline_kernel
def couple_roll(state, contact):
    """Couple a roll that begins to the modes of its objects, if they give way enough."""
    if not _giving_of(state, contact) > GIVING[state.choices.accuracy]:
        return
    contact.light = 1
    contact.debt = 0
    begin_coupled_roll(state.rolls[contact.roll], contact.coupled, state.rate, tolerance_of(state, contact))
    contact.modes = 0
    for side in range(2):
        point = contact.point[side]
        if point.slot >= 0:
            point.modes = state.objects[point.slot].size
            contact.modes += point.modes
    if contact.modes <= MOST or state.choices.accuracy >= _FINE_LEVEL:
        room = room_for_coupling(state)
        if room == 0 or state.stats.coupled_modes + contact.modes <= _SHARE * room:
            contact.solver = COUPLING
            contact.unsettled = 1
            state.stats.coupled += 1
            state.stats.coupled_modes += contact.modes
            return
        state.stats.over_budget += 1
    contact.reduced = 1
    reduce_modes(state, contact, True)
    place_reduced(state, contact)
    contact.unsettled = 1


@kernel
def _giving_of(state, contact):
    """By how much the objects that a roll touches are lighter than rigid: the greatest on its way."""
    target = contact.target
    rest = (target.mass * target.gravity / contact.k) ** (1.0 / contact.a)
    omega_c = math.sqrt(contact.a * target.gravity / rest)
    rows = state.objects[contact.point[0].slot].rows
    greatest = 0.0
    for n in range(_PLACES if contact.travel > 0.0 else 1):
        place(contact.point[0], n / (_PLACES - 1.0) if contact.travel > 0.0 else contact.now.position, rows)
        greatest = max(greatest, target.mass * _mobility(state, contact, omega_c))
    place(contact.point[0], contact.now.position, rows)
    return greatest


@kernel
def _mobility(state, contact, omega_c):
    """sum phi^2/(1 + (omega/omega_c)^2) over the objects' modes, 1/kg."""
    total = 0.0
    for side in range(2):
        point = contact.point[side]
        if point.slot >= 0:
            obj = state.objects[point.slot]
            for i in range(obj.size):
                omega = 2.0 * math.pi * state.bank.frequency[obj.first + i]
                if is_felt(obj, i) and omega > 0.0:
                    phi = shape_at(state, obj, point, i)
                    total += phi * phi / (1.0 + (omega / omega_c) ** 2)
    return total


@kernel
def lead_roll(state, contact):
    """Bring a roll that feels all modes to the coming sample: its path, and where it acts."""
    roll = state.rolls[contact.roll]
    frame = int(roll.t * state.rate + 0.5)
    begin, whole = contact.fraction if roll.t == 0.0 else 0.0, state.choices.accuracy < _FINE_LEVEL
    if lead_coupled_roll(roll, contact.coupled, begin, whole):
        contact.unsettled = 1
    contact.rolled = roll.s
    if contact.travel > 0.0 and frame % _PLACED == 0:
        place(contact.point[0], position_of(contact, 0), state.objects[contact.point[0].slot].rows)
        contact.unsettled = 1


@noinline_kernel
def fill_reduced(state, contact, since, feed):
    """Moments (N s) of the force of a roll that feels reduced modes, over each frame of `feed`, (frames, KEPT).

    since: s from the roll's beginning to that of the first frame.
    """
    roll, coupled, scratch = state.rolls[contact.roll], contact.coupled, state.scratch
    reduced = state.reduced[contact.roll]
    if contact.unsettled == 1 and roll.t > 0.0:
        reduce_modes(state, contact, False)
    if contact.travel > 0.0 or contact.unsettled == 1:
        place(contact.point[0], position_of(contact, QUANTUM), state.objects[contact.point[0].slot].rows)
        place_reduced(state, contact)
        contact.unsettled = 1
    modes, where = reduced_of(reduced), touched_of(reduced)
    first = since * state.rate
    for n in range(len(feed)):
        for k in range(KEPT):
            feed[n, k] = 0.0
        if first + n + 1.0 <= 0.0 or roll.ended == 1:
            continue
        if lead_coupled_roll(roll, coupled, max(-(first + n), 0.0), True) or contact.unsettled == 1:
            receptance(modes, where, scratch.work, scratch.fine)
            respond_with(coupled, scratch.fine)
            contact.unsettled = 0
        observe(modes, where, scratch.work, scratch.observed)
        choose_tolerance(state, contact)
        count_steps(state, contact, -1, 1)
        step_coupled(coupled, scratch.observed, scratch.fine)
        count_steps(state, contact, 1, 1)
        inject_fine(modes, where, scratch.fine)
        ring(modes, scratch.striker, 0, 1)
        for k in range(KEPT):
            feed[n, k] = roll.fade * scratch.fine[k]
    roll.impacts = coupled.contacts - 1


@kernel
def position_of(contact, frame):
    """Where a rolling or sliding body is along the object's strike path, on which it goes to and fro."""
    position = contact.now.position
    if contact.travel > 0.0:
        position += (contact.rolls * (frame / QUANTUM) + contact.rolled) / contact.travel
    position -= 2.0 * math.floor(0.5 * position)
    return min(position, 2.0 - position)
