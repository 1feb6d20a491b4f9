"""Loudness of a gesture as it is heard, by ITU-R BS.1770: its momentary loudness (pyloudnorm) and its true peak; and
the level that suits a preset."""

import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

BLOCK = 0.4
"""s: over which loudness is taken; each block begins a quarter of this after the last."""
LOUDNESS, PEAK, LEAST = -18.0, -3.0, -28.0
"""Targets of a strike at a preset's defaults: its loudness (LUFS), unless its true peak (dB of full scale) is there
before, but at least so much (LUFS)."""
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
    import pyloudnorm

    size = float(np.abs(samples).max(initial=0.0))
    if size == 0.0:
        return Heard(-math.inf, -math.inf)
    silence = np.zeros((round(BLOCK * rate), samples.shape[1]))
    meter = pyloudnorm.Meter(rate, block_size=BLOCK)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # blocks of silence have a loudness of -inf
        meter.integrated_loudness(np.concatenate([samples / size, silence]))
    return Heard(max(map(float, meter.blockwise_loudness)) + decibels(size), decibels(true_peak(samples)))


def true_peak(samples: NDArray[Any]) -> float:
    """Return the highest value between samples (n, channels), or at one, by four times as many."""
    from scipy.signal import resample_poly

    between = np.abs(resample_poly(np.asarray(samples, np.float64), _OVERSAMPLED, 1, axis=0)).max()
    return float(max(between, np.abs(samples).max()))


def decibels(amplitude: float) -> float:
    """Return an amplitude in dB."""
    return 20 * math.log10(amplitude) if amplitude > 0.0 else -math.inf
