"""Single hits in a recording: where they begin, where they end in the noise, and whether they can be fitted at all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfilt

from ..numerics.checks import Array
from .errors import RecordingError

LONGEST_HIT = 3.0
"""s: of a hit, what comes later is left out."""

SHORTEST_HIT = 0.03
"""s"""

_SILENCE = 1e-5  # of full scale: -100 dBFS
_INAUDIBLE = 20.0  # Hz
_STEP = 0.0025  # s, of the envelope
_RISE = 10 ** (9 / 10)  # in power, of a hit's beginning against the 60 ms before
_SOFTEST = 1e-4  # in power, of the loudest: a softer rise is none
_APART = 0.06  # s: of two hits at least
_BEGIN, _RISEN = 0.05, 0.3  # of a hit's highest sample: it begins after the last quiet before it has risen
_NOISE_S_PEAKS = 3.0  # times its rms, in 0.25 ms
_ATTACK = 0.02  # s in which its first peak comes
_DROP, _ABOVE_FLOOR = 60.0, 6.0  # dB: a hit ends so far below its peak, or so little above the floor
_LEAST_FALL, _LEAST_FALL_OF_MANY = -3.0, 15.0  # dB by which a hit must fall before it ends, and before the next one
_NOISE = 10 ** (-15 / 10)  # in power, of the loudest: what is louder is not the noise
_SWELL = 3.0  # dB by which a hit may grow after its attack
_STILL = 1.0  # dB between the halves of the last quarter, where that is noise
_TONAL = 0.2  # of the last quarter's power: so much within a few bins is a tone
_LEAST_QUIET = 0.05  # s
_FLAT_TOP = 3  # samples alike at the peak: clipped
_MOST_CLIPPED = 2  # such places


@dataclass(frozen=True)
class Hit:
    """A hit: its samples (n,) from the onset on, its onset (samples from the recording's beginning), its noise.

    before: what the recording holds between the hit before and the onset, at most 0.5 s. quiet: a part of the recording
    where its noise is heard alone; empty if there is none. fall: by how much (dB) the level falls from the onset to the
    end. found: how many hits the recording has.
    """

    samples: Array
    rate: float
    onset: int
    before: Array
    quiet: Array
    fall: float
    found: int = 1

    @property
    def peak(self) -> float:
        """The highest sample."""
        return float(np.abs(self.samples).max())

    @property
    def floor(self) -> float:
        """rms of the noise; 0 where it is never heard alone."""
        return float(np.sqrt(np.mean(self.quiet**2))) if len(self.quiet) else 0.0


def check(samples: Array, rate: float) -> None:
    """Raise RecordingError if a recording (n,) is silent, too short, clipped, or not of numbers."""
    bad = np.flatnonzero(~np.isfinite(samples))
    if bad.size:
        raise RecordingError(f"sample {bad[0]} is {samples[bad[0]]}: expected numbers")
    if len(samples) < SHORTEST_HIT * rate:
        raise RecordingError(f"{len(samples) / rate:.3g} s long: expected at least {SHORTEST_HIT:g} s")
    peak = float(np.abs(samples).max())
    if peak < _SILENCE:
        level = f"{20 * np.log10(peak):.0f} dBFS" if peak else "0"
        raise RecordingError(f"silent, its highest sample is {level}: expected the sound of a strike")
    top = np.abs(samples) >= peak * (1 - 1e-9)
    runs = np.convolve(top, np.ones(_FLAT_TOP), "valid") == _FLAT_TOP
    places = int(np.sum(np.diff(np.r_[False, runs].astype(int)) == 1))
    if places > _MOST_CLIPPED:
        raise RecordingError(f"clipped in {places} places: expected a recording below full scale")


def hits(samples: Array, rate: float) -> list[Hit]:
    """Find the single hits of a recording (n,) at a rate (Hz), in time's order.

    RecordingError if it cannot be used (`check`), or if nothing in it rings out.
    """
    check(samples, rate)
    samples = without_rumble(samples, rate)
    step = max(1, round(_STEP * rate))
    power = _power(samples, step)
    floor = 0.0 if _is_tone(samples[-len(samples) // 4 :]) else _floor(power)
    slope = np.diff(samples, prepend=samples[0])
    starts = _starts(_power(slope, step), step, rate) or _starts(power, step, rate) or [0]
    ends = [place * step - round(0.01 * rate) for place in starts[1:]] + [len(samples)]
    least = _LEAST_FALL if len(starts) == 1 else _LEAST_FALL_OF_MANY
    found = []
    for number, (start, end) in enumerate(zip(starts, ends, strict=True)):
        onset = _onset(samples, start * step, end, rate, floor)
        length, fall = _length(power[onset // step : end // step], step, rate, floor)
        if length >= SHORTEST_HIT * rate and fall >= least:
            before = samples[max(ends[number - 1] if number else 0, onset - round(0.5 * rate)) : onset]
            before = before[: max(0, len(before) - round(0.005 * rate))]
            after = samples[onset + length : end]
            quiet = after if len(after) > len(before) else before
            quiet = quiet if len(quiet) > _LEAST_QUIET * rate else quiet[:0]
            piece = samples[onset : min(onset + length, end)]
            found.append(Hit(piece, rate, onset, before, quiet, fall, len(starts)))
    if not found:
        raise RecordingError(
            f"{len(starts)} onset{'s' * (len(starts) != 1)} in {len(samples) / rate:.3g} s, and the level falls by "
            f"{least:g} dB after none of them: expected a single strike that rings out"
        )
    return found


def clearest(found: list[Hit]) -> Hit:
    """Return the hit that stands highest above the noise, for longest."""
    return max(found, key=lambda hit: 2 * np.log(hit.peak) + np.log(min(len(hit.samples) / hit.rate, 1.0)))


def without_rumble(samples: Array, rate: float) -> Array:
    """Return a recording without an offset, or what else lies below hearing."""
    sections = butter(2, _INAUDIBLE, "highpass", fs=rate, output="sos")
    filtered: Array = sosfilt(sections, samples - np.median(samples))
    return filtered


def _power(samples: Array, step: int) -> Array:
    """Return the mean power of two steps from each step on."""
    padded = np.pad(samples**2, (0, -len(samples) % step + step))
    each = padded.reshape(-1, step).mean(axis=1)
    power: Array = 0.5 * (each[:-1] + each[1:])
    return power


def _floor(power: Array) -> float:
    """Return the power of the noise: that of the quietest twentieth, unless the recording ends while it still falls."""
    lowest = float(np.median(np.sort(power)[: max(3, len(power) // 20)]))
    last = power[-max(4, len(power) // 4) :]
    halves = [float(np.mean(half)) for half in np.array_split(last, 2)]
    ends_in_noise = abs(10 * np.log10((halves[1] + 1e-30) / (halves[0] + 1e-30))) < _STILL
    begins_in_noise = np.mean(power[:8]) < 4 * lowest
    low_enough = lowest < _NOISE * float(power.max())
    return lowest if low_enough and (ends_in_noise or begins_in_noise) else 0.0


def _is_tone(samples: Array) -> bool:
    """True if one frequency stands out of what is heard, which then is no noise; the slope weighs what is high."""
    power = np.abs(np.fft.rfft(np.diff(samples) * np.hanning(len(samples) - 1))) ** 2
    highest = int(np.argmax(power))
    return bool(power[max(0, highest - 2) : highest + 3].sum() > _TONAL * power.sum())


def _starts(power: Array, step: int, rate: float) -> list[int]:
    """Return steps at which a power rises suddenly: that of the slope weighs what is high, as onsets do and hiss does,
    too."""
    apart = round(_APART * rate / step)
    quiet = float(np.median(np.sort(power)[: max(3, len(power) // 20)]))
    padded = np.r_[np.full(apart, quiet), power]
    before = np.lib.stride_tricks.sliding_window_view(padded, apart)[: len(power)].max(axis=1)
    ahead = np.maximum(power, np.r_[power[1:], 0])
    rises = (ahead > _RISE * before) & (ahead > _SOFTEST * power.max())
    starts: list[int] = []
    for place in np.flatnonzero(rises):
        if not starts or place - starts[-1] > apart:
            starts.append(int(place))
    return starts


def _onset(samples: Array, place: int, end: int, rate: float, floor: float) -> int:
    """Return the sample at which a hit near `place` begins: after the last quiet before it has risen."""
    low = max(0, place - round(_STEP * rate))
    piece = np.abs(samples[low : min(end, place + round(_ATTACK * rate))])
    risen = int(np.argmax(piece > _RISEN * piece.max()))
    width = max(1, round(2.5e-4 * rate))
    envelope = np.array([piece[max(0, i - width) : i + 1].max() for i in range(risen)])
    begin = max(_BEGIN * piece.max(), min(_NOISE_S_PEAKS * np.sqrt(floor), _RISEN * piece.max()))
    quiet = np.flatnonzero(envelope < begin)
    return low + (int(quiet[-1]) if quiet.size else 0)


def _length(power: Array, step: int, rate: float, floor: float) -> tuple[int, float]:
    """Return for how long (samples) a hit of this power is heard above the floor, and by how much it falls until then
    (dB)."""
    if len(power) < 4:
        return 0, 0.0
    level = 10 * np.log10(power + 1e-30)
    peak = float(level[: max(4, round(0.05 * rate / step))].max())
    heard = np.flatnonzero(level > max(peak - _DROP, 10 * np.log10(floor + 1e-30) + _ABOVE_FLOOR))
    length = min((int(heard[-1]) + 2 if heard.size else 0) * step, round(LONGEST_HIT * rate))
    late = level[max(0, length // step - 4) : length // step + 4]
    return length, (float(level.max() - np.mean(late)) if level.max() <= peak + _SWELL else 0.0)
