"""Commands on their way into the engine: their kinds, and the record that carries their values."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import IntEnum
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...schema import (
    BY_POSITION,
    CURVE,
    GESTURES,
    OVER,
    RESTITUTION,
    SETTINGS,
    STEERABLE,
    STRIKE,
    VELOCITY,
    Gesture,
    Parameter,
    record_of,
)


class Kind(IntEnum):
    """Kind of a command."""

    NEW = 0
    FREE = 1  # value 1: at once; 0: once silent
    IMPACT = 2
    BOUNCE = 3
    ROLL = 4  # a roll of that gesture on that object that goes on already takes on what is `given`
    PRESS = 5
    SPIN = 6
    STEER = 7  # a parameter of a gesture
    STOP = 8  # a gesture
    SET = 9  # a setting of an object
    PANIC = 10
    SYNC = 11  # value: a number that appears in the stats
    METHOD = 12  # how contacts with objects that do not give way are solved
    ACCURACY = 13  # value: a place in accuracy.LEVELS
    QUALITY = 14  # value: a Quality
    GAIN = 15  # of everything; value: amplitude
    LIMITER = 16  # value 1: on; 0: off
    PLACE = 17  # an object, by a gain of its own (value) in a channel; channel -1: by its pan again
    BUDGET = 18  # of contacts that are coupled to modes
    SLIDE = 19  # as ROLL
    BANK = 20  # value: a place in schema.FORMS


# The same as plain numbers, which kernels compare with.
KIND_NEW, KIND_FREE = int(Kind.NEW), int(Kind.FREE)
KIND_IMPACT, KIND_BOUNCE, KIND_ROLL, KIND_PRESS = int(Kind.IMPACT), int(Kind.BOUNCE), int(Kind.ROLL), int(Kind.PRESS)
KIND_SPIN = int(Kind.SPIN)
KIND_STEER, KIND_STOP, KIND_SET = int(Kind.STEER), int(Kind.STOP), int(Kind.SET)
KIND_PANIC, KIND_SYNC, KIND_METHOD = int(Kind.PANIC), int(Kind.SYNC), int(Kind.METHOD)
KIND_ACCURACY, KIND_QUALITY = int(Kind.ACCURACY), int(Kind.QUALITY)
KIND_GAIN, KIND_LIMITER, KIND_PLACE = int(Kind.GAIN), int(Kind.LIMITER), int(Kind.PLACE)
KIND_BUDGET, KIND_SLIDE, KIND_BANK = int(Kind.BUDGET), int(Kind.SLIDE), int(Kind.BANK)

GESTURE_KINDS = (Kind.IMPACT, Kind.BOUNCE, Kind.ROLL, Kind.PRESS, Kind.SPIN, Kind.SLIDE)
"""Commands that bring a striker."""

_LEVEL = Parameter(
    "gesture_level", 0.0, np.inf, "", "amplitude of such gestures on the object, times their gain", default=1.0
)
_SOUND = (
    Parameter("sound", 0, np.inf, "", "its place among the strikers that are laid out", default=0.0),
    Parameter("sound_serial", 0, np.inf, "", "its serial there; 0: it does not sound", default=0.0),
)
_PRESSED = Parameter(
    "press", 0, np.inf, "", "number of a press whose force a slide's friction feels; 0: none", default=0.0
)  # fmt: skip
_DELAY = Parameter("delay", 0.0, np.inf, "s", "from the beginning of a bounce to its first contact", default=0.0)


def _own(gesture: Gesture, *more: Parameter) -> dict[str, Parameter]:
    """Return the parameters of a gesture's own record: all but those of the record that every gesture fills."""
    given = (*((gesture.argument,) if gesture.argument.steerable else ()), *gesture.keys, *more)
    return {each.name: each for each in given if each.name not in _STRIKE}


_STRIKE = {each.name: each for each in (VELOCITY, *STRIKE, BY_POSITION, _LEVEL, *_SOUND)}
_BOUNCE = _own(GESTURES["bounce"], _DELAY)
_ROLL = _own(GESTURES["roll"])
_PRESS = _own(GESTURES["press"])
_SPIN = _own(GESTURES["spin"], GESTURES["spin"].argument)
_SLIDE = _own(GESTURES["slide"], _PRESSED)

STRIKE_RECORD = record_of(*_STRIKE)
BOUNCE_RECORD = record_of(*_BOUNCE)
ROLL_RECORD = record_of(*_ROLL)
PRESS_RECORD = record_of(*_PRESS)
SPIN_RECORD = record_of(*_SPIN)
SLIDE_RECORD = record_of(*_SLIDE)
SETTINGS_RECORD = record_of(*SETTINGS)
_AFTER = Parameter("after", 0.0, np.inf, "s", "until it begins; 0: what was asked for before ends", default=0.0)
_RAMP = {each.name: each for each in (OVER, CURVE, _AFTER)}
RAMP_RECORD = record_of(*_RAMP)


def _places(record: np.dtype[np.void]) -> NDArray[np.int64]:
    """Return the place of each steerable parameter in a record, -1 where it is not there."""
    names = list(record.names or ())
    return np.array([names.index(name) if name in names else -1 for name in STEERABLE])


IN_STRIKE, IN_BOUNCE = _places(STRIKE_RECORD), _places(BOUNCE_RECORD)
IN_ROLL, IN_PRESS = _places(ROLL_RECORD), _places(PRESS_RECORD)
IN_SPIN, IN_SLIDE = _places(SPIN_RECORD), _places(SLIDE_RECORD)

STEERS = np.array(
    [
        [kind.name.lower() in GESTURES and name in GESTURES[kind.name.lower()].steerable for name in STEERABLE]
        for kind in Kind
    ]
)
"""True where a gesture of a kind can be steered by a parameter."""
for _kind in GESTURE_KINDS:
    STEERS[_kind] = [name in GESTURES[_kind.name.lower()].steerable for name in STEERABLE]

PROFILE = record_of("roughness", "correlation", "slope", "ripple", "wavelength")
"""A surface: rms height (m), correlation length (m), slope of its spectrum; amplitude (m), length (m) of a ripple."""

_PLACES_OF_NEW = ("first", "size", "table", "rows", "felt", "bent", "unheard")
_SCALES_OF_NEW = ("level", "glide", "cone")
LAYOUT = np.dtype(
    [*((name, np.int64) for name in _PLACES_OF_NEW), *((name, np.float64) for name in _SCALES_OF_NEW)], align=True
)
"""Layout of a new object's modes and shapes: its first mode, how many (padded), first value and rows of its shapes, how
many modes are felt and heard, of how many slow forces are heard, and the first of those that are felt alone; the output
that 1 Pa is; the rise of its tension: for the energy that rings, 1/J, and about a striker, kg (bodies/tension.py)."""

METHOD = np.dtype([(name, np.int64) for name in ("method", "correction", "oversampling")], align=True)
"""Method by which contacts are solved: 0 closed form, else 1 + method; correction; steps per sample."""

BUDGET = np.dtype([(name, np.int64) for name in ("steps", "modes")], align=True)
"""Bounds on the cost of contacts that are coupled to modes: steps per sample of each, on average, and modes at once; 0:
any number."""

COMMAND = np.dtype(
    [
        ("time", np.float64),  # samples since the start; what is past is now
        ("has_clock", np.int64),  # 1: `clock` says when, and `time` is an early guess
        ("clock", np.int64),  # CLOCK_MONOTONIC in ns
        ("number", np.int64),  # of all commands sent
        ("kind", np.int64),  # a Kind
        ("slot", np.int64),
        ("serial", np.int64),  # of the object meant: commands to one that is gone are ignored
        ("order", np.int64),  # of arrival, set by the engine
        ("waits_until", np.float64),  # samples: for an object that is yet to come; set by the engine, -1 before
        ("value", np.float64),  # as Kind says
        ("gesture", np.int64),  # its number, 0: none
        ("parameter", np.int64),  # its place in schema.STEERABLE or schema.SETTINGS
        ("channel", np.int64),  # of a place
        ("given", np.int64),  # of a roll or slide: bits of the places in schema.STEERABLE that were given
        ("by_slot", np.int64),  # of the object that strikes, if one does
        ("by_serial", np.int64),  # else 0
        ("strike", STRIKE_RECORD),
        ("bounce", BOUNCE_RECORD),
        ("roll", ROLL_RECORD),
        ("press", PRESS_RECORD),
        ("spin", SPIN_RECORD),
        ("slide", SLIDE_RECORD),
        ("surface", PROFILE),  # of a roll or slide
        ("settings", SETTINGS_RECORD),  # of a new object
        ("layout", LAYOUT),  # of a new object
        ("method", METHOD),
        ("budget", BUDGET),
        ("ramp", RAMP_RECORD),  # of a change: how it takes its time
    ],
    align=True,
)


@dataclass(frozen=True, slots=True)
class Handle:
    """An object in the engine; commands to one that is gone are ignored."""

    slot: int
    serial: int
    first: int
    table: int


class Command(NamedTuple):
    """A command from Python: when (samples), what, to which object, and the values of its records by name.

    `values` are in the engine's units: gains as amplitudes, tune as a ratio. Values that have a default may be left
    out; a restitution of 0 leaves dissipation as it is.
    """

    time: float
    kind: Kind
    handle: Handle | None = None
    values: Mapping[str, float] = MappingProxyType({})
    value: float = 0.0
    gesture: int = 0
    parameter: str = ""
    given: Collection[str] = ()
    by: Handle | None = None
    surface: tuple[float, ...] = (0.0, 1.0, 2.0, 0.0, 1.0)
    channel: int = -1


_PARAMETERS = {
    "strike": _STRIKE, "bounce": _BOUNCE, "roll": _ROLL, "press": _PRESS, "spin": _SPIN, "slide": _SLIDE,
    "settings": SETTINGS, "ramp": _RAMP,
}  # fmt: skip
_DEFAULTS: dict[str, dict[str, float]] = {
    record: {each.name: each.in_engine(each.default) for each in parameters.values() if each.default is not None}
    for record, parameters in _PARAMETERS.items()
}
_DEFAULTS["strike"] |= {BY_POSITION.name: 0.0, VELOCITY.name: 0.0, RESTITUTION.name: 0.0}

_RECORDS = {
    Kind.NEW: ("layout", "settings"),
    Kind.IMPACT: ("strike",),
    Kind.BOUNCE: ("strike", "bounce"),
    Kind.ROLL: ("strike", "roll"),
    Kind.PRESS: ("strike", "press"),
    Kind.SPIN: ("strike", "spin"),
    Kind.SLIDE: ("strike", "slide"),
    Kind.METHOD: ("method",),
    Kind.BUDGET: ("budget",),
    **dict.fromkeys((Kind.STEER, Kind.SET, Kind.GAIN), ("ramp",)),
}
_FIELDS = {kind: [(name, tuple(COMMAND[name].names or ())) for name in names] for kind, names in _RECORDS.items()}
_TAKEN = {kind: {name for _, names in records for name in names} for kind, records in _FIELDS.items()}
_PLACES = {name: place for place, name in enumerate(STEERABLE)}
_SETTING_PLACES = {name: place for place, name in enumerate(SETTINGS)}


def write(entry: np.void, number: int, command: Command) -> None:
    """Write a command into an entry of COMMAND. ValueError names a value that is missing or that its kind has not."""
    kind = command.kind
    clock = getattr(command.time, "clock", None)
    entry["time"] = command.time
    entry["has_clock"], entry["clock"] = (0, 0) if clock is None else (1, clock)
    entry["number"], entry["kind"] = number, kind
    entry["slot"], entry["serial"] = (command.handle.slot, command.handle.serial) if command.handle else (0, 0)
    entry["by_slot"], entry["by_serial"] = (command.by.slot, command.by.serial) if command.by else (0, 0)
    entry["value"], entry["gesture"], entry["channel"] = command.value, command.gesture, command.channel
    if kind in (Kind.STEER, Kind.SET):
        places = _PLACES if kind is Kind.STEER else _SETTING_PLACES
        if command.parameter not in places:
            raise ValueError(f"{kind.name}: parameter = {command.parameter!r}: expected one of {', '.join(places)}")
        entry["parameter"] = places[command.parameter]
    if kind in _FIELDS:
        values = command.values
        if unknown := values.keys() - _TAKEN[kind]:
            raise ValueError(f"{kind.name}: it has no {', '.join(sorted(unknown))}")
        for record, names in _FIELDS[kind]:
            defaults = _DEFAULTS.get(record, {})
            try:
                entry[record] = tuple(values[name] if name in values else defaults[name] for name in names)
            except KeyError as error:
                raise ValueError(f"{kind.name}: {error.args[0]} is missing") from None
    if kind in (Kind.ROLL, Kind.SLIDE):
        if unknown := set(command.given) - _PLACES.keys():
            raise ValueError(f"{kind.name}: given {', '.join(sorted(unknown))}: expected some of {', '.join(_PLACES)}")
        entry["given"] = sum(1 << _PLACES[name] for name in command.given)
        entry["surface"] = command.surface
