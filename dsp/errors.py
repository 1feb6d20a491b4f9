"""The base of all errors that are Carom's own, and those for want of a compiler or a library."""

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


class MissingLibrary(CaromError, RuntimeError):
    """A library that something needs, and that is not installed; the text says how to get it."""


def require_scipy(what: str, extra: str) -> None:
    """Load scipy's linear algebra; raise MissingLibrary, which names the extra of Carom's that installs it, where there
    is none."""
    try:
        import_module("scipy.linalg")
    except ModuleNotFoundError as error:
        raise MissingLibrary(f"{what}, scipy is needed: pip install 'carom[{extra}]'") from error
