"""The split of a data set into items to learn from and items to test with, by what these have in common."""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...dsp.schema import SETTINGS
from ...dsp.wording import expected
from ...presets import PresetError
from ...presets.schema import Fields, check
from ...presets.values import Quantity, Text, shown
from .spread import Spread, Value

GEOMETRY = "geometry"
"""The word for all of an object but its material and its settings: preset, size, and all lengths."""

SIDES = ("train", "test", "validation")

_KEYS: Fields = {"by": Text(), "test": Quantity(0, 0.9), "validation": Quantity(0, 0.9)}
_NO_GEOMETRY = ("material", *SETTINGS)
_MOST_GROUPS = 10_000


@dataclass(frozen=True)
class Split:
    """A split: items of one group, which are alike in the factors `by`, are on one side.

    shares: of groups, by side. ranks: of groups, where there are few, so that each side has its share of them.
    """

    by: tuple[str, ...]
    seed: int
    shares: tuple[tuple[str, float], ...]
    ranks: Mapping[tuple[Value, ...], float]

    def side(self, factors: Mapping[str, Value]) -> str:
        """Return the side of an item, by its factors."""
        group = tuple(factors[name] for name in self.by if name in factors)
        at = self.ranks[group] if group in self.ranks else _hashed(self.seed, group)
        for side, share in self.shares:
            if at < share:
                return side
            at -= share
        return SIDES[0]


def split_of(
    where: str, table: Mapping[str, Any], factors: Sequence[tuple[str, Spread]], sections: Sequence[str], seed: int
) -> Split:
    """Return the split that a table of a recipe says. factors: all that are drawn, by their names. PresetError says
    what does not fit."""
    where = f"{where}split."
    values = check(where, table, _KEYS, ("by",))
    names = [name for name, _ in factors]
    by = tuple(_of_geometry(names, sections)) if values["by"] == GEOMETRY else (values["by"],)
    if not by:
        drawn = ", ".join(names)
        raise PresetError(f"{where}by = {shown(GEOMETRY)}: no preset or length is drawn; expected one of {drawn}")
    if by[0] not in names:
        raise PresetError(f"{where}by = {shown(by[0])}: {expected(by[0], [GEOMETRY, *names])}")
    shares = tuple((side, values.get(side, 0.2 if side == "test" else 0.0)) for side in SIDES[1:])
    if sum(share for _, share in shares) >= 1.0:
        raise PresetError(
            f"{where}test, validation = {shown([each for _, each in shares])}: expected less than 1 together"
        )
    return Split(by, seed, shares, _ranks([spread for name, spread in factors if name in by], seed))


def _of_geometry(names: Sequence[str], sections: Sequence[str]) -> list[str]:
    parts = [(name, *name.split(".", 1)) for name in names if "." in name]
    return [name for name, section, key in parts if section in sections and key not in _NO_GEOMETRY]


def _ranks(spreads: Sequence[Spread], seed: int) -> dict[tuple[Value, ...], float]:
    """Return the places of all groups in a random order, 0 to below 1, if there are few."""
    if not 0 < math.prod(spread.levels for spread in spreads) <= _MOST_GROUPS:
        return {}
    values = [[spread.at(spread.middle(n)) for n in range(spread.levels)] for spread in spreads]
    groups = sorted(itertools.product(*values), key=lambda group: _hashed(seed, group))
    return {group: place / len(groups) for place, group in enumerate(groups)}


def _hashed(seed: int, group: tuple[Value, ...]) -> float:
    """Return a number from 0 to below 1 that follows from a group alone."""
    digest = hashlib.sha256(repr((seed, group)).encode()).digest()
    return int.from_bytes(digest[:6], "big") / 2.0**48
