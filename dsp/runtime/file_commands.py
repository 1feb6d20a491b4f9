"""Commands of a file: whether an engine can take them. Their bounds are those that `schema.py` declares."""

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ..contact.accuracy import LEVELS as ACCURACIES
from ..engine.memory.capacity import FACE, MODES, MODES_PER_OBJECT, MOST_CHANNELS, OBJECTS, SHAPE_VALUES
from ..engine.memory.commands import (
    COMMAND,
    DEFAULTS,
    KIND_GESTURE,
    KIND_NEW,
    KIND_SET,
    KIND_STEER,
    LEVEL,
    NUMBERS,
    Event,
    Kind,
)
from ..engine.memory.mounted import SENSORS
from ..engine.memory.state import RING, Quality, State
from ..karman.layout import SHEETS
from ..macros import ENGINE_SETTINGS
from ..native.jit import kernel, noinline_kernel
from ..native.typed import View
from ..resonator.simd import LANES
from ..schema import (
    FORMS,
    GESTURES,
    MAIN_GAIN,
    OTHER_SEED,
    OWN_GAIN,
    ROOM,
    STEERABLE,
    STEPS,
    STIFFNESS,
    Parameter,
    gestures_steered_by,
)
from ..schema_values import OF_RAMPS, OWN, SHARED
from .file_records import is_sheet
from .file_words import MANY, WORD, is_tiny

_Bounds = dict[str, tuple[float, float]]


def _bounds_of(each: Parameter, *also: float) -> tuple[float, float]:
    """Return the bounds of a parameter in the engine's units, and of other values that stand for none."""
    none = (0.0,) if each.or_zero else ()
    ends = (each.in_engine(each.low), each.in_engine(each.high), *none, *also)
    return min(ends), max(ends)


def _of_gesture(name: str) -> _Bounds:
    """Return the bounds of a gesture's values; those that it has not are as `commands.py` leaves them."""
    bounds = {f"values.{key}": (value, value) for key, value in DEFAULTS[name].items()}
    for key, each in (SHARED | OWN[name]).items():
        also = (DEFAULTS[name][key],) if key in DEFAULTS[name] else ()
        covers = key == STIFFNESS.name and (GESTURES[name].held or GESTURES[name].rests)  # has no spring
        bounds[f"values.{key}"] = _bounds_of(each, *also, *([0.0] if covers else []))
    if GESTURES[name].breaks:
        least, most = bounds["values.seed"]
        bounds["values.seed"] = least, most + OTHER_SEED
    return bounds


_FAR, _TURN = 1e5, 1.0 + 1e-6
_ANY = (-1e12, 1e12)
_SURFACE = {
    "roughness": (0.0, 1.0), "correlation": (1e-9, 1e4), "slope": (1.0, 10.0), "ripple": (0.0, 1.0),
    "wavelength": (1e-6, 1e4), "variation": (0.0, 100.0), "variation_length": (1e-6, 1e4),
}  # fmt: skip
_LAYOUT = {
    "first": (0, MODES - LANES), "size": (LANES, MODES_PER_OBJECT), "table": (0, SHAPE_VALUES),
    "rows": (1, SHAPE_VALUES), "faces": (0, SHAPE_VALUES), "surface": (0, SHAPE_VALUES), "block": (0, SHAPE_VALUES),
    "felt": (0, MODES_PER_OBJECT), "bent": (0, MODES_PER_OBJECT), "unheard": (0, MODES_PER_OBJECT),
    "level": (0.0, 1e9), "glide": (0.0, 1e9), "cone": (0.0, 1e9), "sheet": (-1, SHEETS - 1),
    "lighter": (-30.0, 30.0),
}  # fmt: skip
_RAMP = {f"ramp.{name}": _bounds_of(each) for name, each in OF_RAMPS.items()}
_SPACE = {
    **{f"told.pose.{n}": (-_FAR, _FAR) for n in range(3)},
    **{f"told.pose.{n}": (-_TURN, _TURN) for n in range(3, 7)},
    "told.over": (0.0, 3600.0),
}
_LISTENER = [
    (0.0, 2.0),
    (0.0, max(math.isqrt(MOST_CHANNELS) - 1, 0)),
    (0.0, 1.0),
    (100.0, 1e3),
    (0.0, 1e3),
    (-10.0, 10.0),
]
_ROOM = [(0.0, 6.0), *[(-2 * _FAR, 2 * _FAR)] * 6, (0.0, 1.0), (0.0, 60.0), (0.0, 60.0), (0.0, 1e3), (0.0, 1e6)]


def _told(bounds: list[tuple[float, float]]) -> _Bounds:
    return _SPACE | {f"told.values.{n}": bounds[n] if n < len(bounds) else (0.0, 0.0) for n in range(16)}


_LONG = 1e12  # samples
"""A time of eight months at 48 kHz."""
_EVERY: _Bounds = {
    "time": (-1.0, _LONG), "has_clock": (0, 0), "number": (0, MANY), "kind": (0, len(Kind) - 1),
    "slot": (0, OBJECTS - 1), "serial": (0, MANY), "value": _ANY, "gesture": (0, MANY),
    "parameter": (0, max(LEVEL, len(ENGINE_SETTINGS) - 1)), "channel": (-1, MOST_CHANNELS - 1),
    "given": (0, 2.0 ** len(STEERABLE) - 1), "by_slot": (0, OBJECTS - 1), "by_serial": (0, MANY),
    "what": (0, len(GESTURES) - 1), "amends": (0, 0), "follows": (0, 1),
}  # fmt: skip
_BY_KIND: dict[Kind, _Bounds] = {
    Kind.NEW: {
        "serial": (1, MANY),
        **{f"layout.{name}": bounds for name, bounds in _LAYOUT.items()},
        **{f"settings.{name}": _bounds_of(each) for name, each in ENGINE_SETTINGS.items()},
    },
    Kind.FREE: {"value": (0.0, 1.0)},
    Kind.GESTURE: {f"surface.{name}": (min(low, 0.0), high) for name, (low, high) in _SURFACE.items()},
    Kind.STEER: _RAMP,
    Kind.SET: _RAMP | {"parameter": (0, len(ENGINE_SETTINGS) - 1)},
    Kind.ACCURACY: {"value": (0, len(ACCURACIES) - 1)},
    Kind.QUALITY: {"value": (0, len(Quality) - 1)},
    Kind.GAIN: _RAMP | {"value": _bounds_of(MAIN_GAIN)},
    Kind.LIMITER: {"value": (0.0, 1.0)},
    Kind.HEADROOM: {"value": (0.0, 1.0)},
    Kind.RESHAPE: {"value": (0, SHAPE_VALUES)},
    Kind.PLACE: {"value": (OWN_GAIN.low, OWN_GAIN.high)},
    Kind.BUDGET: {"budget.steps": (STEPS.low, STEPS.high), "budget.modes": (ROOM.low, ROOM.high)},
    Kind.BANK: {"value": (0, len(FORMS) - 1)},
    Kind.MOUNT: {
        "channel": (0, SENSORS - 1), "value": (0.0, 1.0), "mounted.acceleration": (0, 1),
        "mounted.position": (0.0, 1.0), "mounted.on_surface": (0, 1), "mounted.scale": (-1e9, 1e9),
        **{f"mounted.spot.{n}": (-_FAR, _FAR) for n in range(3)},
        **{f"mounted.direction.{n}": (-_TURN, _TURN) for n in range(3)},
        **{f"mounted.filter.{n}": (-1e3, 1e3) for n in range(3)},
        "mounted.filter.3": (-2.0, 2.0), "mounted.filter.4": (-1.0, 1.0),
    },
    Kind.POSE: _SPACE | {"value": (0.0, 1.0)},
    Kind.LISTEN: _told(_LISTENER) | {"value": (0.0, 1.0)},
    Kind.FURNISH: _told(_ROOM),
}  # fmt: skip
_GROUPS = [_EVERY, *(_BY_KIND.get(kind, {}) for kind in Kind), *map(_of_gesture, NUMBERS)]


def _places(kind: Any, prefix: str = "", at: int = 0) -> Iterator[tuple[str, int, int]]:
    """Yield the name of each number of a record, its word, and 1 if it is whole."""
    for name, (inner, offset, *_) in kind.fields.items():
        path = f"{prefix}{name}"
        if inner.base.names:
            yield from _places(inner.base, f"{path}.", at + offset)
        elif inner.shape:
            for n in range(inner.shape[0]):
                yield f"{path}.{n}", (at + offset) // WORD + n, int(inner.base.kind == "i")
        else:
            yield path, (at + offset) // WORD, int(inner.kind == "i")


def _flat(groups: Iterable[_Bounds]) -> Iterator[tuple[int, int, int, float, float]]:
    places = {name: (word, whole) for name, word, whole in _places(COMMAND)}
    for group, bounds in enumerate(groups):
        for name, (low, high) in bounds.items():
            yield group, *places[name], low, high


_FLAT = list(zip(*_flat(_GROUPS), strict=True))
_GROUP, _AT, _IS_WHOLE = (np.array(each, np.int64) for each in _FLAT[:3])
_LEAST, _MOST = (np.array(each, np.float64) for each in _FLAT[3:])
_BEGINS = np.searchsorted(_GROUP, np.arange(len(_GROUPS) + 1))
_OF_KINDS, _OF_GESTURES = 1, 1 + len(Kind)
_PLACE_OF = {name: word for name, word, _ in _places(COMMAND)}
_VALUE, _LAYOUT_AT, _SLOT = _PLACE_OF["value"], _PLACE_OF["layout.first"], _PLACE_OF["slot"]
_PULSES_OF = _PLACE_OF["values.pulses"]


def _steered(bounds: Iterable[Iterable[tuple[float, float]]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the least and the most of each parameter, of bounds of all that have it."""
    return np.array([(min(low for low, _ in each), max(high for _, high in each)) for each in map(list, bounds)])


_SETTING_BOUNDS = _steered([_bounds_of(each)] for each in ENGINE_SETTINGS.values())
_STEER_BOUNDS = _steered(
    [*(map(_bounds_of, gestures_steered_by(name).values()) for name in STEERABLE), [_bounds_of(SHARED["level"])]]
)


@kernel
def _wrong_of_group(group: int, reals: View[float], wholes: View[int]) -> int:
    """Return the word of a command that is out of a group's bounds, -1 if none is."""
    for n in range(_BEGINS[group], _BEGINS[group + 1]):
        value = float(wholes[_AT[n]]) if _IS_WHOLE[n] == 1 else reals[_AT[n]]
        if not _LEAST[n] <= value <= _MOST[n] or is_tiny(value):
            word: int = _AT[n]
            return word
    return -1


@kernel
def _meets(event: Event, other: Event) -> bool:
    """True if two commands make objects in one place, of the same modes, or of one plate."""
    a, b = event.layout, other.layout
    if other.kind != KIND_NEW:
        return False
    alike = event.slot == other.slot or (a.sheet >= 0 and a.sheet == b.sheet)
    return alike or (a.first < b.first + b.size and b.first < a.first + a.size)


@noinline_kernel
def _is_taken(state: State, event: Event) -> bool:
    """True if an object that is there, or on its way, has the place, modes or the plate of one that is to be made."""
    a = event.layout
    for slot in range(OBJECTS):
        obj = state.objects[slot]
        if obj.used == 1:
            if slot == event.slot or (a.sheet >= 0 and a.sheet == obj.sheet):
                return True
            if a.first < obj.first + obj.size and obj.first < a.first + a.size:
                return True
    for n in range(state.ring.read[0], state.ring.written[0]):
        if _meets(event, state.ring.entries[n % RING]):
            return True
    found = False
    for n in range(state.queue.size):
        found |= _meets(event, state.queue.events[state.queue.heap[n]])
    return found


@noinline_kernel
def _is_laid_out(state: State, event: Event) -> bool:
    """True if the layout of a new object lies in the engine's tables, and fits itself and its plate."""
    a = event.layout
    if a.first % LANES or a.size % LANES or a.unheard % LANES or a.first + a.size > MODES:
        return False
    if not a.felt <= a.bent <= a.unheard <= a.size:
        return False
    rows = a.rows
    if a.faces > 0:
        rows = (a.surface - a.table) // a.size
        if rows < max(a.rows, 3 + 3 * a.block) or a.surface != a.table + rows * a.size:
            return False
        if a.surface + a.faces * FACE > SHAPE_VALUES:
            return False
    elif a.block > 0:
        return False
    if a.rows < 4 or a.table + rows * a.size > SHAPE_VALUES:
        return False
    if a.sheet < 0:
        return True
    sheet = state.sheets[a.sheet]
    return is_sheet(sheet) and sheet.modes <= a.felt


@noinline_kernel
def wrong_field(state: State, event: Event, reals: View[float], wholes: View[int], tables: int) -> int:
    """Return the word of a command by which it is none for an engine, -1 if that may take it.

    reals, wholes: the command's words as float64 and as int64. tables: of pulses that were made.
    """
    wrong = _wrong_of_group(0, reals, wholes)
    if wrong < 0:
        wrong = _wrong_of_group(_OF_KINDS + event.kind, reals, wholes)
    if wrong < 0 and event.kind == KIND_GESTURE:
        wrong = _wrong_of_group(_OF_GESTURES + event.what, reals, wholes)
    if wrong >= 0:
        return wrong
    if event.kind in (KIND_SET, KIND_STEER):
        bounds = _SETTING_BOUNDS if event.kind == KIND_SET else _STEER_BOUNDS
        return -1 if bounds[event.parameter, 0] <= event.value <= bounds[event.parameter, 1] else _VALUE
    if event.kind == KIND_GESTURE and state.traits[event.what].swarms > 0 and not 1.0 <= event.values.pulses <= tables:
        return _PULSES_OF
    if event.kind == KIND_NEW:
        if not _is_laid_out(state, event):
            return _LAYOUT_AT
        if _is_taken(state, event):
            return _SLOT
    return -1
