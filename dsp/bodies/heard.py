"""Modes as they are heard: their load by the air, their sound pressure, their places in the stereo image."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .air import IMPEDANCE, Load
from .material import Array, Indices, Material
from .modes import MOST_MODES, Modes, read_only, selected

BAFFLES = ("free", "wall", "closed")
"""free: the air moves around the edge from one side to the other. wall: in a wall, both sides radiate, one is heard.
closed: in a wall and closed behind, one side radiates."""

_LEAST_MASS = -0.5  # of the air: a cavity's stiffness counts as less than none, but never makes a mode unstable
_SETTLED = 3e-3  # of a frequency: the load does not change much over this
_GOLDEN = (math.sqrt(5) - 1) / 2
_BLOW = 5e-4  # s: between the 0.05 ms of a steel ball on glass and the 5 ms of a finger, as a geometric mean


class Loaded(NamedTuple):
    """Modes in air: frequencies (Hz), resistances (1/s) and, for the air's mass, what their shapes shrink by, (n,)."""

    frequency: Array
    resistance: Array
    shrinking: Array


def loaded(frequency: Array, load: Callable[[Array], Load], guess: Array) -> Loaded:
    """Return the air's load on modes that have these frequencies (Hz) without air; `load` gives it for frequencies in
    air.

    guess (n,): about its mass. The mass mu lowers the frequency by sqrt(1 + mu), and shapes and resistances are those
    of the greater modal mass. One mode's load on another is left out.
    """
    now = frequency / np.sqrt(1 + guess)
    found = load(now)
    mass = np.maximum(found.mass, _LEAST_MASS)
    if np.any(np.abs(frequency / np.sqrt(1 + mass) - now) > _SETTLED * now):
        found = load(frequency / np.sqrt(1 + mass))
        mass = np.maximum(found.mass, _LEAST_MASS)
    return Loaded(frequency / np.sqrt(1 + mass), found.resistance / (1 + mass), 1 / np.sqrt(1 + mass))


def heard(
    material: Material,
    frequency: Array,
    resistance: Array,
    shapes: tuple[Array, Array],
    mass: float,
    passed_on: Array | None = None,
) -> Modes:
    """Return the modes of a body in air; shapes: those along the strike path, and those (n,) of which the sign is
    heard.

    The power that a mode radiates, or passes on to what radiates for it (passed_on, 1/s as the resistance), adds to the
    losses of its material, unless these were measured with it. Then it is in them, and no more than them.
    """
    decay = material.decay(frequency)
    if material.losses == "material":
        decay = decay + (resistance if passed_on is None else passed_on) / 2
    strike, sign = shapes
    return Modes(
        frequency=frequency,
        decay=decay,
        strike=strike,
        pressure=pressure(np.minimum(resistance, 2 * decay), sign),
        mass=mass,
    )


def pressure(resistance: Array, sign: Array) -> Array:
    """Return the sound pressure (2, n) at 1 m per unit modal velocity, alike on both sides: G = sqrt(rho c R/(4
    pi))."""
    size = np.sqrt(IMPEDANCE * resistance / (4 * math.pi))
    one = np.where(sign < 0, -size, size)
    return np.array([one, one])


class Best(NamedTuple):
    """The modes that an object keeps, in a stereo image of a width (0 to 1): at most `most` (None: all), those that a
    blow of 0.5 ms where each moves most makes radiate most.

    By (G phi)^2/sigma/(1 + (2 f t)^2)^2: a half sine of force that lasts t has this spectrum, but for its zeros.
    """

    width: float
    most: int | None = None

    def among(self, frequency: Array, pressure: Array, largest: Array, decay: Array) -> tuple[Indices, Array]:
        """Return which of a body's modes are kept, ascending, and their sound pressures (2, k) in the image; largest
        (n,): how far each moves where it moves most."""
        sides = pressure * _sides(decay.size, self.width)
        if self._are_all(decay.size):
            return np.arange(decay.size), sides
        heard = (sides**2).sum(axis=0) * largest**2 / decay / (1 + (2 * _BLOW * frequency) ** 2) ** 2
        keep = np.sort(np.argsort(-heard, kind="stable")[: self.most])
        return keep, sides[:, keep]

    def of(self, modes: Modes) -> Modes:
        """Return a body with the modes that are kept."""
        if self._are_all(modes.decay.size):
            return replace(modes, pressure=modes.pressure * _sides(modes.decay.size, self.width))
        keep, pressure = self.among(modes.frequency, modes.pressure, largest(modes.strike), modes.decay)
        return replace(selected(modes, keep), pressure=pressure)

    def _are_all(self, count: int) -> bool:
        return self.most is None or count <= self.most


def largest(strike: Array) -> Array:
    """Return how far shapes (P, n) go at most, (n,)."""
    found: Array = np.maximum(strike.max(axis=0), -strike.min(axis=0))
    return found


def _sides(count: int, width: float) -> Array:
    """Return the factors (2, count) that place modes in the image, between -width and width, by equal power.

    The places follow the golden ratio, so that neighbours lie apart and a mode's place does not depend on the others.
    """
    return _all_sides(math.ceil(count / MOST_MODES) * MOST_MODES, width)[:, :count]


@lru_cache(maxsize=64)  # 16 kB each
def _all_sides(count: int, width: float) -> Array:
    place = 2 * ((np.arange(1, count + 1) * _GOLDEN) % 1) - 1
    angle = math.pi / 4 * (1 + width * place)
    sides: Array = math.sqrt(2) * np.stack([np.cos(angle), np.sin(angle)])
    read_only(sides)
    return sides
