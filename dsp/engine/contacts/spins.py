"""A disc that spins down on an object: Euler's disc, whose rim has a flat.

A thin disc of radius R that leans by an angle alpha and rolls on its rim about a centre at rest turns its point of
contact at Omega = 2 sqrt(g/(R sin alpha)); its energy is 3/2 m g R sin alpha. Its losses make it lean ever less, until
it lies still after a finite time. With t left, sin alpha goes as t^(2n), and so the turns per second as t^-n: n = 1/3
where a constant moment of rolling friction brakes it (its power goes as Omega), n = 1/2 where its power is constant. A
film of air alone (Moffatt, Nature 404, 2000) would make it n = 1/6.

The disc turns about its diameter through the point of contact, at Omega sin alpha. Rolling over a flat of the length
d R it turns about the flat's one end, until the other one hits at v = d R Omega sin alpha = 2 d sqrt(g R sin alpha),
which falls as t^n. The rim of a free disc meets it with a fifth of the disc's mass.
"""

import math

from ...native.jit import kernel
from ..memory.commands import Event
from ..memory.records import Contact
from ..memory.state import END_RESTED, END_STOPPED, State
from .contact_list import next_random, release_modes, report_end, schedule_contact

_SHORTEST_TURN = 20e-6  # s: beyond, it lies still
_SLOWEST = 1e-12  # m/s
_SCATTER = 0.25  # of a turn by which an irregular contact comes early or late at most


@kernel
def begin_spin(state: State, contact: Contact, event: Event) -> None:
    """Begin a contact as the first of a disc's."""
    spin = event.values
    contact.lasts = spin.duration
    contact.quickening = spin.quickening
    lean = math.sin(math.radians(spin.angle))
    scale = spin.duration**spin.quickening
    contact.tempo = scale / (math.pi * math.sqrt(spin.radius * lean))
    contact.swing = 2.0 * math.sqrt(spin.radius * lean) / scale
    contact.turned = 0.0
    contact.v_in = _speed_of(contact)


@kernel
def turn_on(state: State, contact: Contact, frame: int) -> bool:
    """End a disc's contact. True if there is another one."""
    release_modes(state, contact)
    contact.touching = 0
    # Find the next contact that is not before now (s from the beginning), unless it lies still first.
    now, power = (state.position + frame - contact.origin) / state.rate, 1.0 - contact.quickening
    left, step = contact.lasts - contact.turned, _step(contact, power)
    before = left**power
    turns = -math.floor((max(contact.lasts - now, 0.0) ** power - before) / step)
    after = max(before - max(turns, 1) * step, 0.0)
    then = after ** (1.0 / power)
    contact.turned = contact.lasts - then
    turn = then**contact.quickening * step / power
    if not turn >= _SHORTEST_TURN:
        report_end(state, contact.gesture, END_RESTED)
        return False
    early = contact.target.irregularity * _SCATTER * turn * (2.0 * next_random(contact) - 1.0)
    contact.elapsed = max(contact.turned + early, now)
    contact.v_in = _speed_of(contact)
    schedule_contact(state, contact)
    if contact.start >= contact.until:
        report_end(state, contact.gesture, END_STOPPED)
        return False
    return True


@kernel
def next_turn(contact: Contact) -> float:
    """Return when the turn is over that has begun with a disc's contact, in s from the beginning."""
    power = 1.0 - contact.quickening
    after = max((contact.lasts - contact.turned) ** power - _step(contact, power), 0.0)
    over: float = contact.lasts - after ** (1.0 / power)
    return over


@kernel
def _step(contact: Contact, power: float) -> float:
    """Return what a turn takes off left^(1 - n), of the time (s) that is left."""
    return power / (contact.tempo * math.sqrt(contact.target.gravity))


@kernel
def _speed_of(contact: Contact) -> float:
    """Return the velocity (m/s) at which the flat hits; a contact that is irregular is weaker."""
    left = contact.lasts - contact.turned
    whole: float = contact.target.flat * contact.swing * math.sqrt(contact.target.gravity) * left**contact.quickening
    return max(whole * (1.0 - contact.target.irregularity * next_random(contact)), _SLOWEST)
