"""Bodies that roll alone on their objects, solved in lanes, a quantum at a time (contact/block_lanes.py).

They come to the same bits as one after the other (blocks.py), whatever else rolls.
"""

from ...contact.block_lanes import (
    EXPONENT,
    enter_lane,
    hand_on,
    lay_lane,
    leave_lane,
    leave_rows,
    resume_lane,
    step_lanes,
    take_forces,
)
from ...contact.block_sizes import LAID
from ...contact.block_tables import feel_delayed
from ...contact.lanes_record import LANES, Lanes
from ...native.jit import kernel, noinline_kernel
from ...rolling.block_path import roll_evenly
from ..memory.state import BEHIND, COUPLING, QUANTUM, Object, State
from .blocks import begin_net, run_alone, step_net

_FEWEST = 3  # contacts that are worth lanes


@noinline_kernel
def solve_in_lanes(state: State) -> None:
    """Solve the rolls of objects that share no contacts over the quantum, if there are enough of them."""
    count = 0
    for i in range(state.active):
        count += _fits_a_lane(state, state.objects[state.order[i]])
    if count < _FEWEST:
        return
    lanes, net, listed = state.scratch.lanes, state.scratch.net, 0
    for i in range(state.active):
        obj = state.objects[state.order[i]]
        if not _fits_a_lane(state, obj) or not begin_net(state, state.order[i], 0):
            continue
        obj.resumes = 0
        contact, block = state.contacts[net.contact[0]], state.blocks[net.block[0]]
        if net.stop < QUANTUM or block.parts > 1 or block.even == 0 or contact.led == 1 or net.lasts == 1:
            run_alone(state, 0, net.stop)
            obj.in_lanes = net.end
            continue
        lanes.slot[listed], lanes.contact[listed], lanes.block[listed] = state.order[i], net.contact[0], net.block[0]
        listed += 1
        if listed == LANES:
            _run(state, listed)
            listed = 0
    _run(state, listed)


@kernel
def _fits_a_lane(state: State, obj: Object) -> bool:
    """True if an object's one contact is a roll that may be solved so."""
    if obj.spectral > 0 or obj.shares_contact == 1 or obj.contact < 0 or obj.has_contact == 0:
        return False
    contact = state.contacts[obj.contact]
    rolls = contact.trait.along == 1 and contact.trait.slips == 0 and contact.solver == COUPLING
    law = contact.coupled.a == EXPONENT and contact.coupled.rest_force > 0.0
    return rolls and law and contact.next < 0 and contact.asleep == 0


@noinline_kernel
def _run(state: State, count: int) -> None:
    """Solve as many contacts as are listed, each as far as blocks follow it."""
    lanes = state.scratch.lanes
    for i in range(count):
        enter_lane(lanes, i, state.contacts[lanes.contact[i]].coupled, state.blocks[lanes.block[i]])
    for i in range(count, LANES):
        lanes.idle[i], lanes.ended[i] = 1.0, 0
    first = 0 if count >= _FEWEST else QUANTUM
    for i in range(count):
        if count < _FEWEST:
            _go_alone(state, i, 0)
    while first < QUANTUM:
        for i in range(count):
            if lanes.ended[i] < 0:
                _lay(state, i, first)
        for s in range(LAID):
            left = step_lanes(lanes, s)
            for i in range(count if left > 0 else 0):
                if lanes.as_most[i] == 0 and lanes.ended[i] < 0:
                    _take_alone(state, i, first, s)
        for i in range(count):
            if lanes.ended[i] < 0:
                _hand_on(state, i, first, LAID)
                state.blocks[lanes.block[i]].at = LAID - 1
        first += LAID
    for i in range(count):
        if lanes.ended[i] < 0:
            leave_lane(lanes, i, state.contacts[lanes.contact[i]].coupled, state.blocks[lanes.block[i]])
            lanes.ended[i] = QUANTUM
        state.objects[lanes.slot[i]].in_lanes = lanes.ended[i]


@kernel
def _bring(state: State, i: int) -> None:
    """Make a lane's contact the net."""
    net, lanes = state.scratch.net, state.scratch.lanes
    net.size, net.begin, net.lasts, net.stop = 1, 0, 0, QUANTUM
    net.contact[0], net.block[0] = lanes.contact[i], lanes.block[i]


@noinline_kernel
def _go_alone(state: State, i: int, frame: int) -> None:
    """Solve a lane's contact by itself from a frame on."""
    lanes = state.scratch.lanes
    _bring(state, i)
    leave_lane(lanes, i, state.contacts[lanes.contact[i]].coupled, state.blocks[lanes.block[i]])
    run_alone(state, frame, QUANTUM)
    _end(lanes, i, state.scratch.net.end)


@kernel
def _end(lanes: Lanes, i: int, frame: int) -> None:
    """End a lane at a frame."""
    lanes.ended[i], lanes.idle[i] = frame, 1.0


@noinline_kernel
def _lay(state: State, i: int, first: int) -> None:
    """Take a lane's path and free motion over a tile from a frame on."""
    lanes = state.scratch.lanes
    contact, block = state.contacts[lanes.contact[i]], state.blocks[lanes.block[i]]
    roll_evenly(state.rolls[contact.roll], block, contact.coupled.period, QUANTUM - first)
    if block.laid < LAID:
        block.at = -1  # as before it was laid
        _go_alone(state, i, first)
        return
    if first > 0:
        feel_delayed(block, block.tables[0], block.recent, first - 1, QUANTUM - first, 1.0)
    lay_lane(lanes, i, block, first)


@noinline_kernel
def _take_alone(state: State, i: int, first: int, s: int) -> None:
    """Take a lane's contact by itself through sample s of a tile; the lane ends there where no block follows that."""
    lanes = state.scratch.lanes
    contact, block = state.contacts[lanes.contact[i]].coupled, state.blocks[lanes.block[i]]
    leave_lane(lanes, i, contact, block)
    leave_rows(lanes, i, block, first + s)
    block.at = s
    _bring(state, i)
    if step_net(state, first + s):
        resume_lane(lanes, i, contact, block)
        take_forces(lanes, i, s, block)
    else:
        _hand_on(state, i, first, s)
        _end(lanes, i, first + s)


@kernel
def _hand_on(state: State, i: int, first: int, samples: int) -> None:
    """Hand on the moments of a lane's forces over so many samples of a tile."""
    block = state.scratch.lanes.block[i]
    hand_on(state.scratch.lanes, i, state.blocks[block], samples, state.feeds[block, BEHIND + first :])
