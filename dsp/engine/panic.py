"""A panic: every gesture ends, and what sounds fades smoothly, whatever is played from then on.

The modes of an object are free at once. Their ringing is put beside them, with their coefficients, goes on by itself
and fades. A force that acts at that moment dies away (fade.py). A mode answers it by a motion of the same form, and
rings freely about that. Strikers that sound ring on where they are, and fade likewise.
"""

import math

from ..native.jit import kernel
from ..resonator.bank import RESPONSES, Modes, ring
from ..resonator.simd import LANES
from .bodies.objects import shape_at
from .bodies.sheets import uncouple
from .contacts.contact_list import end_contacts
from .memory.order import wake
from .memory.records import Contact, ContactPoint
from .memory.state import QUANTUM, ROLLING, Object, State
from .output.fade import RATES, fade_length, going_on, left_of, pace_of, tilt_of
from .output.mix import is_finite, sides_of
from .output.space_lines import add_voice


@kernel
def let_fade(state: State) -> None:
    """End every gesture, and let what sounds fade."""
    spectral, space = state.spectral, state.surroundings
    if spectral.modes > 0:
        # All that rings in the bank fades there. Its objects are free at once, and are at rest.
        for k in range(state.ringer_count):
            obj = state.objects[state.ringers[k]]
            wake(state, state.ringers[k])
            obj.spectral = obj.live = 0
        state.ringer_count = 0
        if spectral.fading == 0:
            spectral.fading, spectral.faded = 1, 0
    if space.on == 1:
        # So does what is on its way, and the room's late part.
        space.fading, space.faded, space.panicked = 1, 0, state.position
    for i in range(state.active):
        # Put what an object's modes ring aside, together with what may be fading there already, and its modes to rest.
        obj = state.objects[state.order[i]]
        if obj.live != 0:
            bank = state.bank
            left = left_of(state.rate, obj.faded) if obj.fading > 0 else 0.0
            for mode in range(obj.first, obj.first + max(obj.live, obj.fading)):
                fades = mode < obj.first + obj.fading  # else what stands there is of an object that has gone
                bank.fading_y1[mode] = (left * bank.fading_y1[mode] if fades else 0.0) + bank.y1[mode]
                bank.fading_y2[mode] = (left * bank.fading_y2[mode] if fades else 0.0) + bank.y2[mode]
                bank.fading_a1[mode], bank.fading_a2[mode] = bank.a1[mode], bank.a2[mode]
                bank.y1[mode] = bank.y2[mode] = 0.0
            _age(state, obj, left)
            for side in range(2):
                obj.driven[0, side, 0] -= obj.static[side]  # of that, a force that goes on for ever, nothing is heard
                obj.static[side] = obj.static_before[side] = 0.0
            uncouple(state, obj)
            obj.fading = max(obj.live, obj.fading)
            obj.faded = obj.live = 0
    for i in range(state.active):
        index = state.objects[state.order[i]].contact
        while index >= 0:
            contact = state.contacts[index]
            # Make the force on a contact's voice die away in a panic, so that its end makes no sound.
            if contact.voice >= 0:
                voice = state.voices[contact.voice]
                gain = 1.0 if contact.solver == ROLLING else contact.now.gain  # a roll's share holds it
                q, u, v, w = going_on(contact.forces, pace_of(contact.forces, state.rate), state.rate)
                voice.held_ratio, voice.held[0], voice.held[1], voice.held[2] = q, gain * u, gain * v, gain * w
            if contact.touching == 1 and (contact.forces[0] != 0.0 or contact.forces[1] != 0.0):
                for side in range(2):
                    _let_go(state, contact, contact.point[side])
            index = contact.next
    for i in range(state.active):
        # Fade all strikers that sound on an object, in a panic; drop their second pulses.
        index = state.objects[state.order[i]].voice
        while index >= 0:
            voice = state.voices[index]
            voice.snap = 0.0
            voice.roll = -1
            voice.fades = 1
            index = voice.next
        end_contacts(state, state.objects[state.order[i]])


@kernel
def _age(state: State, obj: Object, left: float) -> None:
    """Restart the output of an earlier panic's forces from now, at the share that is left of it."""
    seconds = obj.faded / state.rate
    for k in range(len(RATES)):
        share = left * math.exp(-RATES[k] * seconds)
        for side in range(2):
            value, slope, bend = obj.driven[k, side, 0], obj.driven[k, side, 1], obj.driven[k, side, 2]
            obj.driven[k, side, 0] = share * (value + (slope + bend * seconds) * seconds)
            obj.driven[k, side, 1] = share * (slope + 2.0 * bend * seconds)
            obj.driven[k, side, 2] = share * bend


@kernel
def _let_go(state: State, contact: Contact, point: ContactPoint) -> None:
    """Make a contact's force on the fading modes die away.

    A mode takes the momentum p[n] of a sample and its first moment p'[n] into its state, x[n + 1] = M (x[n] + b p[n] +
    b' p'[n]). For p[n] = q^n (u + v n + w n^2), x is q^n (c + d n + e n^2) and what rings freely, with (q - M) e = M W,
    (q - M) d = M V - 2 q e and (q - M) c = M U - q (d + e), W = b w + b' w' and so on.
    """
    if point.slot < 0:
        return
    bank, obj = state.bank, state.objects[point.slot]
    k = pace_of(contact.forces, state.rate)
    q, u, v, w = going_on(contact.forces, k, state.rate)
    u1, v1, w1 = tilt_of(q, u, v, w)
    for n in range(min(point.modes, obj.fading)):
        i = obj.first + n
        a1, a2 = bank.fading_a1[i], bank.fading_a2[i]
        if a2 == 0.0:
            continue
        at = i // LANES * RESPONSES + i % LANES
        b = bank.response[at], bank.response[at + LANES]
        b1 = bank.response[at + 2 * LANES], bank.response[at + 3 * LANES]
        e = _steady(q, a1, a2, _driven(a1, a2, b, b1, w, w1), (0.0, 0.0))
        d = _steady(q, a1, a2, _driven(a1, a2, b, b1, v, v1), (2.0 * e[0], 2.0 * e[1]))
        c = _steady(q, a1, a2, _driven(a1, a2, b, b1, u, u1), (d[0] + e[0], d[1] + e[1]))
        phi = contact.now.gain * shape_at(state, obj, point, n)
        bank.fading_y1[i] -= c[0] * phi
        bank.fading_y2[i] -= c[1] * phi
        balance = 1.0
        for side in range(2):
            obj.driven[k, side, 0] += c[0] * phi * balance
            obj.driven[k, side, 1] += d[0] * phi * state.rate * balance
            obj.driven[k, side, 2] += e[0] * phi * state.rate * state.rate * balance
            balance = bank.balance[i]


@kernel
def _driven(
    a1: float, a2: float, b: tuple[float, float], b1: tuple[float, float], p: float, p1: float
) -> tuple[float, float]:
    """Return M (b p + b' p')."""
    last, before = b[0] * p + b1[0] * p1, b[1] * p + b1[1] * p1
    return a1 * last + a2 * before, last


@kernel
def _steady(
    q: float, a1: float, a2: float, push: tuple[float, float], less: tuple[float, float]
) -> tuple[float, float]:
    """Solve (q - M) x = push - q less for x."""
    first, second, inverse = push[0] - q * less[0], push[1] - q * less[1], 1.0 / (q * (q - a1) - a2)
    return (q * first + a2 * second) * inverse, (first + (q - a1) * second) * inverse


@kernel
def mix_fading(state: State) -> None:
    """Add what fades to the mix."""
    for i in range(state.active):
        obj = state.objects[state.order[i]]
        if obj.fading > 0:
            # Add what fades of one object to the mix.
            slot = state.order[i]
            bank, obj, voice = state.bank, state.objects[slot], state.scratch.voices[0]
            first, last = obj.first, obj.first + obj.fading
            modes = Modes(
                bank.fading_y1[first:last], bank.fading_y2[first:last],
                bank.fading_a1[first:last], bank.fading_a2[first:last],
                bank.balance[first:last], bank.response[first // LANES * RESPONSES : last // LANES * RESPONSES],
            )  # fmt: skip
            ring(modes, voice, 0, QUANTUM)
            for side in range(sides_of(state)):
                for k in range(len(RATES)):
                    # Add the output of the forces that die away at one of the rates.
                    value, slope, bend = obj.driven[k, side, 0], obj.driven[k, side, 1], obj.driven[k, side, 2]
                    if value != 0.0 or slope != 0.0 or bend != 0.0:
                        for n in range(QUANTUM):
                            seconds = (obj.faded + n + 1) / state.rate
                            voice[side, n] += math.exp(-RATES[k] * seconds) * (
                                value + (slope + bend * seconds) * seconds
                            )
                for n in range(QUANTUM):
                    voice[side, n] *= left_of(state.rate, obj.faded + n + 1)
            state.stats.sounding += obj.energy == 0.0  # else it was counted
            state.stats.live_modes += obj.fading
            if is_finite(state, voice):
                add_voice(state, slot, voice)
            obj.faded += QUANTUM
            if obj.faded >= fade_length(state.rate):
                obj.fading = 0
                _age(state, obj, 0.0)
