"""A method for every gesture that the schema declares, of what plays objects by name and of objects."""

import inspect
from collections.abc import Callable
from typing import Any, Protocol, SupportsFloat, TypeVar

from ..dsp.schema import GESTURES, Gesture

Value = Any
"""An argument: a number, a string, bytes, None, or a list or tuple of these; NumPy's scalars and arrays too."""


class OfNamed(Protocol):
    """A gesture on an object of a name: its first argument, a position 0 to 1 on the strike path, a time, keys."""

    def __call__(
        self,
        name: str,
        value: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Value,
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class OfObject(Protocol):
    """A gesture on an object, the same way."""

    def __call__(
        self,
        value: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Value,
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class Gestures:
    """Gestures on objects by name: methods of what has `_gesture(gesture, name, value, position, at, keys)`."""

    impact: OfNamed
    bounce: OfNamed
    roll: OfNamed
    press: OfNamed
    spin: OfNamed
    slide: OfNamed


class ObjectGestures:
    """Gestures on an object: methods of what has a `scene` and a `name`."""

    impact: OfObject
    bounce: OfObject
    roll: OfObject
    press: OfObject
    spin: OfObject
    slide: OfObject


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
