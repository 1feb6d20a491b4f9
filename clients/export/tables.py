"""The tables of mode shapes of a baked scene, coded by the few numbers that they follow from: `tables.js` decodes them.

Of each column come a kind and a scale, then its numbers: a polynomial's coefficients, or the second differences of its
values in steps (`dsp/runtime/series.py`), or its values' bits, where it is neither. A column that is decoded is the
one that was coded, to the bit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...dsp.engine.memory.state import STATE
from ...dsp.runtime.series import LEAST_ROWS, coefficients_of, multiples_of, scale_of, sum_of, values_of
from .baking import MAKES, SHAPES, Baked, Patch
from .coding import Coder, Numbers

SUM, STEPS, BITS = range(3)
"""Kinds of columns."""
KIND_BITS, EXPONENT_BITS = 2, 11
_LEAST_EXPONENT = 1023

Table = NDArray[np.float32]


class Laid(NamedTuple):
    """A table of mode shapes that a batch brings: its first word in the engine's memory, and its values."""

    batch: int
    first: int
    values: Table


def taken_out(baked: Baked) -> tuple[list[Laid], list[list[Patch]]]:
    """Return the tables of many rows that a scene's batches bring, and each batch's words without them."""
    memory = np.zeros(STATE.itemsize // 8, np.uint64)
    for patch in baked.start:
        memory[patch.first : patch.first + len(patch.words)] = patch.words
    tables: list[Laid] = []
    rest: list[list[Patch]] = []
    for number, batch in enumerate(baked.batches):
        for patch in batch.patches:
            memory[patch.first : patch.first + len(patch.words)] = patch.words
        found = {}
        for first, rows, size in _tables(batch.commands):
            end = first + rows * size // 2
            if any(each.first < end and first < each.first + len(each.words) for each in batch.patches):
                found[first] = Laid(number, first, memory[first:end].view(np.float32).reshape(rows, size).copy())
        tables += found.values()
        places = [(each.first, each.first + each.values.size // 2) for each in found.values()]
        rest.append([part for patch in batch.patches for part in _without(patch, places)])
    return tables, rest


def _tables(commands: NDArray[np.void]) -> Iterator[tuple[int, int, int]]:
    """Yield first word, rows and columns of each table that commands name, where it has many rows and no faces."""
    for layout in commands[commands["kind"] == MAKES]["layout"]:
        first = SHAPES + 4 * int(layout["table"])
        if layout["rows"] >= LEAST_ROWS and layout["faces"] == 0 and layout["block"] == 0 and first % 8 == 0:
            yield first // 8, int(layout["rows"]), int(layout["size"])


def _without(patch: Patch, places: Sequence[tuple[int, int]]) -> list[Patch]:
    """Return the parts of a patch that lie in none of some places."""
    at = np.arange(patch.first, patch.first + len(patch.words))
    kept = np.ones(len(at), bool)
    for first, end in places:
        kept &= (at < first) | (at >= end)
    if kept.all():
        return [patch]
    places_kept = np.flatnonzero(kept)
    runs = np.split(places_kept, np.flatnonzero(np.diff(places_kept) > 1) + 1) if len(places_kept) else []
    return [Patch(patch.first + int(run[0]), patch.words[run]) for run in runs]


def coded(tables: Sequence[Table]) -> bytes:
    """Return the bytes of tables."""
    coder = Coder()
    kinds, numbers = [1 << 10] * (1 << KIND_BITS), [Numbers(coder) for _ in (SUM, STEPS)]
    for table in tables:
        for column in table.T:
            kind, exponent, told = _told(column[:, None])
            coder.tree(kinds, 0, kind, KIND_BITS)
            if kind == BITS:
                for value in column.view(np.uint32).tolist():
                    coder.direct(value, 32)
                continue
            coder.direct(exponent + _LEAST_EXPONENT, EXPONENT_BITS)
            numbers[kind].put(told)
    return coder.finished()


def _told(column: Table) -> tuple[int, int, list[int]]:
    """Return the kind of a column (R, 1), the exponent of its scale, and its numbers."""
    own = int(np.frexp(scale_of(column))[1][0]) - 1
    for exponent in (own, own - 1, own + 1):  # what is rounded may reach the next scale
        scale = np.ldexp(np.ones(1), exponent)
        steps = multiples_of(column, scale)
        if _same(values_of(steps, scale), column):
            return STEPS, exponent, np.diff(steps[:, 0], 2, prepend=[0, 0]).tolist()
        sums = coefficients_of(column, scale)
        if _same(sum_of(sums, len(column), scale), column):
            return SUM, exponent, sums[:, 0].tolist()
    return BITS, 0, []


def _same(one: Table, other: Table) -> bool:
    return one.tobytes() == other.tobytes()
