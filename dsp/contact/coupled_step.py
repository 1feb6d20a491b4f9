"""A step of a coupled contact (coupled.py) while it lasts: by collocation, or with the force held."""

import math

from ..native.jit import kernel
from ..native.typed import View
from ..numerics.legendre import FINE
from .collocation import discrete_gradient, end_of, step_within
from .coupled_records import Coupled
from .law import elastic, law
from .power_series import MISSED, NODE_RATES, TAKEN, TO_ENDS, WORK, value_at
from .step_record import NODES, Step

HELD = math.inf
"""Tolerance of one held step a sample: the cheapest, for when there is no time."""

TRIALS = 40
FINEST = 2.0**-16  # of the step tried first: where it comes to this, the force is held
_LOSS = 1e-4  # of the contact's energy, times the tolerance, that a step may lose beyond what the law takes
_LEAST_LOSS = 1e-10  # share of that energy that it may lose in any case: rounding comes near it
_LEAST_SWING = 1e-5  # of the compression at which a striker rests: an amplitude that counts as heard in any case
LEAST = 1e-12  # samples: the force is held no shorter, or steps that fail one after the other come to nothing
RETRY = 0.25  # of a step whose equations are not solved
REFINE = 0.5  # of a step whose energy is not right
ROUNDING = 1e-14  # share of the momentum at hand that needs no force


@kernel
def set_powers(contact: Coupled, eta: float) -> None:
    """Scale the motion of a contact to times of a step of `eta` samples."""
    even, odd, square = 1.0, eta, eta * eta
    for n in range(0, FINE, 2):
        contact.power[n], contact.power[n + 1] = even, odd
        even *= square
        odd *= square
    for n in range(FINE):
        contact.moved[n] = contact.motion[n] * contact.power[n]


@kernel
def take_free(contact: Coupled, eta: float) -> None:
    """Set compression and rate at the nodes of a step of `eta` samples as they are without a force."""
    step, free, rate = contact.step, contact.free, 1.0 / (eta * contact.period)
    step.free_x[0], step.free_x[1], step.free_x[2] = free[0], free[1], free[2]
    for i in range(NODES):
        step.free_v[i] = rate * free[NODE_RATES + i]


@kernel
def keep_at_rest(step: Step, give: View[float], impulse: float) -> None:
    """Correct the nodes so that a force that lasts moves none beyond its answer: the Gauss method's integral of the
    answer differs from it, and steps would be refined for that alone.

    impulse: that force (N) times the step (samples).
    """
    if impulse > 0.0:
        for i in range(NODES):
            step.free_x[i] += impulse * give[MISSED + i]


@kernel
def lasting_force(contact: Coupled) -> float:
    """Return the force (N) that is taken to last over a step: that of the striker at rest, or the end of the last
    step's."""
    if contact.rest_force > 0.0:
        return contact.rest_force
    return max(end_of(contact.force), 0.0) if contact.last > 0.0 else 0.0


@kernel
def taken_at_end(give: View[float], f: View[float], eta: float) -> tuple[float, float]:
    """Return how much the nodes' forces take off compression (m) and its derivative (m per step) at the step's end."""
    x, v = give[TO_ENDS:], give[TO_ENDS + NODES :]
    return eta * (x[0] * f[0] + x[1] * f[1] + x[2] * f[2]), eta * (v[0] * f[0] + v[1] * f[1] + v[2] * f[2])


@kernel
def speed_of(contact: Coupled, x: float, v: float) -> float:
    """Return the greatest of two speeds that kinetic and elastic energy amount to: now, and where compression and rate
    are x and v. Of what rests energy is about its rest, of the mass that is felt there."""
    x0, v0 = contact.motion[0], contact.motion[1] / contact.period
    if contact.swing > 0.0:
        square, rest = contact.swing * contact.swing * contact.m / contact.mass, contact.rest_compression
        least = _LEAST_SWING * _LEAST_SWING * square * rest * rest
        now, then = v0 * v0 + square * (x0 - rest) * (x0 - rest), v * v + square * (x - rest) * (x - rest)
        return math.sqrt(max(now, then, least))
    share = 2.0 / contact.mass
    now, then = elastic(x0, contact.k, contact.a), elastic(x, contact.k, contact.a)
    return math.sqrt(max(v0 * v0 + share * now, v * v + share * then))


@kernel
def ratio_to_longest(contact: Coupled, eta: float, x: float, v: float) -> float:
    """Return the factor by which to change the step to meet the tolerance."""
    speed = speed_of(contact, x, v)
    rest = abs(end_of(contact.step.f) - law(x, v, contact.k, contact.mu, contact.a)) * eta * contact.period
    return step_within(rest, contact.tolerance * contact.mass * speed)


@kernel
def work_of(f: View[float], free: View[float]) -> float:
    """Return a step's work (J) of the nodes' forces (N) along a motion, exactly."""
    return free[WORK] * f[0] + free[WORK + 1] * f[1] + free[WORK + 2] * f[2]


@kernel
def work_against(f: View[float], other: View[float], give: View[float], eta: float) -> float:
    """Return the work (J) of the nodes' forces against what another's forces take off in a step of `eta` samples,
    exactly."""
    work = 0.0
    for i in range(NODES):
        t = give[TAKEN + NODES * i :]
        work += f[i] * (t[0] * other[0] + t[1] * other[1] + t[2] * other[2])
    return eta * work


@kernel
def may_lose(contact: Coupled) -> float:
    """Return the energy (J) that a step may lose beyond what the law takes."""
    return max(_LOSS * contact.tolerance, _LEAST_LOSS) * contact.scale


@kernel
def give_of(answer: View[float], eta: float) -> float:
    """Return the distance (m) by which a point yields to 1 N held for a step, by its answer (FINE, m/(N sample)) to
    it."""
    give = 0.0
    power = eta
    for n in range(1, FINE):
        power *= eta
        give += answer[n] * power / (n + 1)
    return give


@kernel
def hold(contact: Coupled, eta: float, taken: float) -> None:
    """Hold the force for a step, which can't gain energy. taken (m): what others take off the compression meanwhile."""
    h = contact.period
    free = value_at(contact.motion, eta)[0] - contact.motion[0] - taken
    give = give_of(contact.answer, eta)
    force = discrete_gradient(contact.motion[0], free, give, eta * h, contact.k, contact.mu, contact.a)[1]
    contact.held += 1
    contact.next = 2.0 * eta
    for j in range(NODES):
        contact.force[j] = contact.step.f[j] = force
