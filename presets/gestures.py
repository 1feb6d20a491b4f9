"""The usual gestures on an object, where a message leaves values out: the sections [bounce], [roll], [slide], [spin]
and those of swarms.

An object has the section of a gesture that suits it. Another gesture can be played on it, too, if the message says how.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..dsp import schema
from .schema import SUITABLE, Fields, check
from .values import Name, Quantity

ON_SURFACE = tuple(name for name, gesture in schema.GESTURES.items() if gesture.along)

_OTHERS = {"seed", *(each.name for each in schema.STRIKE)}
"""Keys that a section has not: a seed is another for each gesture, and the rest is the striker's."""


def _fields(gesture: schema.Gesture) -> Fields:
    words = ("striker", "surface") if gesture.name in ON_SURFACE else ("striker",)
    numbers = (gesture.argument, *(key for key in gesture.keys if key.name not in _OTHERS))
    named = {each.name: Quantity.of(each) for each in numbers}
    return {**dict.fromkeys(words, Name()), **named}


FIELDS: Mapping[str, Fields] = {name: _fields(schema.GESTURES[name]) for name in SUITABLE}
"""The keys of each section."""

REQUIRED: Mapping[str, tuple[str, ...]] = {
    name: (*(key for key in FIELDS[name] if key in ("striker", "surface")), schema.GESTURES[name].argument.name)
    for name in SUITABLE
}


class Usual(NamedTuple):
    """A gesture as a preset has it: its striker, its surface ("" where it has none), and numbers by name, its first
    argument among them."""

    striker: str
    surface: str
    numbers: Mapping[str, float]

    @classmethod
    def from_data(cls, name: str, where: str, data: Mapping[str, Any]) -> Usual:
        """Make a gesture of a name from its section's data. `where` begins the text of a PresetError."""
        values = check(where, data, FIELDS[name], REQUIRED[name])
        return cls(values.pop("striker"), values.pop("surface", ""), values)
