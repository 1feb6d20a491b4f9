"""The time for which a striker that has left surely touches nothing: until then nobody needs to look.

Two bounds hold for how far an object's point comes: the sum of its modes' amplitudes, as long as nobody else strikes
it; and sqrt(2 E C), with E the energy that the modes have and may be given, and C = sum phi_i^2/omega_i^2 the
compliance of the point, as sum phi_i q_i <= sqrt(sum omega_i^2 q_i^2 sum phi_i^2/omega_i^2).
"""

import math

from ...contact.coupled_flight import apart_for
from ...contact.law import elastic
from ...native.jit import kernel
from ...resonator.mode import energy_of
from ..bodies.objects import modes_of, reach_of
from ..bodies.sheets import is_coupled
from ..memory.quality import keeps_strikers
from ..memory.records import Contact
from ..memory.state import COUPLING, Object, State
from .contact_list import KEPT_ASIDE
from .solver_choice import moved_by


@kernel
def flight(state: State, contact: Contact, seen: bool) -> float:
    """Return samples for which a coupled striker that has left surely touches nothing; infinity if it never comes back.

    seen: the point was looked at just now.
    """
    distance = farthest = speed = acceleration = faster = 0.0
    for side in range(2):
        point = contact.point[side]
        if point.slot >= 0:
            obj = state.objects[point.slot]
            # Bounds of an object's motion where it is touched: displacement (m), velocity (m/s) and acceleration
            # (m/s^2). Coupled modes take energy from each other: of them only that is known, or may come in this
            # quantum.
            if obj.live == 0:
                far, fast, change = 0.0, 0.0, 0.0
            elif not is_coupled(state, obj):
                far, fast, change = reach_of(state, obj, point)
            else:
                sheet = state.sheets[obj.sheet]
                twice = 2.0 * sheet.c0 / sheet.growth * obj.amplified
                far, fast, change = (
                    math.sqrt(twice * point.compliance) / obj.settings.tune,
                    math.sqrt(twice * point.give),
                    math.inf,
                )
            given, kicked = given_by_others(state, contact, side, far) if keeps_strikers(state) else (0.0, 0.0)
            distance += far / contact.now.gain
            speed += fast / contact.now.gain
            acceleration += change / contact.now.gain
            faster += kicked / contact.now.gain
            # How far the point can move with what others may give it: not known where more than an impact does, as the
            # compliance is that of where the contact began.
            if contact.trait.single == 0:
                most = far if given == 0.0 else math.inf
            else:
                most = math.sqrt(2.0 * (given + energy_felt(state, obj)) * point.compliance) / obj.settings.tune
                most = most if given > 0.0 else min(far, most)
            farthest += most / contact.now.gain
    contact.reach = distance
    if contact.trait.held == 1:
        contact.coupled.push = max(contact.coupled.push, contact.push)  # the greatest up to the quantum's end
    if not seen:
        contact.coupled.motion[0] = contact.coupled.position + distance  # at most
        acceleration = math.inf  # the gap's rate is not known
    return apart_for(contact.coupled, farthest, speed, acceleration, faster)


@kernel
def is_beyond(contact: Contact, obj: Object, energy: float, samples: float) -> bool:
    """True if a striker that has left one object for good is farther away than so much energy (J) moves it, and was so
    many samples ago."""
    coupled, point = contact.coupled, contact.point[0]
    if contact.trait.single == 0 or contact.point[1].slot >= 0 or coupled.push > 0.0 or coupled.v > 0.0:
        return False
    away = (coupled.v * samples * coupled.period - coupled.position) * obj.settings.tune * contact.now.gain
    return away > 0.0 and away * away > 2.0 * energy * point.compliance


@kernel
def energy_felt(state: State, obj: Object) -> float:
    """Return the energy (J) of an object's modes that contacts feel."""
    energy, last = 0.0, obj.first + obj.live
    for part in range(2):
        begin, end = (0, min(obj.live, obj.felt)) if part == 0 else (obj.unheard, obj.live)
        if begin < end:
            weights = state.bank.weight[obj.first + begin : last]
            energy += energy_of(modes_of(state, obj, begin, obj.live), weights, end - begin)
    return energy


@kernel
def given_by_others(state: State, contact: Contact, side: int, far: float) -> tuple[float, float]:
    """Return the energy (J) that others which touch an object may give it yet, which moves so far (m), and how much
    faster they make its points (m/s).

    Blows make them faster by twice their own speed at most: a free surface moves with twice the speed of the wave that
    comes to it. What lasts does by sqrt(2 E sum phi^2) at most.
    """
    energy = speed = 0.0
    slot, give = contact.point[side].slot, contact.point[side].give
    index = state.objects[slot].contact
    while index >= 0:
        other = state.contacts[index]
        # A blow gives its energy, if it touches, or may do so again. One that flies off gives none: an object that
        # catches up with it pushes it on.
        touches, blow = index != contact.index and other.touching == 1, other.trait.lasts == 0
        flies = other.solver == COUPLING and other.trait.single == 1 and other.coupled.touching == 0
        flies = flies and other.coupled.contacts > 0 and other.coupled.v <= 0.0 and other.coupled.push <= 0.0
        if touches and blow and other.aside != KEPT_ASIDE and not flies:
            fast = other.v_in * other.now.gain
            energy += 0.5 * other.m * fast * fast
            speed += min(moved_by(contact, other) * contact.v_in * contact.now.gain, 2.0 * fast)
        elif touches and not blow and other.solver == COUPLING:
            # The energy (J) of a body that leans on an object: that of its motion and of its compression, and the work
            # of what pushes it as it follows the object so far (m).
            coupled = other.coupled
            compression = max(coupled.motion[0], 0.0)
            moving = 0.5 * coupled.m * coupled.v * coupled.v
            stored = (
                (moving + elastic(compression, coupled.k, coupled.a) + max(coupled.push, 0.0) * (compression + far))
                * other.now.gain
                * other.now.gain
            )
            energy += stored
            speed += math.sqrt(2.0 * stored * give)
        index = other.next
    return energy, speed
