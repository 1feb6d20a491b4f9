"""The messages of an item: what makes its objects, and what is done with them."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import chain

from ...dsp.schema import GESTURES
from ...server.osc import sensor_verbs
from ...server.osc.score import Line
from ...server.osc.wire import Argument, Message
from .design import Item
from .recipe import OBJECTS, ON, OWN, SCORE, SENSOR, Recipe
from .scores import FILE, filled
from .spread import Value

OBJECT, BY = "object", "by"
"""The names of an item's objects: those of their sections."""


def lines_of(recipe: Recipe, item: Item) -> list[Line]:
    """Return an item's lines, by time: its score, or objects that are made, a gesture, and perhaps its end.

    PresetError as in `object_message`.
    """
    if item.gesture == SCORE:
        values = item.values[SCORE]
        return filled(recipe.scores[str(values[FILE])].lines, values, item.seed)
    made = [object_message(name, item.values[name]) for name in OBJECTS if name in item.values]
    made += [sensor_message(item.values[SENSOR])] if SENSOR in item.values else []
    values = item.values[item.gesture]
    lines = [Line(0.0, message, "") for message in made]
    gesture = gesture_message(item.gesture, values, item.seed, BY in item.values)
    lines.append(Line(number(values, "at"), gesture, ""))
    if "until" in values:
        lines.append(Line(number(values, "until"), Message(f"/gesture/{item.gesture}/stop"), ""))
    return lines


def object_message(name: str, values: Mapping[str, Value]) -> Message:
    """Return the message that makes an object."""
    preset = str(values["preset"])
    given = {key: value for key, value in values.items() if key != "preset" and key not in OWN[name]}
    sized = {"size": values["size"]} if "size" in values else {}
    return Message("/object/new", (name, preset, *_pairs({**sized, **given})))


def sensor_message(values: Mapping[str, Value]) -> Message:
    """Return the message that mounts a sensor."""
    given = {key: value for key, value in values.items() if key not in OWN[SENSOR]}
    return Message(sensor_verbs.SENSOR, (SENSOR, str(values.get(ON, OBJECT)), *_pairs(given)))


def gesture_message(gesture: str, values: Mapping[str, Value], seed: int, has_by: bool) -> Message:
    """Return the message of a gesture, with a seed of its own unless it is given one."""
    argument = "what" if GESTURES[gesture].what else GESTURES[gesture].argument.name
    given = {key: value for key, value in values.items() if key not in (argument, *OWN[gesture])}
    if any(key.name == "seed" for key in GESTURES[gesture].keys):
        given = {"seed": seed, **given}
    if has_by and not GESTURES[gesture].what:
        given["by"] = BY
    first = (values[argument],) if argument in values else ()  # else it is known by an impulse
    return Message(f"/object/{OBJECT}/{gesture}", (*first, *_pairs({**given, "id": gesture})))


def number(values: Mapping[str, Value], key: str, default: float = 0.0) -> float:
    """Return a value that is a number."""
    value = values.get(key, default)
    assert isinstance(value, int | float), key
    return float(value)


def _pairs(values: Mapping[str, Value]) -> tuple[Argument, ...]:
    return tuple(chain.from_iterable(values.items()))
