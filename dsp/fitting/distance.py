"""The distance between two sounds: waveform, spectrum over time, third octaves, decays."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.signal import correlate

from ..numerics.checks import Array
from ..numerics.resampling import resampled
from .hits import without_rumble
from .noise import band

_WINDOW, _HOP = 1024, 256
_DYNAMIC = 1e-6  # of the loudest cell's power: what is heard
_SLACK = 0.1  # of that: beside it, nothing is a gap
_THIRDS = np.r_[0, 100 * 2 ** (np.arange(24) / 3)]  # Hz
_DECAY_BANDS = 62.5 * 2.0 ** np.arange(9)  # Hz, the middles of octaves
_LATEST = 0.05  # s by which two sounds are shifted to agree
_FAINT = 1e-5  # of a sound's energy: an octave that has less is not looked at
_FALL = (-5.0, -25.0)  # dB of the energy that is left: the decay is read off between them (ISO 3382)


@dataclass(frozen=True)
class Distance:
    """Distance of a sound B from A, both from 20 Hz on, after B was shifted and levelled to agree with A.

    Attributes
    ----------
    rate : float
        Sampling rate of A, Hz.
    gain : float
        Change of B's level, dB.
    shift : float
        Change of B's time, s.
    residual : float
        Energy of A - B, dB of A's.
    spectral : float
        Rms of the log-spectral distance, dB.
    thirds : array (n, 3)
        Middle of each third octave (Hz), level of A and of B (dB of A's loudest).
    decays : array (n, 3)
        Middle of each octave (Hz), T60 of A and of B (s); NaN where there is none.
    a, b : array (frames,)
        The two sounds.
    """

    rate: float
    gain: float
    shift: float
    residual: float
    spectral: float
    thirds: Array
    decays: Array
    a: Array
    b: Array


def distance(a: Array, b: Array, rate: float, rate_b: float | None = None) -> Distance:
    """Measure the distance of two sounds (n,), (m,) at their rates (Hz)."""
    if rate_b is not None and rate_b != rate:
        b = at_rate(b, rate_b, rate)
    a, b = without_rumble(a, rate), without_rumble(b, rate)
    shift = _shift(a, b, rate)
    b = b[-shift:] if shift < 0 else np.r_[np.zeros(shift), b]
    b = np.r_[b, np.zeros(max(0, len(a) - len(b)))][: len(a)]
    # By energy, with the sign that fits: the phases of modes need not agree.
    gain = np.sqrt(np.sum(a**2) / max(np.sum(b**2), 1e-30)) * (1 if a @ b >= 0 else -1)
    b = gain * b
    left = np.sum((a - b) ** 2) / max(np.sum(a**2), 1e-30)
    return Distance(
        rate=rate,
        gain=float(20 * np.log10(abs(gain) + 1e-30)),
        shift=shift / rate,
        residual=float(10 * np.log10(left + 1e-30)),
        spectral=log_spectral(a, b, rate),
        thirds=_both(a, b, rate),
        decays=np.array([[middle, decay(a, rate, middle), decay(b, rate, middle)] for middle in octaves(rate)]),
        a=a,
        b=b,
    )


def at_rate(samples: Array, old: float, new: float) -> Array:
    """Resample a sound (n,) to another rate (Hz)."""
    common = np.gcd(round(old), round(new))
    return resampled(samples[:, None], round(new) // common, round(old) // common)[:, 0]


def log_spectral(a: Array, b: Array, rate: float) -> float:
    """Return the log-spectral distance, dB rms over the cells of A within 60 dB of its loudest: thirds of octaves, 21
    ms each."""
    first, second = cells(a, rate), cells(b, rate)
    least = first.max() * _DYNAMIC
    heard = first > least
    apart = 10 * np.log10((first[heard] + _SLACK * least) / (second[heard] + _SLACK * least))
    return float(np.sqrt(np.mean(apart**2)))


def cells(samples: Array, rate: float) -> Array:
    """Return the power (frames, bands) in third octaves from 100 Hz on, and below, of windows of 1024 samples."""
    padded = np.concatenate([np.zeros(_WINDOW // 2), samples, np.zeros(_WINDOW)])
    frames = np.lib.stride_tricks.sliding_window_view(padded, _WINDOW)[::_HOP]
    power = np.abs(np.fft.rfft(frames * np.hanning(_WINDOW))) ** 2
    frequency = np.fft.rfftfreq(_WINDOW, 1 / rate)
    inside = [(frequency >= low) & (frequency < high) for low, high in pairwise(_THIRDS)]
    return np.stack([power[:, each].sum(axis=1) for each in inside if each.any()], axis=1)


def decay(samples: Array, rate: float, middle: float) -> float:
    """Return T60 (s) of the octave about some Hz, by backward integration (M. R. Schroeder 1965); nan if there is
    none."""
    inside = band(samples, rate, middle / np.sqrt(2), middle * np.sqrt(2))
    left = np.cumsum(inside[::-1] ** 2)[::-1]
    if left[0] < _FAINT * np.sum(samples**2):
        return float("nan")
    level = 10 * np.log10(left / left[0] + 1e-30)
    between = np.flatnonzero((level < _FALL[0]) & (level > _FALL[1]))
    if between.size < 8:
        return float("nan")
    slope = np.polyfit(between / rate, level[between], 1)[0]
    return float(-60 / slope) if slope < 0 else float("nan")


def octaves(rate: float) -> Array:
    """Return the middles (Hz) of the octaves below half the rate."""
    middles: Array = _DECAY_BANDS[_DECAY_BANDS * np.sqrt(2) < rate / 2]
    return middles


def third_octaves(samples: Array, rate: float) -> Array:
    """Return rows of third-octave middle (Hz) and level (dB) of a sound (n,), up to half the rate."""
    power = np.abs(np.fft.rfft(samples)) ** 2
    frequency = np.fft.rfftfreq(len(samples), 1 / rate)
    rows = []
    for step in range(-13, 14):
        middle = 1000 * 2 ** (step / 3)
        inside = (frequency >= middle * 2 ** (-1 / 6)) & (frequency < middle * 2 ** (1 / 6))
        if inside.any() and middle * 2 ** (1 / 6) < rate / 2:
            rows.append([middle, 10 * np.log10(power[inside].sum() + 1e-30)])
    return np.array(rows)


def _both(a: Array, b: Array, rate: float) -> Array:
    """Return rows of third-octave middle (Hz) and both levels (dB, against A's loudest)."""
    table = np.column_stack([third_octaves(a, rate), third_octaves(b, rate)[:, 1]])
    table[:, 1:] -= table[:, 1].max()
    return table


def _shift(a: Array, b: Array, rate: float) -> int:
    """Return by how many samples later B agrees best with A: first by their loudness over time, then by their waves."""
    most = round(_LATEST * rate)
    begin = [int(np.argmax(np.abs(each) > 0.05 * np.abs(each).max())) for each in (a, b)]
    rough = begin[0] - begin[1]
    size = min(len(a), round(0.5 * rate))
    first, second = a[begin[0] : begin[0] + size], b[begin[1] : begin[1] + size]
    both = np.abs(correlate(first, second, "full"))
    fine = np.arange(len(both)) - (len(second) - 1)
    near = np.abs(fine) <= min(most, round(0.002 * rate))
    return rough + int(fine[near][np.argmax(both[near])])
