"""The laws of the macros that change a body: how its modes go, as logarithms of base 2.

In another size a body is similar to itself: the laws are those of `similar.py`. In another material a body of one
geometry has the same shapes; its frequencies go with the wave speed c = sqrt(E/rho), its masses with the density, what
it radiates with c/rho, and its material takes what it takes at the new frequencies. Where the shear or Poisson's ratio
matters, a body is made anew of the other material, and each mode goes to its counterpart.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import reduce
from typing import NamedTuple

import numpy as np

from ..numerics.constants import HAND, NEUTRAL
from ..numerics.constants import MACRO_NODES as NODES
from .material import Array, Indices, Material
from .modes import Modes

_OCTAVES = 2.0
"""From the middle of the size to its ends: a quarter, and four times."""
_COAT = 0.01
"""Loss factor at 1 kHz that is added at the dark end; it goes with the frequency: T60 of 0.2 s at 1 kHz, 2.4 s at
300 Hz."""
_CLEARER = 7.0
"""By so much more than as it was a mode far above 1 kHz rings at the bright end."""
_LONGER = 2.0
"""Octaves by which decay times grow at the free end."""
_HELD = 60.0
"""1/s that a hand takes at the other: T60 of 0.1 s."""
_KILOHERTZ = 1000.0
_MOST = 10.0
"""Octaves: +-60 dB, of a mode's sound."""
_GONE = -10.0
"""The same of a mode that the other body of a morph has not."""
_UNLIKE, _APART = 2.0, 1.0
"""Octaves that shapes without anything in common count as, and by which no two counterparts differ."""
_LEAST = 1e-12
"""Of shapes and pressures: less is taken for it, as it is for the logarithm."""


class Change(NamedTuple):
    """How far a body's modes go: frequency, decay and sound of each (3, n), in octaves.

    amplitude: of all shapes; pitch: of the frequencies on the whole, which is that of what is felt alone, too; loss,
    sound: the same of these; stiffness: of a plate's stretching.
    """

    modes: Array
    amplitude: float
    pitch: float
    loss: float
    sound: float
    stiffness: float

    @property
    def click(self) -> float:
        """Octaves of what sounds as the whole body is moved, beside `amplitude`: air that it moves, over its mass."""
        size = self.amplitude + self.pitch - 0.5 * self.stiffness
        return 3.0 * size + self.amplitude


def _change(own: Modes, frequency: Array, decay: Array, sound: Array | float, amplitude: float, more: float) -> Change:
    """Return the change to frequencies (Hz) and decays (1/s); sound: octaves; more: of stiffness, beside what pitch and
    amplitude say."""
    pitches = np.log2(frequency / own.frequency)
    losses = np.log2(decay / np.maximum(own.decay, _LEAST))
    sounds = np.broadcast_to(sound, pitches.shape)
    pitch, loss, heard = (float(each.mean()) if each.size else 0.0 for each in (pitches, losses, sounds))
    stiffness = 2.0 * (pitch + amplitude) + more
    return Change(np.array([pitches, losses, sounds]), amplitude, pitch, loss, heard, stiffness)


def places() -> list[float]:
    """Return the values of a macro at which a body is known."""
    return [node / (NODES - 1) for node in range(NODES)]


def size_at(value: float) -> float:
    """Return the size at a value of its macro."""
    return float(2.0 ** (2.0 * _OCTAVES * (value - NEUTRAL)))


def sized(own: Modes, material: Material | None, value: float) -> Change:
    """Return the change to the size at a value."""
    size = size_at(value)
    frequency, octaves = own.frequency / size, math.log2(size)
    taken = _taken(own, material)
    decay = (own.decay - taken) / size
    if material is not None:
        decay = decay + taken * material.decay(frequency) / np.maximum(material.decay(own.frequency), _LEAST)
    return _change(own, frequency, decay, -0.5 * octaves, -1.5 * octaves, -2.0 * octaves)


def _taken(own: Modes, material: Material | None) -> Array:
    """Return what the material takes of the decay (1/s) of each mode."""
    if material is None:
        return np.zeros_like(own.decay)
    return own.decay if material.losses == "measured" else np.minimum(material.decay(own.frequency), own.decay)


def brightened(own: Modes, material: Material | None, value: float) -> Change:
    """Return the change to the brightness at a value: a loss that goes with the frequency's square, or the losses
    without a part that grows with the frequency."""
    along, f = 2.0 * (value - NEUTRAL), own.frequency
    if along < 0.0:
        decay = own.decay + math.pi * _COAT * along * along * f * f / _KILOHERTZ
    else:
        decay = own.decay / (1.0 + _CLEARER * along * f / (f + _KILOHERTZ))
    return _change(own, f, decay, 0.0, 0.0, 0.0)


def damped(own: Modes, material: Material | None, value: float) -> Change:
    """Return the change to the damping at a value."""
    along = 2.0 * (value - NEUTRAL)
    decay = own.decay * 2.0 ** (_LONGER * along) if along < 0.0 else own.decay + _HELD * along * along
    return _change(own, own.frequency, decay, 0.0, 0.0, 0.0)


LAWS: dict[str, Callable[[Modes, Material | None, float], Change]] = {
    "size": sized, "brightness": brightened, "damping": damped,
}  # fmt: skip
"""The laws of macros that need no more than a body and its material, by name."""


def between(one: Material, other: Material, share: float) -> Material:
    """Return a material a share of the way from one to another: density, moduli and losses go by equal ratios."""

    def ratio(of: Callable[[Material], float]) -> float:
        first, last = (max(of(each), _LEAST) for each in (one, other))
        return float(first * (last / first) ** share)

    def line(of: Callable[[Material], float]) -> float:
        return of(one) + share * (of(other) - of(one))

    if share in (0.0, 1.0):
        return (one, other)[int(share)]
    return replace(
        one, name=f"{one.name}-{other.name}", density=ratio(lambda each: each.density),
        youngs_modulus=ratio(lambda each: each.youngs_modulus), shear=ratio(lambda each: each.shear_modulus),
        across=ratio(lambda each: each.dented_modulus), poisson_ratio=line(lambda each: each.poisson_ratio),
        alpha=ratio(lambda each: each.alpha), beta=line(lambda each: each.beta),
        loss_factor=ratio(lambda each: each.loss_factor), loss_exponent=line(lambda each: each.loss_exponent),
        dissipation=line(lambda each: each.dissipation),
    )  # fmt: skip


def apart(one: Material, other: Material) -> float:
    """Return how far two materials differ: octaves of wave speed, of density, and of losses at 1 kHz by a third."""
    speeds, densities = _ratios(one, other)
    losses = float(other.decay(_KILOHERTZ) / one.decay(_KILOHERTZ))
    return abs(math.log2(speeds)) + abs(math.log2(densities)) + abs(math.log2(losses)) / 3.0


def _ratios(one: Material, other: Material) -> tuple[float, float]:
    """Return the ratios of wave speeds and densities."""
    density = other.density / one.density
    return math.sqrt(other.youngs_modulus / one.youngs_modulus / density), density


def of_material(
    own: Modes, material: Material, other: Material, anew: Modes | None = None, tense: bool = False
) -> Change:
    """Return the change to another material; anew: the body that was made of it, if it was; tense: of a membrane, whose
    waves go by its tension and not by its stiffness."""
    speed, density = _ratios(material, other)
    speed = density**-0.5 if tense else speed
    amplitude = -0.5 * math.log2(density)
    frequency, taken = own.frequency * speed, _taken(own, material)
    decay = (own.decay - taken) * speed / density
    decay = decay + taken * other.decay(frequency) / np.maximum(material.decay(own.frequency), _LEAST)
    sound = np.full(frequency.size, amplitude + math.log2(speed))
    if anew is not None:
        pair = _counterparts(own, anew, speed)
        has = np.flatnonzero(pair >= 0)
        to = pair[has]
        frequency[has], decay[has] = anew.frequency[to], anew.decay[to]
        louder = _octaves(_loudness(anew)[to], _loudness(own)[has])
        moves = _octaves(_moves(anew)[to], _moves(own)[has])
        sound[has] = np.clip(louder + moves - amplitude, -_MOST, _MOST)
    return _change(own, frequency, decay, sound, amplitude, 0.0)


def morphed(own: Modes, position: float, other: Modes, other_position: float) -> Change:
    """Return the change to another body of the family: mode for mode, by their order.

    What a blow at either's own position makes of each mode is the other's. Modes that the other has not fade.
    """
    count = min(own.frequency.size, other.frequency.size)
    order, to = (np.argsort(each.frequency, kind="stable") for each in (own, other))
    frequency, decay = own.frequency.copy(), own.decay.copy()
    amplitude = 0.5 * math.log2(own.mass / other.mass)
    sound = np.full(frequency.size, _GONE)
    has, to = order[:count], to[:count]
    frequency[has], decay[has] = other.frequency[to], other.decay[to]
    frequency[order[count:]] *= frequency[order[count - 1]] / own.frequency[order[count - 1]]
    there, here = _blow(other, other_position)[to], _blow(own, position)[has]
    sound[has] = np.clip(_octaves(there, here) - amplitude, -_MOST, _MOST)
    return _change(own, frequency, decay, sound, amplitude, 0.0)


def retuned(own: Modes, tune: float, decay: float, damp: float) -> Modes:
    """Return a body's modes as an object's settings have them: ratios of frequencies and of decay times, and a hand."""
    return replace(own, frequency=own.frequency * tune, decay=own.decay / decay + HAND * damp * damp)


def share_of(change: Change, share: float) -> Change:
    """Return a share of a change."""
    modes, amplitude, pitch, loss, sound, stiffness = change
    return Change(share * modes, share * amplitude, share * pitch, share * loss, share * sound, share * stiffness)


def sum_of(one: Change, other: Change) -> Change:
    """Return both changes together."""
    return Change(
        one.modes + other.modes, one.amplitude + other.amplitude, one.pitch + other.pitch, one.loss + other.loss,
        one.sound + other.sound, one.stiffness + other.stiffness,
    )  # fmt: skip


def _octaves(one: Array, other: Array) -> Array:
    return np.asarray(np.log2(np.maximum(one, _LEAST) / np.maximum(other, _LEAST)))


def _loudness(body: Modes) -> Array:
    return np.asarray(np.sqrt(np.mean(body.pressure**2, axis=0)))


def _moves(body: Modes) -> Array:
    return np.asarray(np.sqrt(np.mean(body.along**2, axis=0)))


def _blow(body: Modes, position: float) -> Array:
    """Return how loud a blow of 1 N s at a position makes each mode (Pa)."""
    found: Array = _loudness(body) * np.abs(_rows(body.along, np.array([position]))[0])
    return found


def _rows(along: Array, at: Array) -> Array:
    """Return shapes at positions, along lines between those that are known."""
    place = at * (len(along) - 1)
    first = np.clip(place.astype(int), 0, max(len(along) - 2, 0))
    last = np.minimum(first + 1, len(along) - 1)
    found: Array = along[first] + (place - first)[:, None] * (along[last] - along[first])
    return found


def _counterparts(own: Modes, other: Modes, speed: float) -> Indices:
    """Return the number of each mode's counterpart on a body of the same geometry, -1 where there is none: the one most
    like it in shape and frequency that no lower mode has."""
    rows = _rows(other.along, np.linspace(0.0, 1.0, len(own.along)))
    alike = np.abs((own.along / (np.linalg.norm(own.along, axis=0) + _LEAST)).T
        @ (rows / (np.linalg.norm(rows, axis=0) + _LEAST)))  # fmt: skip
    away = np.abs(np.log2(other.frequency)[None] - np.log2(own.frequency * speed)[:, None])
    cost = away + _UNLIKE * (1.0 - alike)
    found = np.full(own.frequency.size, -1)
    for i in np.argsort(own.frequency, kind="stable"):
        j = int(np.argmin(cost[i]))
        if cost[i, j] < _APART:
            found[i] = j
            cost[:, j] = math.inf
    return found


def changed(own: Modes, changes: list[Change]) -> Modes:
    """Return a body with changes that add up, as contacts and ears find it."""
    whole = reduce(sum_of, changes)
    pitch, loss, sound = np.exp2(whole.modes)
    amplitude = whole.amplitude
    unheard = own.unheard and own.unheard._replace(
        frequency=own.unheard.frequency * 2.0**whole.pitch,
        strike=own.unheard.strike * 2.0**amplitude,
    )
    clicks = tuple(each._replace(strength=each.strength * 2.0 ** (whole.click + amplitude)) for each in own.clicks)
    return replace(
        own, clicks=clicks, frequency=own.frequency * pitch, decay=own.decay * loss, pressure=own.pressure * sound,
        strike=own.strike * 2.0**amplitude, mass=own.mass * 4.0**-amplitude, unheard=unheard,
    )  # fmt: skip
