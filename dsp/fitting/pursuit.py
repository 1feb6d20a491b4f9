"""More candidates for the modes of a sound: matching pursuit among damped sines.

ESPRIT's bands need some samples of their own, so that short recordings and short modes have few. Here every frequency
is tried with some decays: the sound is weighed by each decay and transformed, and where the atom explains most of the
energy, there is a candidate (S. Mallat, Z. Zhang, "Matching pursuits with time-frequency dictionaries", IEEE Trans.
Signal Processing 41, 1993; with damped sines: M. M. Goodwin, M. Vetterli, 1999).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..numerics.checks import Array
from .sums import Complex

_DECAYS = np.geomspace(3.0, 2500.0, 9)  # 1/s
_LOWEST, _HIGHEST = 20.0, 20_000.0  # Hz
_APART = 1.5  # candidates lie apart by so many half widths of their peaks, and periods of the whole length


def pursued(takes: Sequence[Array], rate: float, count: int) -> Complex:
    """Log poles per sample of up to `count` damped sines that, each alone, explain most of all takes; peaks apart."""
    gain, frequency = _gains(takes, rate)
    longest = max(map(len, takes)) / rate
    found = []
    for _ in range(count):
        row, place = np.unravel_index(int(np.argmax(gain)), gain.shape)
        if gain[row, place] <= 0:
            break
        found.append(-_DECAYS[row] / rate + 2j * np.pi * frequency[place] / rate)
        for other, decay in enumerate(_DECAYS):
            reach = _APART * (max(_DECAYS[row], decay) / (2 * np.pi) + 1 / longest)
            low, high = np.searchsorted(frequency, [frequency[place] - reach, frequency[place] + reach])
            gain[other, low:high] = 0
    return np.array(found, np.complex128)


def _gains(takes: Sequence[Array], rate: float) -> tuple[Array, Array]:
    """Return the energy (decays, frequencies) that each damped sine alone explains of all takes, and the frequencies
    (Hz)."""
    length = 1 << int(np.ceil(np.log2(2 * max(map(len, takes)))))
    frequency = np.asarray(np.fft.rfftfreq(length, 1 / rate), np.float64)
    gain = np.zeros((len(_DECAYS), len(frequency)))
    for take in takes:
        t = np.arange(len(take)) / rate
        for row, decay in enumerate(_DECAYS):
            fall = np.exp(-decay * t)
            gain[row] += 2 * np.abs(np.fft.rfft(take * fall, length)) ** 2 / (fall @ fall)
    gain[:, (frequency < _LOWEST) | (frequency > min(_HIGHEST, 0.49 * rate))] = 0
    return gain, frequency
