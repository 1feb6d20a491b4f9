"""The blow that a recording begins with: its force over time, and what it does to the modes.

A force of impulses p_j at times t_j (samples) moves a mode of the log pole s as F(s) = sum_j p_j exp(-s t_j) does, once
it is over; before, as much of the sum as has come. So each mode's sound begins as the atom

    a(t) = exp(s t) sum_{t_j <= t} p_j exp(-s t_j)/F(s),

an exponential from the end of the blow on. This is how modes and striker are told apart where nobody measured the
force: the pulse of the Hunt-Crossley law for which the atoms explain the attack is looked for, the longest one that
does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..numerics.checks import Array
from .distance import third_octaves
from .errors import RecordingError
from .pulses import unit_pulse, unit_time
from .refinement import amplitudes, solved
from .sums import Complex, Head, as_weights, real_gram, ringing_products, ringing_project

EXPONENT, DISSIPATION = 1.5, 0.2
"""Exponent and dissipation (s/m) of a striker of which nothing is known: Hertz's."""

_DURATIONS = np.geomspace(5e-5, 8e-3, 18)  # s
_SHARES = (0.0, 0.06, 0.12, 0.2, 0.3, 0.42, 0.55, 0.7, 0.9)  # of a duration: so much before the onset it may begin
_EARLIEST = 0.005  # s: the recording is looked at from so long before the onset
_TOLERANCE = 0.5  # of what the best blow leaves of the attack: as good
_HARDLY = 1e-4  # of the energy of a take, or of its attack
_FOOT, _STANDS_OUT = 0.005, 0.3  # of a measured force's peak: its pulse ends there; its noise may reach so high
_NOISE_S_PEAKS, _MEDIAN_OF_NOISE = (
    4.0,
    0.6745,
)  # rms of noise that its samples hardly reach; its median size over its rms
_LOWEST_LIKENESS, _HIGHEST_LIKENESS = 50.0, 20_000.0  # Hz
LEAST_DRIVE = 0.02  # of the impulse: where a blow moves a mode less, it counts as moving it as much
_ATTACK = 0.02  # s, since the onset
_IN_BAND = 9  # frequencies by which a band is looked at


@dataclass(frozen=True)
class Blow:
    """A force: times (s) since the onset of a take, impulses (N s), (m,) each."""

    times: Array
    impulses: Array

    @property
    def impulse(self) -> float:
        """Momentum that the blow gives, in N s."""
        return float(self.impulses.sum())

    @property
    def duration(self) -> float:
        """Duration of the blow, in s."""
        return float(self.times[-1] - self.times[0])

    def later(self, seconds: float) -> Blow:
        """Return the same blow, so much later."""
        return replace(self, times=self.times + seconds)

    def transform(self, poles: Complex) -> Complex:
        """Return F (N s) at poles (1/s)."""
        transformed: Complex = np.exp(-np.outer(poles, self.times)) @ self.impulses
        return transformed

    def drive(self, poles: Complex) -> Complex:
        """Return F at poles (1/s), where it is next to nothing as large as that is taken to be."""
        force = self.transform(poles)
        size = np.abs(force)
        least = LEAST_DRIVE * self.impulse
        return np.where(size < least, force * (least / np.maximum(size, 1e-30 * least)), force)

    def drive_of_bands(self, low: Array, high: Array) -> Array:
        """Return the rms of |F| (N s) over each of some bands (Hz): a pulse's spectrum has zeros, no band of noise
        has."""
        frequency = np.geomspace(low, high, _IN_BAND)
        force = self.transform(np.ravel(2j * np.pi * frequency)).reshape(frequency.shape)
        return np.asarray(np.sqrt(np.mean(np.abs(force) ** 2, axis=0)))

    def head(self, s: Complex, rate: float, onset: int, length: int | None = None) -> Head:
        """Return the beginnings of the atoms of log poles per sample, and of their slopes, for a take at a rate (Hz).

        onset: the take's. length: of the head, in samples; as long as the blow unless it is given.
        """
        places = self.times * rate
        t = np.arange(length or onset + int(np.ceil(places[-1])) + 1) - onset
        come = np.searchsorted(places, t, side="right")
        parts = self.impulses[:, None] * np.exp(-np.outer(places, s))
        none = np.zeros((1, len(s)))
        force = np.vstack([none, np.cumsum(parts, axis=0)])
        slope = np.vstack([none, np.cumsum(-places[:, None] * parts, axis=0)])
        # A mode that the blow hardly moves begins as the momentum comes, and not as its own small share of it.
        hardly = np.abs(force[-1]) < LEAST_DRIVE * self.impulse
        force[:, hardly] = np.concatenate([[0], np.cumsum(self.impulses)])[:, None]
        slope[:, hardly] = 0
        begun = force[come] / force[-1]
        ringing = np.exp(np.outer(t, s)) * (come > 0)[:, None]
        slopes = ringing * (t[:, None] * begun + (slope[come] - begun * slope[-1]) / force[-1])
        return Head(ringing * begun, slopes, onset)


def pulse(duration: float, impulse: float = 1.0) -> Blow:
    """Return the force of an unknown striker, so long (s) and so strong (N s)."""
    times, impulses = unit_pulse(DISSIPATION, EXPONENT)
    return Blow(times * duration / (times[0] + times[-1]), impulses * impulse / impulses.sum())


def striker_pulse(velocity: float, mass: float, stiffness: float, dissipation: float, exponent: float) -> Blow:
    """Return the force of a known striker on a rigid wall: m/s, kg, N/m^a, s/m and a."""
    times, impulses = unit_pulse(dissipation * velocity, exponent)
    return Blow(times * unit_time(velocity, mass, stiffness, exponent), impulses * mass * velocity)


def measured(force: Array, rate: float) -> Blow:
    """Return a force (n,) in any unit as a hammer measured it at a rate (Hz), without its noise and offset.

    RecordingError if no pulse stands out of it.
    """
    force = force - np.median(force)
    peak = int(np.argmax(np.abs(force)))
    force = force * np.sign(force[peak])
    noise = float(np.median(np.abs(force))) / _MEDIAN_OF_NOISE
    least = max(_FOOT * force[peak], _NOISE_S_PEAKS * noise)
    if least > _STANDS_OUT * force[peak]:
        raise RecordingError("no pulse stands out of its noise: expected the force of a hammer")
    below = np.flatnonzero(force < least)
    begin = int(below[below < peak].max(initial=-1)) + 1
    end = int(below[below > peak].min(initial=len(force)))
    return Blow(np.arange(begin, end) / rate, force[begin:end] / rate)


def alike(blow: Blow) -> Blow:
    """Return the pulse of an unknown striker that is nearest to a blow, by the sizes of their spectra, at the same
    time."""
    frequency = np.geomspace(_LOWEST_LIKENESS, _HIGHEST_LIKENESS, 60)
    turning = np.asarray(2j * np.pi * frequency, np.complex128)
    size = np.abs(blow.transform(turning))
    longest = max(blow.duration, 2 * _DURATIONS[0])
    tried = [pulse(each, blow.impulse) for each in np.geomspace(0.5 * longest, 2 * longest, 81)]
    errors = [np.sum((np.abs(each.transform(turning)) - size) ** 2) for each in tried]
    found = tried[int(np.argmin(errors))]
    middle, its_own = (float(each.times @ each.impulses) / each.impulse for each in (blow, found))
    return found.later(middle - its_own)


def begun(take: Array, s: Complex, rate: float, blow: Blow, onset: int) -> Blow:
    """Return the blow at the time near a take's onset (samples) at which its atoms explain most of the take."""
    tried = [blow.later(start - blow.times[0]) for start in _beginnings(blow.duration, onset / rate)]
    return tried[int(np.argmin(_errors(take, s, rate, tried, onset)))]


def sought(take: Array, s: Complex, rate: float, onset: int) -> Blow:
    """Return the longest blow whose atoms explain a take's attack as well as any do; it begins near the onset
    (samples).

    It is no longer than what is heard of the high modes and bands allows (`_longest`).
    """
    longest = _longest(take, s, rate, onset)
    tried = [pulse(each).later(start) for each in _DURATIONS[:longest] for start in _beginnings(each, onset / rate)]
    errors = _errors(take, s, rate, tried, onset)
    best = tried[int(np.argmin(errors))].head(s, rate, onset)
    (amplitude,), _ = amplitudes([take], s, [best])
    attack = take[: best.length] - (best.atoms @ amplitude).real
    enough = errors.min() + _TOLERANCE * float(attack @ attack)
    least = errors.reshape(longest, -1).min(axis=1)
    number = int(np.flatnonzero(least <= enough)[-1])
    return tried[number * len(_SHARES) + int(np.argmin(errors.reshape(longest, -1)[number]))]


def _longest(take: Array, s: Complex, rate: float, onset: int) -> int:
    """Return how many of _DURATIONS move what is heard: most of what a take has is not from modes that the blow hardly
    moves, nor is most of what its attack has from such bands."""
    (amplitude,), _ = amplitudes([take], s, [pulse(_DURATIONS[0]).head(s, rate, onset)])
    ringing = np.abs(amplitude) ** 2 / -s.real
    middle, attack = _attack(take, rate, onset)
    low, high = middle * 2 ** (-1 / 6), middle * 2 ** (1 / 6)
    for count, duration in enumerate(_DURATIONS[1:], start=1):
        blow = pulse(duration)
        unmoved = ringing[np.abs(blow.transform(s * rate)) < LEAST_DRIVE].sum()
        faint = attack[blow.drive_of_bands(low, high) < LEAST_DRIVE].sum()
        if unmoved > _HARDLY * ringing.sum() or faint > _HARDLY * attack.sum():
            return count
    return len(_DURATIONS)


def _attack(take: Array, rate: float, onset: int) -> tuple[Array, Array]:
    """Return the middles (Hz) of third octaves, and what each has of the energy of a take's attack, less what stays
    until the take's end."""
    size = min(onset + round(_ATTACK * rate), len(take) // 2)
    begin, end = np.hanning(2 * onset)[:onset], np.hanning(2 * (size - onset))[size - onset :]
    window = np.concatenate([begin, end])  # no edge has a spectrum of its own
    (middle, begun), (_, left) = (third_octaves(each * window, rate).T for each in (take[:size], take[-size:]))
    return middle, np.maximum(10 ** (begun / 10) - 10 ** (left / 10), 0)


def _beginnings(duration: float, earliest: float) -> list[float]:
    """Return the times (s) before a blow's sound is heard at which it may begin."""
    return [max(-share * duration, -earliest) for share in _SHARES]


def _errors(take: Array, s: Complex, rate: float, blows: Sequence[Blow], onset: int) -> Array:
    """Return the energy of a take that the atoms of each blow leave unexplained."""
    length = onset + max(int(np.ceil(blow.times[-1] * rate)) for blow in blows) + 1
    plain, crossed = ringing_products(s, len(take) - length, length - onset)
    projected = ringing_project(take[length:], s, length - onset)
    energy, errors = float(take @ take), []
    for blow in blows:
        atoms = blow.head(s, rate, onset, length).atoms
        gram = real_gram(plain + atoms.T @ atoms, crossed + atoms.conj().T @ atoms)
        errors.append(energy - solved(gram, as_weights(projected + take[:length] @ atoms))[1])
    return np.maximum(errors, 1e-12 * energy)


def earliest(rate: float) -> int:
    """Return by how many samples a take begins before the onset."""
    return round(_EARLIEST * rate)
