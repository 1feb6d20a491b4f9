"""Rolls and slides that feel the modes of the object under them.

On an object that yields a roll is coupled to its modes, as a blow is (rolling/coupled_roll.py). Up to -60 it is
solved a quantum at a time where it can be (blocks.py), and so is what has no time for its steps. Where it can't, and
the object hardly yields, for a body that begins under load, where `/budget` has no room, or too few steps for several,
and under a bow the object is a dashpot, which costs as much for any number of modes (rolling/contact_step.py). That is
as loud in each third octave, within 1 dB, on objects that outweigh the body (on lighter ones up to 15 dB off), but its
waveform is off by -15 to -40 dB.
It is one, too, under a slide whose friction comes too late for the swings on its contact; friction or force that is
steered chooses anew, by the greater of the force that is requested and that which it has come to. And it is one beside
as many coupled contacts as a block takes, if steps have a bound: those that are solved together by samples take more
steps than the sum of each, and a force that is held among them gains energy. Without dashpots those would miss them who
play many bodies at once on objects of hundreds of modes: there one costs a third of a block.

All take as much room as those that no blocks follow: one in blocks is taken by samples, too, as soon as a contact that
fits in none touches its object.

The contact swings at omega_c = sqrt(a g/x_e) about x_e, the compression at rest. Modes that are slower yield, those
that are faster hardly move meanwhile. So sum m phi^2/(1 + (omega/omega_c)^2) gives by how much the object is lighter
than rigid. Over a uniform density of modes that is m omega_c/Z, with 1/Z the mean of their mobility.
"""

import math

import numpy as np

from ...contact.accuracy import IN_BLOCKS, LEVELS, STEPS_A_RADIAN
from ...contact.block import renew_block
from ...contact.block_choice import follows, swing_of
from ...contact.block_records import TOGETHER
from ...contact.law import compression_at
from ...native.jit import kernel, noinline_kernel
from ...native.typed import View
from ...resonator.fed import LINE
from ...rolling.body import share_of
from ...rolling.contact_step import BRIEF
from ...rolling.coupled_roll import begin_coupled_roll
from ..bodies.objects import is_felt, shape_at, weigh
from ..bodies.surface import put
from ..memory.quality import BY_ITSELF, holds_steps, room_for_coupling
from ..memory.records import SLID, Contact
from ..memory.state import COUPLING, QUANTUM, State
from .contact_list import share_object
from .solver_choice import price_of, tolerance_of

GIVING = np.array([1e-3, 3e-4, 1e-6, 0.0])
"""Sum, by accuracy, above which a roll feels each of the object's modes even where no block follows it. Where four
modes ring for seconds a dashpot is 6 dB wrong in all at a sum of 0.003, 2 dB at 3e-4."""

_RIGID = 1e-6
"""Sum up to which an object is a wall even where blocks would follow: on a wall a body hops alike at any rate."""

_FINE = LEVELS.index("-80")  # of the accuracies, from which on short steps err no more
_SHARE = 1.0 / 7.0  # of the room for coupled modes, which rolls take at most: they last
_TURNED = 0.25  # rad^2 of a swing on the contact in a sample, times friction: beyond, that comes too late for it
_PLACES = 5  # along the path of a body that moves over its object, at which is looked
_FALLS_SHORT = 1e-6  # share of its way by which a body falls short that has turned
NEVER, LEAVING = -1, 2
"""A slide's answers, whether it may feel the modes: it would not, whatever its friction is; it will from the next
quantum on."""
LEAST = 1e-9
"""Force (N) that presses a slide on at least."""
PASSED = 1e-3
"""Rows of shapes that a body passes in a quantum, within which the object's answer stays."""


@noinline_kernel
def couple_roll(state: State, contact: Contact) -> None:
    """Couple a roll or slide that begins to the objects that it touches, if they yield enough."""
    level, roll = state.choices.accuracy, state.rolls[contact.roll]
    mass, gravity = roll.target.mass, roll.target.gravity
    omega_c = math.sqrt(contact.a * gravity / compression_at(mass * gravity, contact.k, contact.a))
    # Sum phi^2/(1 + (omega/omega_c)^2) over the objects' modes, 1/kg: the mean and the greatest on a roll's way.
    obj = state.objects[contact.point[0].slot]
    mean = greatest = 0.0
    places = _PLACES if contact.travel > 0.0 else 1
    for n in range(places):
        put(state, obj, contact, n / (_PLACES - 1.0) if places > 1 else contact.now.position)
        here = _mobility_here(state, contact, omega_c)
        mean += here / places
        greatest = max(greatest, here)
    put(state, obj, contact, contact.now.position)
    roll.mobility = mean / omega_c
    gives = mass * greatest
    gives_way = gives > GIVING[level]
    roll.brief = BRIEF if level < _FINE or gives_way else 0.0
    lightness = 1.0 + mass * _mobility_here(state, contact, math.inf)
    turn, loss = omega_c * math.sqrt(lightness) / state.rate, roll.mu * gravity * lightness / state.rate
    rolls = contact.trait.slips == 0
    fits = gives > _RIGID and IN_BLOCKS[level] and follows(turn, loss, 1.0 / state.rate)
    feels = (gives_way or fits) and not holds_steps(state)
    if not rolls:
        slide = state.slides[contact.roll]
        slide.turned = turn * turn / _stiffens(contact, mass * gravity)
        slide.feels = int(may_feel(state, contact)) if feels else NEVER
        feels &= slide.feels == 1
    if not feels:
        return
    modes = BY_ITSELF
    for side in range(2):
        if contact.point[side].slot >= 0:
            modes += state.objects[contact.point[side].slot].size
    room, steps = room_for_coupling(state), state.choices.budget.steps
    crowded = room > 0 and state.stats.coupled_modes + modes > _SHARE * room
    if crowded or (steps > 0 and _needed(state, contact, turn, fits) > steps):
        state.stats.over_budget += 1
        return
    roll.mobility = 0.0
    contact.solver = COUPLING
    contact.modes, contact.light, contact.unsettled, contact.debt = modes, 1, 1, 0
    state.stats.coupled += 1
    state.stats.coupled_modes += modes
    fraction = contact.origin - math.floor(contact.origin)
    begin_coupled_roll(roll, contact.coupled, fraction, state.rate, tolerance_of(state, contact))
    renew_block(state.blocks[contact.roll])


@noinline_kernel
def _needed(state: State, contact: Contact, turn: float, fits: bool) -> float:
    """Return the steps in a sample that a contact which swings by `turn` rad in one takes.

    A block takes one for a contact that is alone. Else what no block follows takes them with those coupled already that
    share objects with it, or with another of them: as many as the stiffest, on an object that is as light against all
    of them. From TOGETHER others on they are more than there can be.
    """
    # List the coupled contacts, up to TOGETHER others, that share objects with it, or with another of them.
    found, count, before = state.scratch.candidates, 1, 0
    found[0] = contact.index
    while before < count <= TOGETHER:
        before = count
        for i in range(state.active):
            index = state.objects[state.order[i]].contact
            while index >= 0 and count <= TOGETHER:
                other, beside = state.contacts[index], False
                for j in range(count):
                    beside |= share_object(state.contacts[found[j]], other)
                for j in range(count):
                    beside &= found[j] != index
                if beside and other.solver == COUPLING and other.aside == 0:
                    found[count] = index
                    count += 1
                index = other.next
    if count > TOGETHER:
        return math.inf
    if count == 1:
        return 1.0
    together = 1
    if not fits:
        together = count
        for i in range(1, together):
            turn = max(turn, swing_of(state.contacts[found[i]].coupled))
    per_radian: float = STEPS_A_RADIAN[state.choices.accuracy]
    return price_of(together) * (1.0 + per_radian * turn * math.sqrt(together))


@kernel
def may_feel(state: State, contact: Contact) -> bool:
    """True for a slide whose normal motion is that of the modes: those move under a bow, whose contact stays (sweep 0),
    along the slip. Not where friction has a direction of its own, feels a part of the modes alone, or follows a press,
    which feels them; nor where it comes too late for the swings on the contact, which it would drive."""
    way, asked, slide = contact.direction[0], contact.target, state.slides[contact.roll]
    apart = way[0] != 0.0 or way[1] != 0.0 or way[2] != 0.0
    for side in range(2):
        slot = contact.point[side].slot
        apart |= slot >= 0 and state.objects[slot].size > SLID
    turned = slide.turned * _stiffens(contact, max(asked.force, contact.now.force))
    late = asked.along * max(asked.static, asked.dynamic) * turned > _TURNED
    return asked.sweep != 0.0 and slide.press == 0 and not (apart and asked.along > 0.0) and not late


@kernel
def _stiffens(contact: Contact, force: float) -> float:
    """Return how the square of a contact's swing goes with the force (N) that presses it on."""
    power: float = max(force, LEAST) ** (1.0 - 1.0 / contact.a)
    return power


@kernel
def _mobility_here(state: State, contact: Contact, omega_c: float) -> float:
    """Return that sum at the place of a contact."""
    total = 0.0
    for side in range(2):
        point = contact.point[side]
        if point.slot >= 0:
            obj = state.objects[point.slot]
            for i in range(obj.size):
                omega = 2.0 * math.pi * state.bank.frequency[obj.first + i]
                if is_felt(obj, i) and omega > 0.0:
                    phi = shape_at(state, obj, point, i)
                    total += phi * phi / (1.0 + (omega / omega_c) ** 2)
    return total


@kernel
def share_driven(state: State, contact: Contact) -> float:
    """Return the share of a contact's force that drives its objects: what is left of a roll that has stopped."""
    return share_of(state.rolls[contact.roll]) if contact.trait.along == 1 else 1.0


@kernel
def passed_by(state: State, contact: Contact) -> float:
    """Return how many rows of shapes what rolls or slides passes in a quantum."""
    rows = state.objects[contact.point[0].slot].rows - 1
    return contact.rolls * rows / contact.travel if contact.travel > 0.0 else 0.0


@kernel
def turns(contact: Contact, frame: int, stop: int) -> bool:
    """True if what rolls or slides turns at an end of its path from a frame to another."""
    way = contact.rolls * ((stop - frame) / QUANTUM) / contact.travel
    return abs(position_of(contact, stop) - position_of(contact, frame)) < (1.0 - _FALLS_SHORT) * way


@kernel
def put_on_line(state: State, contact: Contact, frame: int, drift: View[float]) -> None:
    """Put what rolls or slides where it is at a frame: shapes under what travels go as lines for LINE frames, if it
    does not pass too many rows of them. `drift` gets what its weights change by in a frame."""
    obj, point = state.objects[contact.point[0].slot], contact.point[0]
    begin = frame // LINE * LINE
    keeps = contact.travel > 0.0 and keeps_line(contact, obj.rows, frame)
    put(state, obj, contact, position_of(contact, begin if keeps else frame))
    for i in range(4):
        drift[i] = 0.0
    if keeps and point.on_surface == 0:
        weigh(drift, position_of(contact, begin + LINE) * (obj.rows - 1) - point.row, obj.amplitude)
        for i in range(4):
            drift[i] = (drift[i] - point.weights[i]) / LINE
            point.weights[i] += (frame - begin) * drift[i]


@kernel
def keeps_rows(rows: int, begin: float, end: float) -> bool:
    """True if the cubic through the four rows of shapes about one position is one at the other, too."""
    return abs(end - begin) * (rows - 1) <= 1.0


@kernel
def keeps_line(contact: Contact, rows: int, frame: int) -> bool:
    """True if what rolls or slides keeps its rows of shapes over the LINE frames about one."""
    begin = frame // LINE * LINE
    return keeps_rows(rows, position_of(contact, begin), position_of(contact, begin + LINE))


@kernel
def position_of(contact: Contact, frame: float) -> float:
    """Return the position of a rolling or sliding body on the object's strike path, along which it goes to and fro: of
    one that feels the modes amid the sample that begins at the frame."""
    position = contact.now.position
    if contact.travel > 0.0:
        since = frame + 0.5 if contact.solver == COUPLING else frame
        position += (contact.rolls * (since / QUANTUM) + contact.rolled) / contact.travel
    position -= 2.0 * math.floor(0.5 * position)
    return min(position, 2.0 - position)
