"""Rolls and slides that feel all modes, rests, presses and long blows, solved a quantum at a time (contact/block.py)
where nothing else acts on the object, or on those that share contacts with it, but rolls and swarms that feel no modes:
what these do over the quantum is known, and contacts beside them see it.

The modes then get the forces as those of rolls that feel none: their moments, frame by frame. Whether it is so is
decided for each quantum anew: while a contact of another kind acts, or too many do, and where a contact is too stiff,
or loses too much, they go on sample by sample (contact_groups.py), but where there is no time for the steps that this
takes: a block's one step a sample is then as loud in each third octave within 1 dB, or 3 dB where a body hops. So does
a sample in which a press leaves; then another block begins. A body that moves over its object feels the modes where it
comes to; what its force does to the samples after it is known for one place in each block.

Friction follows the normal force and the modes sample by sample (slides.py). So a block under it is solved a sample at
a time, just before: later samples of all its contacts feel friction as they feel their own forces.
"""

import math

from ...contact.accuracy import IN_BLOCKS, STEPS_A_RADIAN
from ...contact.block import begin_block, end_block, forget_energy, renew_block, step_blocks
from ...contact.block_choice import LONG, is_followed, is_soft, swing_of
from ...contact.block_records import SOFT_TERMS, TERMS, TOGETHER, Net
from ...contact.block_tables import feel, take_rows
from ...contact.lanes import takes_law
from ...native.jit import kernel, noinline_kernel
from ...numerics.legendre import KEPT
from ...resonator.fed import LINE
from ...rolling.block_path import begin_evenly, project_path, roll_back, roll_evenly
from ...rolling.body import is_even, share_of
from ...rolling.coupled_roll import lead_coupled_roll
from ..bodies.objects import modes_of
from ..bodies.sheets import is_coupled
from ..bodies.strikers import feed_striker, press_striker
from ..bodies.surface import glides
from ..memory.quality import holds_steps
from ..memory.records import Contact
from ..memory.state import BEHIND, COUPLING, QUANTUM, ROLLING, State
from ..output.fade import note_force
from .block_motion import add_driven, clear_rows, lay_contact, lay_moving, whole_lanes
from .block_places import bends_under, put_amid, settle_net
from .contact_force import observe_points
from .contact_list import acts, places_left, take_roll, take_room_again
from .coupled_rolls import PASSED, passed_by, turns
from .flights import release_spent
from .presses import press
from .rolls import bears, feed_of, register_roll
from .slides import rubs
from .solver_choice import price_of
from .trace import trace_press, trace_roll

_FAR = 0.03  # rows of shapes that a body passes in a quantum, up to which its answer goes as a line within -60 dB

_FEWEST = 8  # frames that are worth a block


@noinline_kernel
def solve_blocks(state: State, slot: int, frame: int) -> None:
    """Solve the lasting contacts of an object, and of those that share contacts with it, from a frame to the quantum's
    end, or to where another one touches, if they can be."""
    obj, net = state.objects[slot], state.scratch.net
    if obj.in_lanes >= 0:
        net.begin = 0
        _gather(state, net, slot, 0, True)
        net.end, obj.in_lanes, obj.resumes = obj.in_lanes, -1, QUANTUM
        _conclude(state, net, frame, net.stop)
    elif begin_net(state, slot, frame, False):
        # Solve the contacts of a net from a frame on, as far as can be, or for a sample under friction.
        stop = frame + 1 if net.rubs == 1 else net.stop
        if net.size == 1:
            run_alone(state, frame, stop)
        else:
            net.end = _run(state, net, net.size, frame, stop)
        _conclude(state, net, frame, stop)


@noinline_kernel
def begin_net(state: State, slot: int, frame: int, in_lanes: bool) -> bool:
    """Begin a block of those contacts from a frame on, or go on with it; true if there is one to be solved. in_lanes: a
    soft one is to have three terms."""
    obj, net = state.objects[slot], state.scratch.net
    obj.resumes, net.factored = QUANTUM, 0
    if not (IN_BLOCKS[state.choices.accuracy] or holds_steps(state) or state.choices.budget.steps > 0):
        return False
    goes_on = obj.laid >= 0
    net.begin = obj.laid if goes_on else frame
    if not _gather(state, net, slot, frame, goes_on):
        # Look again soon where a roll, a slide, a rest or a press is on the object: what touches may have left.
        index = obj.contact if frame + 2 * _FEWEST <= QUANTUM else -1
        while index >= 0:
            trait = state.contacts[index].trait
            if trait.along == 1 or trait.rests == 1 or trait.held == 1:
                obj.resumes = frame + _FEWEST
            index = state.contacts[index].next
        return False
    if not goes_on:
        if not _look(state, net):
            return False
        net.terms = TERMS
        if in_lanes and net.size == 1 and net.stop == QUANTUM and net.lasts == net.rubs == net.moves == 0:
            contact = state.contacts[net.contact[0]]
            rests = contact.trait.rests == 1
            even = rests or (contact.led == 0 and is_even(state.rolls[contact.roll]))
            if even and contact.travel == 0.0 and is_soft(contact.coupled, rests) and takes_law(contact.coupled):
                net.terms = SOFT_TERMS
        settle_net(state, net)
        for i in range(net.size):
            # Begin a block of a contact, by how its objects ring.
            contact, block = state.contacts[net.contact[i]], state.blocks[net.block[i]]
            if contact.trait.single == 1 and block.touch != contact.number:
                block.touch = contact.number
                forget_energy(block)
            scale, place = 1.0 / contact.now.gain, 0.0
            clear_rows(state)
            for side in range(2):
                point = contact.point[side]
                if point.slot >= 0:
                    if side == 0 and contact.travel > 0.0 and point.on_surface == 0:
                        modes = modes_of(state, state.objects[point.slot], 0, point.modes)
                        place += scale * lay_moving(state, contact, frame, net.stop, modes)
                    else:
                        place += scale * lay_contact(state, contact, side, whole_lanes(net.stop - frame))
            take_rows(block, state.scratch.rows, scale, whole_lanes(net.stop - frame), net.terms)
            rolls = contact.trait.along == 1
            begin_block(block, contact.coupled, place, net.terms)
            if not is_followed(contact.coupled, contact.trait.rests == 1):
                block.landing = math.inf  # there is no time for steps, however hard it lands
            if rolls:
                begin_evenly(state.rolls[contact.roll], block, contact.coupled.period)
            else:
                project_path(contact.coupled, block)  # which is level
        for i in range(net.objects):
            if state.objects[net.object[i]].rolls_head >= 0:
                add_driven(state, net, net.object[i], frame)
    return True


@noinline_kernel
def _conclude(state: State, net: Net, frame: int, stop: int) -> None:
    """End a block that was to be solved up to a frame, or leave it so that it goes on; hand on its forces from a frame
    on."""
    for i in range(net.size):
        state.contacts[net.contact[i]].ahead = net.end
    if net.end == stop < net.stop:
        for i in range(net.objects):
            obj = state.objects[net.object[i]]
            obj.laid, obj.resumes = net.begin, net.end
    else:
        # End the blocks of a net's contacts, which are solved up to a frame.
        end = net.end
        for i in range(net.size):
            contact = state.contacts[net.contact[i]]
            block = state.blocks[net.block[i]]
            end_block(block, contact.coupled)
            if contact.trait.along == 1:
                contact.led = 1 if end < net.stop else 0
                if end < net.stop and block.laid > 0:
                    roll_back(state.rolls[contact.roll], contact.coupled, block)
                if end < net.stop and contact.travel > 0.0:
                    contact.unsettled = 1  # its force moves on, and leaves it elsewhere
            state.steps_taken += end - net.begin
        # Say when the objects of a net whose block ends at a frame are to be looked at again.
        apart = 0
        for i in range(net.objects):
            apart = max(apart, state.objects[net.object[i]].apart)
        apart = 1 if end > net.begin else min(max(2 * apart, 1), QUANTUM)
        for i in range(net.objects):
            obj = state.objects[net.object[i]]
            obj.apart, obj.laid = apart, -1
            obj.resumes = end + apart if end + apart <= QUANTUM - _FEWEST else QUANTUM
            if net.moves == 1 and end == net.stop:
                obj.resumes = end
    for i in range(net.size):
        # Hand on the force of a contact from a frame on, as far as it is solved: to the record of contacts, to a
        # striker that sounds, and with its gain to the modes.
        contact = state.contacts[net.contact[i]]
        fed = feed_of(state, contact)
        if contact.ahead > frame and state.objects[contact.point[0].slot].ahead == 0:
            for n in range(QUANTUM):
                if not frame <= n < contact.ahead:
                    for k in range(KEPT):
                        fed[n, k] = 0.0
            register_roll(state, contact.index)
            if bends_under(contact):
                press_striker(state, contact)
            feed_striker(state, contact)
        if bends_under(contact):
            trace_press(state, contact, fed, (frame, contact.ahead))
        else:
            trace_roll(state, contact, fed, (frame, contact.ahead), 0)
        for n in range(max(frame, contact.ahead - len(contact.forces)), contact.ahead):
            note_force(contact.forces, fed[n, 0] * state.rate)
        if contact.now.gain != 1.0:
            for n in range(frame, contact.ahead):
                for k in range(KEPT):
                    fed[n, k] *= contact.now.gain
    for i in range(net.objects):
        state.objects[net.object[i]].ahead |= net.end > frame


@noinline_kernel
def run_alone(state: State, frame: int, stop: int) -> None:
    """Solve the contact of a net that has no other from a frame to another: by code of its own, which is faster, and
    gives the same bits."""
    state.scratch.net.end = _run(state, state.scratch.net, 1, frame, stop)


@noinline_kernel
def _step_net(state: State, n: int) -> bool:
    """Take all contacts of the net through sample n of their block; false if it ends before."""
    return step_blocks(state.contacts, state.blocks, state.scratch.net, state.scratch.net.size, n)


@kernel
def _gather(state: State, net: Net, slot: int, frame: int, goes_on: bool) -> bool:
    """List the contacts that act on an object, and on those that share contacts with it, from a frame on; false if one
    can't be solved in blocks, or another one acts soon. goes_on: their block has begun before, so they can.

    Those that began last come first. Their places would not do: who has which depends on what was freed before, and
    sums are rounded in this order.
    """
    net.size = net.lasts = net.moves = net.rubs = net.objects = 0
    net.stop = QUANTUM
    _join(net, slot)
    i = 0
    while i < net.objects:
        obj = state.objects[net.object[i]]
        if is_coupled(state, obj):
            return False
        if obj.shares_contact == 0 and not _list(state, net, net.object[i], obj.contact, frame, goes_on):
            return False
        if obj.shares_contact == 1:
            for g in range(state.scratch.group_size):
                first = state.objects[state.scratch.group[g]].contact
                if not _list(state, net, net.object[i], first, frame, goes_on):
                    return False
        i += 1
    if net.moves == 1:
        net.stop = min(net.stop, (net.begin + _FEWEST + LINE - 1) // LINE * LINE)
    for i in range(net.size):
        net.gain[i] = state.contacts[net.contact[i]].now.gain
    return net.size > 0 and (goes_on or net.stop >= frame + _FEWEST)


@kernel
def _join(net: Net, slot: int) -> None:
    """Put an object into a net, if it is not there."""
    for i in range(net.objects):
        if net.object[i] == slot:
            return
    net.object[net.objects] = slot
    net.objects += 1


@kernel
def _list(state: State, net: Net, slot: int, index: int, frame: int, goes_on: bool) -> bool:
    """Put those of a list's contacts into a net that act on an object at a frame, and their objects; false if one can't
    be. The net's block stops where others begin to act, also those whose strikers fly till then."""
    while acts(state, index):
        contact = state.contacts[index]
        here = contact.point[0].slot == slot or contact.point[1].slot == slot
        waits = contact.start + 1 - state.position
        listed = False
        for i in range(net.size):
            listed |= net.contact[i] == index
        if here and contact.asleep == 0 and waits > frame:
            net.stop = min(net.stop, waits)
        elif here and contact.asleep == 0 and not listed and not _is_driver(state, contact):
            if net.size == TOGETHER or not (goes_on or _can_be(state, contact)):
                return False
            i = net.size
            while i > 0 and state.contacts[net.contact[i - 1]].number < contact.number:
                net.contact[i], net.block[i] = net.contact[i - 1], net.block[i - 1]
                i -= 1
            net.contact[i], net.block[i] = index, contact.roll
            net.size += 1
            net.lasts |= bends_under(contact)
            net.rubs |= contact.trait.slips == 1 and rubs(contact)
            net.moves |= contact.trait.along == 1 and passed_by(state, contact) > PASSED
            for side in range(2):
                if contact.point[side].slot >= 0:
                    _join(net, contact.point[side].slot)
        index = contact.next
    return True


@kernel
def _is_driver(state: State, contact: Contact) -> bool:
    """True if a roll or a swarm feels no modes, so that its force over the quantum is known; friction is not. The modes
    get it by moments, and there has to be room for them (`add_driven`)."""
    known = contact.solver == ROLLING and not (contact.trait.slips == 1 and rubs(contact))
    obj = state.objects[contact.point[0].slot]
    return known and bears(state, obj) and 4 * obj.size <= len(state.scratch.work)


@kernel
def _can_be(state: State, contact: Contact) -> bool:
    """True if a contact is a roll, a slide, a rest, a press or a long blow that may be solved over the quantum."""
    begun = contact.start + contact.fraction <= state.position - 1
    if contact.solver != COUPLING or not begun:
        return False
    if contact.trait.rests == 1:
        return contact.touching == 1 and _take_place(state, contact)
    if contact.trait.held == 1:
        return not glides(contact) and _stays(state, contact) and _take_place(state, contact)
    if contact.trait.along == 0:
        directed = contact.point[0].directed > 0 or contact.point[1].directed > 0
        blow = contact.trait.single == 1 and not directed  # drivers act along the normal alone
        long = blow and _stays(state, contact) and swing_of(contact.coupled) < LONG
        return long and _take_place(state, contact)
    roll = state.rolls[contact.roll]
    return roll.t > 0.0 and roll.m == roll.target.mass


@kernel
def _stays(state: State, contact: Contact) -> bool:
    """True if a striker touches, and is not taken away in the quantum."""
    if contact.touching == 0 or contact.coupled.touching == 0:
        return False
    if contact.gone_at == math.inf:
        release_spent(state, contact, float(state.position))
    return contact.gone_at >= state.position + QUANTUM


@kernel
def _take_place(state: State, contact: Contact) -> bool:
    """Give a rest or a press a roll's place for its block, if one is free; true if it has one."""
    if contact.roll < 0 and places_left(state) > 0:
        contact.roll = take_roll(state)
        state.rests_placed += 1
        renew_block(state.blocks[contact.roll])
    return contact.roll >= 0


@kernel
def _look(state: State, net: Net) -> bool:
    """True if a block follows all contacts, or if there is no time for their steps.

    A body that moves over its object, and has no tables between the quantum's ends, is put where it is amid the block:
    its force is answered as there.
    """
    follows: bool = IN_BLOCKS[state.choices.accuracy]
    near = net.moves == 1 and net.lasts == 0
    for i in range(net.size):
        contact = state.contacts[net.contact[i]]
        if contact.travel > 0.0:
            near = near and passed_by(state, contact) < _FAR and not turns(contact, 0, QUANTUM)
    net.between = 1 if near else 0
    for i in range(net.size):
        contact = state.contacts[net.contact[i]]
        if contact.travel > 0.0 and net.between == 0:
            put_amid(state, net, contact)
            contact.unsettled = 1
        if contact.unsettled == 1:
            observe_points(state, contact)
        take_room_again(state, contact)
        follows &= is_followed(contact.coupled, contact.trait.rests == 1)
    if follows or holds_steps(state) or state.choices.budget.steps == 0:
        return follows or holds_steps(state)
    # Those that are solved together take as many steps as the stiffest, on an object that is as light against all.
    swing = 0.0
    for i in range(net.size):
        swing = max(swing, swing_of(state.contacts[net.contact[i]].coupled))
    each: float = 1.0 + STEPS_A_RADIAN[state.choices.accuracy] * swing * math.sqrt(net.size)
    return price_of(net.size) * each > state.choices.budget.steps


@kernel
def _run(state: State, net: Net, size: int, frame: int, stop: int) -> int:
    """Solve the contacts of a net, of a size, from a frame to another, as far as blocks follow them: their forces'
    moments are in their feeds. Return the frame of the end."""
    for n in range(frame, stop):
        if n > net.begin:
            feel(state.blocks, net, size, n - 1 - net.begin)
        for i in range(size):
            # Lay the path under a contact over the sample that ends at a frame, or press it on, as it is solved
            # up to another frame.
            contact = state.contacts[net.contact[i]]
            block = state.blocks[net.block[i]]
            if contact.trait.held == 1:
                press(contact, n)
            if contact.trait.along == 0:
                net.share[i] = 1.0
            else:
                roll = state.rolls[contact.roll]
                if contact.led == 0 and block.even == 1:
                    roll_evenly(roll, block, contact.coupled.period, stop - n)
                    net.share[i] = share_of(roll)
                else:
                    if contact.led == 0:
                        lead_coupled_roll(roll, contact.coupled, 0.0)
                    contact.led = 0
                    project_path(contact.coupled, block)
                    net.share[i] = share_of(roll)
        if size == 1:
            taken = step_blocks(state.contacts, state.blocks, net, 1, n - net.begin)
        else:
            taken = _step_net(state, n - net.begin)
        if not taken:
            return n
        for i in range(size):
            feed, moments = state.feeds[net.block[i], BEHIND + n], state.blocks[net.block[i]].moments
            for k in range(KEPT):
                feed[k] = moments[k] = net.share[i] * moments[k]
    return stop
