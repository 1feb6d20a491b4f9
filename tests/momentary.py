"""How loud a sound is from moment to moment: ITU-R BS.1770's momentary loudness, of 0.4 s, every 0.1 s."""

import numpy as np
import pyloudnorm

WINDOW, HOP = 0.4, 0.1


def momentary(samples: np.ndarray, rate: int) -> np.ndarray:
    """The loudness (LUFS) of each window of stereo samples (frames, 2), the first one from the beginning on."""
    heard = samples.astype(float)
    for stage in pyloudnorm.Meter(rate)._filters.values():
        heard = np.stack([stage.apply_filter(channel) for channel in heard.T], axis=1)
    energy = np.concatenate([[0.0], np.cumsum((heard**2).sum(axis=1))])
    first = np.arange(0, len(heard) - round(WINDOW * rate) + 1, round(HOP * rate))
    power = (energy[first + round(WINDOW * rate)] - energy[first]) / round(WINDOW * rate)
    return -0.691 + 10 * np.log10(np.maximum(power, 1e-12))


def quiet(samples: np.ndarray, rate: int, begin: float, end: float, least: float) -> list[float]:
    """The times (s) between `begin` and `end` from which on 0.4 s are softer than `least` (LUFS)."""
    loudness = momentary(samples[round(begin * rate) : round(end * rate)], rate)
    return [round(begin + HOP * n, 1) for n in np.flatnonzero(loudness < least)]
