"""The help of methods, from the table of addresses."""

import inspect
from collections.abc import Callable, Iterable
from functools import wraps
from typing import Any, TypeVar

from .clients.actions import Actions
from .dsp.schema import Parameter as Number
from .server.osc.addresses import VERBS
from .server.osc.arguments import Either, Key, Vector
from .server.osc.tables import default_of

Acting = TypeVar("Acting", bound=Actions)


def documented(cls: type[Acting]) -> type[Acting]:
    """Document keys, as a decorator: the help of each method whose address takes keys ends with these, as numpydoc.

    The methods of Actions stay as they are: a Client starts without the table of addresses.
    """
    for address, verb in reversed(VERBS.items()):  # an object's address comes before another one of its name
        own = address in (f"/{verb.action}", f"/object/NAME/{verb.action}")  # neither a macro's nor a simulation's
        if own and verb.keys and hasattr(Actions, verb.action):
            setattr(cls, verb.action, _with_keys(getattr(Actions, verb.action), verb.keys))
    return cls


def _with_keys(method: Callable[..., None], keys: Iterable[Key]) -> Callable[..., None]:
    """Return a method that does the same; its help ends with keys."""

    @wraps(method)
    def same(*args: Any, **kwargs: Any) -> None:
        method(*args, **kwargs)

    lines = [inspect.getdoc(method) or "", "", "Other Parameters", "----------------"]
    for key in keys:
        default = f", default {default_of(key)}" * (default_of(key) != "")
        lines += [
            f"{key.name} : {_kind(key)}{default}",
            *([f"    {key.help[0].upper()}{key.help[1:]}."] if key.help else []),
        ]
    same.__doc__ = "\n".join(lines)
    return same


def _kind(key: Key) -> str:
    """Say which values a key takes."""
    if isinstance(key, Number):
        return key.allowed
    if isinstance(key, Vector):
        return f"x, y, z, each {key.axes[0].bounds}"
    return f"one of {', '.join(key.words)}" if isinstance(key, Either) else "a name"
