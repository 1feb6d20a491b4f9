"""An object as contacts see it: where it is touched, how its modes decay, how far it can swing."""

import math

from ...native.jit import kernel
from ...native.typed import View
from ...numerics.constants import HAND, RELIEF_DAMPING
from ...numerics.indices import index_of
from ...resonator.bank import RESPONSES, Modes, Point, reach, state_of, top_of
from ...resonator.mode import mode_energy, recurring
from ...resonator.simd import LANES
from ..memory.capacity import DIRECTED
from ..memory.quality import silence_of
from ..memory.records import ContactPoint
from ..memory.state import Object, State

_STILL = 1e-5  # of silence, of what is sensed
TURN = math.sqrt(1.0 - RELIEF_DAMPING * RELIEF_DAMPING)
"""Of a relief, and of a mode that is tuned too high to be heard: its frequency in its natural frequency."""
TAMED = 2.0 * math.pi * RELIEF_DAMPING / TURN
"""The decay (1/s) of the same for each Hz."""
GONE = 0.35  # of a relief's frequency, where the middle of its modes lies an octave above the highest there is
_FADE = 500.0  # 1/s: decay added to a mode that was tuned above the Nyquist share
_MUTED = 2.0**-200  # of a mode's weight while it is only felt: a power of two, so that it comes back to the bit
_FAINTEST = 1e-30  # no mode has a weight below (runtime/plan.py) that is not muted
_HEAVIEST = 10.0  # of a mode's decay a sample, in nepers: it is gone in one, and more only costs digits


@kernel
def place(point: ContactPoint, position: float, obj: Object) -> None:
    """Find rows and weights of the cubic through the mode shapes at a position in [0, 1]."""
    x = position * (obj.rows - 1)
    row = index_of(x - 1.0, obj.rows - 3)
    point.row = row
    weigh(point.weights, x - row, obj.amplitude)


@kernel
def weigh(weights: View[float], x: float, amplitude: float) -> None:
    """Set the weights of the cubic through four rows at x in rows from the first, times an amplitude."""
    weights[0] = -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0
    weights[1] = 0.5 * x * (x - 2.0) * (x - 3.0)
    weights[2] = -0.5 * x * (x - 1.0) * (x - 3.0)
    weights[3] = x * (x - 1.0) * (x - 2.0) / 6.0
    if amplitude != 1.0:
        for n in range(4):
            weights[n] *= amplitude


@kernel
def is_felt(obj: Object, i: int) -> bool:
    """True if contacts feel an object's mode i."""
    return i < obj.felt or i >= obj.unheard


@kernel
def pitch_of(obj: Object) -> float:
    """Return the factor on an object's frequencies: as it is tuned and as tense as it is now."""
    return obj.settings.tune * math.sqrt(1.0 + obj.stretch)


@kernel
def frequency_of(state: State, obj: Object, i: int) -> float:
    """Return the frequency (Hz) of an object's mode i as it is now; of one that is stretched by its own ringing too
    (mode.py), where nothing is pressed on the object."""
    at = obj.first + i
    frequency = state.bank.frequency[at] * obj.settings.tune
    if obj.stretch == 0.0:
        return frequency
    if obj.deflection > 0.0:
        return frequency * math.sqrt(1.0 + obj.stretch)
    bank = state.bank
    energy = mode_energy(bank.y1[at], bank.y2[at], bank.a1[at], bank.a2[at], bank.weight[at]) / obj.amplified
    own = 0.5 * obj.glide * energy
    return frequency * math.sqrt(1.0 + obj.stretch + min(own, 0.5 * obj.stretch))


@kernel
def sigma_of(state: State, obj: Object, i: int) -> float:
    """Return the decay (1/s) of an object's mode i as it is now, with hands on it."""
    at, hand = obj.first + i, HAND * obj.settings.damp * obj.settings.damp
    return min(state.bank.sigma[at] / obj.settings.decay + hand + state.bank.held[at], _HEAVIEST * state.rate)


@kernel
def highest_of(state: State) -> float:
    """Return the frequency (Hz) above which modes are silent."""
    return top_of(state.rate)


@kernel
def least_heard(state: State, obj: Object) -> float:
    """Return the output amplitude of an object's modes below which nobody hears or senses them."""
    return silence_of(state) * (1.0 if obj.sensors == 0 else _STILL)


@kernel
def is_heard(state: State, obj: Object, begin: int, end: int, threshold: float) -> bool:
    """True if one of the bank's modes from `begin` up to `end`, all an object's, is louder than a threshold."""
    bank = state.bank
    for i in range(begin, end):
        if bank.a2[i] != 0.0:
            re, im = state_of(bank.y1[i], bank.y2[i], bank.a1[i], bank.a2[i])
            weight = max(1.0, abs(bank.balance[i])) * max(1.0, obj.place.loudest)
            if weight * weight * (re * re + im * im) > threshold * threshold:
                return True
    return False


@kernel
def relief_of(state: State, obj: Object, i: int) -> tuple[float, float, float]:
    """Return the frequency (Hz), decay (1/s) and weight of an object's mode i, a relief (see runtime/relief.py), as it
    is now.

    It follows the pitch, up to the highest frequency there is, where it answers slow forces as it would above. Where
    the modes that it belongs to are silent, it is.
    """
    pitch = pitch_of(obj)
    frequency = state.bank.frequency[obj.first + i] * pitch
    share = min(1.0, highest_of(state) / max(frequency, 1e-9))
    weight = state.bank.weight[obj.first + i] * share if share > GONE or obj.reshaped >= 0 else 0.0
    return frequency * share, state.bank.sigma[obj.first + i] * pitch * share, weight


@kernel
def ringing_of(state: State, obj: Object, i: int) -> tuple[float, float, float]:
    """Return frequency (Hz), decay (1/s) and weight of the answer to forces of mode i of an object, as it rings now.

    A mode that is tuned above `highest_of` is felt and not heard: its weight is next to nothing as long as it is there.
    It rings as high as the bank can have it, as do those that are felt alone (runtime/unheard.py), but fades, as the
    spectral bank drops it. Nothing excites such a mode of a plate whose modes can be coupled. A mode that macros have
    brought there does not ring: it is damped as its relief is, and answers slow forces as before (`share_of`), so that
    the relief has what it takes away; blows feel it less exactly.
    """
    frequency, sigma = frequency_of(state, obj, i), sigma_of(state, obj, i)
    weight, highest = state.bank.weight[obj.first + i], highest_of(state)
    weight = weight / _MUTED if abs(weight) < _FAINTEST else weight
    if i >= obj.unheard:
        return recurring(frequency, 0.5 * state.rate), sigma, weight
    if frequency <= highest:
        return frequency, sigma, weight
    if obj.reshaped >= 0:
        return highest, TAMED * highest, weight / TURN
    if obj.sheet >= 0:
        return highest, sigma + _FADE, 0.0
    return recurring(frequency, 0.5 * state.rate), sigma + _FADE, _MUTED * weight


@kernel
def weigh_anew(state: State, obj: Object, i: int, weight: float) -> None:
    """Scale the samples of an object's mode i to a weight that `ringing_of` says: it keeps its energy."""
    at, bank = obj.first + i, state.bank
    if weight == 0.0 or weight == bank.weight[at] or obj.reshaped >= 0:
        return
    factor = _MUTED if abs(weight) < abs(bank.weight[at]) else 1.0 / _MUTED
    bank.weight[at] = weight
    bank.y1[at] *= factor
    bank.y2[at] *= factor


@kernel
def share_of(state: State, obj: Object, i: int, frequency: float) -> float:
    """Return the share of its shape by which an object's mode i is felt that rings at a frequency (Hz): at another one
    than its own it yields as far as there."""
    own, tamed = frequency_of(state, obj, i), i < obj.felt and obj.reshaped >= 0
    return (frequency / TURN if tamed else frequency) / own if frequency != own else 1.0


@kernel
def modes_of(state: State, obj: Object, begin: int, end: int) -> Modes:
    """Return an object's modes from number `begin` up to `end`, both multiples of LANES."""
    bank = state.bank
    first, last = obj.first + begin, obj.first + end
    return Modes(
        bank.y1[first:last], bank.y2[first:last], bank.a1[first:last], bank.a2[first:last], bank.balance[first:last],
        bank.response[first // LANES * RESPONSES : last // LANES * RESPONSES],
    )  # fmt: skip


@kernel
def shapes_of(state: State, obj: Object) -> View[float]:
    """Return an object's table of mode shapes, flat: the rows along its strike path, then those of its surface."""
    return state.bank.shape[obj.table : obj.surface]


@kernel
def point_of(state: State, obj: Object, point: ContactPoint) -> Point:
    """Return the point of an object that a record of POINT says."""
    return shapes_at(state, obj, point.row, point.weights, point.directed)


@kernel
def shapes_at(state: State, obj: Object, row: int, weights: View[float], directed: int) -> Point:
    """Return the point of an object at four rows, or with the shapes of a contact that has a direction there."""
    if directed > 0:
        return Point(state.directed[(directed - 1) * DIRECTED : directed * DIRECTED], 0, 0, weights)
    return Point(shapes_of(state, obj), obj.size, row, weights)


@kernel
def reach_of(state: State, obj: Object, point: ContactPoint) -> tuple[float, float, float]:
    """Return bounds of the object's motion where it is touched: displacement (m), velocity (m/s) and acceleration
    (m/s^2)."""
    distance, speed, change = reach(modes_of(state, obj, 0, obj.live), point_of(state, obj, point), state.scratch.work)
    return distance, speed, change * state.rate


@kernel
def shape_at(state: State, obj: Object, point: ContactPoint, i: int) -> float:
    """Return the mass-normalised shape of the object's mode i where the contact is, kg^-1/2."""
    if point.directed > 0:
        return point.weights[0] * state.directed[(point.directed - 1) * DIRECTED + i]
    at = obj.table + point.row * obj.size + i
    phi = 0.0
    for n in range(4):
        phi += point.weights[n] * state.bank.shape[at + n * obj.size]
    return phi
