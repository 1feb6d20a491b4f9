"""Bands of noise, fitted to what modes leave over: one exponential each, above a floor that stays.

The power of a band, in frames that are long against 1/bandwidth, scatters about p(t) = A^2 exp(-2 sigma t) + N^2 as
chi-squared variables do. N is what the recording has where nothing rings. The most likely A and sigma minimize
sum(log p + e/p) over the frames (P. Whittle 1953), so that a noisy recording does not make the decay longer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize
from scipy.signal import butter, sosfilt

from ..numerics.checks import Array

COUNT, LOWEST, HIGHEST = 24, 60.0, 20_000.0
"""Bands: how many, and their outer edges (Hz)."""

_ORDER = 6  # of the bands' filters
_TONAL = 0.04  # of a mode's frequency, at most: so far from it, what is left of it may lie
_BESIDE, _BESIDE_BY_DECAY = 10.0, 1.0  # Hz, and of its decay rate (1/s): the same
_RINGING = 60.0  # 1/s: a mode that decays faster is no tone
_FRAME = 0.003  # s, the shortest
_PERIODS = 1.0  # of the bandwidth in a frame, at least
_MOST_OF_IT, _FEWEST = 0.998, 4  # of a band's energy: what comes after it does not count; frames
_LEAST_DECAY, _MOST_DECAY = 0.3, 6000.0  # 1/s


@dataclass(frozen=True)
class Bands:
    """Bands of noise: edges (n + 1,) in Hz, rms at the onset (n,), decay rates (n,) in 1/s, rms of the floor (n,)."""

    edges: Array
    rms: Array
    decay: Array
    floor: Array

    def sound(self, length: int, rate: float, seed: int = 1) -> Array:
        """Return so many samples of such noise at a rate (Hz), without the floor."""
        spectrum = np.fft.rfft(np.random.default_rng(seed).standard_normal(length))
        frequency, t = np.fft.rfftfreq(length, 1 / rate), np.arange(length) / rate
        total = np.zeros(length)
        for (low, high), rms, decay in zip(pairwise(self.edges), self.rms, self.decay, strict=True):
            inside = (frequency >= low) & (frequency < high)
            if inside.any():
                band = np.fft.irfft(spectrum * inside, length)
                total += rms * np.exp(-decay * t) * band / np.sqrt(np.mean(band**2))
        return total


def band_edges(rate: float) -> Array:
    """Return the bands' edges (Hz) at a rate (Hz): the lowest from 1 Hz on."""
    edges = np.geomspace(LOWEST, HIGHEST, COUNT + 1)
    return np.concatenate([[20.0], edges[edges < 0.49 * rate]])


def noise_bands(rests: Sequence[Array], quiet: Sequence[Array], rate: float) -> Bands:
    """Return the noise that several rests (n,) share at a rate (Hz): its decays, and its rms averaged over them.

    quiet: for each the recording's own noise, (m,); empty where it is not known, and taken to be none.
    """
    edges = band_edges(rate)
    found = []
    for low, high in pairwise(edges):
        width = max(_FRAME, _PERIODS / (high - low))
        frames = [_frames(rest, rate, low, high, width) for rest in rests]
        still = [float(np.mean(_frames(each, rate, low, high, width))) for each in quiet if len(each)]
        found.append(_fitted(frames, width, float(np.mean(still)) if still else 0.0))
    rms, decay, floor = np.array(found).T
    return Bands(edges, rms, decay, floor)


def _frames(rest: Array, rate: float, low: float, high: float, width: float) -> Array:
    """Return the mean power of a band in frames of a width (s)."""
    size = max(1, min(round(width * rate), len(rest) // 4))
    power = band(rest, rate, low, high) ** 2
    powers: Array = power[: len(power) // size * size].reshape(-1, size).mean(axis=1)
    return powers


def without_tones(rest: Array, frequency: Array, decay: Array, rate: float) -> Array:
    """Return a rest (n,) without what is left of modes of these frequencies (Hz) and decay rates (1/s), close beside
    them.

    A tone that was fitted not quite right is no noise, and would fill its whole band.
    """
    length = 1 << int(np.ceil(np.log2(2 * len(rest))))
    spectrum, bins = np.fft.rfft(rest, length), np.fft.rfftfreq(length, 1 / rate)
    for f, sigma in zip(frequency, decay, strict=True):
        if sigma < _RINGING:
            reach = min(_TONAL * f, _BESIDE + _BESIDE_BY_DECAY * sigma)
            spectrum[np.searchsorted(bins, f - reach) : np.searchsorted(bins, f + reach)] = 0
    cleared: Array = np.fft.irfft(spectrum, length)[: len(rest)]
    return cleared


def band(samples: Array, rate: float, low: float, high: float) -> Array:
    """Filter a band (Hz) out of a signal, from what was alone: nothing spreads to before it begins."""
    filtered: Array = sosfilt(_sections(rate, low, min(high, 0.4999 * rate)), samples)
    return filtered


@cache
def _sections(rate: float, low: float, high: float) -> Array:
    found: Array = butter(_ORDER, (low, high), "bandpass", fs=rate, output="sos")
    return found


def _fitted(frames: list[Array], width: float, floor: float) -> tuple[float, float, float]:
    """Return A (rms), sigma (1/s) and N (rms) of bands that decay alike, their powers averaged; floor: N^2."""
    length = min(map(len, frames))
    power = np.mean([each[:length] for each in frames], axis=0)
    scale = float(power.max())
    if scale < 1e-24:
        return 0.0, _MOST_DECAY, float(np.sqrt(floor))
    heard = np.cumsum(np.maximum(power - floor, 0))
    power = power[: max(_FEWEST, int(np.searchsorted(heard, _MOST_OF_IT * heard[-1])) + 1)]
    length = len(power)
    power, still, t = power / scale + 1e-12, floor / scale + 1e-9, (np.arange(length) + 0.5) * width

    def cost(x: Array) -> tuple[float, Array]:
        begin, decay = np.exp(x)
        falling = begin * np.exp(-2 * decay * t)
        model = falling + still
        slope = (1 - power / model) / model
        value = float(np.sum(np.log(model) + power / model))
        return value, np.array([np.sum(slope * falling), np.sum(slope * falling * -2 * decay * t)])

    share = np.cumsum(power) / power.sum()
    half = max(float(t[np.searchsorted(share, 0.5)]), width)
    bounds = [(-30.0, 3.0), (np.log(_LEAST_DECAY), np.log(_MOST_DECAY))]
    begin = np.clip([np.log(power[:2].mean()), np.log(0.35 / half)], *np.transpose(bounds))
    begin, decay = np.exp(minimize(cost, begin, jac=True, method="L-BFGS-B", bounds=bounds).x)
    return float(np.sqrt(begin * scale)), float(decay), float(np.sqrt(floor))
