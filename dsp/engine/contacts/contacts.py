"""The life of a contact: a striker waits for its time, touches, and leaves; one that bounces comes back.

A contact acts on one object, or on two that ring: then the striker is the second one's mass, and the opposite force
goes into its modes. flights.py has the strikers that leave and come back.
"""

import math

import numpy as np

from ...contact.closed_form import state_of_pulse
from ...contact.coupled import begin_within
from ...native.jit import kernel, noinline_kernel
from ...native.records import field, set_field
from ...numerics.legendre import KEPT
from ...rolling.body import fill_roll, weigh
from ...schema import BY_POINT, POINT, STEERABLE, gestures_steered_by
from ..bodies.covers import cover
from ..bodies.strikers import roll_striker
from ..bodies.surface import PLACES, THERE, put, put_other
from ..memory.order import wake
from ..memory.quality import BY_ITSELF, coarseness_of, holds_steps, must_wait, room_for_coupling
from ..memory.records import Contact
from ..memory.state import (
    BEHIND,
    CLOSED,
    COUPLING,
    COVERING,
    END_NO_ROOM,
    END_RESTED,
    END_STOPPED,
    LEAD,
    LEFT_OUT,
    QUANTUM,
    ROLLING,
    Object,
    State,
)
from .contact_force import apply_contact_force, begin_contact, couple, observe_points, update_mode_count
from .contact_groups import solve_alone
from .contact_list import (
    KEPT_ASIDE,
    acts,
    append_contact,
    end_contact,
    is_running,
    release_modes,
    report_end,
    schedule_contact,
    take_out,
)
from .coupled_rolls import LEAVING
from .flights import follow_coupled, is_gone, is_pushed, release_striker
from .gesture_kernels import come_back
from .presses import add_static, glide_push
from .rests import bear_load, begin_rest, load_of
from .rolls import feed_of, register_roll
from .room import fade_out, has_room_for
from .slides import choose_again, lead_slide, rub
from .solver_choice import is_moved
from .swarms import has_run_out, swarm_on
from .trace import trace_roll

_FIRST = 0.05  # of a pulse: the first step after it is coupled
_MOST_PER_SAMPLE = 8  # contacts of one bounce that may begin in a sample: at 8 kHz there is time for 7

_GLIDES = np.array([max(each.glide for each in gestures_steered_by(name).values()) for name in STEERABLE])
_NEAR = np.array([THERE if name in PLACES else 0.0 for name in STEERABLE])
_POSITION, _BY_POSITION = STEERABLE.index("position"), STEERABLE.index("by_position")
_POINT, _BY_POINT = STEERABLE.index(POINT[0].name), STEERABLE.index(BY_POINT[0].name)


@noinline_kernel
def update_contacts(state: State, obj: Object) -> None:
    """Bring an object's contacts to a new quantum: parameters glide, rolls go on, stopped gestures end."""
    covers = uncovers = False
    before = -1
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        after = contact.next
        covers |= contact.solver == COVERING
        obj.rubbed |= contact.trait.slips
        if contact.aside != KEPT_ASIDE:
            # Bring what can be steered nearer to its target.
            now, target = contact.now, contact.target
            for i in range(len(_GLIDES)):
                value, goal = field(now, i), field(target, i)
                if not abs(value - goal) > _NEAR[i]:
                    continue
                left = math.exp(-QUANTUM / (_GLIDES[i] * state.rate)) if _GLIDES[i] > 0.0 else 0.0
                set_field(now, i, goal + (value - goal) * left)
                if (i == _POSITION or _POINT <= i < _POINT + 3) and contact.solver == COUPLING:
                    put(state, obj, contact, now.position)
                    contact.unsettled = 1
                elif (i == _BY_POSITION or _BY_POINT <= i < _BY_POINT + 3) and contact.solver == COUPLING:
                    put_other(state, contact)
                    contact.unsettled = 1
            if contact.trait.rolls == 1 or contact.trait.held == 1 or contact.trait.rests == 1:
                # Give a roll, a press or a rest the contact law that it is steered to, for the whole quantum: what its
                # spring stores changes between steps alone.
                coupled = contact.coupled
                mu = now.dissipation if contact.w == 0.0 else contact.mu
                same = contact.k == now.stiffness and contact.mu == mu and contact.a == now.exponent
                if not (same and (contact.m == now.mass or contact.trait.rolls == 1)):
                    contact.k, contact.mu, contact.a = now.stiffness, mu, now.exponent
                    coupled.k, coupled.a = contact.k, contact.a
                    coupled.mu = mu if contact.w == 0.0 else coupled.mu
                    if contact.trait.rolls == 1:
                        roll = state.rolls[contact.roll]
                        # Give a body that rolls another contact law.
                        a = contact.a
                        roll.k, roll.mu, roll.a = contact.k, mu, a
                        roll.energy_share = 1.0 / (a + 1.0)
                        if roll.stiffness > 0.0:
                            weigh(roll)
                        coupled.k, coupled.rest_compression = roll.stiffness, roll.rest_compression
                    elif contact.m != now.mass:
                        contact.m = coupled.m = now.mass
                        contact.unsettled = 1
                    if contact.trait.rests == 1 and contact.solver == COUPLING:
                        bear_load(contact)
        # Tie the objects of a contact together; forget one that is gone; note where modes are retuned.
        other = contact.point[1]
        if other.slot >= 0:
            partner = state.objects[other.slot]
            if partner.used == 0 or partner.serial != other.serial:
                other.slot = -1
                contact.unsettled = 1
            else:
                wake(state, other.slot)
                partner.leaned_on |= int(contact.trait.rests == 1 or contact.solver == COVERING)
                if contact.asleep == 0:
                    obj.shares_contact = partner.shares_contact = 1
                contact.unsettled |= partner.stale_modes > 0 or partner.detuned == 1
        contact.unsettled |= obj.stale_modes > 0 or obj.detuned == 1
        waits = must_wait(state, index) and not (contact.trait.repeats == 1 and contact.touching == 1)
        ended = _wait_longer(state, contact) if waits else _go_on(state, index)
        if ended:
            rested = is_gone(state, contact) or has_run_out(contact)
            gesture, breaks = contact.gesture, contact.trait.breaks
            uncovers |= contact.solver == COVERING
            beside = contact.solver == COVERING and contact.trait.held == 1  # the press that it is part of has its end
            end_contact(state, obj, before, index)
            if not beside and (breaks == 0 or not is_running(state, gesture)):  # thick parts fall beside the others
                report_end(state, gesture, END_RESTED if rested else END_STOPPED)
        else:
            before = index
            if not waits and contact.asleep == 0 and (contact.touching or contact.start < state.position + QUANTUM):
                obj.has_contact = 1
                if contact.point[1].slot >= 0:
                    state.objects[contact.point[1].slot].has_contact = 1
        index = after
    if covers:
        cover(state, obj, uncovers)


@kernel
def _go_on(state: State, index: int) -> bool:
    """Continue a contact in a new quantum; return True if its gesture has been stopped and is over."""
    contact = state.contacts[index]
    if state.heard[index] == LEFT_OUT:
        return not fade_out(state, index)
    if contact.trait.along == 1:
        # Compute a rolling or sliding body's force for a quantum.
        roll = state.rolls[contact.roll]
        if contact.trait.slips == 1:
            choose_again(state, contact)
        changed = update_mode_count(state, contact)
        if contact.trait.slips == 1:
            lead_slide(state, contact, changed)
        if contact.solver == COUPLING:
            # Bring a roll or slide that feels all modes to a new quantum.
            if changed:
                contact.unsettled = 1
            if contact.trait.rolls == 1:
                since = roll.t - (state.position - 1 - contact.origin) / state.rate  # the quantum's beginning
                contact.rolled = roll.s - roll.modulated_speed * since
                contact.rolls = QUANTUM * roll.modulated_speed / state.rate
            contact.m = roll.m
            contact.ahead = 0
            state.stats.impacts += contact.coupled.contacts - 1 - roll.impacts
            roll.impacts = contact.coupled.contacts - 1
            roll_striker(state, contact)
            return roll.ended == 1
        roll.path.coarseness = coarseness_of(state)
        ends = contact.trait.slips == 1 and state.slides[contact.roll].feels == LEAVING
        met = roll.impacts
        # Keep what this quantum has to know of the force before; `new` is the first frame to be fed.
        known, begun = state.feeds[contact.roll], roll.piece >= 0
        new = BEHIND + LEAD if ends or begun else BEHIND
        for n in range(new):
            for k in range(KEPT):
                known[n, k] = known[QUANTUM + n, k] if begun else 0.0
        if not begun:
            state.sampled[contact.roll] = -1
        if ends:
            # End a body's force with the frames that are computed.
            for n in range(new, len(known)):
                for k in range(KEPT):
                    known[n, k] = 0.0
        else:
            # Compute the force up to LEAD frames behind this quantum's end.
            since = (state.position - 1 - contact.origin + new - BEHIND) / state.rate  # s: of that since it began
            fill_roll(roll, since, state.rate, state.feeds[contact.roll, new:])
        # Hand the force on to what it drives.
        feed = feed_of(state, contact)
        if contact.trait.rolls == 1:
            ahead = roll.t - (state.position - 1 + QUANTUM - contact.origin) / state.rate
            contact.rolled += contact.rolls
            contact.rolls = roll.s - roll.modulated_speed * ahead - contact.rolled
        state.stats.impacts += roll.impacts - met
        trace_roll(state, contact, feed, (0, QUANTUM), 1)
        for n in range(len(contact.forces)):
            contact.forces[n] = feed[QUANTUM - 1 - n, 0] * state.rate
        if roll.ended == 0:
            register_roll(state, index)
            roll_striker(state, contact)
        return roll.ended == 1
    if contact.trait.swarms > 0:
        return swarm_on(state, index)
    if contact.solver == COVERING:
        contact.touching, contact.asleep, contact.ahead = int(contact.start < state.position + QUANTUM), 1, QUANTUM
        return contact.until < state.position + QUANTUM or contact.point[1].slot < 0
    if contact.touching == 0:
        return contact.start >= contact.until
    if is_gone(state, contact):
        return True
    if contact.trait.rests == 1:
        other = contact.point[1]
        if contact.until < state.position + QUANTUM or (other.serial > 0 and other.slot < 0):
            return True  # it was stopped, or what it rests on is gone
        state.resting = 1
        if update_mode_count(state, contact):
            contact.unsettled = 1
        if contact.coupled.rest_force != load_of(contact):
            bear_load(contact)
        return False
    contact.ahead = 0
    if contact.aside == KEPT_ASIDE:
        return False
    if contact.trait.held == 1 and update_mode_count(state, contact):
        _lift(state, contact, 0)
    elif contact.solver == COUPLING:
        # Bring the push on a coupled striker nearer to its target.
        if contact.until < state.position + QUANTUM and contact.gone_at == math.inf:
            release_striker(state, contact, contact.until)
            if contact.trait.held == 1:
                contact.push = 0.0  # a hand is taken away at once
        glide_push(state, contact, float(QUANTUM))
        contact.coupled.push = contact.push
        if contact.push != 0.0:
            add_static(state, contact, contact.push)
    return False


@kernel
def _wait_longer(state: State, contact: Contact) -> bool:
    """Halt a gesture's time for a quantum; return True if it is to end."""
    contact.forces[:] = 0.0
    if contact.trait.held == 1 or contact.trait.rests == 1:
        _lift(state, contact, QUANTUM)
        return contact.start >= contact.until
    contact.origin += QUANTUM
    if contact.trait.swarms > 0:
        contact.until += QUANTUM if has_run_out(contact) else 0
        contact.gone_at += QUANTUM
        return contact.until < state.position
    if contact.trait.repeats == 1:
        schedule_contact(state, contact)
        return contact.start >= contact.until
    if contact.solver == COUPLING:
        contact.start = state.position + QUANTUM
    return state.rolls[contact.roll].target.speed == 0.0


@kernel
def _lift(state: State, contact: Contact, frames: int) -> None:
    """Take a pressing striker away, to be laid on again after so many frames."""
    release_modes(state, contact)
    contact.touching = contact.asleep = contact.ahead = 0
    contact.push = contact.push_gap = 0.0
    contact.start = state.position + frames
    contact.fraction = 0.0


@kernel
def _is_due(state: State, contact: Contact, frame: int) -> bool:
    """True if a contact, but for rolls, acts in the sample that ends at a frame."""
    due = state.position + frame - contact.start - contact.fraction > 0.0
    return contact.solver != ROLLING and frame >= contact.ahead and due


@kernel
def _begin(state: State, contact: Contact, frame: int) -> bool:
    """Begin the touch of a contact that is due, unless it touches already; return False if there is no room for it."""
    if contact.touching == 1:
        return True
    contact.begun = float(state.position + frame)
    if begin_rest(state, contact) if contact.trait.rests == 1 else begin_contact(state, contact, is_pushed(contact)):
        if contact.trait.held == 1:
            # Begin to press a striker on where it begins to touch, with no force yet.
            observe_points(state, contact)
            contact.push = 0.0
            glide_push(state, contact, state.position - 1 + QUANTUM - contact.start - contact.fraction)
            add_static(state, contact, contact.push)
        return True
    report_end(state, contact.gesture, END_NO_ROOM)
    return False


@noinline_kernel
def begin_contacts(state: State, obj: Object, frame: int) -> bool:
    """Begin an object's contacts that are due in the sample that ends at a frame; end those without room.

    Where one begins, the others that touch and are of closed form may not stay so. True if one does.
    """
    began = False
    before = -1
    index = obj.contact
    while acts(state, index):
        contact = state.contacts[index]
        after = contact.next
        touched = contact.touching
        if not _is_due(state, contact, frame) or _begin(state, contact, frame):
            before = index
            began |= contact.touching > touched
        else:
            end_contact(state, obj, before, index)
        index = after
    room = room_for_coupling(state)
    if began and not holds_steps(state) and (room == 0 or state.stats.coupled_modes + BY_ITSELF <= room):
        # Couple the contacts of closed form that others on the same objects move, if there is room.
        index = obj.contact
        while index >= 0:
            contact = state.contacts[index]
            if contact.touching == 1 and contact.solver == CLOSED and contact.m > 0.0 and is_moved(state, contact):
                update_mode_count(state, contact)
                if has_room_for(state, contact):
                    x, v, given = state_of_pulse(contact.pulse, contact.v_in, contact.k)
                    contact.solver = COUPLING
                    couple(state, contact)
                    if contact.pulse.time > 0.0:
                        step = _FIRST * contact.pulse.duration
                        begin_within(contact.coupled, x, contact.v_in - given / contact.m, v, step)
                else:
                    state.stats.over_budget += 1
            index = contact.next
    return began


@noinline_kernel
def run_contacts(state: State, obj: Object, frame: int) -> None:
    """Give the modes the force of all contacts, but for rolls, over the sample that ends at a frame.

    Contacts that end are dropped.
    """
    # Friction comes before other contacts: the force of a press that a slide feels is then always the last sample's.
    index = obj.contact if obj.rubbed == 1 else -1
    while index >= 0:
        if state.contacts[index].trait.slips == 1:
            rub(state, state.contacts[index], frame)
        index = state.contacts[index].next
    before = -1
    index = obj.contact
    while acts(state, index):
        contact = state.contacts[index]
        after = contact.next
        stays = True
        for _ in range(_MOST_PER_SAMPLE):
            if not _is_due(state, contact, frame):
                break
            stays = _begin(state, contact, frame)
            if not stays:
                break
            if contact.solver == COUPLING and contact.solved == 0:
                solve_alone(state, contact, frame)
            if apply_contact_force(state, contact, frame):
                leaves = contact.solver == COUPLING and contact.trait.along == 0
                stays = not leaves or follow_coupled(state, contact, frame)
                break
            # A touch of closed form is over: its striker comes back, or not.
            if contact.trait.repeats == 0:
                report_end(state, contact.gesture, END_RESTED)
            stays = contact.trait.repeats == 1 and come_back(contact.kind, state, contact, frame)
            if not stays:
                break
        if not stays:
            end_contact(state, obj, before, index)
        elif acts(state, index):
            before = index
        else:
            take_out(state, obj, before, index)
            append_contact(state, obj, index)
        index = after
    # Take turns among coupled contacts in the same sample, which see each other one after the other: next time
    # another is the first.
    first = obj.contact
    if acts(state, first) and state.contacts[first].solver == COUPLING and acts(state, state.contacts[first].next):
        take_out(state, obj, -1, first)
        append_contact(state, obj, first)
