"""Commands on their way into the engine: their kinds, and the record that carries their values."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ...rolling.surface import PROFILE
from ...schema import (
    BY_POSITION,
    CURVE,
    GESTURES,
    OVER,
    RESTITUTION,
    SETTINGS,
    STEERABLE,
    STRIKE,
    TRAIT_NAMES,
    VELOCITY,
    Gesture,
    Parameter,
)
from ...schema_records import record_of


class Kind(IntEnum):
    """Kind of a command."""

    NEW = 0
    FREE = 1  # value 1: at once; 0: once silent
    GESTURE = 2  # one of schema.GESTURES; one along a surface that goes on on that object takes on what is `given`
    STEER = 3  # a parameter of a gesture
    STOP = 4  # a gesture
    SET = 5  # a setting of an object
    PANIC = 6
    SYNC = 7  # value: a number that appears in the stats
    METHOD = 8  # how contacts with objects that do not give way are solved
    ACCURACY = 9  # value: a place in accuracy.LEVELS
    QUALITY = 10  # value: a Quality
    GAIN = 11  # of everything; value: amplitude
    LIMITER = 12  # value 1: on; 0: off
    PLACE = 13  # an object, by a gain of its own (value) in a channel; channel -1: by its pan again
    BUDGET = 14  # of contacts that are coupled to modes
    BANK = 15  # value: a place in schema.FORMS


# The same as plain numbers, which kernels compare with.
KIND_NEW, KIND_FREE, KIND_GESTURE = int(Kind.NEW), int(Kind.FREE), int(Kind.GESTURE)
KIND_STEER, KIND_STOP, KIND_SET = int(Kind.STEER), int(Kind.STOP), int(Kind.SET)
KIND_PANIC, KIND_SYNC, KIND_METHOD = int(Kind.PANIC), int(Kind.SYNC), int(Kind.METHOD)
KIND_ACCURACY, KIND_QUALITY = int(Kind.ACCURACY), int(Kind.QUALITY)
KIND_GAIN, KIND_LIMITER, KIND_PLACE = int(Kind.GAIN), int(Kind.LIMITER), int(Kind.PLACE)
KIND_BUDGET, KIND_BANK = int(Kind.BUDGET), int(Kind.BANK)

NUMBERS = {name: number for number, name in enumerate(GESTURES)}
"""The numbers of gestures: their places in schema.GESTURES."""

_SOUND = (
    Parameter("sound", 0, np.inf, "", "its place among the strikers that are laid out", default=0.0),
    Parameter("sound_serial", 0, np.inf, "", "its serial there; 0: it does not sound", default=0.0),
)
_PRESSED = Parameter(
    "press", 0, np.inf, "", "number of a press whose force a slide's friction feels; 0: none", default=0.0
)  # fmt: skip
_DELAY = Parameter("delay", 0.0, np.inf, "s", "from the beginning to the first contact", default=0.0)

_SHARED = {each.name: each for each in (VELOCITY, *STRIKE, BY_POSITION, *_SOUND, _PRESSED, _DELAY)}


def _own(gesture: Gesture) -> dict[str, Parameter]:
    """Return the parameters of a gesture that not every gesture has; one that falls is told the velocity, not the
    height."""
    given = (*gesture.keys, *(() if gesture.falls else (gesture.argument,)))
    return {each.name: each for each in given if each.name not in _SHARED}


_OWN = {name: _own(gesture) for name, gesture in GESTURES.items()}
VALUES = record_of(*dict.fromkeys([*_SHARED, *(name for own in _OWN.values() for name in own)]))
"""The values of a gesture: the parameters of all gestures, 0 for those that it has not."""
SETTINGS_RECORD = record_of(*SETTINGS)
_AFTER = Parameter("after", 0.0, np.inf, "s", "until it begins; 0: what was asked for before ends", default=0.0)
_RAMP = {each.name: each for each in (OVER, CURVE, _AFTER)}
RAMP_RECORD = record_of(*_RAMP)

IN_VALUES = np.array([(VALUES.names or ()).index(name) for name in STEERABLE])
"""The place in VALUES of each steerable parameter."""

STEERS = np.array([[name in gesture.steerable for name in STEERABLE] for gesture in GESTURES.values()])
"""True where a gesture can be steered by a parameter."""

TRAITS = np.dtype([(name, np.float64 if name == "meets" else np.int64) for name in TRAIT_NAMES], align=True)
"""Traits of a gesture, as schema.Gesture says."""

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
        ("given", np.int64),  # of a gesture along a surface: bits of the places in schema.STEERABLE that were given
        ("by_slot", np.int64),  # of the object that strikes, if one does
        ("by_serial", np.int64),  # else 0
        ("what", np.int64),  # of a gesture: its place in schema.GESTURES
        ("values", VALUES),  # of a gesture
        ("surface", PROFILE),  # of a gesture along a surface
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

    kind: a Kind, or the name of a gesture, which begins.
    `values` are in the engine's units: gains as amplitudes, tune as a ratio. Values that have a default may be left
    out; a restitution of 0 leaves dissipation as it is.
    """

    time: float
    kind: Kind | str
    handle: Handle | None = None
    values: Mapping[str, float] = MappingProxyType({})
    value: float = 0.0
    gesture: int = 0
    parameter: str = ""
    given: Collection[str] = ()
    by: Handle | None = None
    surface: tuple[float, ...] = (0.0, 1.0, 2.0, 0.0, 1.0, 0.0, 1.0)
    channel: int = -1


def _defaults(parameters: Iterable[Parameter]) -> dict[str, float]:
    return {each.name: each.in_engine(each.default) for each in parameters if each.default is not None}


_ALWAYS = {BY_POSITION.name: 0.0, VELOCITY.name: 0.0, RESTITUTION.name: 0.0}


def _defaults_of(own: dict[str, Parameter]) -> dict[str, float]:
    """Return the values that a gesture with its own parameters need not be given."""
    has = _SHARED | own
    return {key: 0.0 for key in VALUES.names or () if key not in has} | _defaults(has.values()) | _ALWAYS


_DEFAULTS = {name: _defaults_of(own) for name, own in _OWN.items()}
_HAS = {name: {*_SHARED, *own} for name, own in _OWN.items()}
_OF_RECORDS: dict[str, dict[str, float]] = {"settings": _defaults(SETTINGS.values()), "ramp": _defaults(_RAMP.values())}
_RECORDS = {
    Kind.NEW: ("layout", "settings"),
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
    kind, gesture = (Kind.GESTURE, command.kind) if isinstance(command.kind, str) else (command.kind, "")
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
    if gesture:
        _write_gesture(entry, gesture, command)
    elif kind in _FIELDS:
        _require_known(kind.name, command.values, _TAKEN[kind])
        for record, names in _FIELDS[kind]:
            entry[record] = _filled(kind.name, names, command.values, _OF_RECORDS.get(record, {}))


def _write_gesture(entry: np.void, gesture: str, command: Command) -> None:
    """Write the values of a gesture into an entry of COMMAND."""
    entry["what"] = NUMBERS[gesture]
    _require_known(gesture, command.values, _HAS[gesture])
    entry["values"] = _filled(gesture, VALUES.names or (), command.values, _DEFAULTS[gesture])
    if GESTURES[gesture].along:
        if unknown := set(command.given) - _PLACES.keys():
            raise ValueError(f"{gesture}: given {', '.join(sorted(unknown))}: expected some of {', '.join(_PLACES)}")
        entry["given"] = sum(1 << _PLACES[name] for name in command.given)
        entry["surface"] = command.surface


def _require_known(kind: str, values: Mapping[str, float], known: Collection[str]) -> None:
    if unknown := values.keys() - set(known):
        raise ValueError(f"{kind}: it has no {', '.join(sorted(unknown))}")


def _filled(
    kind: str, names: Iterable[str], values: Mapping[str, float], defaults: Mapping[str, float]
) -> tuple[float, ...]:
    """Return the values of a record's fields in order, the defaults where none is given."""
    try:
        return tuple(values[name] if name in values else defaults[name] for name in names)
    except KeyError as error:
        raise ValueError(f"{kind}: {error.args[0]} is missing") from None
