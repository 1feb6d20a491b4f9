"""Make-up: the level of a gesture for whoever plays, so that each pair of object and striker is heard and none is too
loud.

A gesture is measured at three to five values of its argument, in an engine beside, on the object as its settings and
macros have it, at a gain of 0 dB. What is between two of these values follows from them, and what is between two
positions, too. The numbers of its keys are taken on a grid, so that values that are hardly heard apart share a
measurement, and the level never depends on what was played before. A plate that swells answers to a gain by more or
less than that: its blows get another velocity, and the gain of its other gestures is searched for.
"""

import json
import math
from collections import OrderedDict
from collections.abc import Mapping
from functools import cache
from hashlib import blake2b
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ...dsp.bodies.modes import Modes
from ...dsp.bodies.striker import StrikerSound
from ...dsp.engine.memory.commands import Command
from ...dsp.runtime.engine import NOW, Engine
from ...dsp.runtime.loudness import Heard, decibels, true_peak
from ...dsp.runtime.meter import SILENCE
from ...dsp.schema import DROPS, EXPONENT, GAIN, GESTURES, RATE, VELOCITY, Gesture
from ...dsp.schema_values import OWN, SHARED
from ...presets import BUILT_IN
from .limits import LAW
from .scale import USUAL_SCALE

STORED = BUILT_IN / "loudness.json"
"""What `make levels` measured of built-in objects with their own strikers, by digest."""

_ALIKE = 10.0
"""LU about the loudness that is aimed at within which pairs become equally loud."""
_STAYS = 0.25
"""Share of what lies beyond that stays, so that a feather on a bell is softer than a hammer; and at most:"""
_MOST_STAYS = 6.0  # LU
_CEILING = -0.7
"""dB of full scale up to which the true peak of an ordinary strike is brought: the limiter takes 1 dB at most."""
_HARDER = 1.1
"""dB by which that rises for each LU that a harder strike is to be louder than MIDDLE."""
MIDDLE = -18.0
"""LUFS of a strike at MIDI velocity 100, a forte."""
_SWARM_ROOM = 3.0
"""dB of room below that for the peaks of swarms: grains that come later may add up to more than was measured."""
_MOST = 140.0
"""dB: what needs more is silence."""
_SOFTEST, _LOUDEST = -31.0, -15.0
"""LUFS between which what is aimed at stays: 4 and 3 within what players hear as too soft and as too loud."""
_SEARCHED, _NEAR, _FARTHEST = 4, 1.5, 50.0
"""Renders in which the gain of a gesture on a plate that swells is searched for, the error (dB) at which that ends, and
the most that a gain goes at once."""
_MOST_SWELLS = 60.0
"""dB: gain of a gesture on a plate that swells, at most."""
_POSITIONS = 40
"""Parts of the strike path, in whose middle a gesture is measured where it does not touch at the object's own."""
_STRIKES = ((0.1554, -30.0), (0.5026, -24.0), (1.8566, -18.0), (5.0, -15.0))
"""Velocities (m/s) of strikes and the loudness (LUFS) that is aimed at: those of MIDI velocities 32, 64, 100 and 127.
It rises by half of what physics would have it rise."""
_OFTEN = 1.0
"""m/s of most presets' strikes."""
_LOWEST, _HIGHEST = -31.0, -15.0
"""LUFS that is aimed at beyond these velocities, at most."""
_LASTING = (-27.0, -18.0)
"""LUFS at the lowest and the highest useful argument of all other gestures: on average a few LU below a strike."""
_FRACTIONS = (1.0 / 6.0, 0.5, 5.0 / 6.0)
"""Places in the useful range of an argument, by ratios, at which a gesture is measured."""
_FASTER, _FASTEST = 20.0, 20.0
"""Times by which a plate that swells is struck faster or slower than was requested, and m/s, at most."""
_SLOWER = 0.98  # of the fastest: what is slower was enough
_HALVINGS = 12  # of the ratio between both: to 1 %, as the velocity is rounded
_RATE = 48_000
_SECONDS = {"impact": 0.5, "bounce": 0.8, "slide": 2.0}
"""s of a gesture that are measured: friction builds up in time."""
_USUAL_SECONDS = 1.0
_BLOWS, _MOST_PARTS = 50.0, 5.0
"""Blows of a sparse swarm that are measured, as they differ in strength, and s of them at most."""
_SWELLING = 1.2  # s of a plate that swells, by when it is loudest
_LOOK = 0.1  # s between looks at the momentary loudness, as ITU-R BS.1770 has it
_GRID = 8.0
"""Steps an octave of the values of keys: 0.4 dB of a mass at most."""
_WHOLE = 1_000.0
"""Whole numbers up to here are no matter of degree, and stay as they are."""
_KEPT = 4_096
"""Measurements that are kept."""
_UNTOLD = {"seed", "delay", "press", "travel", "sound", "sound_serial", "pulses"}
"""Values that are no matter of level."""
_OF_PIECES = ("own_stiffness", "own_dissipation", "own_level", "level", "whole")
"""Values that what breaks has besides."""
_ON_OTHER, _ON_NOTHING = 1.0, 2.0
"""Stages of pieces that fall on another object, or on nothing."""
_LEAST = 1e-6
"""Of an argument, whose logarithm a level follows."""
_PLAIN = (0.0, 1.0, 2.0, 0.0, 1.0, 0.0, 1.0)


class Measure(NamedTuple):
    """The loudness (LUFS) and true peak (dB of full scale) of a gesture at each of the values that its argument is
    measured at."""

    loudness: tuple[float, ...]
    peak: tuple[float, ...]
    arguments: tuple[float, ...] = ()
    """These values; empty: `measured_at` has them."""


class Below(NamedTuple):
    """What the pieces of an object fall on: its modes, its level (dB) over that of what breaks, and those values of
    their command that are not what breaks has, on the grid."""

    modes: Modes
    level: float
    values: tuple[tuple[str, float], ...]


class Pair(NamedTuple):
    """A gesture on an object as it is measured: `values` of its command but for its argument, on the grid."""

    modes: Modes
    position: float
    kind: str
    values: tuple[tuple[str, float], ...]
    surface: tuple[float, ...]
    sound: StrikerSound | None
    below: Below | None = None
    argument: float = 0.0
    """One more at which it is measured: that of the gesture, on the grid; 0: none."""
    aim: float | None = None
    """Of a gesture on a plate that swells, whose gain is searched for: the loudness (LUFS) that is aimed at, of a level
    of 0 dB."""

    @property
    def digest(self) -> str:
        """What is the same for equal pairs alone, on any machine."""
        told = blake2b(digest_size=9)
        _tell(told, self.modes)
        told.update(repr((self.position, self.kind, self.values, self.surface, self.sound)).encode())
        if self.below:
            _tell(told, self.below.modes)
            told.update(repr(self.below[1:]).encode())
        if self.argument:
            told.update(repr((self.argument, self.aim)).encode())
        return told.hexdigest()

    @property
    def key(self) -> tuple[object, ...]:
        """What is the same for equal pairs of the same modes, as long as these are there."""
        below = (id(self.below.modes), *self.below[1:]) if self.below else None
        return (id(self.modes), *self[1:6], below, self.argument, self.aim)

    def measured(self) -> Measure:
        """Measure it, in an engine of its own."""
        if self.aim is not None:
            return self._search(self.aim)
        usual = measured_at(self.kind, self.modes.sheet is not None)
        arguments = tuple(sorted({*usual, self.argument})) if self.argument else usual
        found = [self._heard_at(value) for value in arguments]
        loudness, peak = (tuple(round(getattr(each, name), 1) for each in found) for name in ("loudness", "peak"))
        return Measure(loudness, peak, arguments if self.argument else ())

    def _search(self, aim: float) -> Measure:
        """Return the loudness and true peak at a gain of 0 dB that the gain needed for a loudness (LUFS) stands for."""
        argument, gain, room = self.argument, 0.0, _room(self.kind, aim)
        heard = self._heard_at(argument)
        for _ in range(_SEARCHED - 1):
            more = min(aim - heard.loudness, room - heard.peak) if math.isfinite(heard.loudness) else _FARTHEST
            more = min(max(more, -_FARTHEST), _FARTHEST, _MOST_SWELLS - gain)
            if abs(more) < _NEAR:
                break
            gain += more
            heard = self._heard_at(argument, gain)
        return Measure((round(aim - gain, 1),), (round(room - gain, 1),), (argument,))

    def _heard_at(self, argument: float, gain: float = 0.0) -> Heard:
        engine = Engine(_RATE)
        handle = engine.add(self.modes, USUAL_SCALE.at(0.0))
        swarms = GESTURES[self.kind].swarms
        values = {
            **dict(self.values),
            **({"level": GAIN.in_engine(gain)} if gain else {}),
            argument_of(GESTURES[self.kind]): argument,
            "position": self.position,
            **({"seed": 1.0} if "seed" in OWN[self.kind] else {}),
            **(engine.lay_out_striker(self.sound) if self.sound else {}),
        }
        if swarms:
            values |= engine.lay_out_pulses(0.0 if swarms == DROPS else values["exponent"])
        struck = Command(NOW, self.kind, handle, values, gesture=1, surface=self.surface)
        engine.send([struck, self._fall(engine, struck)] if GESTURES[self.kind].breaks else [struck])
        engine.meter.start()
        momentary, sound = [], []
        parts, seconds = self._listens(argument)
        for _ in range(parts * round(seconds / _LOOK)):
            sound.append(engine.process(round(_LOOK * _RATE)))
            momentary.append(engine.meter.loudness)
        loudness = float(np.median(np.reshape(momentary, (parts, -1)).max(axis=1)))
        return Heard(loudness if loudness > SILENCE else -math.inf, decibels(true_peak(np.concatenate(sound))))

    def _listens(self, argument: float) -> tuple[int, float]:
        """Return in how many parts the sound is heard, whose median counts, and how long (s) each is: several of blows
        that are few, as they differ in strength."""
        if self.modes.sheet is not None:
            return 1, _SWELLING
        values, rate = dict(self.values), math.inf
        if GESTURES[self.kind].argument.name == RATE.name:
            rate = argument
        elif "density" in values:
            strong = 10.0 ** ((1.0 - values["steepness"]) * (values["decades"] - 1.0))  # share of the loudest decade
            rate = min(strong, 1.0) * argument * values["density"] / (1.0 - values["excitation"])
        seconds = _SECONDS.get(self.kind, _USUAL_SECONDS)
        return max(1, math.ceil(min(_BLOWS / max(rate, _LEAST), _MOST_PARTS) / seconds)), seconds

    def _fall(self, engine: Engine, cracks: Command) -> Command:
        """Return the command by which the pieces of what breaks fall."""
        if self.below is None:
            return cracks._replace(values={**cracks.values, "stage": _ON_NOTHING}, gesture=2)
        below = engine.add(self.below.modes, USUAL_SCALE.at(self.below.level))
        values = {**cracks.values, **dict(self.below.values), "stage": _ON_OTHER}
        return cracks._replace(handle=below, by=cracks.handle, values=values, gesture=2)


def _tell(told: "blake2b", modes: Modes) -> None:
    """Add what is heard of modes to a digest."""
    shape = np.abs(modes.strike).mean(axis=0)
    for array in (modes.frequency, modes.decay, modes.pressure, shape):
        told.update(np.asarray(array, np.float32).tobytes())


def argument_of(gesture: Gesture) -> str:
    """Return the name of the value that says how strong a gesture is."""
    return VELOCITY.name if gesture.falls else gesture.argument.name


ARGUMENTS = {argument_of(each) for each in GESTURES.values() if each.lasts and not each.held}
"""Names of the arguments that make-up follows as they are steered."""


def measured_at(kind: str, swells: bool = False) -> tuple[float, ...]:
    """Return the values of a gesture's argument at which it is measured; swells: of a plate, whose loudness is no line
    between them."""
    if argument_of(GESTURES[kind]) == VELOCITY.name:
        velocities = [velocity for velocity, _ in _STRIKES]
        return tuple(sorted([*velocities, _OFTEN]) if swells else (velocities[0], *velocities[2:]))
    low, high = GESTURES[kind].argument.useful or (0.1, 10.0)
    return tuple(low * (high / low) ** share for share in _FRACTIONS)


def aimed_at(kind: str, argument: float) -> float:
    """Return the loudness (LUFS) that is aimed at for a gesture at a value of its argument."""
    if argument_of(GESTURES[kind]) == VELOCITY.name:
        velocities, loudness = zip(*_STRIKES, strict=True)
        return min(max(_at(velocities, loudness, argument), _LOWEST), _HIGHEST)
    low, high = GESTURES[kind].argument.useful or (0.1, 10.0)
    share = min(max(math.log(argument / low) / math.log(high / low), 0.0), 1.0)
    return _LASTING[0] + share * (_LASTING[1] - _LASTING[0])


def gain_of(kind: str, argument: float, measure: Measure, level: float) -> float:
    """Return the gain (dB) of a gesture at a value of its argument, on an object of a preset's level (dB)."""
    if argument <= 0.0 or not all(map(math.isfinite, measure.loudness)):
        return 0.0
    if len(measure.loudness) == 1:  # a search's
        return round(min(aimed_at(kind, argument) - measure.loudness[0] - level, _MOST_SWELLS), 1)
    aim, arguments = aimed_at(kind, argument), measure.arguments
    arguments = arguments or measured_at(kind, len(measure.loudness) > len(_FRACTIONS))
    loudness = _at(arguments, measure.loudness, argument) + level
    peak = _at(arguments, measure.peak, argument) + level
    middle = len(arguments) // 2
    apart = measure.loudness[middle] + level - aimed_at(kind, arguments[middle])
    beyond = math.copysign(max(0.0, abs(apart) - _ALIKE), apart)
    stays = min(max(_STAYS * beyond, -_MOST_STAYS), _MOST_STAYS)
    wanted = min(max(aim + stays, _SOFTEST), _LOUDEST)
    return round(min(wanted - loudness, _room(kind, aim) - peak, _MOST), 1)


class Played(NamedTuple):
    """What the make-up of a gesture that goes on follows from, as its argument is steered."""

    kind: str
    measure: Measure
    preset_level: float
    """dB of the object's preset."""

    def level_at(self, argument: float) -> float:
        """Return the gesture's level in the engine at a value of its argument."""
        return GAIN.in_engine(gain_of(self.kind, argument, self.measure, self.preset_level))

    def levels_of(self, commands: list[Command]) -> list[Command]:
        """Return the commands by which its level follows those of a change, if that is of its argument."""
        if commands[0].parameter != argument_of(GESTURES[self.kind]) or commands[-1].value <= 0.0:
            return []
        return [
            each._replace(parameter="level", value=self.level_at(max(each.value, _LEAST)), follows=True)
            for each in commands
        ]


def _room(kind: str, aim: float) -> float:
    """Return the true peak (dB of full scale) up to which a gesture is brought."""
    return _CEILING + _HARDER * max(0.0, aim - MIDDLE) - _SWARM_ROOM * (GESTURES[kind].swarms > 0)


def velocity_of(kind: str, velocity: float, measure: Measure, level: float) -> tuple[float, float]:
    """Return the velocity (m/s) at which a plate that swells is struck in place of one, which makes the loudness that
    is aimed at, and its level in the engine: what is too soft at the fastest is made louder, though that has the plate
    swell as it never does."""
    aim, low, high = aimed_at(kind, velocity), velocity / _FASTER, min(velocity * _FASTER, _FASTEST)
    if not all(map(math.isfinite, measure.loudness)) or high <= low:
        return velocity, 1.0
    at, fastest = measured_at(kind, swells=True), high
    for _ in range(_HALVINGS):
        middle = math.sqrt(low * high)
        loudness, peak = (_at(at, each, middle) + level for each in (measure.loudness, measure.peak))
        if loudness < aim and peak < _room(kind, aim):
            low = middle
        else:
            high = middle
    low = float(f"{low:.3g}")
    short = _SOFTEST - _at(at, measure.loudness, low) - level if low > _SLOWER * fastest else 0.0
    return low, GAIN.in_engine(round(min(max(short, 0.0), _MOST_SWELLS), 1))


def _at(arguments: tuple[float, ...], values: tuple[float, ...], argument: float) -> float:
    """Return a value between those at some arguments, or beyond them, along lines over the argument's logarithm."""
    k = 1
    while k < len(arguments) - 1 and argument > arguments[k]:
        k += 1
    share = math.log(argument / arguments[k - 1]) / math.log(arguments[k] / arguments[k - 1])
    return values[k - 1] + share * (values[k] - values[k - 1])


@cache
def _bounds_of(kind: str) -> dict[str, tuple[float, float]]:
    """Return the least and the most of a gesture's values, in the engine's units."""
    declared = (SHARED | OWN[kind]).items()
    return {name: (each.in_engine(each.low), each.in_engine(each.high)) for name, each in declared}


def _on_grid(kind: str, name: str, value: float) -> float:
    """Return the value of a gesture's key as it is measured: within its bounds, if it is."""
    if value == 0.0 or (value.is_integer() and abs(value) <= _WHOLE):
        return value
    near = math.copysign(float(f"{2.0 ** (round(_GRID * math.log2(abs(value))) / _GRID):.6g}"), value)
    low, high = _bounds_of(kind).get(name, (-math.inf, math.inf))
    return min(max(near, low), high) if low <= value <= high else near


def on_grid(kind: str, values: Mapping[str, float]) -> dict[str, float]:
    """Return those values of a gesture's command by which it is measured, but for its argument."""
    taken = {*LAW, "restitution", *OWN[kind], *_OF_PIECES} - _UNTOLD - {argument_of(GESTURES[kind])}
    found = {name: _on_grid(kind, name, float(value)) for name, value in values.items() if name in taken}
    found[EXPONENT.name] = round(values[EXPONENT.name], 2)  # stiffness goes with it
    return found


def places_of(pair_at: float, own: float, swells: bool) -> list[tuple[float, float]]:
    """Return the positions at which a gesture at one is measured, and the share of each: the object's own position,
    else the two next to it, of which a plate that swells takes one, as to measure it takes long."""
    if pair_at == own:
        return [(own, 1.0)]
    place = min(max(pair_at * _POSITIONS - 0.5, 0.0), _POSITIONS - 1.0)
    first = min(int(place), _POSITIONS - 2)
    share = round(place - first) if swells else place - first
    return [((first + n + 0.5) / _POSITIONS, part) for n, part in ((0, 1.0 - share), (1, share)) if part]


def mixed(measures: list[tuple[Measure, float]]) -> Measure:
    """Return the mean of measurements by their shares; those that are silent count for nothing."""
    heard = [each for each in measures if all(map(math.isfinite, each[0].loudness))]
    if not heard:
        return measures[0][0]
    whole = sum(share for _, share in heard)

    def mean(rows: list[tuple[float, ...]]) -> tuple[float, ...]:
        return tuple(
            sum(x * each[1] for x, each in zip(row, heard, strict=True)) / whole for row in zip(*rows, strict=True)
        )

    loudness, peak = mean([each.loudness for each, _ in heard]), mean([each.peak for each, _ in heard])
    return Measure(loudness, peak, heard[0][0].arguments)


@cache
def _stored(path: Path) -> dict[str, Measure]:
    """Return the measurements in a file, by digest; in the file they are by object and gesture."""
    if not path.exists():
        return {}
    objects = json.loads(path.read_text(encoding="utf-8"))
    rows = (row for gestures in objects.values() for row in gestures.values())
    return {digest: Measure(*map(tuple, measure)) for digest, *measure in rows}


class MakeUp:
    """The measurements of a session, and whether gestures that do not say so are played with make-up."""

    def __init__(self) -> None:
        self.on = False
        self.stored: Mapping[str, Measure] = MappingProxyType(_stored(STORED))
        self._known: OrderedDict[str, Measure] = OrderedDict()
        self._digests: OrderedDict[tuple[object, ...], tuple[Modes, str]] = OrderedDict()

    def pair(self, modes: Modes, position: float, command: Command, sound: StrikerSound | None, level: float) -> Pair:
        """Return the pair that a gesture's command is of, on an object of a preset's level (dB)."""
        kind, argument = str(command.kind), argument_of(GESTURES[str(command.kind)])
        values = on_grid(kind, command.values)
        surface = command.surface if GESTURES[kind].along else _PLAIN
        pair = Pair(modes, position, kind, tuple(sorted(values.items())), surface, sound)
        if argument == VELOCITY.name or command.values[argument] <= 0.0:
            return pair
        strong = _on_grid(kind, argument, max(command.values[argument], _LEAST))
        usual = measured_at(kind)
        if modes.sheet is None and GESTURES[kind].along and usual[0] <= strong <= usual[-1]:
            return pair  # its loudness is near a line, and follows that as the gesture is steered
        aim = None if modes.sheet is None else round(aimed_at(kind, strong) - level, 1)
        return pair._replace(argument=strong, aim=aim)

    def digest(self, pair: Pair) -> str:
        """Return the digest of a pair, which is kept: it takes longer than all else."""
        key = pair.key
        if key not in self._digests:
            self._digests[key] = pair.modes, pair.digest  # the modes stay, so that none has their identity
            if len(self._digests) > _KEPT:
                self._digests.popitem(last=False)
        return self._digests[key][1]

    def known(self, digest: str) -> Measure | None:
        """Return what is known of a pair."""
        return self.stored.get(digest) or self._known.get(digest)

    def measure(self, digest: str, pair: Pair) -> Measure:
        """Measure a pair, and keep that; any thread may."""
        silence = Measure((-math.inf,), (-math.inf,))
        try:
            silence = pair.measured()
        finally:  # what cannot be measured is not tried again
            self._known[digest] = silence
            if len(self._known) > _KEPT:
                self._known.popitem(last=False)
        return silence

    @property
    def measures(self) -> dict[str, Measure]:
        """What it measured of late, by digest."""
        return dict(self._known)
