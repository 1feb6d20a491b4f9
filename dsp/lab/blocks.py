"""Coupled contacts by themselves, solved in blocks (contact/block.py) and sample by sample where no block follows."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..contact.block import begin_block, end_block, step_blocks
from ..contact.block_choice import is_eased
from ..contact.block_records import TERMS, Block, Net
from ..contact.block_tables import feel, settle_tables, take_answers, take_rows
from ..contact.coupled import ContactLaw, begin_coupled, respond_with
from ..contact.coupled_records import COUPLED_GROUP, Coupled
from ..engine.contacts.block_motion import lay_motion
from ..native.jit import kernel
from ..native.typed import View, dtype_of
from ..numerics.legendre import AHEAD, KEPT
from ..resonator.bank import Modes, Point, inject_fine, inject_kept, observe, receptance
from ..resonator.rows import Work
from ..resonator.sizes import ROOM_FOR_FACTORS, ROOM_FOR_ROWS
from .coupled import MEMBER, NOT_KEPT, Bank, Case, Run, bank_of, keep_sample, restart, ring_on, step_alone

Room = tuple[View[float], View[float], View[float]]
"""Room to lay rows out, the rows, and factors of modes in them."""

_TOLERANCE = 1e-3  # of samples that no block follows


@kernel
def lay(modes: Modes, point: Point, room: Room, terms: int) -> float:
    """Lay out the free motion of a point over AHEAD samples, one row after the other, as many as forces have terms;
    return where it is now (m)."""
    flat = room[1]
    for i in range(len(flat)):
        flat[i] = 0.0
    return lay_motion(AHEAD, modes, point, Work(room[0], room[2], False), flat, terms)


@kernel
def find_tables(block: Block, contact: Coupled, bank: Bank, room: Room, terms: int) -> None:
    """Find what the force of one contact, of so many terms, does to its own point."""
    modes, work, moments = bank.modes, bank.work, bank.moments
    settle_tables(block.tables[0], contact.answer, is_eased(contact))
    n = len(modes.y1)
    struck = Modes(work[:n], work[n : 2 * n], modes.a1, modes.a2, modes.balance, modes.response)
    for j in range(terms):
        for i in range(2 * n):
            work[i] = 0.0
        for k in range(KEPT):
            moments[k] = 1.0 if k == j else 0.0
        inject_kept(struck, bank.point, moments)
        ring_on(struck)
        lay(struck, bank.point, room, terms)
        take_answers(block.tables[0], j, room[1], AHEAD, 0, terms)


@kernel
def begin_alone(block: Block, contact: Coupled, bank: Bank, room: Room, terms: int) -> None:
    """Begin a block of one contact, whose force has so many terms, with the modes as they are."""
    place = lay(bank.modes, bank.point, room, terms)
    take_rows(block, room[1], 1.0, AHEAD, terms)
    begin_block(block, contact, place, terms)


@njit(error_model="numpy")
def _simulate(solved, bank, room, case, samples, times, out):
    contacts, group, blocks, net = solved
    modes, point = bank.modes, bank.point
    contact, block = contacts[0].coupled, blocks[0]
    v, m, k, mu, a, push, rate = case
    for _ in range(times):
        restart(bank)
        begin_coupled(contact, v, ContactLaw(m, k, mu, a), push, 0.0, rate, _TOLERANCE)
        contact.wait = -1.0
        receptance(modes, point, bank.work, bank.seen)
        respond_with(contact, bank.seen)
        block.gained = block.scale = 0.0
        find_tables(block, contact, bank, room, TERMS)
        within, first = False, 0
        for t in range(samples):
            if not within or t - first == AHEAD:
                begin_alone(block, contact, bank, room, TERMS)
                within, first = True, t
            within = step_blocks(contacts, blocks, net, 1, t - first)
            if within:
                feel(blocks, net, 1, t - first)
                for j in range(KEPT):
                    bank.moments[j] = block.moments[j]
                inject_kept(modes, point, bank.moments)
            else:
                end_block(block, contact)
                observe(modes, point, bank.work, bank.seen)
                step_alone(contacts, group, bank.seen, bank.moments)
                inject_fine(modes, point, bank.moments)
            ring_on(modes)
            if t < len(out):
                keep_sample(out[t], bank, contact)


def _simulation(case: Case) -> tuple[NDArray[np.void], Callable[..., None]]:
    contacts, group = np.zeros(1, MEMBER), np.zeros(1, COUPLED_GROUP)[0]
    blocks, net = np.zeros(1, dtype_of(Block)), np.zeros(1, dtype_of(Net))[0]
    net["size"], net["gain"], net["share"], net["stop"] = 1, 1.0, 1.0, AHEAD
    room = np.zeros(ROOM_FOR_ROWS), np.zeros(AHEAD * TERMS), np.zeros(ROOM_FOR_FACTORS)
    law = tuple(map(float, (case.v_in, case.m, case.k, case.mu, case.a, case.push, case.rate)))
    return contacts, partial(_simulate, (contacts, group, blocks, net), bank_of(case), room, law)


def simulate_blocks(case: Case) -> Run:
    """Simulate a case that begins on a sample in blocks.

    Return a Run: velocities (m/s), compression (m), energy (J) and contacts begun, float64 (samples,) each.
    """
    contacts, simulation = _simulation(case)
    out = np.empty((case.samples, 5))
    simulation(case.samples, 1, out)
    contact = contacts[0]["coupled"]
    return Run.of(out, int(contact["steps"]), int(contact["held"]))


def blocks_loop(case: Case, samples: int) -> Callable[[int], None]:
    """Return a function that simulates so many samples of a case the given number of times and keeps none, for
    `cost_of`."""
    simulation = _simulation(case)[1]
    return lambda times: simulation(samples, times, NOT_KEPT)
