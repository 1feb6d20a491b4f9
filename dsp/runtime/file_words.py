"""The words of the engine's memory that a file may write, and their bounds.

These are wide: they guard memory and finite sums, not taste.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..engine.memory.capacity import OBJECTS
from ..engine.memory.commands import KIND_NEW
from ..engine.memory.state import RING, STATE, State
from ..engine.memory.striker_state import STRIKER_MODES, STRIKERS
from ..karman.layout import LEVELS, MOST_ORDERS, SHEETS, SPACE, TABLE_VALUES
from ..native.jit import kernel, noinline_kernel
from ..native.typed import View
from ..sizes import MOST_COUPLED, MOST_SCATTERED
from ..swarm.record import (
    DISSIPATIONS,
    MOST_BENDS,
    MOST_LENGTH,
    MOST_NODES,
    MOST_TURNS,
    POINTS,
    PULSES,
    TABLE,
)
from ..swarm.record import (
    MOST_ORDERS as MOST_PULSE_ORDERS,
)

WORD = 8
_REAL, _WHOLE, _SINGLES = range(3)  # kinds of words: a float64, an int64, two float32
MANY = 2.0**53
_TINY = 1e-100

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
    "strained": (0.0, 1.0), "tension": (0.0, 1.0), "share": (0.0, 1.0), "drained": (0.0, 1.0), "follows": (0.0, 1.0),
}  # fmt: skip
_STRIKER = {
    "size": (0, STRIKER_MODES), "serial": (0, MANY), "clicks": (0, STRIKER_MODES), "radius": (0.0, 1e3),
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

    def rows(kind: Any, at: int, period: int, repeats: int, bounds: Mapping[str, tuple[float, float]]) -> Iterator[Any]:
        for name, (low, high) in bounds.items():
            inner, place = kind.fields[name][:2]
            word = {"f8": _REAL, "i8": _WHOLE, "f4": _SINGLES}[inner.base.str[1:]]
            assert (at + place) % WORD == inner.itemsize % WORD == period % WORD == 0
            yield (at + place) // WORD, period // WORD, repeats, inner.itemsize // WORD, word, low, high

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
_PULSES_AT: int = STATE.fields["pulses"][1] // WORD  # type: ignore[index]
_SHEETS_AT: int = STATE.fields["sheets"][1] // WORD  # type: ignore[index]
_SHEET_WORDS: int = STATE["sheets"].base.itemsize // WORD


@kernel
def is_tiny(x: float) -> bool:
    """True of a number that no measure is, and whose products processors compute a hundred times more slowly."""
    return x != 0.0 and abs(x) < _TINY


@kernel
def _is_of_row(row: int, word: int) -> bool:
    """True if a word lies in a row of those that a file may write."""
    after = word - _FIRST[row]
    found: bool = 0 <= after < _PERIOD[row] * _REPEATS[row] and after % _PERIOD[row] < _COUNT[row]
    return found


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
    end: int = min(_FIRST[row] + record * _PERIOD[row] + _COUNT[row], last)
    return end


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
            if not (low <= least <= high and low <= most <= high) or (kind == _REAL and is_tiny(least)):
                return n
        word = _end_of(row, word, last)
    return -1
