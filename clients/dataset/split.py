"""The split of a data set into items to learn from and items to test with, by what these have in common."""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ...dsp.wording import expected
from ...presets import PresetError, Presets
from ...presets.schema import SHAPES, Fields, check
from ...presets.values import Quantity, Text, shown
from .spread import Spread, Value

Group = tuple[Any, ...]

GEOMETRY = "geometry"
"""The word for the lengths of an object, or the preset of one that has none."""

SIDES = ("train", "test", "validation")

_KEYS: Fields = {"by": Text(), "test": Quantity(0, 0.9), "validation": Quantity(0, 0.9)}
_OF_LENGTHS = {"preset", "size", *(key for shape in SHAPES.values() for key in shape.lengths)}
_LISTED = "listed", "mesh"
_MOST_GROUPS = 10_000

Sections = Mapping[str, Mapping[str, Any]]
"""Sections of objects: values, and distributions, by key."""


@dataclass(frozen=True)
class Split:
    """A split: items of one group are on one side, those that are alike in the factors `by`.

    shares: of groups, by side. levels: of the factors, all values, where there are few groups, so that each side has
    its share of them. objects: by sections, values that are not drawn, where objects of the same lengths are alike.
    """

    by: tuple[str, ...]
    seed: int
    shares: tuple[tuple[str, float], ...]
    levels: tuple[tuple[Value, ...], ...]
    objects: Sections | None
    _ranks: dict[Group, float] = field(default_factory=dict, repr=False, compare=False)

    @property
    def sides(self) -> tuple[str, ...]:
        """The sides that have a share."""
        return SIDES[0], *(side for side, share in self.shares if share > 0.0)

    def side(self, factors: Mapping[str, Value], presets: Presets) -> str:
        """Return the side of an item, by its factors."""
        if self.levels and not self._ranks:
            names = [dict(zip(self.by, values, strict=True)) for values in itertools.product(*self.levels)]
            groups = {self._group(each, presets) for each in names}
            ordered = sorted(groups, key=lambda group: _hashed(self.seed, group))
            self._ranks.update((group, place / len(ordered)) for place, group in enumerate(ordered))
        group = self._group(factors, presets)
        at = self._ranks[group] if group in self._ranks else _hashed(self.seed, group)
        for side, share in self.shares:
            if at < share:
                return side
            at -= share
        return SIDES[0]

    def _group(self, factors: Mapping[str, Value], presets: Presets) -> Group:
        drawn = {name: factors[name] for name in self.by if name in factors}
        if self.objects is None:
            return tuple(drawn.values())
        return tuple(_lengths(section, table, drawn, presets) for section, table in self.objects.items())


def split_of(
    where: str, table: Mapping[str, Any], factors: Sequence[tuple[str, Spread]], objects: Sections, seed: int
) -> Split:
    """Return the split that a table of a recipe says. factors: all that are drawn, by their names. objects: the
    recipe's sections of objects. PresetError says what does not fit."""
    where = f"{where}split."
    values = check(where, table, _KEYS, ("by",))
    names = [name for name, _ in factors]
    by = tuple(_of_geometry(names, objects)) if values["by"] == GEOMETRY else (values["by"],)
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
    said = {
        section: {key: value for key, value in table.items() if not isinstance(value, Spread)}
        for section, table in objects.items()
    }
    levels = _levels([spread for name, spread in factors if name in by])
    return Split(by, seed, shares, levels, said if values["by"] == GEOMETRY else None)


def _of_geometry(names: Sequence[str], objects: Sections) -> list[str]:
    parts = [(name, *name.split(".", 1)) for name in names if "." in name]
    return [name for name, section, key in parts if section in objects and key in _OF_LENGTHS]


def _lengths(section: str, table: Mapping[str, Any], drawn: Mapping[str, Value], presets: Presets) -> Group:
    """Return the shape of a section's object and its lengths in order, as a plate that is turned rings alike; or, where
    its modes are listed, its preset."""
    values = {key: drawn.get(f"{section}.{key}", table.get(key)) for key in _OF_LENGTHS}
    name = str(values["preset"])
    lengths = SHAPES[presets.object(name).shape].lengths
    made = presets.changed(name, tuple((key, values[key]) for key in ("size", *lengths) if values[key] is not None))
    if made.shape in _LISTED:
        return made.shape, name
    return made.shape, *sorted(f"{made.geometry[key]:.9g}" for key in lengths if key in made.geometry)


def _levels(spreads: Sequence[Spread]) -> tuple[tuple[Value, ...], ...]:
    """Return all values of some factors, if there are few groups of them."""
    if not 0 < math.prod(spread.levels for spread in spreads) <= _MOST_GROUPS:
        return ()
    return tuple(tuple(spread.at(spread.middle(n)) for n in range(spread.levels)) for spread in spreads)


def _hashed(seed: int, group: Group) -> float:
    """Return a number from 0 to below 1 that follows from a group alone."""
    digest = hashlib.sha256(repr((seed, group)).encode()).digest()
    return int.from_bytes(digest[:6], "big") / 2.0**48
