"""The place at which a gesture touches an object: a position on its strike path, or a point of its surface."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...dsp.bodies.places import position_of
from ...dsp.engine.memory.capacity import DIRECTED
from ...dsp.schema import BY_DIRECTION, BY_POINT, DIRECTION, POINT, SPREAD, Gesture, Parameter
from ..osc.arguments import Refused, Values
from .object_call import ObjectCall
from .objects import PlayedObject

_Point = tuple[float, ...]
_NOWHERE = (0.0, 0.0, 0.0)
MOST_DIRECTED = DIRECTED - 124
"""Modes of an object that may be struck in a direction: others stand beside those that are heard."""


def place_values(to: ObjectCall, by: PlayedObject | None) -> dict[str, float]:
    """Return where a gesture touches its object, and where the one that strikes does, as values of its command.

    Refused if a point is given of an object without a surface, or beside a position.
    """
    position, point, on_surface = _place(to, "position", "point", (to.name, to.obj))
    found = {"position": position, "on_surface": on_surface, **_named(POINT, point)}
    found |= _named(DIRECTION, _direction(to.values, "direction", "point", (to.name, to.obj)))
    if by is None:
        for vector in ("by_point", "by_direction"):
            if vector in to.values.vectors:
                shown = _shown(to.values.vectors[vector])
                raise Refused(f"{vector} = {shown}: expected it beside an object that touches")
        if "by_position" in to.values.numbers:
            position = to.values.numbers["by_position"]
            raise Refused(f"by_position = {position:g}: expected it beside an object that touches")
        return {**found, "by_position": 0.0}
    other = _other(to), by
    position, point, on_surface = _place(to, "by_position", "by_point", other)
    found |= _named(BY_DIRECTION, _direction(to.values, "by_direction", "by_point", other))
    return {**found, "by_position": position, "by_on_surface": on_surface, **_named(BY_POINT, point)}


def feet_values(to: ObjectCall, by: PlayedObject | None) -> list[dict[str, float]]:
    """Return the same for each place on which an object rests: the one that is given, or those of its preset."""
    values, standing = place_values(to, by), to.obj.preset.standing
    if standing is None or "position" in to.values.numbers or "point" in to.values.vectors:
        return [values]
    for point in standing.points:
        require_surface(to.name, to.obj, "points", point)
    lying = [{"position": each, **_named(POINT, _on_path(to.obj, each))} for each in standing.positions]
    return [values | each for each in lying or [{"on_surface": 1.0, **_named(POINT, each)} for each in standing.points]]


def gathered(to: ObjectCall, values: Mapping[str, float]) -> dict[str, float]:
    """Return the values of a swarm of which all blows fall on one point, if it has one."""
    if "point" not in to.values.vectors:
        return dict(values)
    if SPREAD.name in to.values.numbers:
        spread = to.values.numbers[SPREAD.name]
        raise Refused(f"spread = {spread:g}: expected none beside a point, on which all blows fall")
    return {**values, SPREAD.name: 0.0}


def given_of(gesture: Gesture, to: ObjectCall) -> list[str]:
    """Return the names of the values that a message gives a gesture that goes on."""
    given = [name for name in gesture.steerable if name in to.values.numbers]
    if "point" not in to.values.vectors:
        return given
    return [*given, *(["position"] if to.obj.modes.faces is None else (each.name for each in POINT))]


def sensed_place(name: str, obj: PlayedObject, values: Values) -> dict[str, Any]:
    """Return where a sensor is mounted on an object, and in which direction it senses, as values of its command.

    Refused if a point is given of an object without a surface, or beside a position, or a direction without a point.
    """
    position, point = values.numbers.get("position"), values.vectors.get("point")
    if point is not None:
        place = position_on(name, obj, "point", point)
        if position is not None:
            raise Refused(f"position = {position:g}, point = {_shown(point)}: expected one of the two")
        if place is not None:
            position, point = place, None
    found = {"position": obj.preset.position if position is None else position, "on_surface": int(point is not None)}
    way = _vector(values, "direction", "point")
    if way != _NOWHERE:
        require_surface(name, obj, "direction", way)
    length = math.hypot(*way) or 1.0
    return {**found, "spot": point or _NOWHERE, "direction": tuple(each / length for each in way)}


def position_on(name: str, obj: PlayedObject, key: str, point: tuple[float, ...]) -> float | None:
    """Return the position on the strike path that a point of an object is; None of one with a surface.

    Refused of an object whose path has no place in its frame, and of a point that is far from the path.
    """
    if obj.modes.faces is not None:
        return None
    try:
        found = position_of(obj.preset.shape, obj.preset.geometry, point)
    except ValueError as error:
        raise Refused(f"{key} = {_shown(point)}: {error}") from None
    if found is None:
        require_surface(name, obj, key, point)
    return found


def require_surface(name: str, obj: PlayedObject, key: str, point: tuple[float, ...]) -> None:
    """Refuse a point of an object that has no surface."""
    if obj.modes.faces is None:
        raise Refused(
            f"{key} = {_shown(point)}: {name} has no surface, only a strike path: expected position, or an object of "
            "the shape mesh"
        )


def _place(to: ObjectCall, key: str, vector: str, touched: tuple[str, PlayedObject]) -> tuple[float, _Point, float]:
    """Return a position, the point that it is or that is given, and 1 if one is given."""
    name, obj = touched
    position = to.values.numbers.get(key, to.values.defaults.get(key, obj.preset.position))
    point = to.values.vectors.get(vector)
    if point is None:
        return position, _on_path(obj, position), 0.0
    place = position_on(name, obj, vector, point)
    if key in to.values.numbers:
        raise Refused(f"{key} = {position:g}, {vector} = {_shown(point)}: expected one of the two")
    if place is not None:
        return place, _NOWHERE, 0.0
    if travel := to.values.numbers.get("travel"):
        raise Refused(f"travel = {travel:g}: it is along the strike path; expected none beside a point")
    return position, point, 1.0


def _direction(values: Values, key: str, beside: str, touched: tuple[str, PlayedObject]) -> _Point:
    """Return the vector along which a gesture pushes an object; zeros where that is the normal."""
    name, modes = touched[0], touched[1].modes
    count = len(modes.frequency) + (len(modes.unheard.frequency) if modes.unheard else 0)
    way = _vector(values, key, beside)
    if way != _NOWHERE:
        require_surface(name, touched[1], key, way)
    if way != _NOWHERE and count > MOST_DIRECTED:
        raise Refused(f"{key}: {name} has {count} modes: expected at most {MOST_DIRECTED}")
    return way


def _vector(values: Values, key: str, beside: str) -> _Point:
    """Return the direction that a message gives, of any length; zeros if it gives none."""
    given = values.vectors.get(key)
    if given is None:
        return _NOWHERE
    if not math.hypot(*given):
        raise Refused(f"{key} = 0 0 0: expected a vector of some length")
    if beside not in values.vectors:
        raise Refused(f"{key} = {_shown(given)}: expected it beside a {beside}")
    return given


def _on_path(obj: PlayedObject, position: float) -> tuple[float, ...]:
    """Return the point (m) of a position on an object's strike path; zeros for one without a surface."""
    faces = obj.modes.faces
    if faces is None:
        return _NOWHERE
    places = np.linspace(0, 1, faces.path)
    return tuple(float(np.interp(position, places, each)) for each in faces.line.T)


def _named(axes: tuple[Parameter, ...], point: tuple[float, ...]) -> dict[str, float]:
    return {each.name: value for each, value in zip(axes, point, strict=True)}


def _other(to: ObjectCall) -> str:
    return to.values.words.get("by", to.values.words.get("what", ""))


def _shown(point: tuple[float, ...]) -> str:
    return " ".join(f"{each:g}" for each in point)
