"""The record of bodies that go by samples abreast."""

from typing import Annotated

from ..native.typed import Record, View, View2D
from ..numerics.legendre import AHEAD
from .path import PIECES

STEERS = 8
"""Samples from one to the next at which a body that goes by samples is steered."""

ABREAST = 16
"""Bodies that go together, at most."""


class Abreast(Record):
    """Bodies that go together over AHEAD samples: of each, by its number among them, or by a sample and that."""

    count: int
    contact: Annotated[View[int], ABREAST]
    roll: Annotated[View[int], ABREAST]
    origin: Annotated[View[float], ABREAST]  # s: at which the first sample begins
    even: Annotated[View[int], ABREAST]  # 1: nothing steers it
    met: Annotated[View[int], ABREAST]  # times that it met the path
    # The path's height at each half of a sample of a stretch, and where a body is.
    height: Annotated[View2D[float], 2 * STEERS, ABREAST]
    level: Annotated[View[float], ABREAST]
    # Of the body that is walked: where pieces begin, and the last that has begun in each half of a sample, if one has.
    start: Annotated[View[float], PIECES]
    mark: Annotated[View[int], 2 * STEERS + 1]
    # The body, and its contact as a Law.
    y: Annotated[View[float], ABREAST]
    w: Annotated[View[float], ABREAST]
    force: Annotated[View[float], ABREAST]
    stiffness: Annotated[View[float], ABREAST]
    mu: Annotated[View[float], ABREAST]
    mobility: Annotated[View[float], ABREAST]
    weight: Annotated[View[float], ABREAST]
    lightness: Annotated[View[float], ABREAST]
    gravity: Annotated[View[float], ABREAST]
    fade: Annotated[View[float], ABREAST]
    # Moments (N s) of the force over its weight.
    first: Annotated[View2D[float], AHEAD, ABREAST]
    tilt: Annotated[View2D[float], AHEAD, ABREAST]
