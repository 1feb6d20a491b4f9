"""Recipes: TOML files that declare what is drawn for each item of a data set."""

from __future__ import annotations

import errno
import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...dsp.schema import GESTURES
from ...dsp.wording import expected
from ...presets import BUILT_IN, NoPreset, PresetError
from ...presets.library import read_file
from ...presets.schema import Fields, check
from ...presets.values import NAME, Choice, Name, Quantity, Section, Text, Unfit, Whole, shown
from ...server.render import HIGHEST_RATE, LOWEST_RATE
from .scores import Score, read_scores
from .split import Split, split_of
from .spread import Choice as Chosen
from .spread import Spread, Value, Words, spread_of

GESTURE = "gesture"
"""The name of the factor that says which gesture it is, where a recipe has several."""

OBJECTS = ("object", "by")
"""Sections of objects: the one that is touched, and one that strikes it."""

SENSOR, ON = "sensor", "on"
"""The section of a sensor, with the keys of `/sensor/new`, and its key that says on which object it is."""

SCORE = "score"
"""The section of a recipe whose items follow scores: they make their objects, and stand in the place of a gesture."""

DESIGNS = ("random", "sobol", "grid", "pairs")
FORMATS = ("flac", "wav")
SAMPLES = ("16", "24", "float")


class Word(Text):
    """A text without spaces, such as an SPDX identifier."""

    def __str__(self) -> str:
        return "the SPDX identifier of a licence, such as MIT"

    def fit(self, value: object) -> Any:
        if not isinstance(value, str) or not LICENCE.fullmatch(value):
            raise Unfit(value, self)
        return value


LICENCE = re.compile(r"[A-Za-z0-9][A-Za-z0-9.+-]*")
"""Form of a licence's identifier."""

_SECTIONS = (*OBJECTS, *GESTURES, SENSOR, SCORE)

MOST = 1_000_000_000
"""Items that a recipe can have."""

KEYS: Fields = {
    "description": Text(),
    "design": Choice(DESIGNS),
    "differ": Words(),
    "count": Whole(1, MOST),
    "seed": Whole(0, 2**63 - 1),
    "seconds": Quantity(1e-3, 600, "s"),
    "rate": Whole(LOWEST_RATE, HIGHEST_RATE, "Hz"),
    "channels": Whole(1, 8),
    "format": Choice(FORMATS),
    "samples": Choice(SAMPLES),
    "full_scale": Quantity(1e-6, 1e6, "Pa"),
    "licence": Word(),
    "split": Section(),
    "shard": Whole(1, 100_000),
    **dict.fromkeys(_SECTIONS, Section()),
}
"""The keys of a recipe and its sections."""

DEFAULTS: Mapping[str, Any] = {
    "design": "random", "seed": 0, "seconds": 1.0, "rate": 48_000, "channels": 1, "format": "flac", "samples": "24",
    "full_scale": None, "licence": "unknown", "shard": 256,
}  # fmt: skip
"""Defaults of keys that need not be given."""

OWN: Mapping[str, Fields] = {
    "object": {"size": Quantity(1e-3, 1e3, "times")},
    "by": {"size": Quantity(1e-3, 1e3, "times")},
    SENSOR: {ON: Choice(OBJECTS)},
    **{name: {"at": Quantity(0, 600, "s"), "until": Quantity(0, 600, "s")} for name in GESTURES},
}
"""Keys of a section that are the recipe's own, and no message's."""


@dataclass(frozen=True)
class Factor:
    """A factor: SECTION.KEY, and how its values are spread."""

    name: str
    spread: Spread


@dataclass(frozen=True)
class Recipe:
    """A recipe as it is used. text: of its file; where: how an error about it begins.

    count: items; seconds: of each; samples: of the files, 16, 24 or float; full_scale: Pa, None: a power of two of each
    item's own; licence: of the clips; split: of the items (None: all are to learn from); shard: items in each.
    sections: objects and gestures, or a score's, each with values and distributions by key. scores: by their files.
    differ: the factors in which pairs may differ; empty: any.
    """

    name: str
    text: str
    where: str = field(repr=False)
    count: int
    design: str
    seed: int
    seconds: float
    rate: int
    channels: int
    format: str
    samples: str
    full_scale: float | None
    licence: str
    shard: int
    sections: Mapping[str, Mapping[str, Value | Spread]]
    factors: tuple[Factor, ...]
    gestures: tuple[str, ...]
    description: str = ""
    differ: tuple[str, ...] = ()
    split: Split | None = None
    scores: Mapping[str, Score] = field(default_factory=dict, repr=False)

    @property
    def frames(self) -> int:
        """Frames of each clip."""
        return round(self.seconds * self.rate)

    @property
    def shards(self) -> int:
        """Number of files that hold the clips."""
        return math.ceil(self.count / self.shard)

    def numbers(self, shard: int) -> range:
        """Return the numbers of a shard's items."""
        return range(shard * self.shard, min((shard + 1) * self.shard, self.count))


def find(name: str, folders: Sequence[Path] = ()) -> Path:
    """Return the file of a recipe: a file of that name, or a preset in recipes/ of these folders or of Carom's own.

    FileNotFoundError, or NoPreset, which asks for a near name.
    """
    path = Path(name)
    if path.is_file():
        return path
    if not NAME.fullmatch(name):
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), name)
    places = [folder / "recipes" for folder in (*folders, BUILT_IN)]
    for place in places:
        if (place / f"{name}.toml").is_file():
            return place / f"{name}.toml"
    known = sorted({each.stem for place in places for each in place.glob("*.toml")})
    raise NoPreset(f"no recipe {name!r}", lambda: expected(name, known))


def read(path: Path, count: int | None = None) -> Recipe:
    """Read the recipe in a file; count: items, in place of the file's. PresetError names the file, the key, its value
    and what was expected."""
    where, data = read_file(path)
    if not NAME.fullmatch(path.stem):
        raise PresetError(f"{path}: {shown(path.stem)}: expected {Name()} before .toml, as files are named by it")
    return recipe_of(data, Source(path.stem, where, path.read_text(encoding="utf-8"), path.parent), count)


@dataclass(frozen=True)
class Source:
    """The place that a recipe is from: its name, how an error about it begins, its text, and the folder of its
    scores."""

    name: str
    where: str
    text: str
    folder: Path


def recipe_of(data: Mapping[str, Any], source: Source, count: int | None = None) -> Recipe:
    """Return the recipe that data say, as of a file; count: items, in place of theirs. PresetError as of `read`."""
    where = source.where
    needed = () if SCORE in data else ("object",)
    values = {**DEFAULTS, **check(where, dict(data), KEYS, needed)}
    sections = {name: _section(where, name, values.pop(name)) for name in _SECTIONS if name in values}
    gestures = tuple(name for name in (*GESTURES, SCORE) if name in sections)
    if not gestures:
        named = ", ".join(f"[{name}]" for name in (*GESTURES, SCORE))
        raise PresetError(f"{where}no gesture: expected a section {named}")
    scores = {}
    if SCORE in sections:
        if others := [name for name in sections if name != SCORE]:
            raise PresetError(f"{where}[{others[0]}]: expected no section beside [{SCORE}], which makes its objects")
        scores = read_scores(f"{where}[{SCORE}] ", source.folder, sections[SCORE])
    factors = _factors(sections, gestures)
    _count(where, values, factors, count)
    if "split" in values:
        spreads = [(each.name, each.spread) for each in factors]
        objects = {name: table for name, table in sections.items() if name in OBJECTS}
        values["split"] = split_of(where, values["split"], spreads, objects, values["seed"])
    recipe = Recipe(
        name=source.name, text=source.text, where=where, sections=sections, factors=tuple(factors), gestures=gestures,
        scores=scores, **values,
    )  # fmt: skip
    _require_sense(recipe)
    return recipe


def _factors(sections: Mapping[str, Mapping[str, Value | Spread]], gestures: tuple[str, ...]) -> list[Factor]:
    """Return what is drawn for each item."""
    factors = [
        Factor(f"{section}.{key}", value)
        for section, table in sections.items()
        for key, value in table.items()
        if isinstance(value, Spread)
    ]
    if len(gestures) > 1:
        factors.insert(0, Factor(GESTURE, Chosen(gestures)))
    return factors


def _count(where: str, values: dict[str, Any], factors: Sequence[Factor], count: int | None) -> None:
    """Set the number of items: that which is requested, the recipe's, or of a grid its points."""
    if count is not None:
        values.update(check("", {"count": count}, KEYS, ()))
    elif "count" not in values and values["design"] == "grid":
        values["count"] = math.prod(each.spread.levels or 1 for each in factors)
    elif "count" not in values:
        raise PresetError(f"{where}count is missing: expected {KEYS['count']}")


def _section(where: str, name: str, table: Mapping[str, object]) -> dict[str, Value | Spread]:
    """Return the values and distributions of a section."""
    made: dict[str, Value | Spread] = {}
    for key, value in table.items():
        if isinstance(value, dict):
            made[key] = spread_of(f"{where}[{name}] {key}.", value)
        elif isinstance(value, bool) or not isinstance(value, float | int | str | list):
            raise PresetError(f"{where}[{name}] {key} = {shown(value)}: expected a number, a word, a list or a table")
        else:
            made[key] = tuple(value) if isinstance(value, list) else value
    return made


def _require_sense(recipe: Recipe) -> None:
    """Raise PresetError where keys contradict each other."""
    where = recipe.where
    if recipe.format == "flac" and recipe.samples == "float":
        raise PresetError(f"{where}samples = 'float': expected 16 or 24, which FLAC holds")
    if recipe.design == "sobol" and not recipe.factors:
        raise PresetError(f"{where}design = 'sobol': expected a key that is drawn, such as velocity")
    if recipe.design != "pairs":
        return
    if recipe.split:
        able = recipe.differ or tuple(each.name for each in recipe.factors)
        if both := [name for name in recipe.split.by if name in able]:
            raise PresetError(f"{where}split: pairs may differ in {both[0]}; expected differ = [...] without it")
    if recipe.count % 2:
        raise PresetError(f"{where}count = {recipe.count}: expected an even number, as items are pairs")
    names = [factor.name for factor in recipe.factors if factor.spread.levels != 1]
    for name in recipe.differ:
        if name not in names:
            raise PresetError(f"{where}differ = {shown(list(recipe.differ))}: {name}: {expected(name, names)}")
    if not set(names) - {GESTURE}:
        raise PresetError(f"{where}design = 'pairs': expected a key that is drawn, such as velocity")
