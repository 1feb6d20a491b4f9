"""Coupled contacts are solved sample by sample, those that share objects together."""

import math

from ...contact.coupled import answer_of
from ...contact.coupled_group import step_together
from ...contact.coupled_records import GROUP, CoupledGroup
from ...contact.coupled_step import HELD
from ...native.jit import kernel, noinline_kernel
from ...native.typed import View
from ...numerics.legendre import FINE
from ...resonator.fed import LINE
from ...rolling.coupled_roll import lead_coupled_roll
from ...schema import POSITION
from ..bodies.surface import glides, put_behind
from ..memory.quality import holds_steps
from ..memory.records import Contact
from ..memory.state import COUPLING, QUANTUM, State
from .contact_force import drive, find_transfer, gain_of, observe_points
from .contact_list import acts, share_object
from .coupled_rolls import PASSED, passed_by, put_on_line
from .presses import press
from .solver_choice import choose_tolerance, count_steps, price_of

_PLACE_GLIDE = POSITION.glide  # s


@noinline_kernel
def solve_groups(state: State, frame: int) -> None:
    """Solve the coupled contacts of objects of `scratch.group` over the sample that ends at a frame."""
    # List the coupled contacts that may touch in the sample; their number.
    scratch = state.scratch
    count = 0
    for g in range(scratch.group_size):
        index = state.objects[scratch.group[g]].contact
        while acts(state, index):
            contact = state.contacts[index]
            due = state.position + frame - contact.start - contact.fraction > 0.0
            if contact.touching == 1 and contact.solver == COUPLING and frame >= contact.ahead and due:
                choose_tolerance(state, contact)
                scratch.candidates[count] = index
                count += 1
            index = contact.next
    candidates = state.scratch.candidates
    for i in range(count):
        if candidates[i] >= 0:
            # Put a candidate and all that share objects with it, and with these, into `together`; they are
            # candidates no more. More than GROUP see each other one after the other, and so do those whose forces
            # are held.
            group = state.scratch.together
            group.size = 0
            _join(group, candidates, i)
            member = 0
            while member < group.size:
                for k in range(count):
                    if group.size < GROUP and candidates[k] >= 0:
                        one, other = state.contacts[group.member[member]], state.contacts[candidates[k]]
                        held = one.coupled.tolerance == HELD or other.coupled.tolerance == HELD
                        if not held and share_object(one, other):
                            _join(group, candidates, k)
                member += 1
            _solve(state, frame)


@noinline_kernel
def solve_alone(state: State, contact: Contact, frame: int) -> None:
    """Solve a coupled contact by itself over the sample that ends at a frame, in which it begins after the others were
    solved."""
    choose_tolerance(state, contact)
    state.scratch.together.size = 1
    state.scratch.together.member[0] = contact.index
    _solve(state, frame)


@kernel
def _join(group: CoupledGroup, candidates: View[int], i: int) -> None:
    """Put a candidate into the group; it is one no more."""
    group.member[group.size] = candidates[i]
    candidates[i] = -1
    group.size += 1


@noinline_kernel
def _solve(state: State, frame: int) -> None:
    """Find the moments of all forces in `together` over the sample that ends at a frame, and have them act."""
    group = state.scratch.together
    # Bring the members into the order in which they began, so that one keeps its own while contacts take turns.
    for i in range(1, group.size):
        member = group.member[i]
        j = i
        while j > 0:
            one, other = state.contacts[member], state.contacts[group.member[j - 1]]
            if not (one.start < other.start or (one.start == other.start and one.fraction < other.fraction)):
                break
            group.member[j] = group.member[j - 1]
            j -= 1
        group.member[j] = member
    price = price_of(group.size)
    for i in range(group.size):
        contact = state.contacts[group.member[i]]
        if contact.trait.along == 1:
            # Bring a roll that feels all modes to the coming sample: its path, and where it acts.
            roll, led = state.rolls[contact.roll], contact.led
            at = int(contact.origin + 1.0 + roll.t * state.rate + 0.5) - state.position - led  # in the quantum
            if led == 0 and lead_coupled_roll(roll, contact.coupled, contact.fraction if roll.t == 0.0 else 0.0):
                contact.unsettled = 1
            contact.led = 0
            if contact.travel > 0.0:
                put_on_line(state, contact, at, state.scratch.drift)
                if passed_by(state, contact) > PASSED or at % LINE == 0 or at == contact.ahead:
                    contact.unsettled = 1
        if contact.trait.held == 1:
            press(contact, frame)
            # Put a coupled striker that is pressed on where it is amid the sample that ends at a frame; at a
            # surface, and for how objects answer it, where it was at the first of LINE samples.
            if glides(contact):
                left = (QUANTUM - frame - 0.5) / (_PLACE_GLIDE * state.rate)
                anew = frame % LINE == 0
                put_behind(state, contact, math.expm1(left), anew)
                contact.unsettled |= int(anew)
        observe_points(state, contact)
        if contact.coupled.tolerance == HELD and not holds_steps(state):
            state.stats.over_budget += 1
        for n in range(FINE):
            group.observed[i, n] = state.scratch.observed[n]
        count_steps(state, contact, -1, price)
    if group.size > 1:
        # Find how each contact's points answer the others' forces, but where that is known from an earlier sample.
        for k in range(GROUP):
            if k < group.size:
                one = state.contacts[group.member[k]]
                if group.known[k] == one.settled and group.gain[k] == gain_of(state, one):
                    continue
            group.known[k] = 0
        for k in range(group.size):
            for j in range(group.size):
                if k != j and (group.known[k] == 0 or group.known[j] == 0):
                    # Find how the points of contact i answer the force of contact j: on all objects that both touch.
                    contact, other = state.contacts[group.member[k]], state.contacts[group.member[j]]
                    find_transfer(state, contact, other)
                    gain = gain_of(state, other) / contact.now.gain
                    answer_of(state.scratch.receptance, gain / state.rate, group.answer[k, j])
        for k in range(group.size):
            group.known[k] = state.contacts[group.member[k]].settled
            group.gain[k] = gain_of(state, state.contacts[group.member[k]])
    step_together(state.contacts, group)
    for i in range(group.size):
        contact = state.contacts[group.member[i]]
        count_steps(state, contact, 1, price)
        contact.solved = 1
        gain = gain_of(state, contact)
        for n in range(FINE):
            contact.moments[n] = group.moments[i, n]
            state.scratch.fine[n] = gain * contact.moments[n]
        if contact.trait.slips == 0:  # else friction comes first
            drive(state, contact)
