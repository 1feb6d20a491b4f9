"""Soft contacts that last, each alone with its object, solved a quantum at a time in lanes (contact/lanes.py).

They come to the same bits whatever else lasts.
"""

from ...contact.block_records import LANES, SOFT_TERMS, TILE
from ...contact.block_tables import feel_tile
from ...contact.lanes import enter_lane, lay_line, leave_lane, step_lane, step_lanes, take_by_itself
from ...native.jit import kernel, noinline_kernel
from ...rolling.block_path import roll_evenly
from ..memory.state import BEHIND, COUPLING, QUANTUM, Object, State
from .blocks import begin_net, run_alone
from .coupled_rolls import share_driven
from .slides import rubs


@noinline_kernel
def solve_in_lanes(state: State) -> None:
    """Solve the rolls and rests of objects that share no contacts over the quantum."""
    lanes, net, count = state.scratch.lanes, state.scratch.net, 0
    for n in range(state.active):
        slot = state.order[n]
        if not _fits_a_lane(state, state.objects[slot]) or not begin_net(state, slot, 0, True):
            continue
        state.objects[slot].resumes = 0
        if net.terms != SOFT_TERMS:
            run_alone(state, 0, net.stop)
            state.objects[slot].in_lanes = net.end
            continue
        lanes.slot[count], lanes.contact[count], lanes.block[count] = slot, net.contact[0], net.block[0]
        count += 1
        if count == LANES:
            _run(state, count)
            count = 0
    if count > 0:
        _run(state, count)


@kernel
def _fits_a_lane(state: State, obj: Object) -> bool:
    """True if an object's one contact is a roll, a slide without friction, or a rest that may be solved so."""
    if obj.spectral > 0 or obj.shares_contact == 1 or obj.contact < 0 or obj.has_contact == 0:
        return False
    contact = state.contacts[obj.contact]
    rubbed = contact.trait.slips == 1 and rubs(contact)
    lasts = (contact.trait.along == 1 and not rubbed) or contact.trait.rests == 1
    return lasts and contact.solver == COUPLING and contact.next < 0 and contact.asleep == 0


@noinline_kernel
def _run(state: State, count: int) -> None:
    """Solve as many contacts as are listed, each as far as a block follows it."""
    lanes = state.scratch.lanes
    for i in range(LANES):
        if i < count:
            enter_lane(lanes, i, state.contacts[lanes.contact[i]].coupled, state.blocks[lanes.block[i]])
        else:
            lanes.idle[i], lanes.ended[i] = 1.0, 0
    for n in range(QUANTUM):
        for i in range(count):
            if lanes.ended[i] < 0:
                # Lay sample n under a lane's contact: what its forces did to it, and its path.
                contact, block = state.contacts[lanes.contact[i]], state.blocks[lanes.block[i]]
                if n > 0 and n % TILE == 0:
                    feel_tile(block, lanes, i, QUANTUM, n)
                if contact.trait.along == 1:
                    roll_evenly(state.rolls[contact.roll], block, contact.coupled.period, QUANTUM - n)
                lay_line(lanes, i, block, n)
        waits = step_lanes(lanes, n % TILE) if count > 1 else step_lane(lanes, n % TILE)
        for i in range(count):
            if lanes.ended[i] < 0:
                if waits > 0 and lanes.taken[i] == 0 and not take_by_itself(lanes, i):
                    _leave(state, i, n)
                else:
                    # Hand on the moments of the share of a lane's force over sample n that drives its object.
                    share = share_driven(state, state.contacts[lanes.contact[i]])
                    feed, felt = state.feeds[lanes.block[i], BEHIND + n], SOFT_TERMS * (n % TILE)
                    for j in range(len(feed)):
                        feed[j] = 0.0
                    for j in range(SOFT_TERMS):
                        feed[j] = lanes.felt[felt + j, i] = share * lanes.moments[j, i]
    for i in range(count):
        if lanes.ended[i] < 0:
            _leave(state, i, QUANTUM)
        state.objects[lanes.slot[i]].in_lanes = lanes.ended[i]


@kernel
def _leave(state: State, i: int, frame: int) -> None:
    """Leave a lane whose contact is solved up to a frame."""
    lanes = state.scratch.lanes
    contact, block = state.contacts[lanes.contact[i]], state.blocks[lanes.block[i]]
    leave_lane(lanes, i, contact.coupled, block, frame)
    lanes.ended[i], lanes.idle[i] = frame, 1.0
