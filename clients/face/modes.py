"""The modes of an object as the engine plays them: labels for its sound."""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .dsp.bodies.modes import Modes
from .dsp.engine.objects import sigma_of, weigh
from .dsp.engine.render import pan_gains
from .dsp.resonator.bank import NYQUIST_SHARE

_ROWS = 4  # between which mode shapes are interpolated


class ModeTable(NamedTuple):
    """Modes of an object struck at one position, by ascending frequency; each array is float64.

    An impulse of J (N s) at t = 0 sounds, at the left and right output c, as
    J sum_i gains[i, c] exp(-decays[i] t) sin(2 pi frequencies[i] t).
    """

    frequencies: NDArray[np.float64]
    """(n,) Hz."""
    decays: NDArray[np.float64]
    """(n,) 1/s: a level falls by 60 dB in ln(1000)/decay."""
    gains: NDArray[np.float64]
    """(n, 2) of full scale per N s; a mode may be in opposite phase (< 0), or silent at this position (0)."""


class Settings(NamedTuple):
    """The settings of an object as the engine has them: amplitude, pan (-1 to 1), ratios of frequencies and of decay
    times, damping (0 to 1)."""

    gain: float
    pan: float
    tune: float
    decay: float
    damp: float


def mode_table(modes: Modes, level: float, settings: Settings, position: float, rate: float) -> ModeTable:
    """The table of modes that were laid out at a level (amplitude), struck at a position (0 to 1), for a rate in Hz."""
    frequencies = modes.frequency * settings.tune
    made = modes.frequency <= NYQUIST_SHARE * 0.5 * rate
    heard = np.flatnonzero(made & (frequencies <= NYQUIST_SHARE * 0.5 * rate))
    state = SimpleNamespace(bank=SimpleNamespace(sigma=modes.decay), rate=rate)
    obj = SimpleNamespace(first=0, settings=settings)
    decays = np.array([sigma_of.py_func(state, obj, i) for i in heard])
    sides = pan_gains.py_func(obj)
    shape = _shape_at(modes.strike, position)[heard]
    gains = level * (modes.pickup[:, heard] * shape).T * np.array(sides)
    return ModeTable(frequencies[heard], decays, gains)


def _shape_at(strike: NDArray[np.float64], position: float) -> NDArray[np.float64]:
    """Mode shapes (n,) at a position, by the engine's cubic through the four rows around it."""
    if len(strike) < _ROWS:
        return np.asarray(strike[0])  # the position does not matter
    x = position * (len(strike) - 1)
    row = min(max(int(x) - 1, 0), len(strike) - _ROWS)
    weights = np.empty(_ROWS)
    weigh.py_func(weights, x - row)
    return np.asarray(weights @ strike[row : row + _ROWS])
