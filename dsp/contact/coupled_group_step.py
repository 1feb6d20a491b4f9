"""A step of several coupled contacts (coupled_group.py) by collocation: its forces, its length, and what ends it."""

import math

import numpy as np

from ..native.jit import kernel, noinline_kernel
from ..native.typed import Items
from ..numerics.legendre import FINE
from .collocation import (
    CARDINAL,
    FAR,
    GAUSS,
    INTEGRAL,
    LEAST_REST,
    LENGTHEN,
    NEWTON_STEPS,
    SOLVED,
    WEIGHTS,
    WITHIN,
    better_step,
    eliminate,
    eliminate_three,
    end_of,
    force_at,
    until_release,
)
from .coupled_flight import fly
from .coupled_records import CoupledGroup, Member
from .coupled_step import (
    FINEST,
    REFINE,
    RETRY,
    ROUNDING,
    TRIALS,
    set_powers,
    speed_of,
)
from .law import elastic, law, law_with_slopes, spring_of
from .power_series import END, FREE, GIVE, MISSED, NODE_RATES, TAKEN, TO_ENDS, WORK, put
from .step_record import GIVE_COUNT, NODES

_GROWTH = 4e-9  # share of its energy that a contact may gain in all
_LEAST_GROWTH = 1e-15  # what rounding makes of it in a step
_LEAST_LOSS = 1e-10  # share of that energy that it may lose in any case: rounding comes near it
_LOSS = 1e-4  # of the contact's energy, times the tolerance, that a step may lose beyond what the law takes

NOTHING, MEETS, LEAVES = 0, 1, 2
"""The events that end a step for a contact."""

_ON_TIME = 1e-9  # share of a step by which a striker that flies may miss the time at which it meets the object,
_ROUNDED = 1e-10  # and samples by which it may in any case

_RUNNING = np.array(
    [[math.factorial(n) * math.factorial(p) / math.factorial(n + p + 1) for p in range(NODES)] for n in range(FINE)]
)  # int_0^t (t - s)^n s^p ds over t^(n + p + 1)


@noinline_kernel
def find_step(contacts: Items[Member], group: CoupledGroup, eta: float, longest: float) -> float:
    """Find a step that is solved, within the tolerance and right in energy: its length, or 0 if it gets too fine."""
    finest = FINEST * eta
    for _ in range(TRIALS):
        if eta <= finest:
            break
        whole = 0.0
        if _try(contacts, group, eta):
            # The least `ratio` of the contacts that touch. One that asks for a shorter step will next time try that.
            least = math.inf
            for a in range(group.touching):
                i = group.touches[a]
                contact = contacts[group.member[i]].coupled
                # The factor by which to change the step to meet the tolerance.
                x = group.end_x[i]
                v = group.end_v[i]
                speed = speed_of(contact, x, v)
                rest = abs(end_of(contact.step.f) - law(x, v, contact.k, contact.mu, contact.a)) * eta * contact.period
                # The rest grows with h^4 where the force is smooth, and less steeply where the contact begins.
                wanted = contact.tolerance * contact.mass * speed
                if wanted >= FAR * rest:
                    ratio = LENGTHEN
                else:
                    ratio = better_step(math.sqrt(math.sqrt(wanted / max(rest, LEAST_REST))))
                group.ratio[i] = ratio
                if ratio < WITHIN:
                    contact.next = ratio * eta
                least = min(least, ratio)
            ratio = least
            whole = _find_end(contacts, group, eta, longest)
            if ratio < WITHIN:
                whole = min(whole, ratio * eta)
            elif whole == eta:
                if _is_sound(contacts, group, eta):
                    # Take the step's forces.
                    for a in range(group.touching):
                        j = group.touches[a]
                        contact = contacts[group.member[j]].coupled
                        contact.gained = max(contact.gained + group.gained[j], 0.0)
                        for r in range(NODES):
                            contact.force[r] = contact.step.f[r]
                        if group.event[j] == NOTHING:
                            contact.next = max(group.ratio[j] * eta, contact.next)
                    return eta
                whole = REFINE * eta
                ratio = 0.0
            if ratio >= WITHIN:
                eta = whole
                finest = min(finest, FINEST * eta)  # it is short because something happens soon
                continue
        for i in range(group.size):
            group.sought[i] = 0
        eta = whole if whole > 0.0 else RETRY * eta
    return 0.0


@kernel
def _try(contacts: Items[Member], group: CoupledGroup, eta: float) -> bool:
    """Try a step: true if it is solved; all forces are then in the contacts' steps, and `end_x`, `end_v` filled."""
    # Write all series in times of the step, and their products.
    for i in range(group.size):
        contact = contacts[group.member[i]].coupled
        set_powers(contact, eta)
        put(contact.moved, FREE, contact.free)
        for b in range(group.touching):
            j = group.touches[b]
            if i == j and eta == 1.0:
                # Take the products of a point's answer to its own contact over a whole sample, which stay as long as
                # it does.
                give = group.give[i, i]
                if contact.known == 0:
                    put(contact.answer, GIVE, contact.whole)
                    contact.known = 1
                for k in range(GIVE_COUNT):
                    give[k] = contact.whole[k]
            else:
                for n in range(FINE):
                    group.given[n] = group.answer[i, j, n] * contact.power[n]
                put(group.given, GIVE, group.give[i, j])
    # Most contacts are alone, most groups pairs: the loops for one and for two are unrolled.
    if group.touching == 1:
        solved = _solve(contacts, group, eta, 1)
    elif group.touching == 2:
        solved = _solve(contacts, group, eta, 2)
    else:
        solved = _solve(contacts, group, eta, group.touching)
    for i in range(group.size):
        # Find the compression of contact i at the step's end, and its rate.
        contact = contacts[group.member[i]].coupled
        x, v = contact.free[END], contact.free[END + 1]
        for b in range(group.touching):
            j = group.touches[b]
            # What the forces at the nodes of contact j take off compression, and off its change over the step.
            f, give = contacts[group.member[j]].coupled.step.f, group.give[i, j]
            to_x, to_v = give[TO_ENDS:], give[TO_ENDS + NODES :]
            x -= eta * (to_x[0] * f[0] + to_x[1] * f[1] + to_x[2] * f[2])
            v -= eta * (to_v[0] * f[0] + to_v[1] * f[1] + to_v[2] * f[2])
        group.end_x[i] = x
        group.end_v[i] = v / (eta * contact.period)
    return solved


@kernel
def _solve(contacts: Items[Member], group: CoupledGroup, eta: float, touching: int) -> bool:
    """Solve for the forces at all nodes by Newton's method, from where the last ones lead, then from 0, where the law's
    convexity helps it. False if it fails: the step is too long.

    Leaves each node's x and v before the last change of f. Changes of a force below `negligible` don't matter; that is
    needed where 1 + mu v is down to rounding.
    """
    # Write down the equations of all nodes.
    for a in range(touching):
        contact = contacts[group.member[group.touches[a]]].coupled
        # Set compression and rate at the nodes of a step of `eta` samples as they are without a force.
        step, free, rate = contact.step, contact.free, 1.0 / (eta * contact.period)
        step.free_x[0], step.free_x[1], step.free_x[2] = free[0], free[1], free[2]
        for i in range(NODES):
            step.free_v[i] = rate * free[NODE_RATES + i]
        speed = speed_of(contact, contact.motion[0], contact.motion[1] / contact.period)
        group.negligible[a] = ROUNDING * contact.mass * speed / (eta * contact.period)
        for b in range(touching):
            # Fill in how far the nodes' forces of touching contact b move the nodes of touching contact a.
            period = contact.period
            give, rate, time = group.give[group.touches[a], group.touches[b]], 1.0 / period, eta * period
            for r in range(NODES):
                for s in range(NODES):
                    group.give_v[a * NODES + r, b * NODES + s] = rate * give[NODES * r + s]
            # By the Gauss method's own integral of the velocity: so stiff contacts at rest don't need short steps.
            for r in range(NODES):
                for s in range(NODES):
                    x = 0.0
                    for n in range(NODES):
                        x += INTEGRAL[r, n] * group.give_v[a * NODES + n, b * NODES + s]
                    group.give_x[a * NODES + r, b * NODES + s] = x * time
            j = group.touches[b]
            # The force (N) that is taken to last over a step: that of the striker at rest, or the end of the last
            # step's.
            other = contacts[group.member[j]].coupled
            if other.rest_force > 0.0:
                lasts = other.rest_force
            else:
                lasts = max(end_of(other.force), 0.0) if other.last > 0.0 else 0.0
            # Correct the nodes so that a force that lasts moves none beyond its answer: the Gauss method's
            # integral of the answer differs from it, and steps would be refined for that alone.
            impulse = eta * lasts
            if impulse > 0.0:
                for i in range(NODES):
                    contact.step.free_x[i] += impulse * group.give[group.touches[a], j][MISSED + i]
    size = touching * NODES
    for start in range(2):
        for a in range(touching):
            contact = contacts[group.member[group.touches[a]]].coupled
            # Set the forces that Newton's method starts from: where the last ones lead, or at the second `start`
            # zeros.
            f, ratio = contact.force, eta / contact.last if contact.last > 0.0 else 0.0
            for k in range(NODES):
                contact.step.f[k] = force_at(f[0], f[1], f[2], 1.0 + ratio * GAUSS[k]) if start == 0 else 0.0
            for r in range(NODES):
                group.f[a * NODES + r] = contact.step.f[r]
        for _ in range(NEWTON_STEPS):
            for a in range(touching):
                # Fill the rows of Newton's equations for touching contact a.
                contact = contacts[group.member[group.touches[a]]].coupled
                step = contact.step
                for r in range(NODES):
                    u = a * NODES + r
                    x, v = step.free_x[r], step.free_v[r]
                    for w in range(size):
                        x -= group.give_x[u, w] * group.f[w]
                        v -= group.give_v[u, w] * group.f[w]
                    step.x[r] = x
                    step.v[r] = v
                    force, stiffness, damping = law_with_slopes(x, v, (contact.k, contact.mu, contact.a))
                    for w in range(size):
                        group.linear[u, w] = stiffness * group.give_x[u, w] + damping * group.give_v[u, w]
                    group.linear[u, u] += 1.0
                    group.linear[u, size] = force - group.f[u]
            if touching == 1:
                eliminate_three(group.linear)
            else:
                eliminate(group.linear, size)
            converged = True
            for a in range(touching):
                contact = contacts[group.member[group.touches[a]]].coupled
                change = most = 0.0
                for r in range(NODES):
                    u = a * NODES + r
                    group.f[u] += group.linear[u, size]
                    contact.step.f[r] = group.f[u]
                    change = max(change, abs(group.linear[u, size]))
                    most = max(most, abs(group.f[u]))
                converged &= change <= SOLVED * most + group.negligible[a]
            if converged:
                return True
    return False


@kernel
def _find_end(contacts: Items[Member], group: CoupledGroup, eta: float, longest: float) -> float:
    """Return the length of the step that ends where the first contact begins or ends; `eta` itself where this one
    does."""
    shorter, longer, exact = eta, math.inf, False
    for i in range(group.size):
        contact = contacts[group.member[i]].coupled
        group.event[i] = NOTHING
        if contact.wait >= 0.0:
            continue
        x, v = group.end_x[i], group.end_v[i] * contact.period
        if contact.touching == 1:
            sought = group.sought[i] == 1
            whole, sought = until_release(contact.step, x, v, eta, longest, sought, contact.tolerance)
            event = LEAVES
        else:
            whole, sought = _until_meeting(contacts, group, i, eta, longest)
            event = MEETS
        group.sought[i] = sought
        if whole < eta:
            shorter = min(shorter, whole)
        elif whole > eta:
            longer = min(longer, whole)
        elif sought:
            group.event[i] = event
            exact = True
    if shorter < eta:
        return shorter
    return eta if exact or longer == math.inf else longer


@kernel
def _until_meeting(
    contacts: Items[Member], group: CoupledGroup, i: int, eta: float, longest: float
) -> tuple[float, bool]:
    """Return the time at which a flying striker meets the object, and whether it does, else `eta`; compare
    `until_release`."""
    contact = contacts[group.member[i]].coupled
    if group.sought[i] == 0:
        # Write the compression of contact i over the step as a power series, moved by the forces of the others.
        path = group.path
        motion = contacts[group.member[i]].coupled.motion
        for n in range(FINE):
            path[n] = motion[n]
        for b in range(group.touching):
            j = group.touches[b]
            f = contacts[group.member[j]].coupled.step.f
            scale = 1.0
            for p in range(NODES):
                force = scale * (CARDINAL[p, 0] * f[0] + CARDINAL[p, 1] * f[1] + CARDINAL[p, 2] * f[2])
                for n in range(1, FINE - p - 1):
                    path[n + p + 1] -= group.answer[i, j, n] * _RUNNING[n, p] * force
                scale /= eta
        whole, meets = fly(group.path, eta)
        if meets or group.end_x[i] <= 0.0:
            return whole, meets  # else the series, which ends, has missed it
    v = group.end_v[i] * contact.period
    late = group.end_x[i] / v if v > 0.0 else 0.0
    if abs(late) <= max(_ON_TIME * eta, _ROUNDED):
        return eta, v > 0.0
    whole = eta - late
    return (whole, True) if 0.0 < whole <= longest else (eta, False)


@kernel
def _is_sound(contacts: Items[Member], group: CoupledGroup, eta: float) -> bool:
    """True if the step's energy is right: each force's exact work against the change of V, and what its law takes."""
    for a in range(group.touching):
        i = group.touches[a]
        contact = contacts[group.member[i]].coupled
        f = contact.step.f
        stored = elastic(contact.motion[0], contact.k, contact.a)
        v = contact.motion[1] / contact.period
        contact.scale = max(contact.scale, stored + 0.5 * contact.mass * v * v)
        # A step's work (J) of the nodes' forces (N) along a motion, exactly.
        work = contact.free[WORK] * f[0] + contact.free[WORK + 1] * f[1] + contact.free[WORK + 2] * f[2]
        for b in range(group.touching):
            j = group.touches[b]
            # The work against what another's forces take off, exactly.
            other, against = contacts[group.member[j]].coupled.step.f, 0.0
            for r in range(NODES):
                taken = group.give[i, j][TAKEN + NODES * r :]
                against += f[r] * (taken[0] * other[0] + taken[1] * other[1] + taken[2] * other[2])
            work -= eta * against
        gain = elastic(group.end_x[i], contact.k, contact.a) - stored - work
        lost = -gain
        for r in range(NODES):
            spring = spring_of(contact.step.x[r], contact.k, contact.a)
            lost -= eta * contact.period * WEIGHTS[r] * (f[r] - spring) * contact.step.v[r]
        # It may gain half of what is left to gain, and lose little more than the law takes.
        allowed = max(0.5 * (_GROWTH * contact.scale - contact.gained), _LEAST_GROWTH * contact.scale)
        if gain > allowed or lost > max(_LOSS * contact.tolerance, _LEAST_LOSS) * contact.scale:
            return False
        group.gained[i] = gain
    return True
