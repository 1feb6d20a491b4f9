"""A sound beside recordings of one kind: how far it is from them, and how far they are from each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from statistics import median

import numpy as np

from ..numerics.checks import Array
from .distance import decay, octaves, third_octaves
from .hits import without_rumble

_FLOOR = -60.0  # dB under a sound's loudest third octave: what is lower counts as this low
_ONSET = 0.05  # of the highest sample

Sound = tuple[Array, float]
"""Samples (n,) and their rate (Hz)."""


@dataclass(frozen=True)
class Excess:
    """Medians over pairs of sounds, of which the recordings are some.

    gap (dB): between the sound and the recordings, the mean distance of third octaves after one gain. real_gap: between
    the recordings. decay, real_decay (octaves): likewise of T60 by octaves, after no factor. recordings: how many.
    """

    recordings: int
    gap: float
    real_gap: float
    decay: float
    real_decay: float


@dataclass(frozen=True)
class _Profile:
    thirds: dict[float, float]
    decays: Array


def excess(sound: Sound, recordings: Sequence[Sound]) -> Excess:
    """Return how far a sound is from recordings of one kind, beside how far these are from each other.

    All count from their onsets on, and as long as the shortest. ValueError of fewer than two recordings.
    """
    if len(recordings) < 2:
        raise ValueError(f"recordings: {len(recordings)}: expected at least 2 of one kind")
    begun = [(_begun(*each), each[1]) for each in (sound, *recordings)]
    seconds = min(len(samples) / rate for samples, rate in begun)
    ours, *real = [_profile(samples[: int(seconds * rate)], rate) for samples, rate in begun]
    mixed = [(ours, each) for each in real]
    pairs = list(combinations(real, 2))
    return Excess(
        recordings=len(real),
        gap=median(_gap(*pair) for pair in mixed),
        real_gap=median(_gap(*pair) for pair in pairs),
        decay=_typical([_decay_gap(*pair) for pair in mixed]),
        real_decay=_typical([_decay_gap(*pair) for pair in pairs]),
    )


def _begun(samples: Array, rate: float) -> Array:
    level = np.abs(without_rumble(samples, rate))
    begun: Array = without_rumble(samples, rate)[int(np.argmax(level > _ONSET * level.max())) :]
    return begun


def _profile(samples: Array, rate: float) -> _Profile:
    rows = third_octaves(samples, rate)
    loudest = rows[:, 1].max()
    thirds = {float(middle): max(float(level - loudest), _FLOOR) for middle, level in rows}
    return _Profile(thirds, np.array([decay(samples, rate, middle) for middle in octaves(rate)]))


def _gap(a: _Profile, b: _Profile) -> float:
    """Return the mean distance (dB) of the third octaves that are over the floor in one of two sounds."""
    both = [(a.thirds[middle], b.thirds[middle]) for middle in a.thirds.keys() & b.thirds.keys()]
    apart = np.array([one - other for one, other in both if max(one, other) > _FLOOR])
    return float(np.abs(apart - apart.mean()).mean())


def _decay_gap(a: _Profile, b: _Profile) -> float:
    """Return the median distance (octaves) of the decays that both have; nan without any."""
    count = min(len(a.decays), len(b.decays))
    apart = np.abs(np.log2(a.decays[:count] / b.decays[:count]))
    known = apart[np.isfinite(apart)]
    return float(np.median(known)) if len(known) else float("nan")


def _typical(values: Sequence[float]) -> float:
    known = [value for value in values if np.isfinite(value)]
    return median(known) if known else float("nan")
