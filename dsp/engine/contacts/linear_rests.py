"""Rests that swing little, solved a quantum at a time as lines about their loads (contact/linear.py): those that are
the only contact of their objects in it."""

from ...contact.block_records import Net
from ...contact.block_sizes import LINEAR
from ...contact.linear import add_answers, begin_tables, end_tables, look_if_calm, moment_of, solve_linear
from ...native.jit import kernel, noinline_kernel
from ..memory.state import BEHIND, QUANTUM, State
from .block_motion import clear_rows, lay_answers, lay_contact


@kernel
def may_be_linear(state: State, net: Net, parts: int, frame: int) -> bool:
    """True if a net is one rest that swung little in the last quantum, that nothing else touches in this one, and that
    one part of a sample follows."""
    whole = frame == 0 and net.stop == QUANTUM
    return parts == 1 and whole and net.size == 1 and state.blocks[net.block[0]].linear.calm == 1


@noinline_kernel
def run_linear(state: State, net: Net) -> bool:
    """Solve a rest over the quantum: its force's moments are in its feed. False, and nothing done, if it swings too
    far."""
    contact, linear = state.contacts[net.contact[0]], state.blocks[net.block[0]].linear
    if linear.settled != contact.settled or linear.load != contact.coupled.rest_force:
        begin_tables(linear, contact.coupled, contact.settled)
        for moment in range(2):
            lay_answers(state, LINEAR, contact, contact, moment, QUANTUM)
            add_answers(linear, contact.coupled, moment, state.scratch.rows)
        end_tables(linear, state.scratch.work)
    place = 0.0
    clear_rows(state, LINEAR)
    for side in range(2):
        if contact.point[side].slot >= 0:
            place += lay_contact(state, contact, side, LINEAR, QUANTUM)
    if not solve_linear(linear, contact.coupled, state.scratch.rows, place, 1.0 / contact.now.gain):
        linear.calm = 0
        return False
    for n in range(QUANTUM):
        feed = state.feeds[net.block[0], BEHIND + n]
        for moment in range(2):
            feed[moment] = moment_of(linear, contact.coupled, moment, n)
            feed[2 + moment] = 0.0
    contact.ahead = net.end = QUANTUM
    state.steps_taken += QUANTUM
    return True


@kernel
def note_calm(state: State, net: Net, frame: int) -> None:
    """Note whether a net that was solved from a frame on is a rest that swung little over the quantum."""
    contact, largest = state.contacts[net.contact[0]], 0.0
    if net.size > 1 or contact.trait.rests == 0:
        return
    linear = state.blocks[net.block[0]].linear
    linear.calm = 0
    if frame == 0 and net.end == QUANTUM:
        for n in range(QUANTUM):
            largest = max(largest, abs(state.feeds[net.block[0], BEHIND + n, 0]))
        look_if_calm(linear, contact.coupled, largest / contact.coupled.period)
