"""The base of all errors that are Carom's own, and that for want of a compiler."""

from importlib import import_module


class CaromError(Exception):
    """An error of Carom's: its text names the culprit, its value and what was expected."""


COMPILER = "pip install 'carom[compile]'"
"""The way to what compiles kernels."""


class NoCodeError(CaromError, RuntimeError):
    """Machine code that did not come along, and can't be made, for want of a compiler."""


def require_compiler(what: str) -> None:
    """Raise NoCodeError where there is no compiler for something that needs it."""
    try:
        import_module("numba")
    except ModuleNotFoundError as error:
        raise NoCodeError(f"{what} needs numba: `{COMPILER}` installs it") from error
