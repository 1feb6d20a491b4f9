"""Tables of the modes of bodies of size 1, which similar ones of all sizes share (similar.py)."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..kept import Kept
from .heard import largest
from .material import Array, Material
from .modes import Indices, Modes, Silent

_KEPT_BYTES = 256_000_000


@dataclass(frozen=True)
class Table:
    """The modes of a body of size 1 without losses, whose decay is half of its resistance, up to a frequency."""

    modes: Modes

    @cached_property
    def largest(self) -> Array:
        """The most that the modes' shapes go, (n,)."""
        return largest(self.modes.strike)

    @cached_property
    def frequency(self) -> Array:
        """The frequencies (Hz) of its modes and, ascending, of those that are felt alone beyond them: (n + m,)."""
        own = self.modes.unheard
        return self.modes.frequency if own is None else np.append(self.modes.frequency, own.frequency[self._beyond])

    @cached_property
    def _beyond(self) -> Indices:
        own = self.modes.unheard
        assert own is not None
        return np.argsort(own.frequency, kind="stable")

    @cached_property
    def shapes(self) -> Array:
        """The shapes of all these modes, (n + m, P)."""
        own, strike = self.modes.unheard, self.modes.strike
        every = strike if own is None else np.concatenate([strike, own.strike[:, self._beyond]], axis=1)
        return np.ascontiguousarray(every.T)

    @cached_property
    def sums(self) -> tuple[Array, Array]:
        """The sums of squared shapes times u and u^2, u = 1/omega^2, of each of these modes and all after it,
        (n + m + 1, P); the last are 0."""
        u = 1 / (2 * np.pi * self.frequency[:, None]) ** 2
        parts = self.shapes**2 * u
        first, second = (np.zeros((len(parts) + 1, parts.shape[1])) for _ in range(2))
        np.cumsum(parts[::-1], axis=0, out=first[-2::-1])
        np.cumsum((parts * u)[::-1], axis=0, out=second[-2::-1])
        return first, second


class Beyond(NamedTuple):
    """The modes of a table from one on, in a size, as contacts feel them: a `Feeling`."""

    table: Table
    first: int
    size: float

    @property
    def frequency(self) -> Array:
        found: Array = self.table.frequency[self.first :] / self.size
        return found

    def shapes(self, which: Indices) -> Array:
        """Return the shapes of some modes, as `Felt.shapes`."""
        found: Array = self.table.shapes[self.first + which].T * self.size**-1.5
        return found

    def squares(self, which: Indices, u: Array, grid: Array) -> Array:
        """Return sums of squares as `Felt.squares`, of modes that follow each other: as shares are linear in u, by the
        table's sums between the places of the grid."""
        ends = self.first + which[0] + np.searchsorted(-u, -grid[1:], side="right")
        at = np.concatenate([[self.first + which[0]], ends])
        one, other = (sums[at].T for sums in self.table.sums)
        one, other = one / self.size, other * self.size  # of phi^2 u, and of phi^2 u^2
        found = np.zeros_like(one)
        found[:, -1] = one[:, -1]  # beyond the grid
        between, squared, step = one[:, :-1] - one[:, 1:], other[:, :-1] - other[:, 1:], grid[:-1] - grid[1:]
        found[:, :-1] += (squared - grid[1:] * between) / step
        found[:, 1:] += (grid[:-1] * between - squared) / step
        return np.asarray(np.maximum(found, 0.0))


class Store(NamedTuple):
    """A place that outlasts the process: what reads the modes of a key, None if there are none, and what writes
    them."""

    read: Callable[[Hashable], Modes | None]
    write: Callable[[Hashable, Modes], None]


def table_of(
    make: Callable[..., Modes], top: float, material: Material, arguments: Mapping[str, Any], store: Store | None = None
) -> Table | None:
    """Return the table of a body of size 1 up to `top` (Hz); None if it has no mode there. store: of its modes."""
    lossless = replace(material, alpha=0.0, beta=0.0, loss_factor=0.0, losses="material")
    key = (make, top, lossless, *sorted(arguments.items()))
    found = _tables.get(key)
    if found is None:
        modes = store.read(key) if store else None
        if modes is None:
            try:
                modes = make(material=lossless, top=top, **arguments)
                if store:
                    store.write(key, modes)
            except Silent:
                pass
        found = (Table(modes),) if modes else ()
        _tables.put(key, found)
    return found[0] if found else None


def _bytes(tables: tuple[Table, ...]) -> int:
    """Return the bytes of tables, with what follows from them."""
    return sum(4 * 8 * len(each.modes.strike) * each.frequency.size for each in tables)


_tables: Kept[Hashable, tuple[Table, ...]] = Kept(_KEPT_BYTES, _bytes)
