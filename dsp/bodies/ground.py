"""A ground that gives way as a resistance: a point of a large plate, from which no wave comes back."""

import functools
import math

import numpy as np

from .material import Array
from .modes import Modes, Unheard, require_positive

_LOWEST = 4.0  # Hz: the natural frequency of the lowest mode
_RATIO = 2.0  # of each to the one before
_COUNT = 16
_DAMPING = 0.7  # their damping ratio


@functools.lru_cache(maxsize=64)
def ground(resistance: float, top: float) -> Modes:
    """Return modes of a point whose mobility is 1/resistance (m/(N s)), and which are silent.

    They are heavily damped, an octave apart, with phi_i^2 = c omega_i. Over modes at equal ratios r the sum of
    c j x/(1 - x^2 + 2 j zeta x), x = omega/omega_i, is c arccos(zeta)/(sqrt(1 - zeta^2) ln r), at any frequency within
    them: real, as the integral over ln x has no imaginary part. The resistance is within 1 % from 60 Hz to 10 kHz. What
    lies above `top` (Hz) contacts feel alone. ValueError if the resistance is not positive.
    """
    require_positive(resistance=resistance)
    natural = 2.0 * math.pi * _LOWEST * np.float64(_RATIO) ** np.arange(_COUNT)
    turn = math.sqrt(1.0 - _DAMPING**2)
    squares = natural * math.log(_RATIO) * turn / (math.acos(_DAMPING) * resistance)
    frequency: Array = natural * turn / (2.0 * math.pi)
    decay: Array = _DAMPING * natural
    strike = np.sqrt(squares)[None, :]
    low = frequency <= top
    unheard = Unheard(frequency[~low], decay[~low], strike[:, ~low])
    silent = np.zeros((2, int(low.sum())))
    return Modes(frequency[low], decay[low], strike[:, low], silent, mass=1.0, unheard=unheard)
