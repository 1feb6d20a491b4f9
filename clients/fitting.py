"""Objects from recordings: takes, fit, presets written, and the result played by the engine."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from ..dsp.errors import CaromError
from ..dsp.fitting.blow import Blow, alike, measured, pulse, striker_pulse
from ..dsp.fitting.distance import at_rate, distance
from ..dsp.fitting.errors import RecordingError
from ..dsp.fitting.fit import MODES, Fit, fit
from ..dsp.fitting.hits import Hit, clearest, hits
from ..dsp.fitting.strikers import MASS, VELOCITY, Striker, durations, striker_of
from ..dsp.numerics.constants import FULL_SCALE_PRESSURE
from ..dsp.runtime.loudness import heard
from ..presets import Presets
from ..presets import fitted as texts
from ..presets.values import NAME, Name
from ..server.render import Options, blocks
from . import fit_notes as said
from .recordings import Recording, found, read
from .strike import Strike

TOP_RATE = 48_000
"""Hz: of what is analysed; faster recordings are resampled."""

UNKNOWN = "unknown"
"""Source or licence in a preset, where none was given."""

_MOST_MODES = 200
_PEAK = -1.5  # dB of full scale, at most: below the limiter, which finds peaks between samples 0.2 dB otherwise
_AS_NEAR = 0.1  # dB: a strike by the measured force that is no further from the recording than that is as good


class FitError(CaromError, ValueError):
    """Error of a fit that cannot be made as requested; the text names why."""


@dataclass(frozen=True)
class Wanted:
    """Facts known beside the recordings.

    positions: 0 to 1, one for each hit. strikers: a preset each, or a new name. force: the hammer's recording. mass: of
    the body (kg). velocity: of the strikes (m/s). full_scale (Pa), distance (m): the sound pressure that full scale of
    the recordings stands for, and how far the microphone was; None where nobody measured it: the strike plays as loud
    as the recording. source, licence: of the recordings.
    """

    name: str
    modes: int = MODES
    positions: tuple[float, ...] = ()
    strikers: tuple[str, ...] = ()
    force: Path | None = None
    mass: float | None = None
    velocity: float = VELOCITY
    full_scale: float | None = None
    distance: float | None = None
    source: str | None = None
    licence: str | None = None

    def __post_init__(self) -> None:
        if not NAME.fullmatch(self.name):
            raise FitError(f"name = {self.name!r}: expected {Name()}")
        if not 1 <= self.modes <= _MOST_MODES:
            raise FitError(f"modes = {self.modes}: expected 1 to {_MOST_MODES}")
        for position in self.positions:
            if not 0 <= position <= 1:
                raise FitError(f"positions: {position:g}: expected 0 to 1")
        for striker in self.strikers:
            if not NAME.fullmatch(striker):
                raise FitError(f"strikers: {striker!r}: expected {Name()}")
        for key, value, most in (
            ("mass", self.mass, 1e5), ("velocity", self.velocity, 100.0), ("full-scale", self.full_scale, 1e5),
            ("distance", self.distance, 1e3),
        ):  # fmt: skip
            if value is not None and not 1e-3 <= value <= most:
                raise FitError(f"{key} = {value:g}: expected 0.001 to {most:g}")

    @property
    def raised(self) -> float:
        """Level (dB) by which to play the strike louder than the recording, which full scale at 1 m would be."""
        pressure = (self.full_scale or FULL_SCALE_PRESSURE) * (self.distance or 1.0)
        return 20 * float(np.log10(pressure / FULL_SCALE_PRESSURE))


@dataclass(frozen=True)
class Take:
    """A hit that is fitted: its recording, the samples, where (None: unknown) and by what it was struck."""

    recording: Recording
    hit: Hit
    position: float | None
    striker: str | None


@dataclass(frozen=True)
class Made:
    """Result of a fit: the fit, its takes, the files that were written, the notes on it, and the strike as played.

    sound: (n,) at the fit's rate, of the default strike.
    """

    fit: Fit
    takes: tuple[Take, ...]
    files: tuple[Path, ...]
    notes: tuple[str, ...]
    sound: NDArray[np.float64]


def make(recordings: Sequence[Path], out: Path, wanted: Wanted, presets: Presets | None = None) -> Made:
    """Fit an object to recordings and write it and its strikers into a folder of presets, which is made if missing.

    FitError, RecordingError, PresetError or OSError say what cannot be.
    """
    presets = presets or Presets()
    read_in = readable(recordings, out)
    takes, notes = _takes(read_in, wanted)
    known = {name: presets.striker(name) for name in wanted.strikers if name in presets.names("strikers")}
    blows: list[Blow | None] = [None] * len(takes)
    for number, take in enumerate(takes):
        if take.striker in known and wanted.force is None:
            law = known[take.striker].contact(None)
            blows[number] = striker_pulse(wanted.velocity, *law)
    try:
        found_in = fit([take.hit for take in takes], blows, wanted.modes)
    except RecordingError as error:
        raise RecordingError(f"{', '.join(str(each.path) for each in read_in)}: {error}") from None
    found_in, strikers = _strikers(found_in, takes, blows, wanted)
    if wanted.force is not None:
        found_in, strikers, more = _by_force(wanted.force, (found_in, strikers), takes, wanted)
        notes += more
    files, sound, louder, quieter = _write(found_in, takes, wanted, strikers, out)
    licence = [] if wanted.licence else [f"the licence of {read_in[0].path} is unknown: give --licence and --source"]
    notes += said.notes(found_in, [take.hit for take in takes])
    if wanted.full_scale is not None:
        notes += said.too_loud(louder, wanted.mass, wanted.velocity)
    notes += said.too_peaked(quieter)
    return Made(found_in, tuple(takes), tuple(files), (*notes, *licence), sound)


def readable(recordings: Sequence[Path], out: Path) -> list[Recording]:
    """Return recordings, to be fitted into a folder. Errors are those of `make` about files: no engine is needed."""
    if out.exists() and not out.is_dir():
        raise FitError(f"{out}: expected a folder for presets")
    return [read(path) for path in found(list(recordings))]


def _takes(recordings: Sequence[Recording], wanted: Wanted) -> tuple[list[Take], list[str]]:
    """Return the hits that are fitted: of each recording the clearest, or all of one that has as many as positions."""
    rate = min(TOP_RATE, *(recording.rate for recording in recordings))
    chosen: list[tuple[Recording, Hit]] = []
    notes: list[str] = []
    for recording in recordings:
        samples = recording.samples if recording.rate == rate else at_rate(recording.samples, recording.rate, rate)
        try:
            there = hits(samples, rate)
        except RecordingError as error:
            raise RecordingError(f"{recording.path}: {error}") from None
        notes += recording.notes
        labels = max(len(wanted.positions), len(wanted.strikers))
        if len(recordings) == 1 and len(there) == labels > 1:
            chosen += [(recording, hit) for hit in there]
        else:
            chosen.append((recording, clearest(there)))
            if len(there) > 1:
                at = chosen[-1][1].onset / rate
                notes.append(f"{recording.path}: {len(there)} hits: the clearest one, at {at:.2f} s, is taken")
    for key, labels_of in (("positions", wanted.positions), ("strikers", wanted.strikers)):
        if labels_of and len(labels_of) not in (1, len(chosen)):
            raise FitError(f"{key}: {len(labels_of)} for {len(chosen)} hits: expected one, or one for each")
    positions = _each(wanted.positions, len(chosen))
    strikers = _each(wanted.strikers, len(chosen))
    takes = [Take(*pair, at, by) for pair, at, by in zip(chosen, positions, strikers, strict=True)]
    return takes, notes


def _each(values: Sequence, count: int) -> list:  # type: ignore[type-arg]
    """Return a value for each of so many takes: None if there are none, the same if there is one."""
    return list(values) * (count if len(values) == 1 else 1) or [None] * count


def _force(path: Path, take: Take) -> Blow:
    """Return the force that a hammer measured of a take's hit."""
    recording = read(path)
    rate = take.hit.rate
    samples = recording.samples if recording.rate == rate else at_rate(recording.samples, recording.rate, rate)
    if not np.any(samples):
        raise RecordingError(f"{path}: silent: expected the force of a hammer")
    try:
        return measured(samples, rate)
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from None


def _by_force(
    path: Path, heard_of: tuple[Fit, dict[str, Striker]], takes: Sequence[Take], wanted: Wanted
) -> tuple[Fit, dict[str, Striker], list[str]]:
    """Return the fit and its strikers as a hammer measured the force, unless those `heard_of` play nearer to the
    recording."""
    own, _ = heard_of
    forces = [alike(_force(path, take)) for take in takes]
    begun = [each.later(blow.times[0] - each.times[0]) for each, blow in zip(forces, own.blows, strict=True)]
    made = [(take.striker, blow, 1.0) for take, blow in zip(takes, begun, strict=True)]
    hammered = own.struck_by(begun), _named(made, wanted)
    apart, by_force = (_apart(*each, takes, wanted) for each in (heard_of, hammered))
    if by_force <= apart + _AS_NEAR:
        return *hammered, []
    note = (
        f"{path}: its blow of {1e3 * begun[0].duration:.2g} ms leaves the preset {by_force:.1f} dB from the recording, "
        f"a blow of {1e3 * own.blows[0].duration:.2g} ms only {apart:.1f} dB: the latter is used"
    )
    return *heard_of, [note]


def _apart(found_in: Fit, strikers: dict[str, Striker], takes: Sequence[Take], wanted: Wanted) -> float:
    """Return the log-spectral distance (dB) of a fit's default strike from the recording."""
    with TemporaryDirectory() as folder:
        _, sound, *_ = _write(found_in, takes, wanted, strikers, Path(folder))
    return distance(found_in.takes[0], sound, found_in.rate).spectral


def _strikers(
    found_in: Fit, takes: Sequence[Take], blows: Sequence[Blow | None], wanted: Wanted
) -> tuple[Fit, dict[str, Striker]]:
    """Return the strikers that no preset holds yet, by the names of the presets to write, and the fit with them."""
    strengths = np.ones(len(takes))
    new = [number for number, blow in enumerate(blows) if blow is None]
    if len({takes[number].striker for number in new}) > 1:
        amplitude = [found_in.amplitude[number] for number in new]
        times, strengths[new] = durations(amplitude, found_in.poles, [found_in.blows[number] for number in new])
        begun = list(found_in.blows)
        for number, time in zip(new, times, strict=True):
            begun[number] = pulse(time, strengths[number])
        found_in = found_in.struck_by(begun)
    made = [(takes[number].striker, found_in.blows[number], strengths[number]) for number in new]
    return found_in, _named(made, wanted)


def _named(made: Sequence[tuple[str | None, Blow, float]], wanted: Wanted) -> dict[str, Striker]:
    """Return strikers by the names of their presets, of labels, blows and strengths: the first of each label."""
    strikers: dict[str, Striker] = {}
    for label, blow, strength in made:
        name = f"{wanted.name}-{label or 'striker'}"
        strikers.setdefault(name, striker_of(blow.duration, MASS * float(strength), wanted.velocity))
    return strikers


def _write(
    found_in: Fit, takes: Sequence[Take], wanted: Wanted, strikers: dict[str, Striker], out: Path
) -> tuple[list[Path], NDArray[np.float64], float, float]:
    """Write the presets, as loud as the recording says; return the files, the sound of the default strike, by how much
    (dB) it is louder than such a strike can be, and by how much it is quieter than the recording, so that its peaks
    stay under full scale. In pascals it is as loud as it was stated."""
    names = ", ".join(dict.fromkeys(take.recording.path.name for take in takes))
    source = wanted.source or UNKNOWN
    facts = texts.Facts(
        description=f"{wanted.name}, fitted to {names}",
        source=f"fitted to {names} by carom fit; recordings: {source}; masses are assumed",
        licence=wanted.licence or UNKNOWN,
        striker=next(iter(strikers), str(takes[0].striker)),
        velocity=wanted.velocity,
        position=takes[0].position or 0.0,
        positions=tuple(take.position for take in takes if take.position is not None),
        mass=wanted.mass or texts.MASS,
        measured=_measured(found_in, takes),
    )
    files = []
    for folder in ("objects", "strikers"):
        (out / folder).mkdir(parents=True, exist_ok=True)
    for name, striker in strikers.items():
        what = replace(facts, description=f"What struck {wanted.name} ({1e3 * striker.duration:.2g} ms)")
        files.append(_put(out / "strikers" / f"{name}.toml", texts.striker_text(striker, what)))
    file = out / "objects" / f"{wanted.name}.toml"
    _put(file, texts.object_text(found_in, facts))
    rate = int(found_in.rate)
    sound = played(wanted.name, out, rate)
    recorded = np.tile(found_in.takes[0][:, None], 2)  # as it plays from two channels
    as_long = sound[: len(recorded)]
    louder = heard(recorded, rate).loudness + wanted.raised - heard(as_long, rate).loudness
    quieter = max(louder + heard(sound, rate).peak - _PEAK, 0.0) if wanted.full_scale is None else 0.0
    louder -= quieter
    files.insert(0, _put(file, texts.object_text(found_in, facts, louder)))
    return files, sound.mean(axis=1) * 10 ** (louder / 20), louder, quieter


def _put(path: Path, text: str) -> Path:
    """Write a file that appears whole."""
    part = path.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)
    return path


def _measured(found_in: Fit, takes: Sequence[Take]) -> list[str]:
    """Return the lines at the head of an object's file that say what was measured."""
    lines = []
    for take, residual, blow in zip(takes, found_in.residual, found_in.blows, strict=True):
        hit = take.hit
        floor = f", noise at {20 * np.log10(hit.floor / hit.peak):.0f} dB of its peak" if hit.floor else ""
        length, begin = len(hit.samples) / hit.rate, hit.onset / hit.rate
        lines.append(
            f"{take.recording.path.name}: {length:.2f} s, from {begin:.3f} s{floor}; "
            f"{len(found_in.frequency)} modes leave {residual:.1f} dB; a blow of {1e3 * blow.duration:.2g} ms"
        )
    return lines


def played(name: str, folder: Path, rate: int, seconds: float | None = None) -> NDArray[np.float64]:
    """Return the default strike (n, 2) of a folder's object, as the engine plays it, without a limiter."""
    presets = Presets([folder])
    options = Options(rate, seconds=seconds or 4.0, limiter=False)
    score = Strike(name).score(presets)
    pieces = list(blocks(score, options.engine(score), presets, options))
    return np.concatenate(pieces).astype(np.float64)
