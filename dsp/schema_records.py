"""Records of the numbers that the schema declares, as the engine holds them.

Their fields follow from the schema when this is imported. Editors and mypy read them in `schema_records.pyi`, which
`make documents` writes.
"""

import dataclasses
from collections.abc import Collection, Iterable
from typing import Any

from .counters import Stats
from .macros import ENGINE_SETTINGS
from .native.typed import Record, dtype_of
from .schema import STEERABLE, TRAIT_NAMES
from .schema_values import OF_RAMPS, OWN, SHARED


def _record(name: str, doc: str, fields: Iterable[str], whole: Collection[str] = ()) -> Any:
    """Return a record of float64 fields; whole: the names of those that are int64."""
    kinds = {field: int if field in whole else float for field in fields}
    return type(name, (Record,), {"__annotations__": kinds, "__module__": __name__, "__doc__": doc})


_COUNTED = dataclasses.fields(Stats)

Steered = _record("Steered", "A value for each steerable parameter.", STEERABLE)
Values = _record(
    "Values",
    "The values of a gesture: the parameters of all gestures, 0 for those that it has not.",
    dict.fromkeys([*SHARED, *(name for own in OWN.values() for name in own)]),
)
Settings = _record("Settings", "The settings of an object.", ENGINE_SETTINGS)
RampValues = _record("RampValues", "The time that a change takes, and how.", OF_RAMPS)
Traits = _record("Traits", "The traits of a gesture: see `Gesture`.", TRAIT_NAMES, {*TRAIT_NAMES} - {"meets"})
Counters = _record(
    "Counters",
    "The counters as the engine holds them: see `Stats`.",
    [each.name for each in _COUNTED],
    [each.name for each in _COUNTED if each.type in (int, "int")],
)

RECORDS = Steered, Values, Settings, RampValues, Traits, Counters
"""All of them."""
STATS, STEERED, VALUES = dtype_of(Counters), dtype_of(Steered), dtype_of(Values)
