"""The bends of an object's modes under strikers: what they would hold for good under the present force.

A mode that is bent rests about its bend, and not about 0. So where it is retuned under a striker, its bend is taken out
first, what swings about it keeps its energy, and the bend of the new tuning is put back. The point steps, which the
striker does not feel; the modes do not, which would be heard. A bend of a tighter object holds less energy than before:
no more than that is lent to it again when it slackens.
"""

import math

from ...contact.law import law
from ...native.jit import kernel, noinline_kernel
from ...numerics.legendre import KEPT
from ...resonator.bank import Modes, inject_kept
from ...resonator.mode import energy_of, ring_from, settle_under
from ..memory.records import Contact
from ..memory.state import COUPLING, Object, State
from .objects import (
    modes_of,
    point_of,
    relief_of,
    ringing_of,
    shape_at,
    share_of,
    weigh_anew,
)
from .retuning import retune


@kernel
def in_work(state: State, modes: Modes) -> Modes:
    """Return modes of the same kind whose motion is in `scratch.work`."""
    size, work = len(modes.y1), state.scratch.work
    return Modes(work[:size], work[size : 2 * size], modes.a1, modes.a2, modes.balance, modes.response)


@noinline_kernel
def find_bend(state: State, obj: Object, modes: Modes) -> bool:
    """Write how an object's modes are bent by the strikers that are pressed on it into `scratch.work`; false if none
    is."""
    bent, force, found = in_work(state, modes), state.scratch.power, False
    for i in range(len(modes.y1)):
        bent.y1[i] = bent.y2[i] = force[i] = 0.0
    if obj.shares_contact == 1:
        for i in range(state.active):
            found |= _push(state, obj, state.objects[state.order[i]].contact, bent)
    else:
        found = _push(state, obj, obj.contact, bent)
    obj.deflection = 0.0
    if found:
        settle_under(bent)
        for i in range(min(len(modes.y1), obj.felt)):
            omega = 2.0 * math.pi * state.bank.frequency[obj.first + i] * obj.settings.tune
            obj.deflection += 0.5 * force[i] * force[i] / (omega * omega) if omega > 0.0 else 0.0
    return found


@kernel
def _push(state: State, obj: Object, index: int, bent: Modes) -> bool:
    """Add the pushes of a list of contacts on an object's modes to `scratch.power` (N kg^-1/2), and what a sample of
    them gives the modes to `bent`; false if none acts on it."""
    found, moments = False, state.scratch.fine
    while index >= 0:
        contact = state.contacts[index]
        pushed = contact.trait.held == 1 and contact.touching == 1 and contact.solver == COUPLING and contact.push > 0.0
        for side in range(2):
            point = contact.point[side]
            if pushed and point.slot >= 0 and state.objects[point.slot].first == obj.first:
                for k in range(KEPT):
                    moments[k] = 0.0
                force = contact.now.gain * contact.push
                moments[0] = force / state.rate
                n = min(point.modes, len(bent.y1))
                for i in range(n):
                    state.scratch.power[i] += force * shape_at(state, obj, point, i)
                felt = Modes(bent.y1[:n], bent.y2[:n], bent.a1[:n], bent.a2[:n], bent.balance[:n], bent.response)
                inject_kept(felt, point_of(state, obj, point), moments)
                found = True
        index = contact.next
    return found


@kernel
def pressing_force(contact: Contact) -> float:
    """Return the force (N) of a blow or a press that is solved with the modes, as it is now; 0 of other contacts."""
    coupled = contact.coupled
    feels = (contact.trait.lasts == 0 or contact.trait.held == 1) and contact.solver == COUPLING
    if contact.touching == 0 or not feels or coupled.touching == 0:
        return 0.0
    return law(coupled.motion[0], coupled.motion[1] / coupled.period, coupled.k, coupled.mu, coupled.a)


@kernel
def is_pressed(state: State, obj: Object) -> bool:
    """True if a blow or a press bends an object's modes."""
    index, found = obj.contact, False
    while index >= 0:
        found |= pressing_force(state.contacts[index]) > 0.0
        index = state.contacts[index].next
    return found


@noinline_kernel
def retune_bent(state: State, obj: Object, stretch: float, share: float) -> None:
    """Bring the modes of an object to a new tension after a share of the coming sample; their bends as the head of this
    file says."""
    modes = modes_of(state, obj, 0, obj.size)
    allowed = _energy(state, obj, modes) + obj.lent
    _find_bend_now(state, obj)
    bent = in_work(state, modes)
    _add(modes, bent, -1.0)
    swings = _energy(state, obj, modes)
    obj.stretch = stretch
    ring_tensed(state, obj, share)
    obj.retuning = 0
    retune(state, obj, obj.size)
    obj.stale_modes = obj.detuned = 0
    _find_bend_now(state, obj)
    _add(modes, bent, 1.0)
    total = _energy(state, obj, modes)
    if total > allowed:
        # The greatest share s in [0, 1] of a bend at which the energy is allowed, or else that of the least
        # energy. It is swings + s (total - swings - bend) + s^2 bend.
        bend = _energy(state, obj, bent)
        slope = total - swings - bend
        root = slope * slope - 4.0 * bend * (swings - allowed)
        part = (math.sqrt(max(root, 0.0)) - slope) / (2.0 * bend) if bend > 0.0 else 0.0
        kept = min(max(part, 0.0), 1.0)
        _add(modes, bent, kept - 1.0)
        total = _energy(state, obj, modes)
        if total > allowed:
            # Scale the motion of the modes that contacts feel.
            factor = math.sqrt(max(allowed, 0.0) / total)
            for i in range(len(modes.y1)):
                if i < obj.felt or i >= obj.unheard:
                    modes.y1[i] *= factor
                    modes.y2[i] *= factor
            total = allowed
    obj.lent = allowed - total
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        contact.unsettled = 1
        if contact.trait.held == 1:
            # Bring the static output under a press to the modes as they are tuned now: those that have passed the
            # highest frequency answer by another weight.
            force = pressing_force(contact) * contact.now.gain
            for side in range(2):
                point = contact.point[side]
                if point.slot >= 0 and state.objects[point.slot].first == obj.first:
                    for i in range(min(point.modes, obj.bent)):
                        state.scratch.work[i] = shape_at(state, obj, point, i)
                    for channel in range(2):
                        obj.static[channel] -= force * contact.static[side, channel]
                    find_static(state, contact, side, obj, point.modes)
                    for channel in range(2):
                        obj.static[channel] += force * contact.static[side, channel]
        index = contact.next


@kernel
def find_static(state: State, contact: Contact, side: int, obj: Object, count: int) -> None:
    """Put the static output for a push of 1 N on so many modes, whose shapes are in `work`, into `static`."""
    left = right = 0.0
    for i in range(min(count, obj.bent)):
        if i < obj.felt:
            frequency, sigma, weight = ringing_of(state, obj, i)
            weight *= share_of(state, obj, i, frequency)
        else:
            frequency, sigma, weight = relief_of(state, obj, i)
        if frequency > 0.0:
            omega = 2.0 * math.pi * frequency
            heard = state.scratch.work[i] * weight * omega / (omega * omega + sigma * sigma)
            left += heard
            right += heard * state.bank.balance[obj.first + i]
    contact.static[side, 0] = left
    contact.static[side, 1] = right


@kernel
def _find_bend_now(state: State, obj: Object) -> None:
    """Write how an object's modes are bent by the blows and presses on it into `scratch.work`."""
    modes = modes_of(state, obj, 0, obj.size)
    bent, moments = in_work(state, modes), state.scratch.fine
    for i in range(len(modes.y1)):
        bent.y1[i] = bent.y2[i] = 0.0
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        force = pressing_force(contact) * contact.now.gain
        for side in range(2):
            point = contact.point[side]
            if force > 0.0 and point.slot >= 0 and state.objects[point.slot].first == obj.first:
                for k in range(KEPT):
                    moments[k] = 0.0
                moments[0] = force / state.rate
                n = min(point.modes, obj.size)
                felt = Modes(bent.y1[:n], bent.y2[:n], bent.a1[:n], bent.a2[:n], bent.balance[:n], bent.response)
                inject_kept(felt, point_of(state, obj, point), moments)
        index = contact.next
    for i in range(obj.bent, obj.unheard):
        bent.y1[i] = bent.y2[i] = 0.0  # clicks are not retuned
    settle_under(bent)


@kernel
def _add(modes: Modes, bent: Modes, share: float) -> None:
    """Add a share of a bend to modes."""
    for i in range(len(modes.y1)):
        modes.y1[i] += share * bent.y1[i]
        modes.y2[i] += share * bent.y2[i]


@kernel
def _energy(state: State, obj: Object, modes: Modes) -> float:
    """Return the energy (J) of all modes that contacts feel, in `modes` as an object's."""
    weights, begin = state.bank.weight[obj.first : obj.first + obj.size], obj.unheard
    unheard = Modes(
        modes.y1[begin:], modes.y2[begin:], modes.a1[begin:], modes.a2[begin:], modes.balance[begin:], modes.response
    )
    return energy_of(modes, weights, obj.felt) + energy_of(unheard, weights[begin:], obj.size - begin)


@kernel
def ring_tensed(state: State, obj: Object, share: float) -> None:
    """Retune the modes that ring to the tension, after a share of the coming sample."""
    modes = modes_of(state, obj, 0, obj.live)
    for i in range(min(obj.live, obj.felt)):
        frequency, sigma, weight = ringing_of(state, obj, i)
        if frequency > 0.0:
            weigh_anew(state, obj, i, weight)
            ring_from(modes, i, frequency, sigma, state.rate, share)
