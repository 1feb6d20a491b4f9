"""Strikers that leave: the end of a touch, the flight of a bounce, and the striker that comes to rest on the object.

bounces.py has the flights of a bounce. Near rest the striker's weight acts in contact too, until its energy says
that it can't leave any more.
"""

import math

from ...contact.collocation import captured
from ...contact.coupled_flight import fly_on
from ...contact.law import compression_at, elastic
from ...native.jit import kernel, noinline_kernel
from ..memory.quality import keeps_strikers
from ..memory.records import Contact
from ..memory.state import COUPLING, END_RESTED, END_STOPPED, QUANTUM, Object, State
from .bounces import fly_off
from .clearance import energy_felt, flight, given_by_others, is_beyond
from .contact_list import KEPT_ASIDE, acts, append_contact, give_room_back, report_end, take_out
from .gesture_kernels import come_back
from .presses import fly_unseen
from .spins import next_turn

_LONGEST_LEAP = 256.0  # samples that a striker flies without a look at how far the object reaches
_SLOW = 3.0  # times sqrt(g x_e), the velocity below which a bouncing striker's weight counts while it touches
_LIFTED = 0.5  # s that a released striker stays
_LONGEST_TOUCH = 2.0  # s without a flight, after which a striker that nothing presses on is released
_HOP = 16.0  # samples of flight that count as one
_CLEAR = 1e3  # times as high as the object reaches: a bounce that flies higher is not followed
_KEPT, _AFAR = 0.01, 5e-3  # s and m: so long, or until so far away, an object can catch up with a striker that left
_SPENT = 1e-12  # share of its energy (-120 dB) with which a striker that nothing pushes is done


@kernel
def is_pushed(contact: Contact) -> bool:
    """True if the push on a striker counts while it touches: a hand's, or its weight near rest.

    Its weight does below some sqrt(g x_e): as fast moves a striker that rocks on its contact, about where it rests.
    """
    if contact.trait.falls == 0 or contact.has_weight == 1:
        return contact.trait.held == 1 or contact.trait.falls == 1
    deepest = compression_at(contact.m * contact.target.gravity, contact.k, contact.a)
    return contact.v_in < _SLOW * math.sqrt(contact.target.gravity * deepest)


@noinline_kernel
def follow_coupled(state: State, contact: Contact, frame: int) -> bool:
    """Look at a coupled contact after a sample: false where it is over."""
    coupled = contact.coupled
    if contact.trait.rests == 1:
        return math.isfinite(coupled.v)
    now = float(state.position + frame)
    samples = 0.0 if coupled.touching == 1 else flight(state, contact, True)
    if contact.trait.repeats == 1 and contact.trait.falls == 0:
        # A disc's contact is over where its rim has left for good, or surely touches nothing until the next is due.
        due = now + samples >= contact.origin + next_turn(contact) * state.rate
        if contact.gone_at < math.inf:
            over = due or now >= contact.gone_at
        else:
            over = coupled.touching == 0 and coupled.contacts > 0 and (due or samples == math.inf)
        if over or not math.isfinite(coupled.v):
            return come_back(contact.kind, state, contact, frame)
    if now >= contact.gone_at or not math.isfinite(coupled.v):
        report_end(state, contact.gesture, END_RESTED if contact.until == math.inf else END_STOPPED)
        return False
    blow_flies = contact.trait.single == 1 and coupled.touching == 0
    if blow_flies and now + samples >= contact.until and contact.until < math.inf:
        # It is awaited no longer than it surely touches nothing.
        report_end(state, contact.gesture, END_STOPPED)
        return False
    if contact.gone_at == math.inf and (samples == 0.0 or now - contact.begun > _LONGEST_TOUCH * state.rate):
        release_spent(state, contact, now)
    if samples == 0.0:
        return True
    if contact.trait.single == 1 and coupled.v < 0.0 and coupled.position < -_AFAR - contact.reach:
        samples = math.inf
    if contact.trait.held == 1 and contact.gone_at == math.inf:
        if samples == math.inf and contact.push_target == 0.0:
            coupled.v = 0.0  # a hand that does not press hovers
        samples = min(samples, float(QUANTUM - 1 - frame))  # then its push changes
        if samples == 0.0:
            return True
    if samples == math.inf and (contact.trait.single == 0 or not keeps_strikers(state)):
        report_end(state, contact.gesture, END_RESTED if contact.until == math.inf else END_STOPPED)
        return False
    elif samples == math.inf:
        # Keep a striker that has left for good in flight for a while, as another one may throw the object after it.
        away = max(_AFAR + coupled.position, 0.0) / max(-coupled.v, _AFAR / _KEPT)
        contact.gone_at = min(contact.gone_at, now + math.floor(away * state.rate) + 1.0)
        give_room_back(state, contact)
        contact.aside = KEPT_ASIDE
        fly_on(coupled, contact.gone_at - now)
        contact.start = int(contact.gone_at) + QUANTUM  # it is forgotten before: see is_gone
        contact.fraction = 0.0
        return True
    bounces = contact.trait.falls == 1 and contact.gone_at == math.inf and coupled.v < 0.0
    if bounces and coupled.v * coupled.v > 2.0 * contact.target.gravity * _CLEAR * contact.reach:
        # It flies so high that it comes back to the object at rest; else to where the object's ringing has it.
        contact.elapsed = (now - contact.origin) / state.rate
        return fly_off(state, contact, -coupled.v, max(-coupled.position, 0.0))
    skipped = min(samples, _LONGEST_LEAP)
    if contact.trait.falls == 1 and skipped > _HOP:
        contact.begun = now  # a flight: it does not stay
    # Advance a striker unseen by whole samples from a frame on, which it surely stays apart.
    fly_unseen(state, contact, float(state.position + frame), skipped)
    give_room_back(state, contact)
    contact.start = state.position + frame + int(skipped)
    contact.fraction = 0.0
    return True


@kernel
def is_gone(state: State, contact: Contact) -> bool:
    """True if a striker has left that nothing caught up with in the time for which it was kept."""
    return contact.aside == KEPT_ASIDE and state.position >= contact.gone_at


@noinline_kernel
def call_back(state: State, obj: Object, frame: int) -> None:
    """Look sooner at strikers that fly from an object, where another that began to touch may throw it after them."""
    now = float(state.position + frame - 1)
    energy = -1.0
    before, index = -1, obj.contact
    while index >= 0:
        contact = state.contacts[index]
        after = contact.next
        if contact.touching == 1 and contact.solver == COUPLING and contact.aside > 0:
            if contact.aside == KEPT_ASIDE and energy < 0.0:
                # What its modes have, and what others may give it yet: it is the same for all that have left.
                energy = energy_felt(state, obj) + given_by_others(state, contact, 0, contact.reach)[0]
            if contact.aside == 1 or not is_beyond(contact, obj, energy, contact.gone_at - now):
                # Advance a striker unseen, from a time in samples on, for no longer than it surely stays apart.
                until = contact.gone_at if contact.aside == KEPT_ASIDE else float(contact.start)
                if not until <= now:
                    fly_unseen(state, contact, until, now - until)
                    samples = min(flight(state, contact, False), until - now)
                    fly_unseen(state, contact, now, samples)
                    if now + samples < until:
                        contact.start = int(now + samples)
                        contact.gone_at = math.inf if contact.aside == KEPT_ASIDE else contact.gone_at
                        contact.aside = 1
        if acts(state, index) and before >= 0 and not acts(state, before):
            take_out(state, obj, before, index)
            append_contact(state, obj, index)
        else:
            before = index
        index = after


@kernel
def release_spent(state: State, contact: Contact, now: float) -> None:
    """Release a striker that rests on the object, has no more energy to give, or has touched it for long."""
    compression = max(contact.coupled.motion[0], 0.0)
    v, m = contact.coupled.v, contact.m
    rests = contact.trait.held == 0 and now - contact.begun > _LONGEST_TOUCH * state.rate
    if contact.trait.falls == 1:
        rests |= captured(compression, v, m, contact.k, contact.a, contact.push)
    elif contact.trait.held == 0:
        left = 0.5 * m * (_SPENT * contact.v_in * contact.v_in - v * v)
        rests |= left > 0.0 and elastic(compression, contact.k, contact.a) < left
    if rests:
        release_striker(state, contact, now)  # gently: nobody hears it go


@kernel
def release_striker(state: State, contact: Contact, time: float) -> None:
    """Take the push off a striker, and forget it a little later."""
    contact.push_target = 0.0
    contact.gone_at = time + _LIFTED * state.rate
