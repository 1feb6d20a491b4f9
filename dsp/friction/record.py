"""The record of a driver that rubs a point: dry friction's state (stick_slip.py, elastic.py)."""

from typing import Annotated

from ..native.typed import Record, View, View2D, dtype_of
from ..numerics.legendre import FINE

MOST_PIECES = 40
"""Pieces of a sample; what is left then is one held piece."""

SPRINGS = 8
"""Number of springs of an elastic contact (elastic.py)."""


class Friction(Record):
    """A driver and the point that it rubs. Set `static`, `dynamic`, `stribeck` > 0 and `drive`, `normal` >= 0."""

    static: float  # mu_s
    dynamic: float  # mu_d
    stribeck: float  # m/s
    period: float  # a sample, s
    branch: float  # 0: stick; else the sign of the slip
    tank: float  # J: lost so far, that a piece may give back
    # The driver at the sample's beginning and end.
    drive: Annotated[View[float], 2]  # m/s
    normal: Annotated[View[float], 2]  # N
    beside: Annotated[View[float], 2]  # N: start and slope a sample of another force that moves the point along
    # The point: power series of its velocity after a unit impulse, m/(s N) a sample, and that for a unit force that
    # is held, and for one that rises by 1 N a sample; the first power of time that counts is 0, 1 and 2.
    impulse: Annotated[View[float], FINE]
    held: Annotated[View[float], FINE]
    rising: Annotated[View[float], FINE]
    whole: Annotated[View2D[float], 2, 2]  # as `give`, for a whole sample
    whole_held: Annotated[View[float], 2]  # response to a held force after a third and at the end of the sample
    whole_mean: float  # its mean
    whole_moment: float  # and the mean of it times t
    form: Annotated[View[float], 3]  # int f v over the sample of the force's own velocity: of F0^2, F0 F1, F1^2
    motion: Annotated[View[float], FINE]  # power series of v_free from now
    # A piece: the equation at its nodes.
    gap: Annotated[View[float], 2]  # v_d - v_free
    load: Annotated[View[float], 2]  # N
    give: Annotated[View2D[float], 2, 2]  # velocity at a node for 1 N at a node
    guess: Annotated[View[float], 2]  # the same for a held force
    force: Annotated[View[float], 2]  # found, at the nodes
    start: float  # N: the force's line
    slope: float  # N a sample
    # The last sample with events: begin, length, the force's start and slope, and the branch, for each piece.
    piece: Annotated[View2D[float], MOST_PIECES + 1, 5]
    count: int
    # Since it began:
    lost: float  # J
    driven: float  # J: the driver's work
    events: int
    holds: int  # pieces with the force held
    # An elastic contact:
    tangential: float  # N/m: its stiffness along the surface; 0: it is rigid
    pull: Annotated[View[float], SPRINGS]  # N: force of each spring
    stored: float  # J, in the springs
    limit: float  # coefficient of friction, now
    limit_ahead: float  # and in the middle of the coming sample


FRICTION = dtype_of(Friction)
