"""The answers of objects to the forces of contacts that are solved in blocks (blocks.py): tables for the places where
those act.

Where bodies move over objects, and not far in a quantum, there are tables for both its ends, and in each block those on
a line between them. Where one moves fast or turns at an end of its path, and beside presses, each block has tables of
its own.
"""

import math

from ...contact.block_choice import is_eased
from ...contact.block_records import AT_BEGIN, AT_END, TERMS, TOGETHER, Net, Tables
from ...contact.block_tables import settle_tables, take_answers
from ...contact.coupled import answer_of
from ...native.jit import kernel, noinline_kernel
from ...numerics.legendre import AHEAD, FINE
from ...numerics.sums import line_of
from ...resonator.fed import LINE
from ..bodies.surface import put
from ..memory.records import Contact
from ..memory.state import QUANTUM, State
from .block_motion import BENT, lay_answers, whole_lanes
from .contact_force import find_transfer, observe_points
from .coupled_rolls import position_of

_SAME = 1e-9  # of a path: places that differ by less are one


@kernel
def put_amid(state: State, net: Net, contact: Contact) -> None:
    """Put what moves where it is in the middle of its net's block."""
    here = position_of(contact, 0.5 * (net.begin + net.stop))
    put(state, state.objects[contact.point[0].slot], contact, here)


@noinline_kernel
def settle_net(state: State, net: Net) -> None:
    """Find the tables of all contacts of a net whose block begins."""
    for i in range(net.size):
        contact, block = state.contacts[net.contact[i]], state.blocks[net.block[i]]
        if block.settled != contact.settled:
            block.settled = contact.settled
            for j in range(TOGETHER):
                block.tables[j].settled = 0
        if net.between == 0:
            block.reached = math.inf
    if net.between == 1 and not _are_known(state, net, QUANTUM):
        # Find the tables of bodies that move at the quantum's ends: at its beginning they may be those of the last end.
        follows = _are_known(state, net, 0)
        for i in range(net.size):
            for j in range(net.size):
                if follows and _moves(state, net, i, j):
                    tables = state.blocks[net.block[i]].tables[j]
                    for n in range(FINE):
                        tables.ends[n] = tables.ends[FINE + n]
                    first = line_of(tables.later)
                    for n in range(first, first + LINE * TERMS * TERMS):
                        tables.later[n + AT_BEGIN] = tables.later[n + AT_END]
        for end in range(1 if follows else 0, 2):
            for i in range(net.size):
                contact, block = state.contacts[net.contact[i]], state.blocks[net.block[i]]
                if contact.travel > 0.0:
                    block.reached = position_of(contact, end * QUANTUM)
                    put(state, state.objects[contact.point[0].slot], contact, block.reached)
                    contact.unsettled = 1
                    observe_points(state, contact)
                    block.settled = contact.settled
            for i in range(net.size):
                for j in range(net.size):
                    if _moves(state, net, i, j):
                        contact, other = state.contacts[net.contact[i]], state.contacts[net.contact[j]]
                        tables = state.blocks[net.block[i]].tables[j]
                        tables.settled, tables.terms = other.settled, net.terms
                        _find_answer(state, contact, other)
                        for n in range(FINE):
                            tables.ends[end * FINE + n] = state.scratch.fine[n]
                        _lay_all(state, contact, other, tables, LINE, AT_END if end == 1 else AT_BEGIN)
    for i in range(net.size if net.between == 1 else 0):
        # Set the tables amid the block, on lines between the quantum's ends.
        contact, block = state.contacts[net.contact[i]], state.blocks[net.block[i]]
        for j in range(net.size):
            if _moves(state, net, i, j):
                share, tables, answer = 0.5 * (net.begin + net.stop) / QUANTUM, block.tables[j], state.scratch.fine
                for n in range(FINE):
                    answer[n] = tables.ends[n] + share * (tables.ends[FINE + n] - tables.ends[n])
                settle_tables(tables, answer, i == j and is_eased(contact.coupled))
                first = line_of(tables.later)
                for n in range(first, first + LINE * TERMS * TERMS):
                    early = tables.later[n + AT_BEGIN]
                    tables.later[n] = early + share * (tables.later[n + AT_END] - early)
        if contact.travel > 0.0:
            put_amid(state, net, contact)
    for i in range(net.size):
        for j in range(net.size):
            tables, settled = state.blocks[net.block[i]].tables[j], state.contacts[net.contact[j]].settled
            if tables.settled != settled or tables.terms != net.terms:
                tables.settled, tables.terms = settled, net.terms
                # What stays where it is keeps its tables.
                samples = whole_lanes(net.stop - net.begin) if _moves(state, net, i, j) else QUANTUM
                contact, other = state.contacts[net.contact[i]], state.contacts[net.contact[j]]
                _find_answer(state, contact, other)
                settle_tables(tables, state.scratch.fine, i == j and is_eased(contact.coupled))
                _lay_all(state, contact, other, tables, samples, 0)
                if bends_under(other):
                    # Find what the tables miss of a force that lasts, where 1 N bends the modes by `place` (m): by the
                    # rows of their motion if they are let go.
                    place = lay_answers(state, contact, other, BENT, samples)
                    rows, own = state.scratch.rows, contact.coupled.period**2 / contact.m if i == j else 0.0
                    tables.missed[0] = rows[(TERMS - 1) * AHEAD] - place + tables.within[0, 0] - 0.5 * own
                    for k in range(1, TERMS):
                        tables.missed[k] = rows[(k - 1) * AHEAD] + tables.within[k, 0] - (0.5 * own if k == 1 else 0.0)


@kernel
def _moves(state: State, net: Net, i: int, j: int) -> bool:
    """True if one of two contacts of a net moves over its object."""
    return state.contacts[net.contact[i]].travel > 0.0 or state.contacts[net.contact[j]].travel > 0.0


@kernel
def _are_known(state: State, net: Net, frame: int) -> bool:
    """True if the tables at an end of a quantum are those of the places at a frame."""
    known = True
    for i in range(net.size):
        contact, block = state.contacts[net.contact[i]], state.blocks[net.block[i]]
        if contact.travel > 0.0:
            known = known and abs(block.reached - position_of(contact, frame)) < _SAME
        for j in range(net.size):
            if _moves(state, net, i, j):
                known = known and block.tables[j].settled == state.contacts[net.contact[j]].settled
                known = known and block.tables[j].terms == net.terms
    return known


@kernel
def _find_answer(state: State, contact: Contact, other: Contact) -> None:
    """Put how a contact's points answer another one's force, or its own, into the scratch `fine`, m/(N sample)."""
    if contact.index == other.index:
        for n in range(FINE):
            state.scratch.fine[n] = contact.coupled.answer[n]
    else:
        find_transfer(state, contact, other)
        answer_of(state.scratch.receptance, 1.0 / state.rate, state.scratch.fine)


@noinline_kernel
def _lay_all(state: State, contact: Contact, other: Contact, tables: Tables, samples: int, begin: int) -> None:
    """Take the answers to all moments of a contact's force over so many samples; begin: as `take_answers` has it."""
    terms = state.scratch.net.terms
    for moment in range(terms):
        lay_answers(state, contact, other, moment, samples)
        take_answers(tables, moment, state.scratch.rows, samples, begin, terms)


@kernel
def bends_under(contact: Contact) -> bool:
    """True if objects bend under all of a contact's force: there is no other that is in balance with it."""
    return contact.trait.along == 0 and contact.trait.rests == 0
