"""How loud a strike is heard: integrated loudness by ITU-R BS.1770 (pyloudnorm), and the level that suits a preset."""

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

SECONDS, BLOCK = 0.8, 0.2
"""s from the onset that are listened to; s, the meter's blocks: half the standard's, for short sounds."""
PEAK = 1 / 8
"""Of full scale, at most: eight strikes at once do not limit."""
LOUDEST = -41.8
"""LUFS: of the built-in presets' default strikes."""
ONSET = 1e-3  # of the peak


@dataclass(frozen=True)
class Heard:
    """Integrated loudness (LUFS) and peak (dB below full scale) of a gesture."""

    loudness: float
    peak: float

    @property
    def raise_by(self) -> float:
        """What is to be added to a preset's level (dB): then it is as loud as the built-in ones, its peak allowing."""
        return min(20 * float(np.log10(PEAK)) - self.peak, LOUDEST - self.loudness)


def heard(samples: NDArray[Any], rate: int) -> Heard:
    """What is heard of stereo samples (n, 2) at a rate (Hz) in the first 0.8 s from the onset."""
    import pyloudnorm

    size = np.abs(samples).max()
    length = round(SECONDS * rate)
    begin = int(np.argmax(np.abs(samples).max(axis=1) > ONSET * size))
    piece = samples[begin : begin + length].astype(float) / size
    piece = np.pad(piece, ((0, max(0, length - len(piece))), (0, 0)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # pyloudnorm warns of samples above full scale, where there are none
        loudness = pyloudnorm.Meter(rate, block_size=BLOCK).integrated_loudness(piece)
    peak = 20 * float(np.log10(size))
    return Heard(float(loudness) + peak, peak)
