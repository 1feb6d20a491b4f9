"""Resting contacts: an object lies on another one, or on a support, under a load.

The contact is as all that are coupled to modes: its spring and its loss act on all modes of both, and it may open, so
that what moves by more than the load compresses it buzzes. The load is in balance with the contact at rest, and acts on
both alike: modes get the force beyond it, and so need not bend under it. The object as a whole, or the hand's flesh, is
the mass on which the load acts.

A rest begins at the compression x = (load/k)^(1/a), without a blow, wherever the object's point is then. A load or a
law that is steered moves both along to its own compression: U = V(x) - V(x_0) - load (x - x_0), the energy of the
contact, is what it was about another rest, and one that is still stays so.

Where nothing moves, nothing is computed. Objects that rest on each other fall asleep together, once nobody hears their
modes and no contact swings any more. They awake before the first sample in which anything else touches one of them, so
that a rest that slept and one that did not are the same to the bit, but for what nobody heard.
"""

import math

from ...contact.coupled import begin_at_rest
from ...contact.law import compression_at
from ...native.jit import kernel, noinline_kernel
from ...numerics.constants import HARDEST_REST
from ..bodies.objects import is_heard, least_heard
from ..bodies.sheets import is_coupled
from ..bodies.surface import put_other
from ..memory.records import Contact
from ..memory.state import COUPLING, COVERING, QUANTUM, State
from .contact_force import couple, touch
from .contact_list import give_place_back
from .room import find_coupled_room

_FIRST = 0.2  # of a radian of its swing: the first step to try
_STILL = 1e-2  # of the compression at rest: a contact that swings by less stays closed, and swings ever less


@noinline_kernel
def begin_rest(state: State, contact: Contact) -> bool:
    """Lay an object on what it rests on. False if there is no room for it."""
    touch(state, contact)
    coupled = contact.coupled
    put_other(state, contact)
    contact.light = 1
    if not find_coupled_room(state, contact):
        return False
    contact.solver = COUPLING
    couple(state, contact)
    _press(contact, load_of(contact))
    begin_at_rest(coupled, 0.0, contact.fraction, _FIRST / (coupled.swing * coupled.period))
    return True


@kernel
def _press(contact: Contact, load: float) -> None:
    """Put a load (N) on a contact."""
    coupled = contact.coupled
    coupled.push = coupled.rest_force = load
    coupled.rest_compression = compression_at(load, contact.k, contact.a)
    coupled.swing = math.sqrt(contact.a * load / (contact.m * coupled.rest_compression))


@kernel
def load_of(contact: Contact) -> float:
    """Return the load (N) on a rest: as it is steered, as far as its mass bears that."""
    return min(contact.now.load, HARDEST_REST * contact.m)


@kernel
def bear_load(contact: Contact) -> None:
    """Move both bodies of a rest along to the compression at which it bears its load, where that or its law is another
    than before."""
    coupled, before = contact.coupled, contact.coupled.rest_compression
    _press(contact, load_of(contact))
    shift = coupled.rest_compression - before
    coupled.position += shift
    coupled.motion[0] += shift
    if coupled.touching == 1:
        coupled.motion[0] = max(coupled.motion[0], 0.0)


@noinline_kernel
def settle_rests(state: State) -> None:
    """Say which rests sleep in this quantum: those of objects that nothing else moves, nor what rests on these."""
    if state.resting == 0:
        return
    for i in range(state.active):
        index = state.objects[state.order[i]].contact
        while index >= 0:
            # Say whether the objects of a contact can't sleep: it acts on them, a rest swings, or they ring.
            contact, coupled = state.contacts[index], state.contacts[index].coupled
            acts = contact.touching == 1 or contact.start < state.position + QUANTUM
            rests = contact.trait.rests == 1 and contact.solver == COUPLING
            least = _STILL * coupled.rest_compression
            away, pace = abs(coupled.motion[0] - coupled.rest_compression), abs(coupled.v)
            still = coupled.touching == 1 and away < least and pace < least * coupled.swing
            moves = acts and contact.solver != COVERING and not (rests and (contact.asleep == 1 or still))
            for side in range(2):
                if contact.point[side].slot >= 0:
                    obj = state.objects[contact.point[side].slot]
                    if moves:
                        obj.restless = 1
                    elif rests and obj.restless == 0:  # they ring, or may
                        rings = obj.spectral > 0 or obj.fading > 0 or is_coupled(state, obj)
                        if rings or is_heard(state, obj, obj.first, obj.first + obj.live, least_heard(state, obj)):
                            obj.restless = 1
            index = state.contacts[index].next
    spreads = True
    while spreads:
        # Keep those awake that rest on what can't sleep, and what they rest on.
        spreads = False
        for i in range(state.active):
            index = state.objects[state.order[i]].contact
            while index >= 0:
                contact = state.contacts[index]
                if contact.trait.rests == 1 and contact.touching == 1 and contact.point[1].slot >= 0:
                    one, other = state.objects[contact.point[0].slot], state.objects[contact.point[1].slot]
                    spreads |= one.restless != other.restless
                    one.restless = other.restless = max(one.restless, other.restless)
                index = contact.next
    for i in range(state.active):
        index = state.objects[state.order[i]].contact
        while index >= 0:
            contact = state.contacts[index]
            if contact.trait.rests == 1 and contact.solver == COUPLING:
                if state.objects[contact.point[0].slot].restless == 1:
                    # Wake a rest, to be computed in this quantum.
                    contact.asleep = contact.ahead = 0
                    for side in range(2):
                        if contact.point[side].slot >= 0:
                            obj = state.objects[contact.point[side].slot]
                            obj.has_contact = 1
                            if contact.point[1].slot >= 0:
                                obj.shares_contact = 1
                elif contact.asleep == 0:
                    # Put a rest and the modes of its objects to rest, from this quantum on.
                    coupled = contact.coupled
                    contact.asleep = 1
                    give_place_back(state, contact)
                    contact.ahead = QUANTUM
                    contact.forces[:] = 0.0
                    coupled.v = 0.0
                    coupled.motion[0] = coupled.position = coupled.rest_compression
                    for side in range(2):
                        if contact.point[side].slot >= 0:
                            obj = state.objects[contact.point[side].slot]
                            for mode in range(obj.first, obj.first + obj.live):
                                state.bank.y1[mode] = state.bank.y2[mode] = 0.0
                            obj.live = obj.has_contact = 0
            index = contact.next
