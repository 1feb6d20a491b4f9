"""Tries what a recipe may draw, before anything is rendered: names, keys and both ends of every range."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ...dsp.schema import GESTURES
from ...dsp.wording import expected, near
from ...presets import PresetError, Presets
from ...presets.schema import NO_REST, check
from ...presets.supports import SUPPORTS
from ...presets.values import shown
from ...server.new_object import changed
from ...server.osc import sensor_verbs
from ...server.osc.addresses import VERBS, calls
from ...server.osc.arguments import Refused
from ...server.scene.sensing import sensor_asked
from .messages import gesture_message, object_message, sensor_message
from .recipe import OBJECTS, ON, OWN, SCORE, SENSOR, Recipe
from .scores import FILE, NAMED, filled, require_filled, require_performable
from .spread import Spread, Value

_MADE = {"id": "no key", "by": "a section [by], as the object that strikes"}
"""Keys of gestures that a recipe does not have, and what is expected in their place."""
_OF_TABLES = {"material", "density", "youngs_modulus", "poisson_ratio"}
"""Keys of an object that a mesh's table of modes has to agree with."""
_ANY_TOP = 1_000.0  # Hz


def require_sound(recipe: Recipe, presets: Presets) -> None:
    """Raise PresetError that names the file, the section, the key and the value that no item could have."""
    for section, table in recipe.sections.items():
        where = f"{recipe.where}[{section}] "
        if section == SCORE:
            require_filled(where, recipe.scores, table, recipe.seconds)
            for score in recipe.scores.values():
                require_performable(score.fixed(), presets)
            drawn = {name: score.drawn() for name, score in recipe.scores.items()}
            for values in _tried(table, FILE):
                require_performable(filled(drawn[str(values[FILE])], values, 0), presets)
            continue
        kind = _kind(section, table)
        if kind and kind not in table:
            _require_near(where, section, table, kind)
            raise PresetError(f"{where}{kind} is missing: expected {_wanted(section)}")
        for key, value in table.items():
            if section in GESTURES and key in _MADE:
                raise PresetError(f"{where}{key} = {shown(value)}: expected {_MADE[key]}")
            if key in OWN[section]:
                for end in _ends(value):
                    check(where, {key: end}, OWN[section], ())
        for values in _tried(table, "preset" if section in OBJECTS else ""):
            try:
                _try(section, values, presets, "by" in recipe.sections)
            except ValueError as error:  # Refused and PresetError, too
                of = str(values.get("preset", ""))
                raise PresetError(f"{where}{error}{f' (preset {of})' if of not in str(error) else ''}") from None


def _require_near(where: str, section: str, table: Mapping[str, Value | Spread], kind: str) -> None:
    """Raise PresetError where a key that is none stands for the one that is missing."""
    known = OWN[section].keys() | (VERBS[f"/object/NAME/{section}"].named.keys() if section in GESTURES else ())
    for key in table.keys() - known:
        if near(key, (kind,)):
            raise PresetError(f"{where}{key} = {shown(table[key])}: did you mean {kind}?")


def _kind(section: str, table: Mapping[str, Value | Spread]) -> str:
    """Return the key that a section cannot be without."""
    if section == SENSOR:
        return ""
    if section in OBJECTS:
        return "preset"
    gesture = GESTURES[section]
    if gesture.instead in table:
        return gesture.instead
    return "what" if gesture.what else gesture.argument.name


def _wanted(section: str) -> str:
    if section in OBJECTS:
        return "the name of an object"
    return GESTURES[section].what or str(GESTURES[section].argument)


def _ends(value: Value | Spread) -> tuple[Value, ...]:
    return value.ends if isinstance(value, Spread) else (value,)


def _tried(table: Mapping[str, Value | Spread], first: str) -> Iterator[dict[str, Value]]:
    """Yield values of a section: each end of each key, with the others in the middle, for all values of the key
    `first`."""
    middle = {key: value.at(0.5) if isinstance(value, Spread) else value for key, value in table.items()}
    for chosen in _ends(table[first]) if first else (None,):
        base = {**middle, **({first: chosen} if chosen is not None else {})}
        yield base
        for key, value in table.items():
            if key != first and isinstance(value, Spread):
                for end in value.ends:
                    yield {**base, key: end}


def _try(section: str, values: Mapping[str, Value], presets: Presets, has_by: bool) -> None:
    """Try a message of these values; raise Refused or PresetError if it cannot be carried out."""
    if section in OBJECTS:
        message = object_message(section, values)
        (call,) = calls(message)
        assert call.verb
        made = changed(presets, call.verb.parse(message.args))
        if made.shape == "mesh" and values.keys() & _OF_TABLES:
            made.modes(_ANY_TOP)  # ValueError where its table is of another material
        return
    if section == SENSOR:
        if values.get(ON, OBJECTS[0]) == OBJECTS[1] and not has_by:
            raise Refused(f"{ON} = {OBJECTS[1]}: expected a section [{OBJECTS[1]}] with it")
        sensor_asked(VERBS[sensor_verbs.SENSOR].parse(sensor_message(values).args))
        return
    if has_by and (GESTURES[section].swarms or GESTURES[section].breaks):
        raise Refused(f"[{OBJECTS[1]}]: no object strikes in a {section}; expected no such section beside it")
    message = gesture_message(section, values, 0, has_by)
    VERBS[f"/object/NAME/{section}"].parse(message.args)
    grounds = (*SUPPORTS, NO_REST, *OBJECTS[1 : 1 + has_by])
    if GESTURES[section].what and values["what"] not in grounds:
        raise Refused(f"what = {shown(values['what'])}: {expected(values['what'], grounds)}")
    for key, find in NAMED.items():
        if key in values:
            find(presets, str(values[key]))
