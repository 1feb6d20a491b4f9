"""A body's modes, noise and striker from recordings of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..numerics.blas import on_one_thread
from ..numerics.checks import Array
from .blow import LEAST_DRIVE, Blow, begun, earliest, sought
from .errors import RecordingError
from .esprit import candidates
from .evidence import Floor, energies, floor_of, floor_of_rest, needed, slowest_known, spread, standing, unknown
from .gains import real_gains
from .hits import Hit
from .noise import Bands, noise_bands, without_tones
from .pruning import prune
from .pursuit import pursued
from .refinement import amplitudes, plain, refine
from .selection import select
from .sums import Complex, Head, ring

MODES = 40
"""Most modes of a fit, unless the caller says otherwise."""

LOWEST_HEARD = 20.0
"""Hz"""

_ROUNDS, _HARDLY_LESS = 3, 0.995  # in which modes of the rest take the place of weaker ones, while less is left
_CLEARINGS, _NEAR = 8, 20.0  # times that modes are left out whose decays nobody knows, one of those so near (Hz)
_STEPS, _FEW, _LAST = 10, 4, 25
_POOREST, _LEAST_FALL = -6.0, 15.0  # dB: the residual of what need not fall, the fall of what modes need not explain
_NOISY = 2.0  # times the noise's energy: a rest that has less is noise
_FALL_IN_NOISE = 6.0  # dB, which a hit falls at least into noise
_SHORT_BLOW, _LONGEST_BLOW = 0.0015, 0.01  # s
_RINGING, _CLICK = 0.4, 1000.0  # of its angular frequency, and 1/s: a mode that decays faster is a click
_STEADY = 0.12  # nepers, by which a mode falls over the whole recording: less is a tone that stands
_FILTERED, _FILTER_DAMPED = 40.0, 0.3  # Hz, of its angular frequency: the answer of the filter that takes rumble away
_BRIEFEST, _RINGS = 460.0, 0.1  # 1/s, and a share of the energy: so much has to decay no faster
_TELLS = 0.5  # s: less shows nothing


@dataclass(frozen=True)
class Fit:
    """The result of a fit to one hit or several: k modes, R takes.

    frequency (k,) in Hz and decay (k,) in 1/s of the undamped mode, ascending; amplitude: of each take's modes (k,) at
    its onset; gains (R, k): of each mode, per N s of an ideal blow; noise: bands as loud, per N s. blows: of each take,
    in time from its onset.
    residual (R,) in dB: what the modes leave of each take's energy. takes: the samples from 5 ms before the onset on,
    without tones that stand. modes: their part of each take. spread (k,): standard deviations of the decays, as shares
    of them. at_least (k,): whether a mode rings for longer than the takes show. tones: Hz, of what stands.
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
    spread: Array
    at_least: npt.NDArray[np.bool_]
    tones: Array

    def sound(self, take: int = 0, noise: bool = True) -> Array:
        """Return a take as it was fitted."""
        early = earliest(self.rate)
        sound = self.modes[take].copy()
        if noise:
            sound[early:] += self.heard_noise.sound(len(sound) - early, self.rate)
        return sound

    heard_noise: Bands
    """The noise as it is in the takes."""

    @property
    def poles(self) -> Complex:
        """Poles of the modes, in 1/s."""
        omega = 2 * np.pi * self.frequency
        poles: Complex = -self.decay + 1j * np.sqrt(omega**2 - np.minimum(self.decay, 0.99 * omega) ** 2)
        return poles

    def struck_by(self, blows: Sequence[Blow]) -> Fit:
        """Return the same with other blows, and the gains that follow from them."""
        poles = self.poles
        # A velocity's answer to an impulse begins as 1 + i sigma/omega, in amplitude and phase.
        answer = 1 - 1j * poles.real / poles.imag
        free = [c / blow.drive(poles) / answer for c, blow in zip(self.amplitude, blows, strict=True)]
        gains = real_gains(free, poles / self.rate, [len(take) for take in self.takes])
        return replace(self, blows=tuple(blows), gains=gains, noise=_per_impulse(self.heard_noise, blows))


def fit_modes(takes: Sequence[Array], rate: float, count: int, floors: Sequence[Floor] | None = None) -> Complex:
    """Log poles per sample of the modes that explain most of all takes, which begin with the modes' ringing.

    count: at most so many; fewer where no more rise above the noise. floors: of each take; what modes leave at its end
    unless it is given.
    """
    with on_one_thread():
        heads = plain(takes)
        s = select(takes, _candidates(takes, rate, count), count)
        s = refine(takes, s, rate, heads, _STEPS)
        floors = floors or [floor_of_rest(rest, rate) for rest in _rests(takes, s)]
        s = prune(takes, s, count, needed(takes, floors, s, rate))
        best, least = s, amplitudes(takes, s, heads(s))[1]
        for _ in range(_ROUNDS):
            rests = _rests(takes, s)
            more = select(rests, _candidates(rests, rate, count // 2), -(-count // 2))
            s = refine(takes, np.concatenate([s, more]), rate, heads, _FEW)
            s = refine(takes, prune(takes, s, count, needed(takes, floors, s, rate)), rate, heads, _STEPS)
            left = amplitudes(takes, s, heads(s))[1]
            if left >= _HARDLY_LESS * least:
                break
            best, least = s, left
        return _known(takes, refine(takes, best, rate, heads, _LAST), rate, floors)


def _known(takes: Sequence[Array], s: Complex, rate: float, floors: Sequence[Floor]) -> Complex:
    """Return the modes that rise above the noise and whose decays are known; the least known ones go first."""
    heads = plain(takes)
    for _ in range(_CLEARINGS):
        s = prune(takes, s, len(s), needed(takes, floors, s, rate))
        if not len(s):
            return s
        amplitude, _ = amplitudes(takes, s, heads(s))
        rests = [take - ring(c, s, len(take)) for c, take in zip(amplitude, takes, strict=True)]
        doubt = spread(takes, rests, s, amplitude, heads(s))
        keep, unclear = np.ones(len(s), bool), unknown(doubt, energies(takes, s, amplitude))
        for mode in np.argsort(-doubt):
            near = np.abs(s.imag - s.imag[mode]) < 2 * np.pi * _NEAR / rate
            keep[mode] = not (unclear[mode] and np.all(keep[near]))
        if keep.all() or not keep.any():
            return s
        s = refine(takes, s[keep], rate, heads, _FEW)
    return s


def _candidates(takes: Sequence[Array], rate: float, count: int) -> Complex:
    return np.concatenate([candidates(takes, rate), pursued(takes, rate, count)])


def _rests(takes: Sequence[Array], s: Complex) -> list[Array]:
    """Return the rests of takes: what modes leave of each."""
    found, _ = amplitudes(takes, s, [None] * len(takes))
    return [take - ring(amplitude, s, len(take)) for amplitude, take in zip(found, takes, strict=True)]


def fit(found: Sequence[Hit], blows: Sequence[Blow | None], count: int = MODES) -> Fit:
    """Fit modes, noise and blows to hits on one body, all at one rate.

    blows: the force of each where it is known, from any time on; None where it is to be found. count: of modes.
    RecordingError if there are none.
    """
    with on_one_thread():
        return _fit(found, blows, count)


def _fit(found: Sequence[Hit], blows: Sequence[Blow | None], count: int) -> Fit:
    rate = found[0].rate
    after = [hit.samples[_blow_end(hit, blow) :] for hit, blow in zip(found, blows, strict=True)]
    floors = [floor_of(hit.quiet, rate) for hit in found] if all(len(hit.quiet) for hit in found) else None
    s = fit_modes(after, rate, count, floors)
    if not len(s):
        raise RecordingError("nothing in it rings: expected the sound of a strike")
    early = earliest(rate)
    takes = [_with_beginning(hit, early) for hit in found]
    begins = _begun(takes, s, rate, blows)
    s = refine(takes, s, rate, lambda each: [blow.head(each, rate, early) for blow in begins], _STEPS)
    s = prune(after, s, len(s))
    s = s[np.argsort(s.imag)]
    heads = [blow.head(s, rate, early) for blow in begins]
    amplitude, _ = amplitudes(takes, s, heads)
    rests = [take - ring(c, s, len(take), head) for c, take, head in zip(amplitude, takes, heads, strict=True)]
    residual = [10 * np.log10(np.sum(rest**2) / np.sum(take**2)) for take, rest in zip(takes, rests, strict=True)]
    _require_ringing(residual, rests, found, len(s))
    spreads = spread(takes, rests, s, amplitude, heads)
    keep = _decaying(found, s, amplitude)
    kept = [Head(head.atoms[:, keep], head.slopes[:, keep], head.origin) for head in heads]
    amplitude = [c[keep] for c in amplitude]
    tones = s[~keep].imag * rate / (2 * np.pi)
    s, spreads = s[keep], spreads[keep]
    modes = [ring(c, s, len(take), head) for c, take, head in zip(amplitude, takes, kept, strict=True)]
    takes = [mode + rest for mode, rest in zip(modes, rests, strict=True)]
    clear = s.imag * rate / (2 * np.pi), -s.real * rate
    heard = noise_bands(
        [without_tones(rest[early:], *clear, rate) for rest in rests], [hit.quiet for hit in found], rate
    )
    least = slowest_known(takes)
    poles = np.minimum(s.real, -least) * rate + 1j * s.imag * rate
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
        spread=spreads,
        at_least=-s.real < least,
        tones=tones[tones > LOWEST_HEARD],
        heard_noise=heard,
    )
    return blank.struck_by(begins)


def _require_ringing(residual: Sequence[float], rests: Sequence[Array], found: Sequence[Hit], count: int) -> None:
    """Raise RecordingError where so many modes leave too much (dB), and what they leave is not the noise."""
    if np.mean(residual) > _POOREST and not all(_is_noise(*pair) for pair in zip(rests, found, strict=True)):
        explained = 100 - 100 * 10 ** (np.mean(residual) / 10)
        raise RecordingError(
            f"its level hardly falls, and {count} modes explain {explained:.0f} %: expected a strike that rings out"
        )


def _is_noise(rest: Array, hit: Hit) -> bool:
    """True if the rest of a hit may be so large: the hit falls well, or the rest is no more than the noise."""
    noise = _NOISY * len(rest) * hit.floor**2
    return hit.fall >= _LEAST_FALL or (hit.fall >= _FALL_IN_NOISE and float(rest @ rest) < noise)


def _decaying(found: Sequence[Hit], s: Complex, amplitude: Sequence[Complex]) -> npt.NDArray[np.bool_]:
    """True for the modes that ring and are heard: neither hum, nor too low to hear.

    RecordingError if there are none, or if what is loudest does not decay.
    """
    rate = found[0].rate
    energy = energies([hit.samples for hit in found], s, amplitude)
    longest = max(len(hit.samples) for hit in found)
    steady = -s.real * longest < _STEADY
    dead = energy[steady].sum() > 0.5 * energy.sum() and min(hit.fall for hit in found) < _LEAST_FALL
    filtered = (s.imag * rate < 2 * np.pi * _FILTERED) & (-s.real > _FILTER_DAMPED * s.imag)
    keep = ~(standing(found, s, amplitude) | filtered | (s.imag * rate < 2 * np.pi * LOWEST_HEARD))
    if (dead and longest > _TELLS * rate) or not keep.any():
        raise RecordingError("nothing that is heard decays: expected the sound of a strike")
    rings = keep & (-s.real < np.minimum(_BRIEFEST / rate, _RINGING * s.imag))
    if energy[rings].sum() < _RINGS * sum(np.sum(hit.samples**2) for hit in found):
        raise RecordingError("a click, in which nothing rings for 15 ms: expected the sound of a strike")
    return keep


def _begun(takes: Sequence[Array], s: Complex, rate: float, blows: Sequence[Blow | None]) -> list[Blow]:
    """Return each take's blow, known or sought, where it begins; by the modes that ring, as clicks would explain any
    blow."""
    early, rings = earliest(rate), -s.real < np.minimum(_RINGING * s.imag, _CLICK / rate)
    s = s[rings] if rings.any() else s
    return [
        sought(take, s, rate, early) if blow is None else begun(take, s, rate, blow, early)
        for take, blow in zip(takes, blows, strict=True)
    ]


def _blow_end(hit: Hit, blow: Blow | None) -> int:
    """Return the sample from which on a hit rings by itself; the onset where the blow is short, or nobody knows it."""
    if blow is None or blow.duration < _SHORT_BLOW:
        return 0
    return round(min(blow.duration, _LONGEST_BLOW) * hit.rate)


def _with_beginning(hit: Hit, early: int) -> Array:
    """Return a hit from so many samples before its onset on."""
    before = hit.before[-early:] if len(hit.before) else hit.before
    return np.concatenate([np.zeros(early - len(before)), before, hit.samples])


def _per_impulse(noise: Bands, blows: Sequence[Blow]) -> Bands:
    """Return the noise per N s of an ideal blow."""
    bands = noise.edges[:-1], noise.edges[1:]
    drives = [np.maximum(blow.drive_of_bands(*bands), LEAST_DRIVE * blow.impulse) for blow in blows]
    drive = np.sqrt(np.mean(np.square(drives), axis=0))
    return Bands(noise.edges, noise.rms / drive, noise.decay, noise.floor)
