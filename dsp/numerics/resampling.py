"""Samples at another rate, by a polyphase filter."""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from .checks import Array

_LOBES = 10  # of the windowed sinc on each side, at the lower of both rates
_KAISER = 5.0  # its window's beta


def resampled(samples: Array, up: int, down: int) -> Array:
    """Return samples (n, channels) at up/down times their rate, ceil(n up/down) of them, as many from 0 on.

    By a sinc that ends below half the lower rate, under Kaiser's window; beyond the ends there is silence.
    """
    half = _LOBES * max(up, down)
    at = np.arange(-half, half + 1)
    filtering = np.sinc(at / max(up, down)) * np.kaiser(len(at), _KAISER)
    filtering *= up / filtering.sum()
    taps = 2 * half // up + 1
    windows = sliding_window_view(np.pad(samples, ((taps, taps), (0, 0))), taps, axis=0)
    made = np.zeros((math.ceil(len(samples) * up / down), samples.shape[1]))
    phases = up // math.gcd(up, down)
    for phase in range(min(phases, len(made))):  # each lies between two samples as all have that come `phases` later
        near = (phase * down - half + up - 1) // up
        tap = phase * down + half - (near + np.arange(taps)) * up
        weight = np.where(tap >= 0, filtering[np.maximum(tap, 0)], 0.0)
        count = len(made[phase::phases])
        made[phase::phases] = windows[near + taps :: phases * down // up][:count] @ weight
    return made
