"""What a file may write into the engine's memory, and what a command from a file may say.

A baked scene is words of the engine's memory, and commands. Whoever opens one without Python asks here before the
engine sees it: each number lies in its bounds, each index in its table. A command's bounds are those that `schema.py`
declares. The bounds of words are wide: they guard memory and finite sums, not taste.
"""

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ..contact.accuracy import LEVELS as ACCURACIES
from ..contact.sampled import CORRECTIONS, METHODS
from ..karman.layout import LEVELS, MOST_ORDERS, SPACE, TABLE_VALUES, Grid, Sheet
from ..karman.simd import LANES as SINGLES
from ..karman.simd import ROWS
from ..native.jit import carray, kernel, noinline_kernel
from ..native.typed import View
from ..resonator.simd import LANES
from ..schema import (
    FORMS,
    GESTURES,
    MAIN_GAIN,
    OWN_GAIN,
    ROOM,
    SETTINGS,
    STEERABLE,
    STEPS,
    TRAIT_NAMES,
    Parameter,
    gestures_steered_by,
)
from ..schema_values import OF_RAMPS, OWN, SHARED
from ..sizes import MOST_COUPLED, MOST_SCATTERED
from ..spectral.layout import PHASES, REGION
from ..swarm.grid import STEPS as WIDTHS_OF_OCTAVE
from ..swarm.record import (
    DISSIPATIONS,
    MOST_BENDS,
    MOST_LENGTH,
    MOST_NODES,
    MOST_TURNS,
    OCTAVES,
    POINTS,
    PULSES,
    TABLE,
    PulseTable,
)
from ..swarm.record import (
    MOST_ORDERS as MOST_PULSE_ORDERS,
)
from .memory.capacity import FACE, MODES, MODES_PER_OBJECT, MOST_CHANNELS, OBJECTS, SHAPE_VALUES
from .memory.commands import _DEFAULTS, COMMAND, KIND_GESTURE, KIND_NEW, KIND_SET, KIND_STEER, NUMBERS, Event, Kind
from .memory.mounted import SENSORS
from .memory.state import CONTACTS, DEFAULT, EVENTS, QUANTUM, RING, ROLLS, SHEETS, STATE, VOICES, Quality, State
from .memory.striker_state import STRIKER_MODES, STRIKERS

_WORD = 8
_REAL, _WHOLE, _SINGLES = range(3)  # kinds of words: a float64, an int64, two float32
_MANY = 2.0**53
_TINY = 1e-100
_LONG = 1e12  # samples
"""A time of eight months at 48 kHz."""

# Bounds of words. Frequencies and decays of modes that are felt alone go far beyond what is heard.
_BANK = {"frequency": (0.0, 1e9), "sigma": (0.0, 1e9), "weight": (-1e9, 1e9), "balance": (-1e15, 1e15)}
_GRID = {
    "orders": (0, MOST_ORDERS), "stresses": (0, MOST_ORDERS - 1), "points": (0, SPACE), "angles": (0, SPACE),
    "first": (0, MOST_COUPLED), "count": (0, MOST_COUPLED), "row": (0, MOST_COUPLED), "stress": (0, MOST_COUPLED),
    **dict.fromkeys(
        ("strain", "shapes", "stretch", "cosine", "sine", "stress_cosine", "stress_sine", "bent"), (0, TABLE_VALUES)
    ),
    "domed": (0, 1),
}  # fmt: skip
_SHEET = {
    "functions": (0, MOST_COUPLED), "plain": (0, MOST_COUPLED), "modes": (0, MOST_SCATTERED),
    "rungs": (0, MOST_SCATTERED), "ladder": (0, MOST_SCATTERED), "below": (0.0, 1e6), "span": (0.0, 1.0),
    "start": (0, MOST_SCATTERED), "free": (0, MOST_SCATTERED), "mixing": (0.0, 1e30), "mixes": (0, 1_000_000),
    "highest": (0.0, 1e6), "every": (0, 64), "growth": (0.0, 1e9), "least": (0.0, 1e9), "scale": (0.0, 1.0),
    "tension": (0.0, 1.0), "share": (0.0, 1.0), "drained": (0.0, 1.0), "follows": (0.0, 1.0),
}  # fmt: skip
_STRIKER = {
    "size": (0, STRIKER_MODES), "serial": (0, _MANY), "clicks": (0, STRIKER_MODES), "radius": (0.0, 1e3),
    "frequency": (0.0, 1e9), "sigma": (0.0, 1e9), "weight": (-1e9, 1e9), "momentum": (0.0, 1e3),
    "exponent": (0.0, 100.0), "scatter": (0.0, 100.0), "delay": (0.0, 10.0), "mobility": (0.0, 1e12),
    "bends": (0, MOST_BENDS), "bend": (0.0, 1e9),
}  # fmt: skip
_PULSE = {
    "dissipations": (0, DISSIPATIONS), "first": (0, TABLE), "block": (0, TABLE), "phases": (0, MOST_TURNS),
    "length": (0, MOST_LENGTH), "lead": (0, MOST_LENGTH), "width": (-10.0, 10.0), "middle": (-20.0, 20.0),
    "momentum": (0.0, 10.0), "size": (0, TABLE), "nodes": (0, MOST_NODES), "points": (0, POINTS),
    "times": (-100.0, 100.0), "impulses": (-1.0, 1.0), "orders": (0, MOST_PULSE_ORDERS), "weight": (-10.0, 10.0),
}  # fmt: skip


def _words() -> Iterator[tuple[int, int, int, int, int, float, float]]:
    """Yield the words that a file may write: the first, the words from one record to the next, how many records, how
    many words of each, their kind, and bounds."""

    def rows(kind: Any, at: int, period: int, repeats: int, bounds: dict[str, tuple[float, float]]) -> Iterator[Any]:
        for name, (low, high) in bounds.items():
            inner, place = kind.fields[name][:2]
            word = {"f8": _REAL, "i8": _WHOLE, "f4": _SINGLES}[inner.base.str[1:]]
            assert (at + place) % _WORD == inner.itemsize % _WORD == period % _WORD == 0
            yield (at + place) // _WORD, period // _WORD, repeats, inner.itemsize // _WORD, word, low, high

    places: Any = STATE.fields
    bank, at = places["bank"][:2]
    yield from rows(bank, at, bank.itemsize, 1, {**_BANK, "shape": (-1e12, 1e12)})
    strikers, at = places["strikers"][:2]
    yield from rows(strikers.base, at, strikers.base.itemsize, STRIKERS, _STRIKER)
    sheets, at = places["sheets"][:2]
    yield from rows(sheets.base, at, sheets.base.itemsize, SHEETS, _SHEET)
    grids, begin = sheets.base.fields["grids"][:2]
    for level in range(LEVELS):
        first = at + begin + level * grids.base.itemsize
        yield from rows(grids.base, first, sheets.base.itemsize, SHEETS, _GRID)
    yield from rows(STATE, 0, STATE.itemsize, 1, {"curves": (-1e15, 1e15)})
    pulses, at = places["pulses"][:2]
    tables, begin = pulses.fields["tables"][:2]
    yield from rows(tables.base, at + begin, tables.base.itemsize, PULSES, _PULSE)


_ROWS = list(_words())
_FIRST, _PERIOD, _REPEATS, _COUNT, _KIND = (np.array(each, np.int64) for each in list(zip(*_ROWS, strict=True))[:5])
_LOW, _HIGH = (np.array(each, np.float64) for each in list(zip(*_ROWS, strict=True))[5:])
_PULSES_AT: int = STATE.fields["pulses"][1] // _WORD  # type: ignore[index]
_SHEETS_AT: int = STATE.fields["sheets"][1] // _WORD  # type: ignore[index]
_SHEET_WORDS: int = STATE["sheets"].base.itemsize // _WORD


@kernel
def _is_tiny(x: float) -> bool:
    """True of a number that no measure is, and whose products processors compute a hundred times more slowly."""
    return x != 0.0 and abs(x) < _TINY


@kernel
def _is_of_row(row: int, word: int) -> bool:
    """True if a word lies in a row of those that a file may write."""
    after = word - _FIRST[row]
    return 0 <= after < _PERIOD[row] * _REPEATS[row] and after % _PERIOD[row] < _COUNT[row]


@kernel
def _row_of(word: int) -> int:
    """Return the row in which a word lies, -1 if a file may not write it."""
    for row in range(len(_FIRST)):
        if _is_of_row(row, word):
            return row
    return -1


@kernel
def _end_of(row: int, word: int, last: int) -> int:
    """Return the word after those of a row that lie together from a word on, at most `last`."""
    record = (word - _FIRST[row]) // _PERIOD[row]
    return min(_FIRST[row] + record * _PERIOD[row] + _COUNT[row], last)


@noinline_kernel
def word_in_use(state: State, first: int, count: int, starts: int) -> int:
    """Return the first of some words that a file may not write now, -1 if it may write all.

    It writes the tables of pulses as a scene starts, and plates that no object has.
    """
    word, last = first, first + count
    while word < last:
        row = _row_of(word)
        if row < 0 or (word >= _PULSES_AT and starts == 0):
            return word
        sheet = (word - _SHEETS_AT) // _SHEET_WORDS
        if starts == 0 and 0 <= sheet < SHEETS and _has_sheet(state, sheet):
            return word
        word = _end_of(row, word, last)
    return -1


@noinline_kernel
def wrong_word(reals: View[float], wholes: View[int], singles: View[np.float32], first: int, count: int) -> int:
    """Return the first of some words of the engine's memory whose value is out of its bounds, -1 if there is none."""
    word, last = first, first + count
    while word < last:
        row = _row_of(word)
        if row < 0:
            return word
        low, high, kind = _LOW[row], _HIGH[row], _KIND[row]
        for n in range(word, _end_of(row, word, last)):
            least = most = reals[n]
            if kind == _WHOLE:
                least = most = float(wholes[n])
            elif kind == _SINGLES:
                least, most = float(singles[2 * n]), float(singles[2 * n + 1])
            if not (low <= least <= high and low <= most <= high) or (kind == _REAL and _is_tiny(least)):
                return n
        word = _end_of(row, word, last)
    return -1


# --- a fresh memory ---

_TRAITS = np.array(
    [tuple(getattr(each, name) for name in TRAIT_NAMES) for each in GESTURES.values()], STATE["traits"].base
).view(np.int64)
_TRAITS_AT: int = STATE.fields["traits"][1] // _WORD  # type: ignore[index]


@noinline_kernel
def begin(state: State, wholes: View[int]) -> None:
    """Make a memory of zeros a fresh one, as `new_state` does, but for its rate and channels."""
    for n in range(len(_TRAITS)):
        wholes[_TRAITS_AT + n] = _TRAITS[n]
    output, choices, spectral = state.output, state.choices, state.spectral
    output.consumed, output.silent = QUANTUM, 1
    output.limit = state.stats.limit_lowest = choices.gain = 1.0
    choices.limiter, choices.accuracy = 1, DEFAULT
    for side in range(2):
        output.gain[side] = 1.0
    for n in range(2 * QUANTUM):
        output.allowed[n] = 1.0
    known = state.scratch.together.known
    for n in range(len(known)):
        known[n] = -1
    for n in range(CONTACTS):
        contact = state.contacts[n]
        contact.sound = contact.voice = -1
        contact.index = state.free_contact[n] = n
    for n in range(EVENTS):
        state.queue.heap[n] = n
    for n in range(ROLLS):
        state.free_roll[n] = n
    for n in range(VOICES):
        state.free_voice[n] = n
    spectral.spare = PHASES * REGION
    for n in range(PHASES):
        spectral.phases[n].region = spectral.phases[n].top = n * REGION


# --- plates and pulses ---


@kernel
def _has_sheet(state: State, place: int) -> bool:
    """True if an object that is there, or on its way, has a plate's place."""
    for slot in range(OBJECTS):
        if state.objects[slot].used == 1 and state.objects[slot].sheet == place:
            return True
    for n in range(state.ring.read[0], state.ring.written[0]):
        if state.ring.entries[n % RING].kind == KIND_NEW and state.ring.entries[n % RING].layout.sheet == place:
            return True
    for n in range(state.queue.size):
        event = state.queue.events[state.queue.heap[n]]
        if event.kind == KIND_NEW and event.layout.sheet == place:
            return True
    return False


@noinline_kernel
def _is_grid(grid: Grid, functions: int) -> bool:
    """True if the tables of a plate's grid, and what is computed with them, have room."""
    points, orders, stresses, angles = grid.points, grid.orders, grid.stresses, grid.angles
    width = 3 * points
    if points < 1 or points % SINGLES or orders < 1 or stresses < 1 or angles < 1:
        return False
    if max(2 * orders * width, 4 * angles * width, 2 * stresses * points) > SPACE:
        return False
    room = TABLE_VALUES - ROWS * width  # rows are read some together
    for order in range(orders):
        last = grid.row[order] + grid.count[order]
        if grid.first[order] + grid.count[order] > functions or grid.shapes + last * width > room:
            return False
    for order in range(stresses):
        count = grid.stress[order + 1] - grid.stress[order]
        if count < 0:
            return False
        if grid.domed == 1 and order < orders and grid.bent + grid.strain[order] + count * grid.count[order] > room:
            return False
    if grid.stretch + grid.stress[stresses] * points > room:
        return False
    for odd in range(2):
        if max(grid.cosine[odd], grid.sine[odd]) + angles * orders > room:
            return False
        if max(grid.stress_cosine[odd], grid.stress_sine[odd]) + angles * stresses > room:
            return False
    return True


@noinline_kernel
def is_sheet(sheet: Sheet) -> bool:
    """True if a plate's numbers fit each other."""
    if sheet.functions < 1 or sheet.plain > sheet.functions or 2 * sheet.functions - sheet.plain > sheet.modes:
        return False
    if sheet.rungs > sheet.modes or sheet.every < 1 or sheet.mixes < 1 or sheet.below < 1.0 or sheet.span <= 0.0:
        return False
    for n in range(sheet.rungs):
        if sheet.ladder[n] >= sheet.modes:
            return False
    for level in range(LEVELS):
        if sheet.start[level] > sheet.rungs or sheet.free[level] > sheet.rungs:
            return False
        if not _is_grid(sheet.grids[level], sheet.functions):
            return False
    return sheet.scale > 0.0 and sheet.tension > 0.0 and sheet.follows > 0.0 and sheet.highest > 0.0


@noinline_kernel
def is_pulse_table(table: PulseTable, values: int) -> bool:
    """True if the numbers of a table of pulses fit each other, and its values lie in so many."""
    if table.dissipations < 2 or table.nodes < 1 or table.points < 3 or table.first[0] + table.size > values:
        return False
    for octave in range(OCTAVES):
        length, phases, block = table.length[octave], table.phases[octave], table.block[octave]
        if length < LANES or length % LANES or phases < 1 or length * phases > MOST_TURNS:
            return False
        if table.lead[octave] >= length or table.orders[octave] < 1:
            return False
        if block != (WIDTHS_OF_OCTAVE + 1) * (phases + 1) * length or table.first[octave] < table.first[0]:
            return False
        if table.first[octave] + table.dissipations * block > table.first[0] + table.size:
            return False
    return True


@noinline_kernel
def wrong_record(state: State, values: int, plates: int) -> int:
    """Return the number of a record that a file has laid out and that does not fit itself, -1 if there is none: of
    plates, then of strikers, then of tables of pulses.

    values: of pulses, that there is memory for; plates: 1 if there is memory for the tables of plates.
    """
    for n in range(SHEETS):
        if state.sheets[n].functions > 0 and (plates == 0 or not is_sheet(state.sheets[n])):
            return n
    for n in range(STRIKERS):
        if state.strikers[n].size % LANES or state.strikers[n].clicks > state.strikers[n].size:
            return SHEETS + n
    for n in range(PULSES if values > 0 else 0):
        if state.pulses.tables[n].size > 0 and not is_pulse_table(state.pulses.tables[n], values):
            return SHEETS + STRIKERS + n
    return -1


# --- commands ---

_CAPS = {"sound": STRIKERS - 1, "pulses": PULSES, "friction": 1e3, "own_stiffness": 1e16, "own_dissipation": 1e6}
"""Bounds of values that only Python writes, and whose declarations leave them open."""
_OPEN = {"sound_serial": _MANY, "press": _MANY, "delay": 1e6, "whole": 1e6, "own_level": 1e12, "level": 1e12}
_OPEN_TIMES = {"after": 1e6}
_Bounds = dict[str, tuple[float, float]]


def _bounds_of(each: Parameter, *also: float) -> tuple[float, float]:
    """Return the bounds of a parameter in the engine's units, and of other values that stand for none."""
    ends = (each.in_engine(each.low), each.in_engine(min(each.high, 1e300)), *also)
    high = {**_CAPS, **_OPEN, **_OPEN_TIMES}.get(each.name, max(ends)) if math.isinf(each.high) else max(ends)
    return min(ends), high


def _of_gesture(name: str) -> _Bounds:
    """Return the bounds of a gesture's values; those that it has not are as `commands.py` leaves them."""
    bounds = {f"values.{key}": (value, value) for key, value in _DEFAULTS[name].items()}
    for key, each in (SHARED | OWN[name]).items():
        also = (_DEFAULTS[name][key],) if key in _DEFAULTS[name] else ()
        bounds[f"values.{key}"] = _bounds_of(each, *also)
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


_EVERY: _Bounds = {
    "time": (-1.0, _LONG), "has_clock": (0, 0), "number": (0, _MANY), "kind": (0, len(Kind) - 1),
    "slot": (0, OBJECTS - 1), "serial": (0, _MANY), "value": _ANY, "gesture": (0, _MANY),
    "parameter": (0, max(len(STEERABLE), len(SETTINGS)) - 1), "channel": (-1, MOST_CHANNELS - 1),
    "given": (0, 2.0 ** len(STEERABLE) - 1), "by_slot": (0, OBJECTS - 1), "by_serial": (0, _MANY),
    "what": (0, len(GESTURES) - 1),
}  # fmt: skip
_BY_KIND: dict[Kind, _Bounds] = {
    Kind.NEW: {
        "serial": (1, _MANY),
        **{f"layout.{name}": bounds for name, bounds in _LAYOUT.items()},
        **{f"settings.{name}": _bounds_of(each) for name, each in SETTINGS.items()},
    },
    Kind.FREE: {"value": (0.0, 1.0)},
    Kind.GESTURE: {f"surface.{name}": (min(low, 0.0), high) for name, (low, high) in _SURFACE.items()},
    Kind.STEER: _RAMP,
    Kind.SET: _RAMP | {"parameter": (0, len(SETTINGS) - 1)},
    Kind.METHOD: {
        "method.method": (0, len(METHODS)), "method.correction": (0, len(CORRECTIONS) - 1),
        "method.oversampling": (0, 1024),
    },
    Kind.ACCURACY: {"value": (0, len(ACCURACIES) - 1)},
    Kind.QUALITY: {"value": (0, len(Quality) - 1)},
    Kind.GAIN: _RAMP | {"value": _bounds_of(MAIN_GAIN)},
    Kind.LIMITER: {"value": (0.0, 1.0)},
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
                yield f"{path}.{n}", (at + offset) // _WORD + n, int(inner.base.kind == "i")
        else:
            yield path, (at + offset) // _WORD, int(inner.kind == "i")


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


_SETTING_BOUNDS = _steered([_bounds_of(each)] for each in SETTINGS.values())
_STEER_BOUNDS = _steered(map(_bounds_of, gestures_steered_by(name).values()) for name in STEERABLE)


@kernel
def _wrong_of_group(group: int, reals: View[float], wholes: View[int]) -> int:
    """Return the word of a command that is out of a group's bounds, -1 if none is."""
    for n in range(_BEGINS[group], _BEGINS[group + 1]):
        value = float(wholes[_AT[n]]) if _IS_WHOLE[n] == 1 else reals[_AT[n]]
        if not _LEAST[n] <= value <= _MOST[n] or _is_tiny(value):
            return _AT[n]
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


# --- what a host asks ---

BEGIN, MAY_START, MAY_WRITE, WRONG_WORD, WRONG_RECORD = range(5)
"""What a host asks of `answer`, in C and in a page by its number."""
_STATE_WORDS, _COMMAND_WORDS = STATE.itemsize // _WORD, COMMAND.itemsize // _WORD


@noinline_kernel
def answer(memory: int, question: int, first: int, count: int) -> int:
    """Answer a host's question about the memory at an address, below 0 where nothing is wrong.

    BEGIN: makes zeros a fresh memory. MAY_START, MAY_WRITE: the first word, of `count` from `first` on, that is not to
    be written as a scene starts, or later. WRONG_WORD: the first of them whose value is out of its bounds.
    WRONG_RECORD: as `wrong_record`, with `first` values of pulses, and `count` 1 where there is memory for plates.
    """
    state: State = carray(memory, (1,), STATE)[0]
    wholes: View[int] = carray(memory, (_STATE_WORDS,), np.int64)
    if question == BEGIN:
        begin(state, wholes)
    elif question in (MAY_START, MAY_WRITE):
        return word_in_use(state, first, count, int(question == MAY_START))
    elif question == WRONG_WORD:
        reals: View[float] = carray(memory, (_STATE_WORDS,), np.float64)
        singles: View[np.float32] = carray(memory, (2 * _STATE_WORDS,), np.float32)
        return wrong_word(reals, wholes, singles, first, count)
    elif question == WRONG_RECORD:
        return wrong_record(state, first, count)
    return -1


@noinline_kernel
def judge_command(memory: int, command: int, tables: int) -> int:
    """Return the word by which the command at an address is none for the memory at another, -1 if that may take it.

    tables: of pulses that were made.
    """
    state: State = carray(memory, (1,), STATE)[0]
    event: Event = carray(command, (1,), COMMAND)[0]
    reals: View[float] = carray(command, (_COMMAND_WORDS,), np.float64)
    wholes: View[int] = carray(command, (_COMMAND_WORDS,), np.int64)
    return wrong_field(state, event, reals, wholes, tables)
