"""A step of a coupled contact (coupled.py) while it lasts: by collocation, or with the force held."""

import math

from ..native.jit import kernel
from ..numerics.legendre import FINE
from .collocation import (
    GAUSS,
    INTEGRAL,
    NODES,
    WEIGHTS,
    WITHIN,
    allowance,
    better_step,
    discrete_gradient,
    elastic,
    end_of,
    extrapolate,
    law,
    solve,
    until_release,
)
from .power_series import DOUBLE, FORCE_AT, QUADRATURE, QUADRATURE_WEIGHTS, TO_END, TO_NODE, value_at

HELD = math.inf
"""Tolerance of one held step a sample: the cheapest, for when there is no time."""

TRIALS = 40
FINEST = 2.0**-16  # of the step tried first: where it comes to this, the force is held
_LOSS = 1e-4  # of the contact's energy, times the tolerance, that a step may lose beyond what the law takes
_LEAST_LOSS = 1e-10  # share of that energy that it may lose in any case: rounding comes near it
_LEAST_SWING = 1e-3  # of the compression at which a striker rests: an amplitude that counts as heard in any case
LEAST = 1e-12  # samples: the force is held no shorter, or steps that fail one after the other come to nothing
RETRY = 0.25  # of a step whose equations are not solved
REFINE = 0.5  # of a step whose energy is not right
ROUNDING = 1e-14  # share of the momentum at hand that no force is asked for


@kernel
def stay(contact, left, last):
    """A step in contact, at most `left` samples long: its length, and whether it ends in the release.

    A step is accepted where |f_end - f(x, v)| times its length, with f_end the end of the force's quadratic, is below
    tolerance times the momentum at hand, and energy grows by no more than rounding. The `last` step holds the force for
    what is left.
    """
    contact.steps += 1
    held = last or contact.tolerance == HELD
    eta = left if held else min(contact.next, left)
    finest = left if held else FINEST * eta
    closing = False
    for _ in range(TRIALS):
        if eta <= finest:
            break
        solved, x, v = _collocate(contact, eta)
        if not solved:
            eta *= RETRY
            closing = False
            continue
        whole, closing = until_release(contact.step, x, v * contact.period, eta, left, closing)
        ratio = ratio_to_longest(contact, eta, x, v)
        if whole != eta or ratio < WITHIN:
            # No need to seek a release that is too far away for one step.
            closing = closing and ratio >= WITHIN
            if whole < eta:
                finest = min(finest, FINEST * whole)  # it is short as the release comes soon
            eta = whole if ratio >= WITHIN else min(whole, ratio * eta)
            continue
        if _sound(contact, eta, x):
            if not closing:
                contact.next = max(ratio * eta, contact.next if eta == left else 0.0)
            for j in range(NODES):
                contact.force[j] = contact.step.f[j]
            extrapolate(contact.step, contact.next / eta)
            return eta, closing
        eta *= REFINE
        closing = False
    eta = max(eta, finest, min(LEAST, left))
    hold(contact, eta, 0.0)
    return eta, False


@kernel
def _collocate(contact, eta):
    """Try a step: whether it is solved, and x and v at its end."""
    step = contact.step
    power = contact.power
    power[0] = 1.0
    for n in range(1, FINE):
        power[n] = power[n - 1] * eta
    h = contact.period
    for i in range(NODES):
        step.free_x[i], slope = value_at(contact.motion, eta * GAUSS[i])
        step.free_v[i] = slope / h
        for j in range(NODES):
            give = 0.0
            for n in range(1, FINE):
                give += n * contact.answer[n] * power[n] * TO_NODE[n - 1, i, j]
            step.give_v[i, j] = give / h
    # By the Gauss method's own integral of the velocity: so stiff contacts at rest don't need short steps.
    for i in range(NODES):
        for j in range(NODES):
            give = 0.0
            for n in range(NODES):
                give += INTEGRAL[i, n] * step.give_v[n, j]
            step.give_x[i, j] = give * eta * h
    speed = speed_of(contact, contact.motion[0], contact.motion[1] / h)
    solved = solve(step, contact.k, contact.mu, contact.a, ROUNDING * contact.mass * speed / (eta * h))
    x, v = value_at(contact.motion, eta)
    for n in range(FINE):
        contact.impulse[n] = (
            eta * power[n] * (TO_END[n, 0] * step.f[0] + TO_END[n, 1] * step.f[1] + TO_END[n, 2] * step.f[2])
        )
        x -= contact.answer[n] * contact.impulse[n]
        if n > 0:
            v -= n * contact.answer[n] * contact.impulse[n - 1]
    return solved, x, v / h


@kernel
def speed_of(contact, x, v):
    """The speed that kinetic and elastic energy amount to; of a striker that rests, about its rest."""
    if contact.swing > 0.0:
        away = contact.swing * (x - contact.rest_compression)
        return max(math.sqrt(v * v + away * away), _LEAST_SWING * contact.swing * contact.rest_compression)
    return math.sqrt(v * v + 2.0 * elastic(x, contact.k, contact.a) / contact.mass)


@kernel
def ratio_to_longest(contact, eta, x, v):
    """What to multiply the step with for the tolerance."""
    speed = max(speed_of(contact, x, v), speed_of(contact, contact.motion[0], contact.motion[1] / contact.period))
    rest = abs(end_of(contact.step.f) - law(x, v, contact.k, contact.mu, contact.a)) * eta * contact.period
    mass = contact.m if contact.swing > 0.0 else contact.mass
    return better_step(rest, contact.tolerance * mass * speed)


@kernel
def _sound(contact, eta, x):
    """Whether the step's energy is right: its exact work against the change of V, and what dissipation takes."""
    f = contact.step.f
    stored = elastic(contact.motion[0], contact.k, contact.a)
    v = contact.motion[1] / contact.period
    contact.scale = max(contact.scale, stored + 0.5 * contact.mass * v * v)
    work = 0.0
    for q in range(len(QUADRATURE)):
        force = FORCE_AT[q, 0] * f[0] + FORCE_AT[q, 1] * f[1] + FORCE_AT[q, 2] * f[2]
        work += eta * QUADRATURE_WEIGHTS[q] * force * value_at(contact.motion, eta * QUADRATURE[q])[1]
    for n in range(1, FINE):
        form = 0.0
        for i in range(NODES):
            for j in range(NODES):
                form += f[i] * DOUBLE[n - 1, i, j] * f[j]
        work -= n * contact.answer[n] * contact.power[n] * eta * form
    gain = elastic(x, contact.k, contact.a) - stored - work
    lost = -gain
    for i in range(NODES):
        node = contact.step.x[i]
        spring = contact.k * node**contact.a if node > 0.0 else 0.0
        lost -= eta * contact.period * WEIGHTS[i] * (f[i] - spring) * contact.step.v[i]
    if gain > allowance(contact.gained, contact.scale) or lost > may_lose(contact):
        return False
    contact.gained = max(contact.gained + gain, 0.0)
    return True


@kernel
def may_lose(contact):
    """Energy (J) that a step may lose beyond what the law takes."""
    return max(_LOSS * contact.tolerance, _LEAST_LOSS) * contact.scale


@kernel
def give_of(answer, eta):
    """How far (m) a point gives way to 1 N that is held for a step, by its answer (FINE, m/(N sample)) to it."""
    give = 0.0
    power = eta
    for n in range(1, FINE):
        power *= eta
        give += answer[n] * power / (n + 1)
    return give


@kernel
def hold(contact, eta, taken):
    """Hold the force for a step, which can't gain energy. taken (m): what others take off the compression meanwhile."""
    h = contact.period
    free = value_at(contact.motion, eta)[0] - contact.motion[0] - taken
    give = give_of(contact.answer, eta)
    force = discrete_gradient(contact.motion[0], free, give, eta * h, contact.k, contact.mu, contact.a)[1]
    contact.held += 1
    contact.next = 2.0 * eta
    for j in range(NODES):
        contact.force[j] = contact.step.f[j] = force
