"""Modes on their way into the spectral bank and back, and as they are looked at there.

A mode is taken from its state to its amplitude in the middle of the block, and back, by powers of what its state is
multiplied by in a sample: these are as exact as the recursion itself.
"""

import math

from ...native.jit import kernel
from ...numerics.indices import index_of
from ...resonator.bank import state_of
from ...resonator.mode import energy_of
from ...spectral.basis import BINS, CENTRE, FRAMES, MOST_LOSS, RADIUS
from ...spectral.layout import PHASES, Spectral
from ...spectral.places import give_place, number, put_number, take_place
from ...spectral.simd import CHUNK, ROWS
from ..bodies.objects import modes_of, relief_of, ringing_of
from ..memory.order import wake
from ..memory.quality import silence_of
from ..memory.state import QUANTUM, Bank, Object, State
from ..output.mix import sides_of
from .tails import begin_tail

_LOOKED = 256  # modes that are looked at in a quantum, on average
_SOFTEST = 1e-9  # gain (-180 dB) below which an output's gain does not go in the bank
_HUGE = 1e30
_LEAST_A2 = math.exp(-2.0 * MOST_LOSS)  # of -a2
_LEAST_LOSS = 2.0**-21
"""Nepers a block at least of a mode that is kept in float32 (60 dB in 43 hours): rounding raises it by less."""
_POWERS = 10  # squarings that reach the powers that are taken


@kernel
def _is_heard(state: State, obj: Object, i: int, re: float, im: float) -> bool:
    """True if a mode of the bank (its number there) with a state z is louder than silence."""
    weight = max(1.0, abs(state.bank.balance[i])) * max(1.0, obj.place.loudest)
    threshold = 0.25 * silence_of(state)
    return weight * weight * (re * re + im * im) > threshold * threshold


@kernel
def go(state: State, slot: int, turn: int) -> None:
    """Take an object's modes into a phase whose block begins now; those that nobody hears come to rest."""
    obj, bank, spectral = state.objects[slot], state.bank, state.spectral
    for i in range(obj.first, obj.first + obj.live):
        # All modes that are heard must decay slowly enough, and be numbers.
        if bank.a2[i] != 0.0:
            re, im = state_of(bank.y1[i], bank.y2[i], bank.a1[i], bank.a2[i])
            if not re * re + im * im < _HUGE or (-bank.a2[i] < _LEAST_A2 and _is_heard(state, obj, i, re, im)):
                obj.returned_at = state.position
                return
    # The gains of an object's modes at the left and at the right, the first far enough from 0 to be divided by.
    left = obj.place.gain[0]
    right = obj.place.gain[1] if sides_of(state) == 2 else 0.0
    least = _SOFTEST * max(abs(right), _SOFTEST)
    left, right = left if abs(left) > least else least, right
    phase = spectral.phases[turn]
    for i in range(obj.live):
        at = obj.first + i
        if bank.a2[at] != 0.0:
            re, im = state_of(bank.y1[at], bank.y2[at], bank.a1[at], bank.a2[at])
            if _is_heard(state, obj, at, re, im):
                frequency, sigma, _ = ringing_of(state, obj, i) if i < obj.felt else relief_of(state, obj, i)
                theta, loss = 2.0 * math.pi * frequency / state.rate, sigma / state.rate
                b = index_of(theta * BINS / math.pi + 0.5, BINS)
                place = take_place(spectral, phase, b, at, bank.place)
                bank.bin[at] = b
                offset = theta - math.pi * b / BINS
                balance = bank.balance[at] * right / left
                # Write a mode, whose state z it was a sample ago and now begins its block, to its place.
                single = phase.single[b]
                z = complex(re, im) * left
                step = _step(bank, at)
                middle = _power(step, FRAMES // 2)
                c = complex(z.imag, -z.real) * middle * step
                put_number(spectral, single, place, 0, c.real)
                put_number(spectral, single, place, 1, c.imag)
                _put_turn(spectral, single, place, middle * middle)
                put_number(spectral, single, place, 4, (-loss * (FRAMES // 2) - CENTRE) / RADIUS)
                put_number(spectral, single, place, 5, offset * (FRAMES // 2) / RADIUS)
                put_number(spectral, single, place, 6, balance)
        bank.y1[at] = bank.y2[at] = 0.0
    obj.spectral, obj.ringer, obj.returns = 1 + turn, state.ringer_count, 0
    obj.spectral_gain = left
    state.ringers[state.ringer_count] = slot
    state.ringer_count += 1
    obj.energy = 0.0


@kernel
def _put_turn(spectral: Spectral, single: int, place: int, turned: complex) -> None:
    """Write exp(lambda FRAMES) to a mode's place, in float32 so that rounding lets no mode grow."""
    least = _LEAST_LOSS * single
    if turned.real * turned.real + turned.imag * turned.imag > 1.0 - 2.0 * least:
        turned = turned * (1.0 - least)
    put_number(spectral, single, place, 2, turned.real)
    put_number(spectral, single, place, 3, turned.imag)


@kernel
def take_form(state: State, budget: int) -> None:
    """Bring bins into the form, float64 or float32, that is chosen: about `budget` modes at a time."""
    spectral = state.spectral
    if spectral.single != state.choices.bank:
        spectral.single, spectral.unlike = state.choices.bank, PHASES * BINS
    while spectral.unlike > 0 and budget > 0:
        spectral.unlike -= 1
        phase, b = spectral.phases[spectral.unlike // BINS], spectral.unlike % BINS
        if phase.single[b] != spectral.single:
            budget -= phase.used[b]
            # Bring a bin into the form that is chosen. From float32 to float64 its modes ring on as exactly as they
            # are.
            before, single = phase.single[b], spectral.single
            phase.single[b] = single
            for place in range(phase.start[b] * CHUNK, (phase.start[b] + phase.count[b]) * CHUNK):
                for row in range(ROWS):
                    put_number(spectral, single, place, row, number(spectral, before, place, row))
                turned = complex(number(spectral, before, place, 2), number(spectral, before, place, 3))
                if single == 0 and spectral.owner[place] > 0:
                    turned = _power(_step(state.bank, spectral.owner[place] - 1), FRAMES)
                _put_turn(spectral, single, place, turned)


@kernel
def _step(bank: Bank, i: int) -> complex:
    """Return exp(lambda), the factor of a mode's state from sample to sample."""
    cosine = 0.5 * bank.a1[i]
    return complex(cosine, math.sqrt(-bank.a2[i] - cosine * cosine))


@kernel
def _power(base: complex, exponent: int) -> complex:
    """Raise to a power with an exponent from 0 to 1,023, by squaring."""
    result = complex(1.0, 0.0)
    for k in range(_POWERS):
        if exponent >> k & 1:
            result = result * base
        base = base * base
    return result


@kernel
def come_back(state: State, obj: Object) -> None:
    """Bring an object's modes back, as they are at the last sample; what is laid out of them yet is taken out."""
    bank, spectral = state.bank, state.spectral
    phase = spectral.phases[obj.spectral - 1]
    # In the bank is c of the block to come, whose first sample is FRAMES after that of this one.
    rung = state.position - phase.begin
    back = FRAMES + FRAMES // 2 + 1 - rung
    live = 0
    for i in range(obj.live):
        at = obj.first + i
        if bank.place[at] == 0:
            continue
        live = i + 1
        single, place = phase.single[bank.bin[at]], bank.place[at] - 1
        c = complex(number(spectral, single, place, 0), number(spectral, single, place, 1))
        step = _step(bank, at)
        inverse = step.conjugate() * (1.0 / -bank.a2[at])
        z = complex(-c.imag, c.real) * _power(inverse, back) * (1.0 / obj.spectral_gain)
        bank.y1[at] = z.imag
        bank.y2[at] = (z * inverse).imag
        give_place(spectral, phase, bank.bin[at], at, bank.place)
    obj.live = min(obj.live, (live + CHUNK - 1) // CHUNK * CHUNK)
    _forget_ringer(state, obj)
    if rung < FRAMES and obj.live > 0:
        begin_tail(state, obj, phase.begin + FRAMES)
    obj.returned_at = state.position
    if obj.glide > 0.0:
        weights = bank.weight[obj.first : obj.first + obj.live]
        obj.rang = energy_of(modes_of(state, obj, 0, obj.live), weights, obj.felt)


@kernel
def _forget_ringer(state: State, obj: Object) -> None:
    """Take an object off the list of those in the bank."""
    last = state.ringer_count - 1
    moved = state.ringers[last]
    state.ringers[obj.ringer] = moved
    state.objects[moved].ringer = obj.ringer
    state.ringer_count = last
    obj.spectral = obj.returns = 0


@kernel
def look(state: State) -> None:
    """Put modes in the bank to rest that nobody hears any more, object by object in turn."""
    looked = 0
    if state.ringer_count == 0:
        state.looked_at = state.to_look_at = 0
    state.to_look_at = min(state.to_look_at + _LOOKED, _LOOKED)
    while state.to_look_at > 0 and looked < state.ringer_count:
        state.looked_at = (state.looked_at + 1) % state.ringer_count
        slot = state.ringers[state.looked_at]
        state.to_look_at -= state.objects[slot].live
        looked += 1
        # Measure what an object in the bank sounds, and put its silent modes to rest; without any, it is at rest.
        obj, bank, spectral = state.objects[slot], state.bank, state.spectral
        phase = spectral.phases[obj.spectral - 1]
        gain = obj.spectral_gain
        live, energy = 0, 0.0
        for i in range(obj.live):
            at = obj.first + i
            if bank.place[at] == 0:
                continue
            single, place = phase.single[bank.bin[at]], bank.place[at] - 1
            re, im = number(spectral, single, place, 0), number(spectral, single, place, 1)
            balance = number(spectral, single, place, 6)
            if _is_heard(state, obj, at, re / gain, im / gain):
                live = i + 1
                energy += 0.5 * QUANTUM * (re * re + im * im) * (1.0 + balance * balance)
            else:
                give_place(spectral, phase, bank.bin[at], at, bank.place)
        obj.live = min(obj.live, (live + CHUNK - 1) // CHUNK * CHUNK)
        obj.energy = energy
        if live == 0:
            wake(state, slot)
            _forget_ringer(state, obj)
