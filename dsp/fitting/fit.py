"""A body's modes, noise and striker from recordings of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..numerics.blas import on_one_thread
from ..numerics.checks import Array
from .blow import Blow, begun, earliest, sought
from .errors import RecordingError
from .esprit import candidates
from .gains import real_gains
from .hits import Hit
from .noise import Bands, noise_bands, without_tones
from .pruning import prune
from .pursuit import pursued
from .refinement import amplitudes, plain, refine
from .selection import select
from .sums import Complex, ring

MODES = 40
"""Unless it is said."""

_ROUNDS, _HARDLY_LESS = 3, 0.995  # in which modes of the rest take the place of weaker ones, while less is left
_STEPS, _FEW, _LAST = 10, 4, 25
_HUM = 0.5  # of a mode's amplitude: what has that before the hit already is no mode
_POOREST, _LEAST_FALL = -6.0, 15.0  # dB: the residual of what need not fall, the fall of what modes need not explain
_SHORT_BLOW, _LONGEST_BLOW = 0.0015, 0.01  # s
_RINGING, _CLICK = 0.4, 1000.0  # of its angular frequency, and 1/s: a mode that decays faster is a click
_STEADY = 60.0  # s, of a decay by 60 dB: what takes longer stands still
_TELLS = 0.5  # s: in less, nobody can tell


@dataclass(frozen=True)
class Fit:
    """What was found in one hit or several: k modes, R takes.

    frequency (k,) in Hz and decay (k,) in 1/s of the undamped mode, ascending; amplitude: of each take's modes (k,) at
    its onset; gains (R, k): of each mode, per N s of an ideal blow; noise: bands as loud, per N s. blows: of each take,
    in time from its onset.
    residual (R,) in dB: what the modes leave of each take's energy. takes: the samples from 5 ms before the onset on.
    modes, rest: the parts of each take.
    """

    rate: float
    frequency: Array
    decay: Array
    amplitude: tuple[Complex, ...]
    gains: Array
    noise: Bands
    blows: tuple[Blow, ...]
    residual: Array
    takes: tuple[Array, ...]
    modes: tuple[Array, ...]

    def sound(self, take: int = 0, noise: bool = True) -> Array:
        """A take as it was fitted."""
        early = earliest(self.rate)
        sound = self.modes[take].copy()
        if noise:
            sound[early:] += self.heard_noise.sound(len(sound) - early, self.rate)
        return sound

    heard_noise: Bands
    """The noise as it is in the takes."""

    @property
    def poles(self) -> Complex:
        """Of the modes, in 1/s."""
        omega = 2 * np.pi * self.frequency
        poles: Complex = -self.decay + 1j * np.sqrt(omega**2 - np.minimum(self.decay, 0.99 * omega) ** 2)
        return poles

    def struck_by(self, blows: Sequence[Blow]) -> Fit:
        """The same with other blows, and the gains that follow from them."""
        poles = self.poles
        # A velocity's answer to an impulse begins as 1 + i sigma/omega, in amplitude and phase.
        answer = 1 - 1j * poles.real / poles.imag
        free = [c / blow.drive(poles) / answer for c, blow in zip(self.amplitude, blows, strict=True)]
        gains = real_gains(free, poles / self.rate, [len(take) for take in self.takes])
        return replace(self, blows=tuple(blows), gains=gains, noise=_per_impulse(self.heard_noise, blows))


def fit_modes(takes: Sequence[Array], rate: float, count: int) -> Complex:
    """Log poles per sample of the `count` modes that explain most of all takes, which begin with the modes' ringing."""
    with on_one_thread():
        heads = plain(takes)
        s = candidates(takes, rate)
        if len(s) < count:
            s = np.concatenate([s, pursued(takes, rate, count)])
        s = select(takes, s, count)
        s = refine(takes, s, rate, heads, _STEPS)
        best, least = s, amplitudes(takes, s, heads(s))[1]
        for _ in range(_ROUNDS):
            rests = [take - part for take, part in zip(takes, _parts(takes, s), strict=True)]
            more = np.concatenate([candidates(rests, rate), pursued(rests, rate, count // 2)])
            more = select(rests, more, -(-count // 2))
            s = refine(takes, np.concatenate([s, more]), rate, heads, _FEW)
            s = refine(takes, prune(takes, s, count), rate, heads, _STEPS)
            left = amplitudes(takes, s, heads(s))[1]
            if left >= _HARDLY_LESS * least:
                break
            best, least = s, left
        return refine(takes, best, rate, heads, _LAST)


def _parts(takes: Sequence[Array], s: Complex) -> list[Array]:
    found, _ = amplitudes(takes, s, [None] * len(takes))
    return [ring(amplitude, s, len(take)) for amplitude, take in zip(found, takes, strict=True)]


def fit(found: Sequence[Hit], blows: Sequence[Blow | None], count: int = MODES) -> Fit:
    """The modes, noise and blows of hits on one body, all at one rate.

    blows: the force of each where it is known, from any time on; None where it is to be found. count: of modes.
    RecordingError if there are none.
    """
    with on_one_thread():
        return _fit(found, blows, count)


def _fit(found: Sequence[Hit], blows: Sequence[Blow | None], count: int) -> Fit:
    rate = found[0].rate
    after = [hit.samples[_blow_end(hit, blow) :] for hit, blow in zip(found, blows, strict=True)]
    s = _without_hum(fit_modes(after, rate, count), found)
    early = earliest(rate)
    takes = [_with_beginning(hit, early) for hit in found]
    begins = _begun(takes, s, rate, blows)
    s = refine(takes, s, rate, lambda each: [blow.head(each, rate, early) for blow in begins], _STEPS)
    s = s[np.argsort(s.imag)]
    heads = [blow.head(s, rate, early) for blow in begins]
    amplitude, _ = amplitudes(takes, s, heads)
    modes = [ring(c, s, len(take), head) for c, take, head in zip(amplitude, takes, heads, strict=True)]
    residual = [
        10 * np.log10(np.sum((take - mode) ** 2) / np.sum(take**2)) for take, mode in zip(takes, modes, strict=True)
    ]
    if np.mean(residual) > _POOREST and min(hit.fall for hit in found) < _LEAST_FALL:
        raise RecordingError(
            f"its level hardly falls, and {count} modes explain {100 - 100 * 10 ** (np.mean(residual) / 10):.0f} %: "
            "expected a strike that rings out"
        )
    tones = s.imag * rate / (2 * np.pi), -s.real * rate
    rests = [without_tones(take[early:] - mode[early:], *tones, rate) for take, mode in zip(takes, modes, strict=True)]
    heard = noise_bands(rests, [hit.quiet for hit in found], rate)
    poles = s * rate
    blank = Fit(
        rate=rate,
        frequency=np.abs(poles) / (2 * np.pi),
        decay=-poles.real,
        amplitude=tuple(amplitude),
        gains=np.zeros((len(takes), len(s))),
        noise=heard,
        blows=tuple(begins),
        residual=np.array(residual),
        takes=tuple(takes),
        modes=tuple(modes),
        heard_noise=heard,
    )
    return blank.struck_by(begins)


def _begun(takes: Sequence[Array], s: Complex, rate: float, blows: Sequence[Blow | None]) -> list[Blow]:
    """Each take's blow, known or sought, where it begins; by the modes that ring, as clicks would explain any blow."""
    early, rings = earliest(rate), -s.real < np.minimum(_RINGING * s.imag, _CLICK / rate)
    s = s[rings] if rings.any() else s
    return [
        sought(take, s, rate, early) if blow is None else begun(take, s, rate, blow, early)
        for take, blow in zip(takes, blows, strict=True)
    ]


def _blow_end(hit: Hit, blow: Blow | None) -> int:
    """The sample from which on a hit rings by itself; the onset where the blow is short, or nobody knows it."""
    if blow is None or blow.duration < _SHORT_BLOW:
        return 0
    return round(min(blow.duration, _LONGEST_BLOW) * hit.rate)


def _with_beginning(hit: Hit, early: int) -> Array:
    """A hit from so many samples before its onset on."""
    before = hit.before[-early:] if len(hit.before) else hit.before
    return np.concatenate([np.zeros(early - len(before)), before, hit.samples])


def _per_impulse(noise: Bands, blows: Sequence[Blow]) -> Bands:
    """Noise per N s of an ideal blow."""
    middle = np.sqrt(noise.edges[:-1] * noise.edges[1:])
    drive = np.sqrt(np.mean([np.abs(blow.drive(2j * np.pi * middle)) ** 2 for blow in blows], axis=0))
    return Bands(noise.edges, noise.rms / drive, noise.decay, noise.floor)


def _without_hum(s: Complex, found: Sequence[Hit]) -> Complex:
    """The modes that do not stand in the recording before the hit already.

    RecordingError if there are none, or if what is loudest does not decay.
    """
    rate = found[0].rate
    keep = np.ones(len(s), bool)
    size = [np.abs(c) for c in amplitudes([hit.samples for hit in found], s, [None] * len(found))[0]]
    for hit, amplitude in zip(found, size, strict=True):
        if len(hit.before) > 0.1 * rate:
            window = np.hanning(len(hit.before))
            tone = np.exp(-1j * np.outer(s.imag, np.arange(len(hit.before))))
            keep &= 2 * np.abs(tone @ (window * hit.before)) / window.sum() < _HUM * amplitude
    energy = np.sum(np.square(size), axis=0) / -s.real
    steady = -s.real * rate < np.log(1000) / _STEADY
    stands = energy[steady].sum() > 0.5 * energy.sum() and min(hit.fall for hit in found) < _LEAST_FALL
    stands &= max(len(hit.samples) for hit in found) > _TELLS * rate
    if stands or not keep.any():
        raise RecordingError("nothing that is heard decays: expected the sound of a strike")
    return s[keep]
