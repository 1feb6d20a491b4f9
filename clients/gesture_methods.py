"""A method for every gesture that the schema declares, of what plays objects by name and of objects."""

import inspect
from collections.abc import Callable
from typing import Any, TypeVar

from ..dsp.schema import GESTURES, Gesture
from .gesture_keys import (
    BounceOfNamed,
    BounceOfObject,
    ImpactOfNamed,
    ImpactOfObject,
    PressOfNamed,
    PressOfObject,
    RollOfNamed,
    RollOfObject,
    SlideOfNamed,
    SlideOfObject,
    SpinOfNamed,
    SpinOfObject,
)

Value = Any
"""An argument: a number, a string, bytes, None, or a list or tuple of these; NumPy's scalars and arrays too."""


class Gestures:
    """Gestures on objects by name: methods of what has `_gesture(gesture, name, value, position, at, keys)`."""

    impact: ImpactOfNamed
    bounce: BounceOfNamed
    roll: RollOfNamed
    press: PressOfNamed
    spin: SpinOfNamed
    slide: SlideOfNamed


class ObjectGestures:
    """Gestures on an object: methods of what has a `scene` and a `name`."""

    impact: ImpactOfObject
    bounce: BounceOfObject
    roll: RollOfObject
    press: PressOfObject
    spin: SpinOfObject
    slide: SlideOfObject


def _on_named(gesture: Gesture) -> Callable[..., None]:
    def method(
        self: Any, name: str, value: Value = None, position: Value = None, at: Value = None, **keys: Value
    ) -> None:
        if value is None:
            value = keys.pop(gesture.argument.name, None)
        self._gesture(gesture.name, name, value, position, at, keys)

    return method


def _on_object(gesture: Gesture) -> Callable[..., None]:
    def method(self: Any, value: Value = None, position: Value = None, at: Value = None, **keys: Value) -> None:
        getattr(self.scene, gesture.name)(self.name, value, position, at, **keys)

    return method


def _described(method: Callable[..., None], gesture: Gesture) -> Callable[..., None]:
    """Return a method with the name, the argument and the help of a gesture."""
    method.__name__ = gesture.name
    lasts = " A gesture of that `id` that goes on (None: the object's own) is steered." if gesture.along else ""
    method.__doc__ = (
        f"Begin a gesture that {gesture.help.replace(' it', ' the object', 1)}.\n\n"
        f"{gesture.argument.name}: {gesture.argument.bounds}; {gesture.argument.help}.{lasts}"
    )
    signature = inspect.signature(method)
    named = [
        each.replace(name=gesture.argument.name) if each.name == "value" else each
        for each in signature.parameters.values()
    ]
    method.__signature__ = signature.replace(parameters=named)  # type: ignore[attr-defined]
    return method


_Class = TypeVar("_Class", bound=type)


def with_gestures(cls: _Class) -> _Class:
    """Give a class of Gestures the methods, as a decorator."""
    for gesture in GESTURES.values():
        setattr(cls, gesture.name, _described(_on_named(gesture), gesture))
    return cls


def with_object_gestures(cls: _Class) -> _Class:
    """Give a class of ObjectGestures the methods, as a decorator."""
    for gesture in GESTURES.values():
        setattr(cls, gesture.name, _described(_on_object(gesture), gesture))
    return cls
