"""The choice of a contact's solver: the cheapest whose error is known to be small enough (contact/accuracy.py).

The closed form of a rigid wall, with an effective mass where the objects yield, if a striker is light or slow
against them and they are quiet; otherwise the contact is coupled to their modes (contact/coupled.py).
"""

import math

from ...contact.accuracy import (
    DEFAULT,
    IN_BLOCKS,
    LIGHT,
    LIGHT_TOLERANCE,
    RESIDUAL,
    STEPS_A_RADIAN,
    TOLERANCE,
    closed_form_will_do,
)
from ...contact.block_choice import swing_of
from ...contact.closed_form import begin_pulse, find_nodes, find_power
from ...contact.coupled_step import HELD
from ...native.jit import kernel
from ...schema import VELOCITY
from ..bodies.objects import is_felt, pitch_of, reach_of, shape_at
from ..memory.quality import holds_steps
from ..memory.records import Contact
from ..memory.state import CLOSED, COUPLING, State

_RESOLVED = 28.0  # rad of a mode over a pulse: up to here its nodes give the spectrum, beyond it is as good as 0
_BURST = 256  # times its steps per sample that a coupled contact may need at once: a blow at `exact` takes 4,000
_BURST_OF_ALL = 1024  # the same of all coupled contacts, in a quantum
_CHEAP = 16  # the square of a group's size at which its equations cost as much as the rest of a step
_FINER_AT_REST = 0.1  # share of the tolerance: a rest feels each step of a slow blow, and errs by all of them
_FINEST = float(LIGHT_TOLERANCE.min())
_MIDDLE = math.sqrt(2.0)  # times m v_in: an impulse that is wrong by 3 dB at most
_YIELDS = 0.7  # effective mass, in that of the striker, below which it is taken; of 0.3 to 0.9 the impulses fit best
_FASTEST = VELOCITY.high
_LIGHT = 1e-4  # sum of m phi^2 below which the object is as good as a rigid wall (-80 dB)


@kernel
def tolerance_of(state: State, contact: Contact) -> float:
    """Return the tolerance of coupled contacts at the accuracy requested, as far as there is time for it."""
    if holds_steps(state):
        return HELD
    tolerance: float = (LIGHT_TOLERANCE if contact.light == 1 else TOLERANCE)[state.choices.accuracy]
    return max(_FINER_AT_REST * tolerance, _FINEST) if contact.trait.rests == 1 else tolerance


@kernel
def choose_tolerance(state: State, contact: Contact) -> None:
    """Give a coupled contact the tolerance for the coming sample: HELD where its force is held, as that of a blow that
    has had its steps is. Without that, those would miss it who play live: a sample would take as long as it liked.

    What rolls or slides, and would take more steps for -80 or more than there are, has the tolerance of -60.
    """
    tolerance, steps, level = tolerance_of(state, contact), state.choices.budget.steps, state.choices.accuracy
    if steps > 0 and (contact.debt > _BURST * steps or state.steps_taken > _BURST_OF_ALL * steps):
        tolerance = HELD
    elif (
        steps > 0
        and not IN_BLOCKS[level]
        and contact.trait.along == 1
        and 1.0 + STEPS_A_RADIAN[level] * swing_of(contact.coupled) > steps
    ):
        tolerance = max(tolerance, LIGHT_TOLERANCE[DEFAULT])
    contact.coupled.tolerance = tolerance


@kernel
def price_of(size: int) -> int:
    """Return the price of a step of a group of a size for each of its contacts, against those of one that is alone."""
    return 1 + size * size // _CHEAP


@kernel
def count_steps(state: State, contact: Contact, sign: int, price: int) -> None:
    """Bring the stats and the debt of steps up to date: with -1 before a coupled contact steps, with 1 after.

    price: of its steps, against those of a contact that is alone.
    """
    coupled, stats = contact.coupled, state.stats
    stats.held += sign * coupled.held
    if contact.trait.along == 0:
        stats.recontacts += sign * max(coupled.contacts - 1, 0)
    contact.debt += sign * price * coupled.steps
    state.steps_taken += sign * price * coupled.steps
    if sign > 0:
        steps = state.choices.budget.steps
        contact.debt = max(contact.debt - steps, 0) if steps > 0 else 0


@kernel
def choose_solver(state: State, contact: Contact, has_room: bool) -> tuple[int, float, float]:
    """Return the solver for a contact, with its sums of r_i and of r_i P_i; begin its wall pulse, unless nothing asks
    for that.

    r_i = m phi_i^2, and P_i is the wall pulse's power spectrum at mode i over that at 0. The second sum is -1 where it
    was not needed. Where there is no room to couple it, the closed form has to do on objects that outweigh the striker.
    """
    mass_ratio, ringing_ratio = _ratios(state, contact)
    contact.light = int(mass_ratio >= LIGHT)
    couples = has_room or contact.light == 1
    level = 0 if holds_steps(state) else state.choices.accuracy
    residual: float = RESIDUAL[level]
    rings = ringing_ratio >= residual
    goes_by_it = contact.sound >= 0 or contact.trait.single == 0  # strikers that sound, and bounces
    if goes_by_it or not (rings and couples):
        begin_pulse(contact.pulse, contact.v_in, contact.m, contact.k, contact.mu, contact.a, state.rate)
    if rings and couples:
        return COUPLING, mass_ratio, -1.0
    if mass_ratio < _LIGHT and mass_ratio + ringing_ratio < residual:
        return CLOSED, mass_ratio, -1.0
    find_nodes(contact.pulse)
    seen = _seen_mass_ratio(state, contact)
    if not rings and closed_form_will_do(level, seen, mass_ratio, ringing_ratio, contact.pulse.restitution):
        return CLOSED, mass_ratio, seen
    if couples:
        return COUPLING, mass_ratio, seen
    state.stats.over_budget += 1
    return CLOSED, mass_ratio, seen


@kernel
def find_speed(state: State, contact: Contact) -> None:
    """Give the striker of a blow of an impulse J that meets objects which yield the speed J/(m y).

    y is 1 + E on a rigid wall, with its restitution E, where the speed that the contact has is exact. On anything it is
    1 to 2, as the striker comes to rest at least, and loses its speed twice at most; where modes take much of it, y is
    in the middle of that, as neither its rebounds nor what lies behind it follow from a formula.
    """
    mass_ratio = _ratios(state, contact)[0]
    if mass_ratio < _LIGHT:
        return
    mu = contact.w / contact.v_in if contact.w > 0.0 else contact.mu
    begin_pulse(contact.pulse, contact.v_in, contact.m, contact.k, mu, contact.a, state.rate)
    find_nodes(contact.pulse)
    on_wall = 1.0 + contact.pulse.restitution
    kept = max(1.0 / (1.0 + _seen_mass_ratio(state, contact)) - _YIELDS, 0.0) / (1.0 - _YIELDS)
    contact.v_in = min(contact.impulse / (contact.m * (_MIDDLE + (on_wall - _MIDDLE) * kept)), _FASTEST)


@kernel
def _ratios(state: State, contact: Contact) -> tuple[float, float]:
    """Return sum r_i over the objects' modes, and how fast their ringing can be against the striker."""
    mass_ratio = ringing_ratio = 0.0
    for side in range(2):
        point = contact.point[side]
        if point.slot >= 0:
            obj = state.objects[point.slot]
            point.give = point.compliance = 0.0
            for i in range(obj.size):
                omega = 2.0 * math.pi * state.bank.frequency[obj.first + i]
                if is_felt(obj, i) and omega > 0.0:
                    phi = shape_at(state, obj, point, i)
                    point.give += phi * phi
                    point.compliance += phi * phi / (omega * omega)
            mass_ratio += contact.m * point.give
            if obj.live > 0:
                ringing_ratio += reach_of(state, obj, point)[1] / (contact.v_in * contact.now.gain)
    return mass_ratio, ringing_ratio


@kernel
def moved_by(contact: Contact, other: Contact) -> float:
    """Return the speed that another contact may give a contact's points, against its own: sum |phi_i phi'_i| 2 J'/v_in.

    The sum is at most sqrt(sum phi_i^2 sum phi'_i^2), which is taken: it costs the same however many modes there are.
    """
    total = 0.0
    for side in range(2):
        for other_side in range(2):
            point, struck = contact.point[side], other.point[other_side]
            if point.slot >= 0 and point.slot == struck.slot:
                total += math.sqrt(point.give * struck.give)
    return total * 2.0 * other.m * other.v_in * other.now.gain / (contact.v_in * contact.now.gain)


@kernel
def is_moved(state: State, contact: Contact) -> bool:
    """True if the others that touch a contact's objects may move it by more than the accuracy requested."""
    residual: float = RESIDUAL[0 if holds_steps(state) else state.choices.accuracy]
    moved = 0.0
    for side in range(2):
        if contact.point[side].slot >= 0:
            index = state.objects[contact.point[side].slot].contact
            while index >= 0:
                other = state.contacts[index]
                blow = other.trait.along == 0 and other.trait.swarms == 0
                if index != contact.index and other.touching == 1 and blow:
                    moved += moved_by(contact, other)
                index = other.next
    return moved > residual


@kernel
def soften_pulse(state: State, contact: Contact, mass_ratio: float, seen_mass_ratio: float) -> None:
    """Give a wall pulse the effective mass of striker and object, by the sums of `choose_solver`.

    That is m* = m/(1 + sum r_i P_i). The same v_in leaves w, and so the pulse's form, as it is: its time scales by
    (m*/m)^(1/(a+1)) and its momentum by m*/m. A shorter pulse reaches higher modes: where it would give them more than
    the striker loses, its momentum J is held to 2 m v_in/(1 + sum r_i P'_i), with P' of the shorter pulse; there
    m v_in^2/2 = m (v_in - J/m)^2/2 + sum (phi_i J)^2 P'_i/2.
    """
    if seen_mass_ratio < 0.0:
        return
    pulse = contact.pulse
    ratio = 1.0 / (1.0 + seen_mass_ratio)
    # Scale a pulse's times.
    shorter = ratio ** (1.0 / (pulse.exponent + 1.0))
    pulse.duration *= shorter
    for i in range(len(pulse.node_time)):
        pulse.node_time[i] *= shorter
    for phase in range(2):
        pulse.phase_time[phase] *= shorter
        for i in range(len(pulse.time_series[phase])):
            pulse.time_series[phase, i] *= shorter
    if (1.0 + pulse.restitution) * (1.0 + mass_ratio) > 2.0 * (1.0 + seen_mass_ratio):
        ratio = min(ratio, 2.0 / ((1.0 + pulse.restitution) * (1.0 + _seen_mass_ratio(state, contact))))
    pulse.momentum *= ratio


@kernel
def _seen_mass_ratio(state: State, contact: Contact) -> float:
    """Return sum r_i P_i over the objects' modes, with P by the pulse's nodes, which `find_nodes` has set."""
    share, pulse = 0.0, contact.pulse
    for side in range(2):
        point = contact.point[side]
        for part in range(2 if point.slot >= 0 else 0):
            obj = state.objects[point.slot]
            begin, end = (0, obj.felt) if part == 0 else (obj.unheard, obj.size)
            if begin == end:
                continue
            frequency = state.bank.frequency[obj.first + begin : obj.first + end]
            power, pitch = state.scratch.power[begin:end], pitch_of(obj)
            find_power(pulse, pitch / state.rate, frequency, power)
            highest = _RESOLVED * state.rate / (2.0 * math.pi * pulse.duration * pitch)
            seen = 0.0
            for i in range(end - begin):
                if frequency[i] < highest:
                    phi = shape_at(state, obj, point, begin + i)
                    seen += contact.m * phi * phi * power[i]
            share += seen
    return share
