"""A method for every gesture that the schema declares; and for an object all that its scene can do to it by its name.

Editors and mypy read these methods in `gesture_methods.pyi`, which `make documents` writes.
"""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

from ..dsp.schema import GESTURES, Gesture

Value = Any
"""An argument: a number, a string, bytes, None, or a list or tuple of these; NumPy's scalars and arrays too."""


class Gestures:
    """Gestures on objects by name: methods of what has `_gesture(gesture, name, value, position, at, keys)`."""


class ObjectMethods:
    """Methods on an object: those of its scene on objects, without the name."""


_Class = TypeVar("_Class", bound=type)
_Method = Callable[..., None]


def with_gestures(cls: _Class) -> _Class:
    """Give a class of Gestures the methods, as a decorator."""
    for gesture in GESTURES.values():
        setattr(cls, gesture.name, _begin(gesture))
    return cls


def with_methods_of(scene: type) -> Callable[[_Class], _Class]:
    """Return a decorator that gives a class of ObjectMethods, which has a `scene` and a `name`, a scene's methods."""

    def decorate(cls: _Class) -> _Class:
        for method in vars(scene).values():
            if inspect.isfunction(method) and [*inspect.signature(method).parameters][1:2] == ["name"]:
                setattr(cls, method.__name__, _on_object(method))
        return cls

    return decorate


_NAMED = {
    "name": "name : str\n    Name of the object, or a pattern.\n",
    "id": "id : str\n    Id of the gesture, or a pattern.\n",
}
_AT = "at : float, optional\n    Time at which it is heard, s. Default: as soon as possible."
_OVER = "over, curve : float, optional\n    Duration of the change, s, and its shape, -20 to 20.\n"


def with_shared_help(cls: _Class) -> _Class:
    """Complete the help of a class's methods with the parameters that they share, as a decorator."""
    for method in vars(cls).values():
        if not inspect.isfunction(method) or method.__name__.startswith("_"):
            continue
        given = inspect.signature(method).parameters
        if "at" in given:
            summary, _, rest = inspect.cleandoc(method.__doc__ or "").partition("\n\n")
            own, _, more = rest.removeprefix("Parameters\n----------\n").partition("\n\n")
            named = "".join(text for name, text in _NAMED.items() if name in given)
            over = _OVER * ("RampKeys" in str(given.get("keys")))
            parts = summary, f"Parameters\n----------\n{named}{own}{chr(10) * (own != '')}{over}{_AT}", more
            method.__doc__ = "\n\n".join(part for part in parts if part)
    return cls


def _begin(gesture: Gesture) -> _Method:
    """Return the method that begins a gesture, with its argument by name, and its help."""

    first = "what" if gesture.what else gesture.argument.name

    def method(
        self: Any, name: str, value: Value = None, position: Value = None, at: Value = None, **keys: Value
    ) -> None:
        if value is None:
            value = keys.pop(first, None)
        self._gesture(gesture.name, name, value, position, at, keys)

    method.__name__ = method.__qualname__ = gesture.name
    kind = "str" if gesture.what else f"float, {gesture.argument.allowed}"
    meaning = gesture.what or gesture.argument.help
    method.__doc__ = (
        f"Begin a gesture that {gesture.help}.\n\n"
        f"Parameters\n----------\n{first} : {kind}\n    {meaning[0].upper()}{meaning[1:]}.\n"
        "position : float, 0 to 1, optional\n    Position on the object's strike path."
    )
    given = inspect.signature(method).parameters.values()
    named = [each.replace(name=first) if each.name == "value" else each for each in given]
    method.__signature__ = inspect.Signature(named)  # type: ignore[attr-defined]
    return method


def _on_object(method: _Method) -> _Method:
    """Return a scene's method on objects as one of an object."""

    @wraps(method)
    def same(self: Any, *args: Value, **keys: Value) -> None:
        getattr(self.scene, method.__name__)(self.name, *args, **keys)

    same.__doc__ = (method.__doc__ or "").replace(_NAMED["name"], "")
    given = inspect.signature(method).parameters.values()
    same.__signature__ = inspect.Signature([each for each in given if each.name != "name"])  # type: ignore[attr-defined]
    return same
