"""Public calls that refuse arguments which they do not take, or lack, in a sentence, in place of Python's words.

A call that succeeds is not looked at: its arguments are read once Python has refused them.
"""

import os
import reprlib
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from .errors import CaromError
from .wording import expected

_Given = ParamSpec("_Given")
_Result = TypeVar("_Result")
_Class = TypeVar("_Class", bound=type)


class ArgumentError(CaromError, TypeError):
    """An argument that a call does not take, or lacks; the text names the call, the argument and its value."""


def explain_arguments(call: Callable[_Given, _Result]) -> Callable[_Given, _Result]:
    """Make a function raise ArgumentError for arguments that it does not take, or lacks, as a decorator."""
    return _explained(call, call.__name__)


def explain_all_arguments(cls: _Class) -> _Class:
    """Do that with the making of a class's objects, and with the public methods that it declares, as a decorator."""
    for name, member in list(vars(cls).items()):
        if name in ("__init__", "__new__") and callable(getattr(member, "__func__", member)):
            own = _explained(getattr(member, "__func__", member), cls.__name__)
            setattr(cls, name, staticmethod(own) if name == "__new__" else own)
        elif not name.startswith("_") and type(member) is type(explain_arguments):
            setattr(cls, name, _explained(member, name))
    return cls


def refuse_unknown(call: str, keys: Mapping[str, object], known: Iterable[str]) -> None:
    """Raise ArgumentError for a key that is none of those that a call knows."""
    known = list(known)
    for key, value in keys.items():
        if key not in known:
            raise ArgumentError(f"{call}(): {key} = {reprlib.repr(value)}: {expected(key, known)}")


def switch_of(name: str, value: object, refusal: type[CaromError] = ArgumentError) -> bool:
    """Return a switch as it is; raise a refusal for what is neither true nor false."""
    try:
        known = value in (True, False)
    except ValueError:  # an array, which is neither
        known = False
    if not known:
        raise refusal(f"{name} = {reprlib.repr(value)}: expected True or False")
    return bool(value)


def path_of(name: str, value: object, wanted: str) -> Path:
    """Return a path; raise ArgumentError, which says what is wanted, for what is none."""
    if not isinstance(value, str | os.PathLike):
        raise ArgumentError(f"{name} = {reprlib.repr(value)}: expected {wanted}")
    return Path(value)


def _explained(call: Callable[_Given, _Result], name: str) -> Callable[_Given, _Result]:
    @wraps(call)
    def same(*args: _Given.args, **keys: _Given.kwargs) -> _Result:
        try:
            return call(*args, **keys)
        except TypeError as error:
            raised = error
        refused = _refused(call, name, args, keys)  # not above, where it would be shown after Python's own words
        if refused:
            raise ArgumentError(refused)
        raise raised

    return same


def _refused(call: Callable[..., object], name: str, args: tuple[Any, ...], keys: Mapping[str, object]) -> str:
    """Say which arguments a call does not take, or lacks; "" if it takes them all."""
    from inspect import Parameter, signature

    parameters = list(signature(call).parameters.values())
    if parameters and parameters[0].name in ("self", "cls", "_cls"):
        parameters, args = parameters[1:], args[1:]
    kinds = {each.kind for each in parameters}
    placed = [each.name for each in parameters if each.kind is Parameter.POSITIONAL_OR_KEYWORD]
    named = [*placed, *(each.name for each in parameters if each.kind is Parameter.KEYWORD_ONLY)]
    if Parameter.VAR_KEYWORD not in kinds:
        refuse_unknown(name, keys, named)
    if Parameter.VAR_POSITIONAL not in kinds and len(args) > len(placed):
        most = f"at most {', '.join(placed)}" if placed else "none"
        return f"{name}(): {reprlib.repr(args[len(placed)])}: one argument without a name too many; expected {most}"
    for key in placed[: len(args)]:
        if key in keys:
            return f"{name}(): {key} = {reprlib.repr(keys[key])}: it was given twice; expected it once"
    needed = [each.name for each in parameters if each.name in named and each.default is Parameter.empty]
    missing = [key for key in needed if key not in keys and key not in placed[: len(args)]]
    if not missing:
        return ""
    return f"{name}(): {', '.join(missing)} missing: expected {', '.join(needed)}"
