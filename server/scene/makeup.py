"""Make-up: the level of a gesture for whoever plays, so that each pair of object and striker is heard and none is too
loud.

A gesture is measured at three to five values of its argument, in an engine beside, at the object's own position and
at a gain of 0 dB. What is between two of these values follows from them. The numbers of its keys are taken on a grid,
so that values that are hardly heard apart share a measurement, and the level never depends on what was played before.
"""

import json
import math
from collections import OrderedDict
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...dsp.bodies.modes import Modes
from ...dsp.bodies.striker import StrikerSound
from ...dsp.engine.memory.commands import Command
from ...dsp.runtime.engine import NOW, Engine
from ...dsp.runtime.loudness import Heard, decibels, true_peak
from ...dsp.runtime.meter import SILENCE
from ...dsp.schema import DROPS, EXPONENT, GAIN, GESTURES, VELOCITY, Gesture
from ...dsp.schema_values import OWN
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
_MOST = 80.0
"""dB: what needs more is silence."""
_STRIKES = ((0.1554, -30.0), (0.5026, -24.0), (1.8566, -18.0), (5.0, -15.0))
"""Velocities (m/s) of strikes and the loudness (LUFS) that is aimed at: those of MIDI velocities 32, 64, 100 and 127.
It rises by half of what physics would have it rise."""
_OFTEN = 1.0
"""m/s of most presets' strikes."""
_LOWEST, _HIGHEST = -34.0, -15.0
"""LUFS that is aimed at beyond these velocities, at most."""
_LASTING = (-29.0, -17.0)
"""LUFS at the lowest and the highest useful argument of all other gestures: on average a few LU below a strike."""
_FRACTIONS = (1.0 / 6.0, 0.5, 5.0 / 6.0)
"""Places in the useful range of an argument, by ratios, at which a gesture is measured."""
_FASTER, _FASTEST = 20.0, 20.0
"""Times by which a plate that swells is struck faster or slower than was requested, and m/s, at most."""
_HALVINGS = 12  # of the ratio between both: to 1 %, as the velocity is rounded
_RATE = 48_000
_SECONDS = {"impact": 0.5, "bounce": 0.8, "slide": 2.0}
"""s of a gesture that are measured: friction builds up in time."""
_USUAL_SECONDS = 1.0
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
_ON_NOTHING = 2.0
"""Stage of pieces that fall on nothing."""
_LEAST = 1e-6
"""Of an argument, whose logarithm a level follows."""
_PLAIN = (0.0, 1.0, 2.0, 0.0, 1.0, 0.0, 1.0)


class Measure(NamedTuple):
    """The loudness (LUFS) and true peak (dB of full scale) of a gesture at each of the values that its argument is
    measured at."""

    loudness: tuple[float, ...]
    peak: tuple[float, ...]


class Pair(NamedTuple):
    """A gesture on an object as it is measured: `values` of its command but for its argument, on the grid."""

    modes: Modes
    position: float
    kind: str
    values: tuple[tuple[str, float], ...]
    surface: tuple[float, ...]
    sound: StrikerSound | None

    @property
    def digest(self) -> str:
        """What is the same for equal pairs alone, on any machine."""
        told = blake2b(digest_size=9)
        shape = np.abs(self.modes.strike).mean(axis=0)
        for array in (self.modes.frequency, self.modes.decay, self.modes.pressure, shape):
            told.update(np.asarray(array, np.float32).tobytes())
        told.update(repr((self.position, *self[2:])).encode())
        return told.hexdigest()

    def measured(self) -> Measure:
        """Measure it, in an engine of its own."""
        found = [self._heard_at(value) for value in measured_at(self.kind, self.modes.sheet is not None)]
        return Measure(tuple(round(each.loudness, 1) for each in found), tuple(round(each.peak, 1) for each in found))

    def _heard_at(self, argument: float) -> Heard:
        engine = Engine(_RATE)
        handle = engine.add(self.modes, USUAL_SCALE.at(0.0))
        swarms = GESTURES[self.kind].swarms
        values = {
            **dict(self.values),
            argument_of(GESTURES[self.kind]): argument,
            "position": self.position,
            **({"seed": 1.0} if "seed" in OWN[self.kind] else {}),
            **(engine.lay_out_striker(self.sound) if self.sound else {}),
        }
        if swarms:
            values |= engine.lay_out_pulses(0.0 if swarms == DROPS else values["exponent"])
        struck = Command(NOW, self.kind, handle, values, gesture=1, surface=self.surface)
        falls = struck._replace(values={**values, "stage": _ON_NOTHING}, gesture=2)
        engine.send([struck, falls] if GESTURES[self.kind].breaks else [struck])
        engine.meter.start()
        loudness, sound = -math.inf, []
        seconds = _SWELLING if self.modes.sheet is not None else _SECONDS.get(self.kind, _USUAL_SECONDS)
        for _ in range(round(seconds / _LOOK)):
            sound.append(engine.process(round(_LOOK * _RATE)))
            loudness = max(loudness, engine.meter.loudness)
        return Heard(loudness if loudness > SILENCE else -math.inf, decibels(true_peak(np.concatenate(sound))))


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
    aim, arguments = aimed_at(kind, argument), measured_at(kind, len(measure.loudness) > len(_FRACTIONS))
    loudness = _at(arguments, measure.loudness, argument) + level
    peak = _at(arguments, measure.peak, argument) + level
    middle = len(arguments) // 2
    apart = measure.loudness[middle] + level - aimed_at(kind, arguments[middle])
    beyond = math.copysign(max(0.0, abs(apart) - _ALIKE), apart)
    stays = min(max(_STAYS * beyond, -_MOST_STAYS), _MOST_STAYS)
    return round(min(aim + stays - loudness, _room(kind, aim) - peak, _MOST), 1)


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
        return [each._replace(parameter="level", value=self.level_at(max(each.value, _LEAST))) for each in commands]


def _room(kind: str, aim: float) -> float:
    """Return the true peak (dB of full scale) up to which a gesture is brought."""
    return _CEILING + _HARDER * max(0.0, aim - MIDDLE) - _SWARM_ROOM * (GESTURES[kind].swarms > 0)


def velocity_of(kind: str, velocity: float, measure: Measure, level: float) -> float:
    """Return the velocity (m/s) at which a plate that swells is struck in place of one: it makes the loudness that is
    aimed at. A gain would have it swell as it never does."""
    aim, low, high = aimed_at(kind, velocity), velocity / _FASTER, min(velocity * _FASTER, _FASTEST)
    if not all(map(math.isfinite, measure.loudness)) or high <= low:
        return velocity
    at = measured_at(kind, swells=True)
    for _ in range(_HALVINGS):
        middle = math.sqrt(low * high)
        loudness, peak = (_at(at, each, middle) + level for each in measure)
        if loudness < aim and peak < _room(kind, aim):
            low = middle
        else:
            high = middle
    return float(f"{low:.3g}")


def _at(arguments: tuple[float, ...], values: tuple[float, ...], argument: float) -> float:
    """Return a value between those at some arguments, or beyond them, along lines over the argument's logarithm."""
    k = 1
    while k < len(arguments) - 1 and argument > arguments[k]:
        k += 1
    share = math.log(argument / arguments[k - 1]) / math.log(arguments[k] / arguments[k - 1])
    return values[k - 1] + share * (values[k] - values[k - 1])


def _on_grid(value: float) -> float:
    """Return the value of a key as it is measured."""
    if value == 0.0 or (value.is_integer() and abs(value) <= _WHOLE):
        return value
    return math.copysign(float(f"{2.0 ** (round(_GRID * math.log2(abs(value))) / _GRID):.6g}"), value)


@cache
def _stored(path: Path) -> dict[str, Measure]:
    """Return the measurements in a file, by digest; in the file they are by object and gesture."""
    if not path.exists():
        return {}
    objects = json.loads(path.read_text(encoding="utf-8"))
    rows = (row for gestures in objects.values() for row in gestures.values())
    return {digest: Measure(tuple(loudness), tuple(peak)) for digest, loudness, peak in rows}


class MakeUp:
    """The measurements of a session, and whether gestures that do not say so are played with make-up."""

    def __init__(self) -> None:
        self.on = False
        self.stored = _stored(STORED)
        self._known: OrderedDict[str, Measure] = OrderedDict()
        self._digests: OrderedDict[tuple[object, ...], tuple[Modes, str]] = OrderedDict()

    def pair(self, modes: Modes, position: float, command: Command, sound: StrikerSound | None) -> Pair:
        """Return the pair that a gesture's command is of."""
        kind = str(command.kind)
        taken = {*LAW, "restitution", *OWN[kind], *_OF_PIECES} - _UNTOLD - {argument_of(GESTURES[kind])}
        values = {name: _on_grid(float(value)) for name, value in command.values.items() if name in taken}
        values[EXPONENT.name] = round(command.values[EXPONENT.name], 2)  # stiffness goes with it
        surface = command.surface if GESTURES[kind].along else _PLAIN
        return Pair(modes, position, kind, tuple(sorted(values.items())), surface, sound)

    def digest(self, pair: Pair) -> str:
        """Return the digest of a pair, which is kept: it takes longer than all else."""
        key = (id(pair.modes), *pair[1:])
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
