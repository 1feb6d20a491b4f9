"""Samples at another rate, by a polyphase filter."""

import math

import numpy as np

from .checks import Array

_LOBES = 10  # of the windowed sinc on each side, at the lower of both rates
_KAISER = 5.0  # its window's beta
_TOGETHER = 1 << 22  # products that are in memory at once


def resampled(samples: Array, up: int, down: int) -> Array:
    """Return samples (n, channels) at up/down times their rate, ceil(n up/down) of them, as many from 0 on.

    By a sinc that ends below half the lower rate, under Kaiser's window; beyond the ends there is silence.
    """
    half = _LOBES * max(up, down)
    at = np.arange(-half, half + 1)
    filtering = np.sinc(at / max(up, down)) * np.kaiser(len(at), _KAISER)
    filtering *= up / filtering.sum()
    taps = 2 * half // up + 1
    padded = np.pad(samples, ((taps, taps), (0, 0)))
    count = math.ceil(len(samples) * up / down)
    made = np.zeros((count, samples.shape[1]))
    step = max(1, _TOGETHER // taps)
    for first in range(0, count, step):
        place = np.arange(first, min(first + step, count))[:, None] * down
        near = -((half - place) // up) + np.arange(taps)
        tap = place - near * up + half
        weight = np.where(tap >= 0, filtering[np.maximum(tap, 0)], 0.0)
        made[first : first + len(place)] = np.einsum("kt,ktc->kc", weight, padded[near + taps])
    return made
