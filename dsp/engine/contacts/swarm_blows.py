"""The blows of a swarm, or of pieces that land: laid onto its grids, or contacts of their own where they are heavy.

They are drawn and laid some at a time, so that loops over them become SIMD.
"""

import math

import numpy as np

from ...native.jit import kernel, noinline_kernel
from ...numerics.constants import STANDARD_GRAVITY
from ...numerics.elementary import exp, log
from ...numerics.indices import index_of
from ...schema import DROPS
from ...swarm.blows import STREAM, draw_blows, known_of, mean_mass, pulse_of, yielding
from ...swarm.grid import HALF, LEAST, lay_pulse
from ...swarm.pieces import (
    BOUNCES,
    MIDDLE,
    SLOWEST,
    TILT,
    bend_piece,
    bounce_piece,
    freed_within,
    heard_above,
    landing_of,
    number_of,
    piece_below,
    piece_beside,
    piece_of,
    size_at,
    size_of,
)
from ...swarm.record import BACK, BATCH, CLICKS, OCTAVES, ONE_SIZE, SIZES, SWARMS, Blows, Swarm
from ...swarm.ringing import bent_by, clicks_apart, kept_of, left_by
from ...swarm.times import PLACE, SIZE, take_blows, uniform
from ..memory.commands import NUMBERS
from ..memory.records import Contact
from ..memory.state import CLOSED, QUANTUM, State
from .contact_list import append_contact, schedule_contact, take_contact

_HEAVY = 0.1  # m M of a blow, above which it is a contact of its own
_WIDEST = math.log(LEAST * 2.0**OCTAVES)  # ln of samples: the rms width of a pulse
AT_ONCE = 4.0
"""Contacts of its own that a swarm may have soon after one another."""
_OFTEN = 100.0  # such contacts of a swarm a second
_RISE, _BELOW = 0.2, 2.0  # of ln of the momentum that such a blow must have, at each; so far below the last at least
_AWAITED = 0.005  # s from the beginning of such a blow: one that flies off then touches no more
_SOONEST = 1e-4  # s: from a landing of a piece to its next, as a stream's share has it
_MOST = 16_384  # blows of a swarm in a quantum
_EARLY = BACK + HALF  # samples from a grid's beginning to the quantum's
_IMPACT = NUMBERS["impact"]


@noinline_kernel
def lay_drawn(state: State, contact: Contact, swarm: Swarm, until: float) -> None:
    """Lay a swarm's blows up to a time (s from its beginning) onto its grids."""
    blows, most = state.scratch.batch, swarm.index + _MOST
    while swarm.index < most:
        take_blows(swarm, blows, until)
        if blows.count == 0:
            break
        draw_blows(swarm, state.pulses.tables[swarm.table], blows)
        _lay_blows(state, contact, swarm, blows)


@noinline_kernel
def lay_pieces(state: State, contact: Contact, swarm: Swarm, until: float) -> None:
    """Lay the blows of pieces that land up to a time (s from the beginning); where all lie still, the swarm is over.

    A piece and what it falls on change their momenta by the same. A floor that yields takes less than a wall would, and
    so does a floor under a piece that rings. A corner that still moves downwards after its blow stops there, and its
    further push is not heard. Landings that follow one another soon, of one piece or of all, are a stream: each is
    fainter.
    """
    table, blows = state.pulses.tables[swarm.table], state.scratch.batch
    # How many kilograms a second land: each corner flies for 2 v/g.
    flow = 0.0
    for p in range(swarm.pieces):
        if swarm.next_of[p] < math.inf:
            v, mass, _ = landing_of(swarm, p)
            flow += mass * 0.5 * STANDARD_GRAVITY / max(v, SLOWEST)
    left, often = False, flow / swarm.m
    blows.count = 0
    for p in range(swarm.pieces):
        for _ in range(BOUNCES):
            if not swarm.next_of[p] < until:
                break
            n, number = blows.count, number_of(swarm, p)
            v, mass, flat = landing_of(swarm, p)
            if v < SLOWEST:
                bounce_piece(swarm, p, 0.0)
                continue
            below = piece_below(swarm, p, swarm.next_of[p])
            light = log(mass / (swarm.k if below < 0 else swarm.hard))
            loss, width = pulse_of(swarm, table, light, v)
            given = known_of(table.momentum, loss)
            blows.alike[n], blows.shorter[n], bounces = bend_piece(swarm, p, mass, width, flat, given, below)
            blows.time[n], blows.number[n], blows.v[n], blows.mass[n] = swarm.next_of[p], number, v, mass
            blows.place[n] = int(uniform(swarm, number, PLACE) * swarm.places)
            blows.loss[n], blows.width[n], blows.toward[n], blows.below[n] = loss, width, flat / TILT, below
            blows.heard[n] = 1.0 + bounces
            blows.alike[n] *= given / blows.heard[n]
            ratio, _, _ = _yielded(swarm, blows, n, 0.0)  # the same bits at any rate, whatever falls beside it
            bounce_piece(swarm, p, max(blows.heard[n] * ratio - 1.0, 0.0))
            blows.rate[n] = often + mass / swarm.m / max(swarm.next_of[p] - blows.time[n], _SOONEST)
            blows.count += 1
            if blows.count == BATCH:
                _lay_blows(state, contact, swarm, blows)
                blows.count = 0
        left = left or swarm.next_of[p] < math.inf
    if blows.count > 0:
        _lay_blows(state, contact, swarm, blows)
    if not left and contact.until == math.inf:
        contact.until = contact.gone_at = float(state.position + QUANTUM)


@noinline_kernel
def _lay_blows(state: State, contact: Contact, swarm: Swarm, blows: Blows) -> None:
    """Lay blows onto the grids, or make them contacts of their own."""
    rate, sizes, mass = state.rate / swarm.every, swarm.sized == 1, swarm.together * mean_mass(swarm)
    # How many kilograms a second other swarms bring to a swarm's object.
    total = 0.0
    for k in range(SWARMS):
        other = state.swarms[k]
        if other.used == 1 and other.slot == swarm.slot:
            total += other.flow
    stream = STREAM * mass, STREAM * max(total - swarm.flow, 0.0)
    for n in range(blows.count):
        # Find a blow's momentum, its width (ln of samples) and its middle (in that) by how its place yields; the
        # momentum is 0 where it becomes a contact of its own.
        table, mass, v, loss = state.pulses.tables[swarm.table], blows.mass[n], blows.v[n], blows.loss[n]
        ratio, width, asked = _yielded(swarm, blows, n, stream[0] * blows.rate[n] + stream[1])
        width += swarm.log_rate
        blows.at[n], blows.width[n], blows.ratio[n] = known_of(table.middle, loss), min(width, _WIDEST), ratio
        swarm.energy += 0.5 * mass * v * v
        if asked > _HEAVY and contact.trait.breaks == 0 and _may_be_contact(state, swarm, blows.time[n], log(mass * v)):
            _become_contact(state, contact, blows, n)
            blows.momentum[n] = 0.0
        else:
            state.stats.impacts += 1
            blows.momentum[n] = (
                (blows.heard[n] if swarm.pieces > 0 else known_of(table.momentum, loss)) * ratio * mass * v
            )
            if swarm.law == DROPS:
                blows.momentum[n] *= blows.heard[n]
            if width > _WIDEST:
                # As loud at frequencies above the longer pulse's, and less below: it begins as t^(power - 1).
                power = 1.5 if swarm.law == DROPS else swarm.a + 1.0
                blows.momentum[n] *= exp(power * (_WIDEST - width))
    if sizes and swarm.cracked == swarm.pieces == 0:
        # Find what grains that ring take of their blows: the factor on the momentum, and by how much ln of the width is
        # less. Both are those of rigid ones where they do not ring.
        if swarm.bends == 0:
            for n in range(BATCH):
                blows.alike[n], blows.shorter[n] = 1.0, 0.0
        else:
            table, varied = state.pulses.tables[swarm.table], swarm.finer > ONE_SIZE
            for n in range(BATCH):
                given = known_of(table.momentum, blows.loss[n])
                size = size_of(swarm, blows.mass[n]) if varied else 0.0
                mass_ratio = 1.0 if varied else blows.mass[n] / swarm.m
                kept, blows.shorter[n] = kept_of(swarm, mass_ratio, blows.width[n] - swarm.log_rate - size, given)
                blows.alike[n] = math.sqrt(left_by(given, blows.ratio[n]) * kept)
    origin = (contact.origin - state.position + swarm.lead) / swarm.every + _EARLY
    for n in range(BATCH):
        blows.at[n] = origin + blows.time[n] * rate + blows.at[n] * exp(blows.width[n])
    for n in range(blows.count):
        momentum = blows.momentum[n]
        if momentum == 0.0:
            continue
        at, width, loss, where = blows.at[n], blows.width[n], blows.loss[n], blows.place[n]
        if swarm.places > 0:
            end = lay_pulse(state.pulses, swarm.table, swarm.grid[where], at, width, loss, momentum)
            swarm.busy[where] = max(swarm.busy[where], end)
        if sizes:
            c, alike = _size_of_blow(state, contact, swarm, blows, n, width - swarm.log_rate)
            if clicks_apart(swarm) and state.strikers[contact.sound].clicks > 0:
                # Lay a pulse onto the grid of a grain's or a piece's click: all of its blow moves it, as a whole.
                step, heard, mass = SIZES + c // (SIZES // CLICKS), 1.0, blows.mass[n]
                if swarm.pieces > 0:
                    heard = blows.toward[n] * heard_above(blows.toward[n] * TILT)
                    mass = contact.trait.meets * swarm.mass_of[piece_of(blows.number[n])]
                elif swarm.finer <= ONE_SIZE:
                    mass = swarm.m
                pushes = blows.momentum[n] * heard * swarm.m * math.exp(3.0 * size_at(swarm, step)) / mass
                end = lay_pulse(
                    state.pulses, swarm.table, swarm.size_grid[step], at, blows.width[n], blows.loss[n], pushes
                )
                swarm.size_busy[step] = max(swarm.size_busy[step], end)
            width -= blows.shorter[n]
            _ring(state, swarm, c, at, width, loss, alike * momentum)
            if swarm.pieces > 0 and blows.below[n] >= 0:
                c, alike = _size_of_piece(state, contact, swarm, blows, n, blows.below[n])
                _ring(state, swarm, c, at, width, loss, MIDDLE * alike * momentum)
        swarm.impulse += momentum


@kernel
def _ring(state: State, swarm: Swarm, c: int, at: float, width: float, loss: float, momentum: float) -> None:
    """Lay a pulse onto the grid of a size of grains."""
    end = lay_pulse(state.pulses, swarm.table, swarm.size_grid[c], at, width, loss, momentum)
    swarm.size_busy[c] = max(swarm.size_busy[c], end)


@kernel
def _yielded(swarm: Swarm, blows: Blows, n: int, flow: float) -> tuple[float, float, float]:
    """Return what `yielding` does of a blow, in a stream of a flow (kg/s) as the stream's share has it."""
    if swarm.places == 0:
        return 1.0, blows.width[n], 0.0
    where = blows.place[n]
    ratio, width, asked = yielding(swarm, where, blows.mass[n], blows.width[n])
    return ratio / (1.0 + ratio * flow * swarm.slow[where]), width, asked


@kernel
def _size_of_blow(
    state: State, contact: Contact, swarm: Swarm, blows: Blows, n: int, width: float
) -> tuple[int, float]:
    """Return the size by which a blow sounds, and the factor on its momentum with which a grain of that size moves as
    fast as its own would. width: ln of it (s). A crack moves a piece beside it while it runs round that, with what that
    leaves it. What rings has its share of what the object leaves."""
    mass, ratio, varied = blows.mass[n], blows.ratio[n], swarm.finer > ONE_SIZE
    if swarm.cracked == swarm.pieces == 0:
        if not varied:
            return 0, blows.alike[n]
        at_size = (size_of(swarm, mass) - swarm.smallest) * swarm.finer + uniform(swarm, blows.number[n], SIZE)
        c = index_of(at_size, SIZES)
        return c, blows.alike[n] * swarm.m * math.exp(3.0 * (swarm.smallest + c / swarm.finer)) / mass
    if swarm.pieces > 0:
        c, alike = _size_of_piece(state, contact, swarm, blows, n, piece_of(blows.number[n]))
        return c, blows.toward[n] * alike
    u = uniform(swarm, blows.number[n], SIZE)
    piece = swarm.mass_of[piece_beside(swarm, u)]
    freed = max(width, freed_within(swarm, piece))
    blows.shorter[n] = width - freed
    at_size = (math.log(contact.trait.meets * piece / contact.m) / 3.0 - swarm.smallest) * swarm.finer + 0.5
    # m M of the crack beside the piece, where M is the mobility of that one's modes.
    bent = bent_by(swarm.bend, swarm.bends, swarm.bending * mass / piece, freed + log(swarm.usual / piece))
    alike = _left_to(state, swarm, blows, n) / (1.0 + ratio * bent)
    return index_of(at_size, SIZES), alike


@kernel
def _size_of_piece(state: State, contact: Contact, swarm: Swarm, blows: Blows, n: int, piece: int) -> tuple[int, float]:
    """Return the size by which a piece rings, and the factor on a blow's momentum with which a grain of that size moves
    as fast as the piece does."""
    mass = contact.trait.meets * swarm.mass_of[piece]
    c = index_of((size_of(swarm, mass) - swarm.smallest) * swarm.finer + 0.5, SIZES)
    alike = swarm.m * math.exp(3.0 * (swarm.smallest + c / swarm.finer)) / mass
    return c, _left_to(state, swarm, blows, n) * blows.alike[n] * alike


@kernel
def _left_to(state: State, swarm: Swarm, blows: Blows, n: int) -> float:
    """Return the factor on a blow's momentum that moves what rings, by the energy that the object leaves it."""
    given = known_of(state.pulses.tables[swarm.table].momentum, blows.loss[n])
    return math.sqrt(left_by(given, blows.ratio[n])) if swarm.bends > 0 else 1.0


@kernel
def _may_be_contact(state: State, swarm: Swarm, time: float, momentum: float) -> bool:
    """True if a swarm's heavy blow at a time (s), of ln of a momentum, may be a contact of its own: the strongest are,
    by their times and momenta alone, where there is room. What they must have falls with time, and rises with each."""
    if swarm.law == DROPS:
        return False
    since = (time - swarm.spared) * _OFTEN
    swarm.spare, swarm.bar = min(swarm.spare + 2.0 * since, AT_ONCE), swarm.bar - _RISE * since
    swarm.spared = time
    if momentum < swarm.bar or swarm.spare < 1.0 or state.stats.contacts_active - state.fading >= state.most_contacts:
        return False
    swarm.spare -= 1.0
    swarm.bar = max(swarm.bar, momentum - _BELOW) + _RISE
    return True


@kernel
def _become_contact(state: State, contact: Contact, blows: Blows, n: int) -> None:
    """Make a blow of a swarm an impact of its own."""
    mass, position = blows.mass[n], state.swarms[contact.swarm].position[blows.place[n]]
    swarm = state.swarms[contact.swarm]
    index = take_contact(state)
    state.contacts[index] = contact
    blow = state.contacts[index]
    blow.index, blow.kind, blow.trait = index, _IMPACT, state.traits[_IMPACT]
    blow.gesture, blow.voice, blow.solver, blow.touching = 0, -1, CLOSED, 0
    blow.roll = blow.swarm = -1  # which stay the swarm's
    blow.unsettled = blow.solved = blow.ahead = blow.led = 0
    blow.forces[:] = 0.0
    blow.spot = np.uint64(0)
    blow.gone_at = math.inf
    blow.v_in, blow.m = blows.v[n], mass
    blow.k = swarm.k * math.exp(math.log(mass / swarm.m) / 6.0)
    blow.now.position = blow.target.position = position
    blow.origin = contact.origin + swarm.lead
    blow.elapsed = blows.time[n]
    schedule_contact(state, blow)
    blow.until = blow.start + _AWAITED * state.rate
    append_contact(state, state.objects[contact.point[0].slot], index)
