"""Checks of what is reported of a simulation, and the error that they raise."""

import reprlib
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...dsp.numerics.quantities import Range
from ..osc.arguments import Refused, shown


class WorldError(Refused):
    """An error in the description of a simulation.

    The text names the body, the value and what was expected; of a step its number, too.
    """


def require_number(name: str, value: object, within: Range) -> None:
    """Raise WorldError for a value that is no number in a range."""
    if not (isinstance(value, Real) and within.within(float(value)) is not None):
        told = shown(float(value)) if isinstance(value, float) else repr(value)
        raise WorldError(f"{name} = {told}: expected {within.expected}")


def require_kind(name: str, value: object, kind: type) -> None:
    """Raise WorldError for a value that is neither None nor of a kind, one of those of carom."""
    if not (value is None or isinstance(value, kind)):
        raise WorldError(f"{name} = {value!r}: expected a carom.{kind.__name__}")


def array_of(name: str, value: ArrayLike, wanted: str) -> NDArray[np.float64]:
    """Return an array of numbers; raise WorldError, which says what is wanted, for what is none."""
    try:
        return np.asarray(value, np.float64)
    except (TypeError, ValueError):
        raise WorldError(f"{name} = {reprlib.repr(value)}: expected {wanted}") from None
