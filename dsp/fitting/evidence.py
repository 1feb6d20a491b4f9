"""The evidence of a recording for modes: which rise above its noise, which are steady tones, and how well decays are
known.

In noise of the power S per sample at a mode's frequency, the most likely damped sine explains 2 S of the noise on
average, and the luckiest of N some 2 S ln N. A mode that explains no more may be noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.signal import welch

from ..numerics.checks import Array
from .hits import Hit
from .refinement import variances
from .sums import Complex, Head, products, project

_SURE = 40.0  # times the noise's power, a mode's energy: the luckiest of 100,000 sines in noise has 23
_LEAST_HEARD = 1e-7  # of a take's energy
_SEGMENT = 1024  # samples
_SMOOTH = 9  # lines of the spectrum, of whose powers the median counts: a hum's line is no noise
_BESIDE = (1.5, 2.5, 3.5)  # half widths of a mode's peak: so far from it, what modes leave is measured
_FALL = 6.0  # dB by which a mode falls over the longest take: if it falls less, nobody knows how long it rings
_FAINT = 0.003  # of all modes' energy: one that has less, and falls by less than twice that, is a tone that stands
_RINGS_OUT = 15.0  # dB: so much has to fall for that
_HUM = 0.5  # of a mode's amplitude: what has that before the hit already is no mode
_BEFORE = 0.1  # s of a recording before the hit in which a tone is looked for
_MAINS, _NEAR, _HIGHEST_HUM = (50.0, 60.0), 0.3, 1000.0  # Hz: frequencies of hum, and how near them it is
_BARELY = 1e-5  # of all modes' energy: a decay of a mode that has less has to be known twice as well
_TAIL = 4  # the last of so many parts of what modes leave is taken for noise where none is heard alone


@dataclass(frozen=True)
class Floor:
    """The noise of a recording: power per sample (n,) at frequencies (n,) in Hz; if it is white, its rms squared."""

    frequency: Array
    power: Array

    def at(self, s: Complex, rate: float) -> Array:
        """Return the power at log poles per sample (k,)."""
        powers: Array = np.interp(s.imag * rate / (2 * np.pi), self.frequency, self.power)
        return powers


def floor_of(noise: Array, rate: float) -> Floor:
    """Estimate the floor of noise that is heard alone (n,)."""
    segment = min(_SEGMENT, len(noise))
    frequency, density = welch(noise, rate, nperseg=segment)
    padded = np.pad(density, _SMOOTH // 2, "reflect")
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(padded, _SMOOTH), axis=1)
    return Floor(frequency, 0.5 * rate * smooth)


def floor_of_rest(rest: Array, rate: float) -> Floor:
    """Estimate the floor of what modes leave of a take (n,), towards its end."""
    return floor_of(rest[-max(2 * _SMOOTH, len(rest) // _TAIL) :], rate)


def needed(takes: Sequence[Array], floors: Sequence[Floor], s: Complex, rate: float) -> Array:
    """Return the energy (k,) that modes of log poles per sample must explain of all takes together, so that none is
    noise."""
    noise = _SURE * np.sum([floor.at(s, rate) for floor in floors], axis=0)
    energies: Array = np.maximum(noise, _LEAST_HEARD * sum(float(take @ take) for take in takes))
    return energies


def energies(takes: Sequence[Array], s: Complex, amplitude: Sequence[Complex]) -> Array:
    """Return the energy (k,) of each mode by itself, in all takes."""
    found: Array = np.sum(
        [0.5 * np.abs(c) ** 2 * np.diag(products(s, len(take))[1]).real
         for c, take in zip(amplitude, takes, strict=True)],
        axis=0,
    )  # fmt: skip
    return found


def slowest_known(takes: Sequence[Array]) -> float:
    """Return the least decay per sample that takes can show: what decays more slowly may ring on for any time."""
    return float(np.log(10) / 20 * _FALL / max(map(len, takes)))


def standing(found: Sequence[Hit], s: Complex, amplitude: Sequence[Complex]) -> npt.NDArray[np.bool_]:
    """True for the modes (k,) that are steady tones, as hum is: those that are there before the hit, and faint ones
    that hardly fall."""
    rate, takes = found[0].rate, [hit.samples for hit in found]
    energy, slow = energies(takes, s, amplitude), -s.real < slowest_known(takes)
    share, frequency = energy / energy.sum(), s.imag * rate / (2 * np.pi)
    hum = np.any([np.abs(frequency - mains * np.round(frequency / mains)) < _NEAR for mains in _MAINS], axis=0)
    lingers = (-s.real < 2 * slowest_known(takes)) & (share < _FAINT) & (min(hit.fall for hit in found) > _RINGS_OUT)
    stands: npt.NDArray[np.bool_] = lingers | slow & hum & (frequency < _HIGHEST_HUM) & (share < 0.5)
    for hit, c in zip(found, amplitude, strict=True):
        if len(hit.before) > _BEFORE * rate:
            window = np.hanning(len(hit.before))
            tone = np.exp(-1j * np.outer(s.imag, np.arange(len(hit.before))))
            stands |= 2 * np.abs(tone @ (window * hit.before)) / window.sum() > _HUM * np.abs(c)
    return stands


def unknown(doubt: Array, energy: Array) -> npt.NDArray[np.bool_]:
    """True for decays that the recording leaves open, given their standard deviations as shares (k,) and the modes'
    energies (k,)."""
    found: npt.NDArray[np.bool_] = doubt > np.where(energy < _BARELY * energy.sum(), 0.5, 1.0)
    return found


def spread(
    takes: Sequence[Array], rests: Sequence[Array], s: Complex, amplitude: list[Complex], heads: Sequence[Head | None]
) -> Array:
    """Return the standard deviations of the decays (k,), as shares of the decays, or of the slowest known one.

    rests: what modes leave. Near each mode's frequency and as long as it rings, that counts as noise.
    """
    own = np.sqrt(np.maximum(variances(takes, s, amplitude, heads), 0))
    half = np.maximum(-s.real, np.pi / max(map(len, takes)))
    beside = [s + 1j * sign * share * half for share in _BESIDE for sign in (-1, 1)]
    noise = np.zeros(len(s))
    for rest in rests:
        energy = np.diag(products(s, len(rest))[1]).real
        noise += np.mean([np.abs(project(rest, each)) ** 2 for each in beside], axis=0) / energy
    shares: Array = own * np.sqrt(noise) / np.maximum(-s.real, slowest_known(takes))
    return shares
