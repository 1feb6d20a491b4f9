"""A ground that yields as a resistance: points of a large plate, from which no wave comes back."""

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..numerics.bessel import jn
from .material import Array
from .modes import Modes, Unheard, require_positive


class _Series(NamedTuple):
    """Modes at equal ratios."""

    lowest: float  # Hz: the natural frequency of the first one
    ratio: float  # of each to the one before
    modes: int
    damping: float  # their damping ratio
    ends: float  # factor of the mobility of the first and the last one, in whose place there were more

    @property
    def natural(self) -> Array:
        """Natural frequencies (rad/s)."""
        return 2.0 * math.pi * self.lowest * np.float64(self.ratio) ** np.arange(self.modes)

    @property
    def turn(self) -> float:
        """Frequencies over the natural ones."""
        return math.sqrt(1.0 - self.damping**2)

    def squares(self, resistance: float) -> Array:
        """Return the squares of their shapes, for a mobility of 1/resistance."""
        squares = self.natural * math.log(self.ratio) * self.turn / (math.acos(self.damping) * resistance)
        squares[[0, -1]] *= self.ends
        return squares


_ALONE = _Series(13.5, 3.18, 8, 0.998, 1.2)
"""Modes of one point: few, for 1 % and 4 degrees from 60 Hz to 10 kHz. Ratio, damping and ends were fitted to that."""
_APART = _Series(4.0, 2.0, 16, 0.7, 1.0)
"""Modes of several points, between which the mobility changes from mode to mode."""
_ROWS = 4  # of shapes that a position is read between
_LEAST = 1e-4  # share of a mode's mobility in a pattern of points, below which it is left out

Place = tuple[float, ...]


@functools.lru_cache(maxsize=64)
def ground(resistance: float, top: float, places: tuple[Place, ...] = ((0.0,),), wavelength: float = 0.0) -> Modes:
    """Return modes of points whose mobility is 1/resistance (m/(N s)), and which are silent.

    They are heavily damped, at equal ratios r, with phi_i^2 = c omega_i. Over many such modes the sum of
    c j x/(1 - x^2 + 2 j zeta x), x = omega/omega_i, is c arccos(zeta)/(sqrt(1 - zeta^2) ln r), at any frequency within
    them: real, as the integral over ln x has no imaginary part. The resistance is within 1 % from 60 Hz to 10 kHz. What
    lies above `top` (Hz) contacts feel alone.

    places (m) are the points, number n of which is at `position_of(n, len(places))`. Bending waves of a `wavelength` (m
    at 1 kHz) go from one to the other: the real part of the mobility between two of them is J0(k d)/resistance (Cremer,
    Heckl and Petersson, Structure-Borne Sound). So each mode is one for each pattern, an eigenvector of J0. Without a
    wavelength none feels another. ValueError if the resistance is not positive.
    """
    require_positive(resistance=resistance)
    series = _ALONE if len(places) == 1 else _APART
    natural, squares = series.natural, series.squares(resistance)
    patterns = [_patterns(places, 2.0 * math.pi / wavelength * math.sqrt(each / 2e3 / math.pi) if wavelength else 0.0)
                for each in natural]  # fmt: skip
    strike = np.concatenate([math.sqrt(c) * each for c, each in zip(squares, patterns, strict=True)], axis=1)
    natural = np.repeat(natural, [each.shape[1] for each in patterns])
    frequency: Array = natural * series.turn / (2.0 * math.pi)
    decay: Array = series.damping * natural
    low = frequency <= top
    unheard = Unheard(frequency[~low], decay[~low], strike[:, ~low])
    silent = np.zeros((2, int(low.sum())))
    return Modes(frequency[low], decay[low], strike[:, low], silent, mass=1.0, unheard=unheard)


def position_of(number: int, count: int) -> float:
    """Return where on a ground's strike path the point of a number is, of `count`."""
    return number / (max(count, _ROWS) - 1)


def _patterns(places: Sequence[Place], wave: float) -> Array:
    """Return the patterns in which points of a ground move at a wave number (1/m; 0: each alone), by their shares."""
    points = np.array(places)
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    coupling = jn(0, wave * apart) if wave else np.eye(len(points))
    shares, vectors = np.linalg.eigh(coupling)
    found = vectors * np.sqrt(np.maximum(shares, 0.0))
    rows = len(points) if len(points) == 1 else max(len(points), _ROWS)
    return np.pad(found[:, shares > _LEAST], ((0, rows - len(points)), (0, 0)))
