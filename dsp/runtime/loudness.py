"""Loudness of a gesture as it is heard, by ITU-R BS.1770: its momentary loudness and its true peak; and the level that
suits a preset."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..engine.memory.meter_record import WINDOW, k_weighting
from ..numerics.resampling import resampled
from .meter import OFFSET

LOUDNESS, PEAK, LEAST = -18.0, -3.0, -28.0
"""Targets of a strike at a preset's defaults: its loudness (LUFS), unless its true peak (dB of full scale) is there
before, but at least so much (LUFS)."""
_STEP = WINDOW / 4.0
"""s from where a block of which loudness is taken begins to where the next one does."""
_OVERSAMPLED = 4  # as annex 2 of the recommendation asks for at 48 kHz


@dataclass(frozen=True)
class Heard:
    """The greatest momentary loudness (LUFS) and the true peak (dB of full scale) of a gesture."""

    loudness: float
    peak: float

    @property
    def raise_by(self) -> float:
        """Gain (dB) to add to a preset's level to make this the loudness of its strike, the peak allowing."""
        return min(PEAK - self.peak, LOUDNESS - self.loudness)


def heard(samples: NDArray[Any], rate: int) -> Heard:
    """Return the loudness of stereo samples (n, 2) at a rate (Hz). A sound that ends or begins inside a block counts as
    it is."""
    from scipy.signal import sosfilt

    size = float(np.abs(samples).max(initial=0.0))
    if size == 0.0:
        return Heard(-math.inf, -math.inf)
    block = round(WINDOW * rate)
    whole = np.concatenate([samples / size, np.zeros((block, samples.shape[1]))])
    sections = [(*each[:3], 1.0, *each[3:]) for each in k_weighting(rate)]
    weighed = sosfilt(sections, whole, axis=0)
    power = np.concatenate([[0.0], np.cumsum((weighed**2).sum(axis=1))])
    begins = np.round(np.arange(0.0, len(whole) - block + 0.5, _STEP * rate)).astype(int)
    greatest = float((power[begins + block] - power[begins]).max()) / block
    return Heard(OFFSET + 10.0 * math.log10(greatest) + decibels(size), decibels(true_peak(samples)))


def true_peak(samples: NDArray[Any]) -> float:
    """Return the highest value between samples (n, channels), or at one, by four times as many."""
    between = np.abs(resampled(np.asarray(samples, np.float64), _OVERSAMPLED, 1)).max()
    return float(max(between, np.abs(samples).max()))


def decibels(amplitude: float) -> float:
    """Return an amplitude in dB."""
    return 20 * math.log10(amplitude) if amplitude > 0.0 else -math.inf
