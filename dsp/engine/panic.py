"""A panic: every gesture ends, and what sounds fades smoothly, whatever is played from then on.

The modes of an object are free at once. What they rang is put beside them, with their coefficients, rings on by itself
and fades. A force that acts at that moment dies away (fade.py). A mode answers it by a motion of the same form, and
rings freely about that. Strikers that sound ring on where they are, and fade likewise.
"""

import math

from ..native.jit import kernel
from ..resonator.bank import RESPONSES, Modes, ring
from ..resonator.simd import LANES
from .contact_list import end_contacts
from .fade import RATES, fade_length, going_on, left_of, pace_of, tilt_of
from .mix import add_share, is_finite, sides_of
from .objects import shape_at
from .state import QUANTUM
from .strikers import fade_voices, let_voice_go


@kernel
def let_fade(state):
    """End every gesture, and let what sounds fade."""
    for i in range(state.active):
        _set_aside(state, state.objects[state.order[i]])
    for i in range(state.active):
        index = state.objects[state.order[i]].contact
        while index >= 0:
            contact = state.contacts[index]
            let_voice_go(state, contact)
            if contact.touching == 1 and (contact.force != 0.0 or contact.force_before != 0.0):
                for side in range(2):
                    _let_go(state, contact, contact.point[side])
            index = contact.next
    for i in range(state.active):
        fade_voices(state, state.objects[state.order[i]])
        end_contacts(state, state.objects[state.order[i]])


@kernel
def _set_aside(state, obj):
    """Put what an object's modes ring aside, together with what may be fading there already, and its modes to rest."""
    if obj.live == 0:
        return
    bank = state.bank
    left = left_of(state.rate, obj.faded) if obj.fading > 0 else 0.0
    for i in range(obj.first, obj.first + max(obj.live, obj.fading)):
        before = left if i < obj.first + obj.fading else 0.0
        bank.fading_y1[i] = before * bank.fading_y1[i] + bank.y1[i]
        bank.fading_y2[i] = before * bank.fading_y2[i] + bank.y2[i]
        bank.fading_a1[i], bank.fading_a2[i] = bank.a1[i], bank.a2[i]
        bank.y1[i] = bank.y2[i] = 0.0
    _age(state, obj, left)
    for side in range(2):
        obj.driven[0, side, 0] -= obj.static[side]  # of that, a force that goes on for ever, nothing is heard
        obj.static[side] = obj.static_before[side] = 0.0
    obj.fading = max(obj.live, obj.fading)
    obj.faded = obj.live = 0


@kernel
def _age(state, obj, left):
    """Let the output of an earlier panic's forces begin now, at a share that is left of it."""
    seconds = obj.faded / state.rate
    for k in range(len(RATES)):
        share = left * math.exp(-RATES[k] * seconds)
        for side in range(2):
            obj.driven[k, side, 0] = share * (obj.driven[k, side, 0] + obj.driven[k, side, 1] * seconds)
            obj.driven[k, side, 1] *= share


@kernel
def _let_go(state, contact, point):
    """Let a contact's force on the modes that fade die away.

    A mode takes the momentum p[n] of a sample and its first moment p'[n] into its state, x[n + 1] = M (x[n] + b p[n] +
    b' p'[n]). For p[n] = q^n (u + v n), x is q^n (c + d n) and what rings freely, with (q - M) d = M (b v + b' v') and
    (q - M) c = M (b u + b' u') - q d.
    """
    if point.slot < 0:
        return
    bank, obj = state.bank, state.objects[point.slot]
    k = pace_of(contact.force, (contact.force - contact.force_before) * state.rate)
    q, u, v = going_on(contact.force, contact.force_before, k, state.rate)
    tilt, tilting = tilt_of(q, u, v)
    for n in range(min(point.modes, obj.fading)):
        i = obj.first + n
        a1, a2 = bank.fading_a1[i], bank.fading_a2[i]
        if a2 == 0.0:
            continue
        at = i // LANES * RESPONSES + i % LANES
        last, before = bank.response[at], bank.response[at + LANES]
        turned, turned_before = bank.response[at + 2 * LANES], bank.response[at + 3 * LANES]
        u2, u1 = u * last + tilt * turned, u * before + tilt * turned_before  # b u + b' u'
        v2, v1 = v * last + tilting * turned, v * before + tilting * turned_before
        phi, inverse = contact.now.gain * shape_at(state, obj, point, n), 1.0 / (q * (q - a1) - a2)
        first, second = a1 * v2 + a2 * v1, v2
        d1, d2 = (q * first + a2 * second) * inverse, (first + (q - a1) * second) * inverse
        first, second = a1 * u2 + a2 * u1 - q * d1, u2 - q * d2
        c1, c2 = (q * first + a2 * second) * inverse, (first + (q - a1) * second) * inverse
        bank.fading_y1[i] -= c1 * phi
        bank.fading_y2[i] -= c2 * phi
        balance = 1.0
        for side in range(2):
            obj.driven[k, side, 0] += c1 * phi * balance
            obj.driven[k, side, 1] += d1 * phi * state.rate * balance
            balance = bank.balance[i]


@kernel
def mix_fading(state):
    """Add what fades to the mix."""
    for i in range(state.active):
        obj = state.objects[state.order[i]]
        if obj.fading > 0:
            _mix(state, state.order[i])


@kernel
def _add_driven(state, obj, k, side, voice):
    """Add the output of the forces that die away at one of the rates."""
    value, slope = obj.driven[k, side, 0], obj.driven[k, side, 1]
    if value == 0.0 and slope == 0.0:
        return
    for n in range(QUANTUM):
        seconds = (obj.faded + n + 1) / state.rate
        voice[side, n] += math.exp(-RATES[k] * seconds) * (value + slope * seconds)


@kernel
def _mix(state, slot):
    """Add what fades of one object to the mix."""
    bank, obj, voice = state.bank, state.objects[slot], state.scratch.voices[0]
    first, last = obj.first, obj.first + obj.fading
    modes = Modes(
        bank.fading_y1[first:last], bank.fading_y2[first:last], bank.fading_a1[first:last], bank.fading_a2[first:last],
        bank.balance[first:last], bank.response[first // LANES * RESPONSES : last // LANES * RESPONSES],
    )  # fmt: skip
    ring(modes, voice, 0, QUANTUM)
    for side in range(sides_of(state)):
        for k in range(len(RATES)):
            _add_driven(state, obj, k, side, voice)
        for n in range(QUANTUM):
            voice[side, n] *= left_of(state.rate, obj.faded + n + 1)
    state.stats.sounding += obj.energy == 0.0  # else it was counted
    state.stats.live_modes += obj.fading
    if is_finite(state, voice):
        add_share(state, slot, voice)
    obj.faded += QUANTUM
    if obj.faded >= fade_length(state.rate):
        obj.fading = 0
        _age(state, obj, 0.0)
