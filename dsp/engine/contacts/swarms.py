"""Swarms on an object: many small blows, which drive its modes by one force a sample and place, as rolls do.

A swarm's blows are laid onto grids (swarm/grid.py) some LOOK samples before they sound: all of it is heard LEAD s late,
and what steers it acts as late, so that blows are the same at any sampling rate. A blow that is heavy for its place is
a contact of its own, as an impact's.
"""

import math

import numpy as np

from ...native.jit import kernel, noinline_kernel
from ...native.records import clear_record
from ...native.typed import View
from ...numerics.constants import STANDARD_GRAVITY
from ...numerics.elementary import log
from ...numerics.indices import index_of
from ...resonator.sizes import REACH
from ...schema import DROPS, FALLS, MOST_BLOWS, SPEEDS
from ...schema_records import Steered
from ...swarm.blows import NARROWEST, ROLL_OFF, mean_mass
from ...swarm.course import CHANGE, FASTEST, PIECES, course_at, next_bend
from ...swarm.grid import find_force, find_moments, find_samples, frames_of, move_on
from ...swarm.pieces import CRACKING, JUNCTIONS, STRONGEST, break_up, freed_by_cracks, size_at
from ...swarm.record import BANDS, FORCES, GRID, ONE_SIZE, PLACES, SIZES, SOUNDS, WIDTHS, Knot, Swarm
from ...swarm.ringing import bent_by
from ...swarm.times import add_knot, drop_knots, on_lattice, seed_swarm
from ..bodies.objects import frequency_of, is_felt, shape_at
from ..bodies.strikers import roll_striker, sound_grains
from ..bodies.surface import has_moved, keep_spot, put
from ..memory.commands import Event
from ..memory.records import Contact
from ..memory.state import BEHIND, QUANTUM, ROLLING, ROLLS, ROWS_OF_SWARM, Object, State
from .contact_force import update_mode_count
from .contact_list import clear_row
from .swarm_blows import AT_ONCE, lay_drawn, lay_pieces
from .trace import trace_place

LEAD = 1e-3
"""s: from a blow's own time to when it sounds, and from what steers a swarm to when it acts; at low rates it is LOOK
samples of a grid."""
LOOK = 44
"""Samples of a grid after a quantum's end up to which blows are drawn: half the filter and the bump, and some."""

_SAME = 1e-6  # of a position
_LOWEST = 16.0  # Hz: of the bands of modes
_BRIEFEST = 1e-6  # s: of a memory
_NEAR = 1e-9  # of a rate
_BENT = 1e-6  # of a step's highest rate: its bends lie on the lattice of knots
_ACTS = 0.5  # share of blows that act in the quantum after the one in which they are drawn


@noinline_kernel
def begin_swarm(state: State, contact: Contact, event: Event) -> None:
    """Begin a swarm: there is room for one."""
    values = event.values
    index = 0
    while state.swarms[index].used == 1:
        index += 1
    swarm = state.swarms[index]
    clear_record(swarm)
    for row in range(ROLLS + index * ROWS_OF_SWARM, ROLLS + (index + 1) * ROWS_OF_SWARM):
        clear_row(state, row)
    contact.swarm, contact.roll = index, ROLLS + index * ROWS_OF_SWARM
    contact.solver, contact.touching = ROLLING, 1
    state.contact_count += 1
    contact.number = state.contact_count
    swarm.used, swarm.law, swarm.table = 1, contact.trait.swarms, int(values.pulses) - 1
    seed_swarm(swarm, np.uint64(values.seed))
    swarm.memory, swarm.spare, swarm.bar = 1.0, AT_ONCE, -math.inf
    swarm.m, swarm.k, swarm.mu, swarm.a, swarm.w = contact.m, contact.k, contact.mu, contact.a, contact.w
    swarm.places = PLACES if values.spread > 0.0 else 1
    swarm.retuned, swarm.spread, swarm.centre = -1, values.spread, -1.0
    reach = max(values.reach, 1.0)
    swarm.beyond, swarm.together = reach * reach - 1.0, 4.0 / ((reach + 1.0) * (reach + 1.0))
    swarm.every = frames_of(state.rate)
    swarm.lead = max(LEAD * state.rate, (LOOK + 1.0) * swarm.every)
    swarm.log_rate = math.log(state.rate / swarm.every)
    for p in range(PLACES):
        for n in range(GRID):
            swarm.grid[p, n] = 0.0
    if contact.trait.treads == 1:
        swarm.duration = values.duration
        contact.until = contact.gone_at = contact.origin + swarm.duration * state.rate
    swarm.store = math.inf
    # Learn by which modes of its own the usual grain rings.
    swarm.bends, swarm.usual = 0, contact.m / contact.trait.meets
    if contact.sound >= 0 and state.strikers[contact.sound].serial == contact.sound_serial:
        striker = state.strikers[contact.sound]
        swarm.bends, swarm.bending = striker.bends, striker.mobility / max(striker.bends, 1)
        for i in range(striker.bends):
            swarm.bend[i] = striker.bend[i]
        for j in range(WIDTHS):
            swarm.bent[j] = bent_by(swarm.bend, swarm.bends, swarm.bending, (NARROWEST + j) * math.log(2.0))
    varied = values.variety > 0.0
    swarm.sized = int(contact.sound >= 0 and (varied or swarm.bends > 0))
    swarm.smallest = -math.log(2.0) if varied else 0.0
    swarm.finer = (SIZES - 1) / (2.0 * math.log(2.0)) if varied else ONE_SIZE
    for c in range(SOUNDS):
        swarm.voice[c] = -1
        for n in range(GRID):
            swarm.size_grid[c, n] = 0.0
    if contact.trait.breaks == 1:
        # Begin the cracks of what breaks, or the fall of its pieces.
        swarm.friction = values.friction
        swarm.hard = values.own_stiffness if values.own_stiffness > 0.0 else contact.k
        whole, pieces, steepness = values.whole, int(values.pieces), values.steepness
        break_up(swarm, whole, pieces, values.velocity, values.height, swarm.usual, steepness)
        swarm.smallest += math.log(contact.trait.meets) / 3.0
        swarm.sized = int(contact.sound >= 0)
        if values.stage > 0.0:
            swarm.places = swarm.places if values.stage == 1.0 else 0
        else:
            swarm.pieces, swarm.cracked = 0, swarm.pieces
            swarm.store = freed_by_cracks(swarm, whole, values.velocity)
            contact.until = contact.gone_at = contact.origin + CRACKING * state.rate
            contact.target.energy, contact.target.steepness, contact.target.decades = STRONGEST * swarm.store, 1.5, 2.0
            contact.target.rate = 2.0 * JUNCTIONS * values.pieces / CRACKING
    swarm.light = log(swarm.m / swarm.k)
    _add_knot(swarm, contact, 0.0)
    swarm.slot = contact.point[0].slot
    _find_flow(swarm, 0.0)


@kernel
def has_run_out(contact: Contact) -> bool:
    """True if a swarm that lasts for a time of its own has not been stopped before."""
    return contact.trait.treads + contact.trait.breaks > 0 and contact.until >= contact.gone_at


@kernel
def _add_knot(swarm: Swarm, contact: Contact, time: float) -> Knot:
    """Give a swarm's blows from a time (s from its beginning) on the law that is requested; return its knot."""
    asked, knot = contact.target, add_knot(swarm, time)
    knot.rate, knot.slope, knot.scale = _asked_of(swarm, contact, knot.time)
    knot.excitation, knot.memory = asked.excitation, max(asked.memory, _BRIEFEST)
    knot.steepness = _exponent(swarm, asked)
    knot.span, knot.variety = asked.decades * math.log(10.0), math.log1p(asked.variety)
    return knot


@kernel
def _exponent(swarm: Swarm, asked: Steered) -> float:
    """Return the exponent of a swarm's speeds or energies that is requested."""
    return asked.evenness if swarm.law == SPEEDS else asked.steepness


@kernel
def _asked_of(swarm: Swarm, contact: Contact, time: float) -> tuple[float, float, float]:
    """Return the rate (1/s) of a swarm's own blows at a time (s from its beginning), its slope (1/s^2), and their
    scale, as they are requested."""
    asked = contact.target
    if swarm.law == DROPS:
        return asked.rate, 0.0, asked.size
    if swarm.law == SPEEDS:
        return asked.rate * (1.0 - asked.excitation), 0.0, asked.speed
    if swarm.law == FALLS:
        return asked.rate, 0.0, math.sqrt(2.0 * STANDARD_GRAVITY * asked.height)
    if contact.trait.breaks == 1:
        if swarm.pieces > 0 or time >= CRACKING:
            return 0.0, 0.0, 0.0
        return asked.rate * (1.0 - time / CRACKING), -asked.rate / CRACKING, asked.energy
    if swarm.duration > 0.0:
        rate, slope = course_at(swarm, time)
        whole = _whole_of(swarm, asked)
        return whole * rate, whole * slope, asked.energy
    return min(asked.speed * asked.density, MOST_BLOWS) * (1.0 - asked.excitation), 0.0, asked.energy


@kernel
def _whole_of(swarm: Swarm, asked: Steered) -> float:
    """Return how many crackles a whole step has."""
    return min(CHANGE * asked.force * asked.crackles, MOST_BLOWS / FASTEST * swarm.duration)


@kernel
def _follow_course(swarm: Swarm, until: float) -> None:
    """Give a step's blows the pieces of its course that begin before a time (s from its beginning), by the law that
    they have before: what is requested by now may begin later."""
    while swarm.duration > 0.0 and swarm.piece < PIECES and next_bend(swarm) <= until:
        bend, last = next_bend(swarm), swarm.knots[swarm.count - 1]
        _, before = course_at(swarm, bend)
        swarm.piece += 1
        _, after = course_at(swarm, bend)
        knot = add_knot(swarm, bend)
        knot.slope = last.slope * after / before if before != 0.0 else 0.0
        if swarm.piece >= PIECES:
            knot.rate = 0.0
        knot.scale, knot.excitation, knot.memory = last.scale, last.excitation, last.memory
        knot.steepness, knot.span, knot.variety = last.steepness, last.span, last.variety


@kernel
def steer_swarm(state: State, contact: Contact, time: float) -> None:
    """Give a swarm's blows from a time (samples) on the law that is requested now."""
    swarm = state.swarms[contact.swarm]
    if contact.trait.breaks == 1:
        return
    since = max((max(time, float(state.position)) - contact.origin) / state.rate, 0.0)
    _follow_course(swarm, since)
    _add_knot(swarm, contact, since)


@noinline_kernel
def swarm_on(state: State, index: int) -> bool:
    """Compute a swarm's forces for a quantum; true if it has come to its end: then no list holds it, as another may
    take its place within the quantum."""
    contact = state.contacts[index]
    swarm, obj = state.swarms[contact.swarm], state.objects[contact.point[0].slot]
    if state.position > contact.until + swarm.lead + GRID * swarm.every:
        return True
    update_mode_count(state, contact)
    begin = max((state.position - contact.origin) / state.rate, 0.0)
    if contact.trait.breaks == 0:
        # Follow what a ramp asks for at the end of a quantum: the rate goes there by a line, and a step's by its
        # course.
        seconds = QUANTUM / state.rate
        last, asked = swarm.knots[swarm.count - 1], contact.target
        rate, _, scale = _asked_of(swarm, contact, begin)
        there = max(last.rate + last.slope * max(begin - last.time, 0.0), 0.0)
        if swarm.duration == 0.0:
            ramped = abs(rate - there) > _NEAR * rate
        else:
            highest = FASTEST * _whole_of(swarm, asked) / swarm.duration
            ramped = last.time <= begin and abs(rate - there) > _BENT * highest
        others = scale != last.scale or asked.excitation != last.excitation or _exponent(swarm, asked) != last.steepness
        others = others or max(asked.memory, _BRIEFEST) != last.memory or math.log1p(asked.variety) != last.variety
        others = others or (last.slope != 0.0 and swarm.duration == 0.0)
        if ramped or others or asked.decades * math.log(10.0) != last.span:
            knot = _add_knot(swarm, contact, begin)
            if ramped and swarm.duration == 0.0:
                knot.rate, knot.slope = there, (rate - there) / seconds
        _follow_course(swarm, begin + seconds)
    _spread_out(state, swarm, contact, obj)
    until = (state.position + QUANTUM + LOOK * swarm.every - swarm.lead - contact.origin) / state.rate
    if contact.until < math.inf:
        until = min(until, on_lattice((contact.until - contact.origin) / state.rate))
    swarm.impulse, told = 0.0, swarm.energy
    _find_flow(swarm, begin)
    if swarm.pieces > 0:
        lay_pieces(state, contact, swarm, until)
    else:
        lay_drawn(state, contact, swarm, until)
    swarm.coming = _ACTS * swarm.coming + swarm.energy - told
    drop_knots(swarm, until)
    # Make the forces of a quantum from a swarm's grids, at each place and of all of them.
    total = swarm.force[0]
    for j in range(FORCES):
        total[j] = 0.0
    for p in range(swarm.places):
        swarm.sounds[p] = int(swarm.busy[p] > 0)
        if swarm.sounds[p] == 0:
            continue
        force = swarm.force[1 + p]
        find_force(swarm.grid[p], force)
        move_on(swarm.grid[p], QUANTUM // swarm.every)
        swarm.busy[p] -= QUANTUM // swarm.every
        _hand_on(state, swarm, contact.roll + 1 + p, force)
        trace_place(state, contact, swarm.position[p], state.feeds[contact.roll + 1 + p, BEHIND:])
        for j in range(FORCES):
            total[j] += force[j]
    _hand_on(state, swarm, contact.roll, total)
    for n in range(len(contact.forces)):
        contact.forces[n] = state.feeds[contact.roll, BEHIND + QUANTUM - 1 - n, 0] * state.rate
    obj.live = max(obj.live, contact.point[0].modes)
    obj.driven_modes = max(obj.driven_modes, contact.point[0].modes)
    obj.driven_gain = max(obj.driven_gain, contact.now.gain)
    contact.point[0].next_roll = obj.rolls_head
    obj.rolls_head = 2 * index
    if swarm.sized == 1:
        # Drive the voices of a swarm's grains, size by size.
        force = swarm.force[0]
        for c in range(SOUNDS):
            if swarm.size_busy[c] > 0:
                find_force(swarm.size_grid[c], force)
                move_on(swarm.size_grid[c], QUANTUM // swarm.every)
                swarm.size_busy[c] -= QUANTUM // swarm.every
                row = contact.roll + 1 + PLACES + c
                find_moments(force, swarm.every, state.feeds[row, BEHIND:], state.scratch.work)
                sound_grains(state, contact, c, math.exp(size_at(swarm, c)), row)
    else:
        roll_striker(state, contact)
    return False


@kernel
def _find_flow(swarm: Swarm, time: float) -> None:
    """Find how many kilograms a second a swarm's blows bring at a time (s from its beginning), for others on its
    object, as a stream has them."""
    last = swarm.knots[swarm.count - 1]
    rate = max(last.rate + last.slope * max(time - last.time, 0.0), 0.0) + swarm.excited
    swarm.flow = swarm.together * mean_mass(swarm) * rate


@kernel
def _spread_out(state: State, swarm: Swarm, contact: Contact, obj: Object) -> None:
    """Place a swarm about its position, and find how its object yields there, unless that is known."""
    moved = abs(contact.now.position - swarm.centre) > _SAME
    if not moved and not has_moved(contact, swarm.spot) and swarm.retuned == obj.retuned:
        return
    keep_spot(contact, swarm.spot)
    swarm.centre, swarm.retuned = contact.now.position, obj.retuned
    begin = min(max(swarm.centre - 0.5 * swarm.spread, 0.0), 1.0 - swarm.spread)
    for p in range(swarm.places):
        swarm.position[p] = begin + swarm.spread * (p + 0.5) / swarm.places
        put(state, obj, contact, swarm.position[p])
        # Find the mobility of a point for pulses of all widths, by half octaves of the modes, each as its lowest;
        # return the sum of phi^2/omega (s/kg).
        point = contact.point[0]
        mobility = swarm.mobility[p]
        bands, slow = state.scratch.power, 0.0
        for n in range(BANDS):
            bands[n] = 0.0
        for i in range(obj.size):
            if not is_felt(obj, i):
                continue
            frequency = frequency_of(state, obj, i)
            if frequency > 0.0:
                phi = shape_at(state, obj, point, i)
                bands[index_of(2.0 * math.log2(frequency / _LOWEST), BANDS)] += phi * phi
                slow += phi * phi / (2.0 * math.pi * frequency)
        for n in range(WIDTHS):
            width = 2.0 ** (NARROWEST + n)
            mobility[n] = 0.0
            for band in range(BANDS):
                turns = 2.0 * math.pi * _LOWEST * 2.0 ** (0.5 * band) * ROLL_OFF * width if band > 0 else 0.0
                mobility[n] += bands[band] / (1.0 + turns * turns * turns)
        swarm.slow[p] = slow


@kernel
def _hand_on(state: State, swarm: Swarm, row: int, force: View[float]) -> None:
    """Hand a force on to what rings by it: by one number a frame, and by moments."""
    find_samples(force, swarm.every, state.samples[row], REACH - 1)
    find_moments(force, swarm.every, state.feeds[row, BEHIND:], state.scratch.work)
