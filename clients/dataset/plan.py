"""The plan that a worker follows, and the shard that it makes."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

from ...dsp.bodies.modes import Modes
from ...dsp.numerics.blas import on_one_thread
from ...dsp.resonator.bank import top_of
from ...dsp.schema import SETTINGS
from ...presets import PresetError, Presets
from ...presets.making import keep, kept
from ...server.new_object import new_object
from ...server.osc.addresses import calls
from ...server.osc.arguments import Refused
from ...server.osc.wire import Message
from .clip import render
from .design import items
from .messages import object_message
from .presets import presets_of
from .recipe import OBJECTS, Recipe
from .shard import packed
from .spread import Spread
from .table import rows_file
from .versions import require_same, versions

_MOST_SHIPPED = 256
"""Objects of different modes that are made before the workers begin, if there are no more."""


@dataclass(frozen=True)
class Plan:
    """A recipe, the folders of the user's presets, the versions that its bytes need, and modes that were made."""

    recipe: Recipe
    folders: tuple[str, ...]
    versions: Mapping[str, str]
    modes: tuple[tuple[Hashable, Modes], ...] = field(default=(), repr=False)


@dataclass(frozen=True)
class Made:
    """A shard: its number, the bytes of its tar, and of its rows of the table."""

    shard: int
    tar: bytes = field(repr=False)
    rows: bytes = field(repr=False)


def planned(recipe: Recipe, folders: Sequence[Path]) -> Plan:
    """Return the plan of a recipe, with modes that many items share."""
    plan = outlined(recipe, folders)
    presets = Presets(plan.folders)
    for message in shared_objects(recipe):
        make_modes(recipe, message, presets)
    return replace(plan, modes=tuple(kept()))


def outlined(recipe: Recipe, folders: Sequence[Path]) -> Plan:
    """Return the plan of a recipe, without modes."""
    places = tuple(map(str, folders))
    return Plan(recipe, places, dict(versions(places)))


def make(plan: Plan, shard: int, worker: str, go_on: Callable[[], object] = lambda: None) -> Made:
    """Make a shard of a plan. go_on: called before each item; what it raises ends the work. worker: how an error names
    it.

    VersionError if this process would make other bytes; ItemError names an item that cannot be.
    """
    require_same(plan.versions, versions(plan.folders), worker)
    keep(plan.modes)
    presets = presets_of(plan.folders)
    clips = []
    with on_one_thread():
        for item in items(plan.recipe, plan.recipe.numbers(shard)):
            go_on()
            clips.append(render(plan.recipe, item, presets))
        return Made(shard, packed(plan.recipe, clips), rows_file(plan.recipe, shard, clips))


def shared_objects(recipe: Recipe) -> list[Message]:
    """Return the messages that make all objects that there can be, of other modes each, if they are few."""
    found: list[Message] = []
    for section in OBJECTS:
        table = {key: value for key, value in recipe.sections.get(section, {}).items() if key not in SETTINGS}
        spreads = [value for value in table.values() if isinstance(value, Spread)]
        count = 1
        for spread in spreads:
            count *= spread.levels
        if not table or not 0 < count <= _MOST_SHIPPED:
            continue
        ways = [
            [value.at(value.middle(n)) for n in range(value.levels)] if isinstance(value, Spread) else [value]
            for value in table.values()
        ]
        for values in itertools.product(*ways):
            found.append(object_message(section, dict(zip(table, values, strict=True))))
    return found


def make_modes(recipe: Recipe, message: Message, presets: Presets) -> None:
    """Make the modes of an object; they are kept. One that cannot be is left to the first item that has it, if any:
    its error names that."""
    (call,) = calls(message)
    with suppress(PresetError, Refused):
        new_object(call, presets, top_of.py_func(recipe.rate))
