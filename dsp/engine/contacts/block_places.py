"""The answers of objects to the forces of contacts that are solved in blocks (blocks.py): tables for the places where
those act.

What moves over an object by itself has tables at both ends of a quantum, and in each block a line between them. Where
it moves fast or turns at an end of its path, and where other contacts are in its net, each block has tables of its own.
"""

from ...contact.block_records import Block, Net, Tables, moments_of
from ...contact.block_tables import answer_of, mix_tables, settle_tables, take_answers, take_missed, values_for
from ...native.jit import kernel, noinline_kernel
from ...resonator.fed import LINE
from ..bodies.surface import put
from ..memory.records import Contact
from ..memory.state import QUANTUM, State
from .block_motion import BENT, lay_answers
from .contact_force import find_transfer, observe_points
from .coupled_rolls import passed_by, position_of, turns

_FAR = 0.03  # rows of shapes that a body passes in a quantum, up to which its answer goes as a line within -60 dB
_SAME = 1e-9  # of a path: places that differ by less are one


@kernel
def goes_alone(state: State, net: Net, contact: Contact) -> bool:
    """True if a net is one body that goes one way over its object in the quantum, and not far, but to other answers."""
    near = net.size == 1 and net.moves == 1 and passed_by(state, contact) < _FAR
    return near and not turns(contact, 0, QUANTUM)


@kernel
def amid_block(net: Net, contact: Contact) -> float:
    """Return the position of what moves in the middle of its net's block."""
    return position_of(contact, 0.5 * (net.begin + net.stop))


@noinline_kernel
def settle_between(state: State, net: Net, contact: Contact, block: Block) -> None:
    """Set the tables of a body that goes alone: those amid the block, on a line between the quantum's ends."""
    tables, first, last = block.tables[0], block.tables[1], block.tables[2]
    begin, end, here = position_of(contact, 0), position_of(contact, QUANTUM), amid_block(net, contact)
    count = values_for(block, LINE)
    if last.settled != contact.settled or block.reached != end:
        if last.settled == contact.settled and abs(block.reached - begin) < _SAME:
            mix_tables(first, last, last, 0.0, count)
        else:
            _settle_at(state, contact, block, first, begin)
        _settle_at(state, contact, block, last, end)
        block.settled = first.settled = last.settled = contact.settled
        block.reached = end
    mix_tables(tables, first, last, (here - begin) / (end - begin), count)
    tables.settled = contact.settled
    put(state, state.objects[contact.point[0].slot], contact, here)


@kernel
def _settle_at(state: State, contact: Contact, block: Block, tables: Tables, position: float) -> None:
    """Find the tables of a body's own force at a position."""
    put(state, state.objects[contact.point[0].slot], contact, position)
    contact.unsettled = 1
    observe_points(state, contact)
    settle_with(state, contact, contact, block, tables, LINE)


@kernel
def bends_under(contact: Contact) -> bool:
    """True if objects bend under all of a contact's force: there is no other that is in balance with it."""
    return contact.trait.along == 0 and contact.trait.rests == 0


@noinline_kernel
def settle_with(state: State, contact: Contact, other: Contact, block: Block, tables: Tables, samples: int) -> None:
    """Find what the force of another contact, or its own, does at a contact's points: within a sample and in so many
    after it."""
    own = contact.index == other.index
    if own:
        settle_tables(tables, contact.coupled.answer, block.parts)
    else:
        find_transfer(state, contact, other)
        answer_of(state.scratch.receptance, 1.0 / state.rate, state.scratch.fine)
        settle_tables(tables, state.scratch.fine, block.parts)
    for moment in range(moments_of(block)):
        lay_answers(state, block.parts, contact, other, moment, samples)
        take_answers(block, tables, moment, state.scratch.rows, samples)
    if bends_under(other):
        place = lay_answers(state, block.parts, contact, other, BENT, samples)
        take_missed(block, tables, state.scratch.rows, place, contact.coupled.period**2 / contact.m if own else 0.0)
