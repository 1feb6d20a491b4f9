"""Commands on their way into the engine: their kinds, and the record that carries their values."""

from collections.abc import Callable, Collection, Iterable, Mapping, Set
from enum import IntEnum
from functools import cache
from operator import itemgetter
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ...macros import ENGINE_SETTINGS
from ...native.typed import Record, dtype_of
from ...rolling.surface import Profile
from ...schema import (
    BY_DIRECTION,
    BY_POINT,
    BY_POSITION,
    DIRECTION,
    GESTURES,
    IMPULSE,
    POINT,
    RESTITUTION,
    SETTINGS,
    STEERABLE,
    VELOCITY,
    Parameter,
)
from ...schema_records import VALUES, RampValues, Settings, Values
from ...schema_values import OF_RAMPS, OWN, SHARED
from .mounted import Mounted
from .told import Told


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
    ACCURACY = 8  # value: a place in accuracy.LEVELS
    QUALITY = 9  # value: a Quality
    GAIN = 10  # of everything; value: amplitude
    LIMITER = 11  # value 1: on; 0: off
    PLACE = 12  # an object, by a gain of its own (value) in a channel; channel -1: by its pan again
    BUDGET = 13  # of contacts that are coupled to modes
    BANK = 14  # value: a place in schema.FORMS
    MOUNT = 15  # a sensor, its number in `channel`, on an object; on none: value 0
    POSE = 16  # an object, where it goes in space (value 1), or in space no more (0)
    LISTEN = 17  # the listener, with all its values (value 1) or its pose alone (0)
    FURNISH = 18  # walls, and a late part
    HEADROOM = 19  # value 1: on; 0: off
    RESHAPE = 20  # an object; value: first value of the table by which settings change its modes
    RELEVEL = 21  # a gesture: what it was to follow macros and make-up by, and waits, is none; other comes instead


# The same as plain numbers, which kernels compare with.
KIND_NEW, KIND_FREE, KIND_GESTURE = int(Kind.NEW), int(Kind.FREE), int(Kind.GESTURE)
KIND_STEER, KIND_STOP, KIND_SET = int(Kind.STEER), int(Kind.STOP), int(Kind.SET)
KIND_PANIC, KIND_SYNC = int(Kind.PANIC), int(Kind.SYNC)
KIND_ACCURACY, KIND_QUALITY = int(Kind.ACCURACY), int(Kind.QUALITY)
KIND_GAIN, KIND_LIMITER, KIND_PLACE = int(Kind.GAIN), int(Kind.LIMITER), int(Kind.PLACE)
KIND_BUDGET, KIND_BANK, KIND_MOUNT = int(Kind.BUDGET), int(Kind.BANK), int(Kind.MOUNT)
KIND_POSE, KIND_LISTEN, KIND_FURNISH = int(Kind.POSE), int(Kind.LISTEN), int(Kind.FURNISH)
KIND_HEADROOM, KIND_RESHAPE, KIND_RELEVEL = int(Kind.HEADROOM), int(Kind.RESHAPE), int(Kind.RELEVEL)

NUMBERS = {name: number for number, name in enumerate(GESTURES)}
"""The numbers of gestures: their places in schema.GESTURES."""

IN_VALUES = np.array([(VALUES.names or ()).index(name) for name in STEERABLE])
"""The place in VALUES of each steerable parameter."""

LEVEL = len(STEERABLE)
"""The number of the level of a running gesture, which no message names: its make-up, beside the gain."""

STEERS = np.array([[name in gesture.steerable for name in STEERABLE] for gesture in GESTURES.values()])
"""True where a gesture can be steered by a parameter."""


class Layout(Record):
    """The layout of a new object's modes and shapes."""

    first: int  # its first mode
    size: int  # how many modes, padded
    table: int  # first value of its shapes
    rows: int  # of them along the strike path
    faces: int  # triangles of its surface
    surface: int  # first value of these, after the shapes
    block: int  # rows from their shapes along the normal to those along x, y, and z
    felt: int  # modes that are felt and heard
    bent: int  # modes of which slow forces are heard
    unheard: int  # the first of those that are felt alone
    level: float  # output that 1 Pa is
    glide: float  # 1/J: rise of its tension for the energy that rings (bodies/tension.py)
    cone: float  # kg: the same about a striker
    sheet: int  # place of a plate whose modes can be coupled, -1: it is none
    lighter: float  # octaves of its shapes, of an object that is similar to the one whose table it has


class Budget(Record):
    """Bounds on the cost of contacts that are coupled to modes; 0: any number."""

    steps: int  # per sample of each, on average
    modes: int  # at once


class Event(Record):
    """A command, as it waits in the engine."""

    time: float  # samples since the start; what is past is now
    has_clock: int  # 1: `clock` says when, and `time` is an early guess
    clock: int  # CLOCK_MONOTONIC in ns
    number: int  # of all commands sent
    kind: int  # a Kind
    slot: int
    serial: int  # of the object meant: commands to one that is gone are ignored
    order: int  # of arrival, set by the engine
    waits_until: float  # samples: for an object that is yet to come; set by the engine, -1 before
    value: float  # as Kind says
    gesture: int  # its number, 0: none
    parameter: int  # its place in schema.STEERABLE or macros.ENGINE_SETTINGS, or LEVEL
    channel: int  # of a place
    given: int  # of a gesture along a surface: bits of the places in schema.STEERABLE that were given
    by_slot: int  # of the object that strikes, if one does
    by_serial: int  # else 0
    what: int  # of a gesture: its place in schema.GESTURES
    amends: int  # 1 + the number of a command that waits: it gets this number and values; `value` -1 drops it; 0: none
    follows: int  # of a gesture's parameter: 1 if it follows macros or make-up
    values: Values  # of a gesture
    surface: Profile  # of a gesture along a surface
    settings: Settings  # of a new object
    layout: Layout  # of a new object
    budget: Budget
    ramp: RampValues  # of a change: how it takes its time
    mounted: Mounted  # of a sensor
    told: Told  # of space


COMMAND = dtype_of(Event)


class Handle(NamedTuple):
    """An object in the engine; commands to one that is gone are ignored."""

    slot: int
    serial: int
    first: int
    table: int
    sheet: int = -1


class Command(NamedTuple):
    """A command from Python: when (samples), what, to which object, and the values of its records by name.

    kind: a Kind, or the name of a gesture, which begins.
    `values` are in the engine's units: gains as amplitudes, tune as a ratio. Values that have a default may be left
    out; a restitution of 0 leaves dissipation as it is.
    """

    time: float
    kind: Kind | str
    handle: Handle | None = None
    values: Mapping[str, Any] = MappingProxyType({})
    value: float = 0.0
    gesture: int = 0
    parameter: str = ""
    given: Collection[str] = ()
    by: Handle | None = None
    surface: tuple[float, ...] = (0.0, 1.0, 2.0, 0.0, 1.0, 0.0, 1.0)
    channel: int = -1
    amends: int = -1
    follows: bool = False


def _defaults(parameters: Iterable[Parameter]) -> dict[str, float]:
    return {each.name: each.in_engine(each.default) for each in parameters if each.default is not None}


_PLACED = (*POINT, *BY_POINT, *DIRECTION, *BY_DIRECTION)
_ALWAYS = {each.name: 0.0 for each in (BY_POSITION, VELOCITY, IMPULSE, RESTITUTION, *_PLACED)}


def _defaults_of(own: dict[str, Parameter]) -> dict[str, float]:
    """Return the values that a gesture with its own parameters need not be given."""
    has = SHARED | own
    return {key: 0.0 for key in VALUES.names or () if key not in has} | _defaults(has.values()) | _ALWAYS


DEFAULTS = {name: _defaults_of(own) for name, own in OWN.items()}
_HAS = {name: {*SHARED, *own} for name, own in OWN.items()}
_OF_RECORDS: dict[str, dict[str, float]] = {
    "settings": _defaults(ENGINE_SETTINGS.values()),
    "ramp": _defaults(OF_RAMPS.values()),
}
_RECORDS = {
    Kind.NEW: ("layout", "settings"),
    Kind.BUDGET: ("budget",),
    Kind.MOUNT: ("mounted",),
    **dict.fromkeys((Kind.POSE, Kind.LISTEN, Kind.FURNISH), ("told",)),
    **dict.fromkeys((Kind.STEER, Kind.SET, Kind.GAIN), ("ramp",)),
}
_FIELDS = {kind: [(name, tuple(COMMAND[name].names or ())) for name in names] for kind, names in _RECORDS.items()}
_TAKEN = {kind: {name for _, names in records for name in names} for kind, records in _FIELDS.items()}
_VALUE_NAMES = VALUES.names or ()
_PLACES = {name: place for place, name in enumerate(STEERABLE)}
_STEERED_PLACES = _PLACES | {"level": LEVEL}
_SETTING_PLACES = {name: place for place, name in enumerate(ENGINE_SETTINGS)}


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
    entry["amends"], entry["follows"] = command.amends + 1, command.follows
    if kind in (Kind.STEER, Kind.SET):
        places = _STEERED_PLACES if kind is Kind.STEER else _SETTING_PLACES
        if command.parameter not in places:
            raise ValueError(f"{kind.name}: parameter = {command.parameter!r}: expected one of {', '.join(places)}")
        entry["parameter"] = places[command.parameter]
    if gesture:
        _write_gesture(entry, gesture, command)
    elif kind in _FIELDS:
        _require_known(kind.name, command.values, _TAKEN[kind])
        for record, names in _FIELDS[kind]:
            values = command.values
            if record == "settings":  # macros begin in the middle, and `size` is the layout's
                values = {name: value for name, value in values.items() if name in SETTINGS}
            entry[record] = _filled(kind.name, names, values, _OF_RECORDS.get(record, {}))


def _write_gesture(entry: np.void, gesture: str, command: Command) -> None:
    """Write the values of a gesture into an entry of COMMAND."""
    entry["what"] = NUMBERS[gesture]
    _require_known(gesture, command.values, _HAS[gesture])
    entry["values"] = _filled(gesture, _VALUE_NAMES, command.values, DEFAULTS[gesture])
    if GESTURES[gesture].along:
        if unknown := set(command.given) - _PLACES.keys():
            raise ValueError(f"{gesture}: given {', '.join(sorted(unknown))}: expected some of {', '.join(_PLACES)}")
        entry["given"] = sum(1 << _PLACES[name] for name in command.given)
        entry["surface"] = command.surface


def _require_known(kind: str, values: Mapping[str, float], known: Set[str]) -> None:
    if not values.keys() <= known:
        unknown = values.keys() - known
        raise ValueError(f"{kind}: it has no {', '.join(sorted(unknown))}")


def _filled(
    kind: str, names: tuple[str, ...], values: Mapping[str, Any], defaults: Mapping[str, float]
) -> tuple[Any, ...]:
    """Return the values of a record's fields, at least two, in order, the defaults where none is given."""
    try:
        return _taking(names)({**defaults, **values})
    except KeyError as error:
        raise ValueError(f"{kind}: {error.args[0]} is missing") from None


@cache
def _taking(names: tuple[str, ...]) -> Callable[[Mapping[str, Any]], tuple[Any, ...]]:
    """Return what takes the values of these names, two or more, in order: in half of the time of one by one."""
    return itemgetter(*names)
