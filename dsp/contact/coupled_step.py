"""A step of a coupled contact (coupled.py) while it lasts: by collocation, or with the force held."""

import math

from ..native.jit import kernel
from ..native.typed import View, View2D
from ..numerics.legendre import FINE
from .collocation import INTEGRAL, discrete_gradient, elastic, end_of, law, solve, step_within
from .coupled_records import Coupled
from .power_series import ANSWER_AT, ANSWER_TO_END, AT_NODES, MISSED, TAKEN, WORK, value_at
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
ROUNDING = 1e-14  # share of the momentum at hand that no force is asked for


@kernel
def collocate(contact: Coupled, eta: float) -> tuple[bool, float, float]:
    """Try a step: whether it is solved, and x and v at its end."""
    step, h = contact.step, contact.period
    set_powers(contact, eta)
    put_free(step, contact.moved, 1.0 / (eta * h))
    _put_give(step, contact.given, eta * h, 1.0 / h)
    keep_at_rest(step, contact.given, eta * lasting_force(contact))
    speed = speed_of(contact, contact.motion[0], contact.motion[1] / h)
    solved = solve(step, contact.k, contact.mu, contact.a, ROUNDING * contact.mass * speed / (eta * h))
    x, v = end_without(contact.moved)
    taken_x, taken_v = taken_at_end(contact.given, step.f, eta)
    return solved, x - taken_x, (v - taken_v) / (eta * h)


@kernel
def set_powers(contact: Coupled, eta: float) -> None:
    """Scale the series of a contact to times of a step of `eta` samples."""
    power = 1.0
    for n in range(FINE):
        contact.power[n] = power
        contact.moved[n] = contact.motion[n] * power
        contact.given[n] = contact.answer[n] * power
        power *= eta


@kernel
def put_free(step: Step, moved: View[float], rate: float) -> None:
    """Set compression and rate at the nodes as they are without a force; rate: steps per s."""
    s = _sums_of_six(AT_NODES, moved)
    step.free_x[0], step.free_x[1], step.free_x[2] = s[0], s[1], s[2]
    step.free_v[0], step.free_v[1], step.free_v[2] = rate * s[3], rate * s[4], rate * s[5]


@kernel
def _sums_of_six(table: View2D[float], series: View[float]) -> tuple[float, float, float, float, float, float]:
    """Return sum_n series[n] table[n, k] for each k < 6: six sums that do not wait for each other."""
    s0 = s1 = s2 = s3 = s4 = s5 = 0.0
    for n in range(FINE):
        s0 += series[n] * table[n, 0]
        s1 += series[n] * table[n, 1]
        s2 += series[n] * table[n, 2]
        s3 += series[n] * table[n, 3]
        s4 += series[n] * table[n, 4]
        s5 += series[n] * table[n, 5]
    return s0, s1, s2, s3, s4, s5


@kernel
def _put_give(step: Step, given: View[float], time: float, rate: float) -> None:
    """Set how far the nodes' forces move the nodes over a step of `time` seconds; rate: samples per s."""
    g = sums_of_nine(ANSWER_AT, given)
    step.give_v[0, 0], step.give_v[0, 1], step.give_v[0, 2] = rate * g[0], rate * g[1], rate * g[2]
    step.give_v[1, 0], step.give_v[1, 1], step.give_v[1, 2] = rate * g[3], rate * g[4], rate * g[5]
    step.give_v[2, 0], step.give_v[2, 1], step.give_v[2, 2] = rate * g[6], rate * g[7], rate * g[8]
    # By the Gauss method's own integral of the velocity: so stiff contacts at rest don't need short steps.
    for i in range(NODES):
        for j in range(NODES):
            give = 0.0
            for n in range(NODES):
                give += INTEGRAL[i, n] * step.give_v[n, j]
            step.give_x[i, j] = give * time


@kernel
def keep_at_rest(step: Step, given: View[float], impulse: float) -> None:
    """Correct the nodes so that a force that lasts moves none beyond its answer: the Gauss method's integral of the
    answer differs from it, and steps would be refined for that alone.

    impulse: that force (N) times the step (samples).
    """
    if impulse > 0.0:
        for i in range(NODES):
            missed = 0.0
            for n in range(NODES, FINE):
                missed += given[n] * MISSED[n, i]
            step.free_x[i] += impulse * missed


@kernel
def lasting_force(contact: Coupled) -> float:
    """Return the force (N) that is taken to last over a step: that of the striker at rest, or the end of the last
    step's."""
    if contact.rest_force > 0.0:
        return contact.rest_force
    return max(end_of(contact.force), 0.0) if contact.last > 0.0 else 0.0


@kernel
def sums_of_nine(
    table: View2D[float], series: View[float]
) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Return sum_n series[n] table[n, k], n > 0, for each k < 9: nine sums that do not wait for each other."""
    s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = s8 = 0.0
    for n in range(1, FINE):
        term = series[n]
        s0 += term * table[n, 0]
        s1 += term * table[n, 1]
        s2 += term * table[n, 2]
        s3 += term * table[n, 3]
        s4 += term * table[n, 4]
        s5 += term * table[n, 5]
        s6 += term * table[n, 6]
        s7 += term * table[n, 7]
        s8 += term * table[n, 8]
    return s0, s1, s2, s3, s4, s5, s6, s7, s8


@kernel
def end_without(moved: View[float]) -> tuple[float, float]:
    """Return x (m) and its derivative (m per step) at a step's end without the forces."""
    x = v = 0.0
    for n in range(FINE):
        x += moved[n]
        v += n * moved[n]
    return x, v


@kernel
def taken_at_end(given: View[float], f: View[float], eta: float) -> tuple[float, float]:
    """Return how much the nodes' forces take off compression and rate at the step's end."""
    s = _sums_of_six(ANSWER_TO_END, given)
    return eta * (s[0] * f[0] + s[1] * f[1] + s[2] * f[2]), eta * (s[3] * f[0] + s[4] * f[1] + s[5] * f[2])


@kernel
def speed_of(contact: Coupled, x: float, v: float) -> float:
    """Return the speed that kinetic and elastic energy amount to; of what rests, about its rest, of the mass that is
    felt there."""
    if contact.swing > 0.0:
        swing = contact.swing * math.sqrt(contact.m / contact.mass)
        away = swing * (x - contact.rest_compression)
        return max(math.sqrt(v * v + away * away), _LEAST_SWING * swing * contact.rest_compression)
    return math.sqrt(v * v + 2.0 * elastic(x, contact.k, contact.a) / contact.mass)


@kernel
def ratio_to_longest(contact: Coupled, eta: float, x: float, v: float) -> float:
    """Return the factor by which to change the step to meet the tolerance."""
    speed = max(speed_of(contact, x, v), speed_of(contact, contact.motion[0], contact.motion[1] / contact.period))
    rest = abs(end_of(contact.step.f) - law(x, v, contact.k, contact.mu, contact.a)) * eta * contact.period
    return step_within(rest, contact.tolerance * contact.mass * speed)


@kernel
def work_of(f: View[float], moved: View[float]) -> float:
    """Return a step's work (J) of the nodes' forces (N) along a series of its times, exactly."""
    w0 = w1 = w2 = 0.0
    for n in range(1, FINE):
        w0 += moved[n] * WORK[n, 0]
        w1 += moved[n] * WORK[n, 1]
        w2 += moved[n] * WORK[n, 2]
    return w0 * f[0] + w1 * f[1] + w2 * f[2]


@kernel
def work_against(f: View[float], other: View[float], given: View[float], eta: float) -> float:
    """Return the work (J) of the nodes' forces against what another's forces take off in a step of `eta` samples,
    exactly."""
    t = sums_of_nine(TAKEN, given)
    o0, o1, o2 = other[0], other[1], other[2]
    work = f[0] * (t[0] * o0 + t[1] * o1 + t[2] * o2)
    work += f[1] * (t[3] * o0 + t[4] * o1 + t[5] * o2)
    work += f[2] * (t[6] * o0 + t[7] * o1 + t[8] * o2)
    return eta * work


@kernel
def may_lose(contact: Coupled) -> float:
    """Return the energy (J) that a step may lose beyond what the law takes."""
    return max(_LOSS * contact.tolerance, _LEAST_LOSS) * contact.scale


@kernel
def give_of(answer: View[float], eta: float) -> float:
    """Return the distance (m) by which a point gives way to 1 N held for a step, by its answer (FINE, m/(N sample)) to
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
