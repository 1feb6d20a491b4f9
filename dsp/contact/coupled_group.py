"""The solver of coupled contacts: one, or several in one sample, where the force of each moves the points of all.

As in coupled.py, modes enter over a sample by polynomials. Between two contacts there is the response of the point of
one to the force of the other, g_ij(t) = sum phi_i phi_j exp(-sigma t) sin(omega t)/omega, with

    x_i(t) = D_i(t) - sum_j int_0^t g_ij(t - s) f_j(s) ds.

All contacts take the same steps, as short as the one that needs the shortest asks for. In a step the equations of all
nodes are one system, solved by Newton's method. A step ends where any of them begins or ends. For each contact the work
of its force is that of its own point's motion, to which all forces add, so that the bound on its energy is the same
as alone. Where steps get too fine the forces are held one after the other, each seeing what those before it did: that
can't gain energy either.
"""

from ..native.jit import kernel
from ..native.typed import Items
from ..numerics.legendre import FINE
from .collocation import discrete_gradient
from .coupled import lay_on, lift, look, move, move_to_end, pass_kinks, settle, until_kink
from .coupled_flight import fly
from .coupled_group_step import LEAVES, MEETS, NOTHING, find_step
from .coupled_records import CoupledGroup, Member
from .coupled_step import FINEST, HELD, LEAST, give_of, set_powers
from .power_series import BINOMIAL, legendre_moments, value_at
from .step_record import NODES
from .touches import begin_touch

_STRETCHED = 1.1  # times the step to try: so long may one be that comes to the sample's end, rather than leave a sliver

MOST_STEPS = 3_000  # in a sample; what is left of it then is one held step
_SHARES = 8  # of them; each of the second half begins with wider tolerances, so that the sample is mostly done by then
_WIDER = 32.0  # a power of 2: tolerances come back to the bit; steps are some 2.5 times as long


@kernel
def step_together(contacts: Items[Member], group: CoupledGroup) -> None:
    """Take all contacts of a group through the coming sample; fill the `moments` (N s) of their forces on the object.

    `observed` holds for each how the object's point would move without them; of two objects, the difference of both,
    where the striker's moves against its place in the striker; it gets the moments' negative. A contact whose tolerance
    is HELD is a group of its own.
    """
    for i in range(group.size):
        contact = contacts[group.member[i]].coupled
        look(contact, group.observed[i])
        for k in range(FINE):
            group.moments[i, k] = 0.0
            group.answer[i, i, k] = contact.answer[k]
    for j in range(group.size):
        if contacts[group.member[j]].coupled.wait < 0.0:
            _lift_from(contacts, group, j)
    at, widened, eta = 0.0, 1.0, 0.0
    for count in range(MOST_STEPS + 1):
        left = 1.0 - at
        if left <= 0.0:
            break
        if count % (MOST_STEPS // _SHARES) == 0 and MOST_STEPS // 2 <= count < MOST_STEPS:
            for i in range(group.size):
                contacts[group.member[i]].coupled.tolerance *= _WIDER
            widened *= _WIDER
        eta = _step(contacts, group, at, count == MOST_STEPS)
        at = 1.0 if eta >= left else at + eta
        for i in range(group.size):
            contact = contacts[group.member[i]].coupled
            if contact.wait >= 0.0 and contact.rest_force > 0.0 and group.event[i] == MEETS:
                contact.wait = -1.0
                lay_on(contact, at, group.moments[i])
                _lift_from(contacts, group, i)
            elif contact.wait < 0.0 or group.event[i] == MEETS:
                contact.wait = min(contact.wait, -1.0)
                settle(contact, at, group.event[i] == MEETS, group.event[i] == LEAVES)
            pass_kinks(contact, at)
    for i in range(group.size):
        contact = contacts[group.member[i]].coupled
        contact.tolerance *= 1.0 / widened
        if eta < 1.0:
            legendre_moments(group.moments[i])
        group.moments[i, 0] -= contact.rest_force * contact.period


@kernel
def _lift_from(contacts: Items[Member], group: CoupledGroup, j: int) -> None:
    """Undo it for the weight of one of them, from now on."""
    force = contacts[group.member[j]].coupled.rest_force
    if force > 0.0:
        for i in range(group.size):
            if i != j:
                lift(contacts[group.member[i]].coupled, group.answer[i, j], force)


@kernel
def _step(contacts: Items[Member], group: CoupledGroup, at: float, last: bool) -> float:
    """Take a step from `at` on, with its events; the `last` one holds the forces for the rest. Return its length."""
    left = 1.0 - at
    longest = eta = left
    group.touching = 0
    for i in range(group.size):
        contact = contacts[group.member[i]].coupled
        group.event[i] = NOTHING
        group.sought[i] = 0
        if not last:
            longest = min(longest, until_kink(contact, at))
        if contact.wait >= 0.0:
            longest = min(longest, contact.wait)
        elif contact.touching == 1 or last:
            if contact.touching == 0:
                begin_touch(contact, at)  # the last step may
            group.touches[group.touching] = i
            group.touching += 1
            contact.steps += 1
            eta = min(eta, contact.next)
    eta = longest if longest < _STRETCHED * eta else eta
    if eta > 0.0:
        held = group.touching > 0 and contacts[group.member[0]].coupled.tolerance == HELD
        taken = 0.0
        if group.touching == 0 and not last:
            # The time until the first of strikers that all fly meets the object, at most `longest`.
            first = longest
            for k in range(group.size):
                one = contacts[group.member[k]].coupled
                if one.wait < 0.0:
                    time, meets = fly(one.motion, first)
                    if meets:
                        first = time
                        for j in range(k):
                            group.event[j] = NOTHING
                        group.event[k] = MEETS
            taken = first
            # Find where contacts that all fly are after `eta` samples; of one that is `left` to the sample's end, only
            # the end of its path.
            if group.size == 1 and taken >= left:
                contact = contacts[group.member[0]].coupled
                group.end_x[0], rate = value_at(contact.motion, taken)
                group.end_v[0] = rate / contact.period
            else:
                for i in range(group.size):
                    set_powers(contacts[group.member[i]].coupled, taken)
        elif not last and not held:
            taken = find_step(contacts, group, eta, longest)
        if taken > 0.0 and taken >= left and group.size == 1:
            eta = taken
            contact = contacts[group.member[0]].coupled
            move_to_end(contact, eta, at, (group.end_x[0], group.end_v[0]), group.moments[0])
        elif taken > 0.0:
            eta = taken
            for i in range(group.size):
                move(contacts[group.member[i]].coupled, eta, at, group.moments[i])
            _answer_others(contacts, group, False)
        else:
            eta = left if last else longest if held else max(FINEST * eta, min(LEAST, eta))
            # Hold the forces for a step, one after the other, and go on by it. Two forces do the same work, each
            # against the motion that the other gives to its point. The later one is found where the other is known, and
            # does the work of both: so energy can't grow.
            for b in range(group.touching):
                j = group.touches[b]
                contact = contacts[group.member[j]].coupled
                given = 0.0
                for a in range(b):
                    i = group.touches[a]
                    given += 2.0 * give_of(group.answer[j, i], eta) * contacts[group.member[i]].coupled.force[0]
                # A held force can't gain energy; others take `given` (m) off the compression meanwhile.
                h = contact.period
                free = value_at(contact.motion, eta)[0] - contact.motion[0] - given
                give = give_of(contact.answer, eta)
                force = discrete_gradient(contact.motion[0], free, give, eta * h, contact.k, contact.mu, contact.a)[1]
                contact.held += 1
                contact.next = 2.0 * eta
                for j in range(NODES):
                    contact.force[j] = contact.step.f[j] = force
                contact.motion[0] -= given
                contact.position -= given
            for i in range(group.size):
                set_powers(contacts[group.member[i]].coupled, eta)
                move(contacts[group.member[i]].coupled, eta, at, group.moments[i])
            _answer_others(contacts, group, True)
    for i in range(group.size):
        contact = contacts[group.member[i]].coupled
        if contact.wait >= 0.0:
            contact.wait = max(contact.wait - eta, 0.0)
            if contact.wait == 0.0:
                group.event[i] = MEETS
        elif contact.touching == 0 and contact.motion[0] > 0.0:
            group.event[i] = MEETS
    return eta


@kernel
def _answer_others(contacts: Items[Member], group: CoupledGroup, kept: bool) -> None:
    """Move every point as it answers the other contacts' forces over the step that was taken.

    Where compressions are `kept` the strikers that touch move along: what is compressed holds energy.
    """
    for i in range(group.size):
        contact = contacts[group.member[i]].coupled
        for b in range(group.touching):
            if group.touches[b] != i:
                other = contacts[group.member[group.touches[b]]].coupled
                # Move the point of a contact as it answers another's force; its compression now may be `kept`.
                stays = kept and contact.touching == 1
                for k in range(FINE):
                    total = 0.0
                    for n in range(k, FINE):
                        total += BINOMIAL[n, k] * (group.answer[i, group.touches[b]][n] * other.impulse[n - k])
                    if k == 0 and stays:
                        contact.position += total
                    else:
                        contact.motion[k] -= total
