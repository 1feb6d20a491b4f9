"""The record of a rolling body."""

from typing import Annotated

from ..contact.step_record import NODES, Step
from ..native.typed import Record, View, dtype_of
from ..schema_records import Steered
from .path import Path


class Roll(Record):
    """A rolling body. Its surface is path.surface, to be set up first."""

    path: Path
    step: Step
    target: Steered  # of what can be steered; some are glided to
    # The body and where it is.
    k: float
    mu: float
    a: float
    energy_share: float  # 1/(a + 1): elastic energy over force times compression
    stiffness: float  # k, as far as it makes a difference
    rest_compression: float  # m: compression under its weight
    swing: float  # 1/s^2: square of the angular frequency at which it swings about that
    lightness: float  # 1/kg: 1/m
    m: float
    g: float
    mobility: float  # m/(N s): of the object, where that yields as a dashpot; 0: it is rigid
    v: float  # m/s along the surface
    top_speed: float  # the speed last requested
    modulated_speed: float  # v as asymmetry modulates it
    modulated_gravity: float  # g as asymmetry modulates it
    angle: float
    s: float  # m rolled since the beginning
    t: float  # s since the beginning
    y: float  # height of the lowest point, m
    w: float  # its rate, m/s
    piece: int  # of the path
    along: float  # m into it
    touching: int
    next: float  # s: the step to try
    brief: float  # s: a shorter step may err by more (contact_step.py); 0: none may
    debt: float  # events beyond what is granted
    fade: float  # share of its force that drives the object: 1, falling to 0 when the roll has stopped
    ended: int
    # The last event: what is heard from `since` on for `span` s is the quadratic through `force` (N) at GAUSS.
    since: float
    span: float
    force: Annotated[View[float], NODES]
    given: float  # s: up to where moments have been taken
    level: Annotated[View[float], NODES + 1]  # of the path at a step's nodes and end
    path_rate: Annotated[View[float], NODES + 1]  # its rate
    v_in: float  # m/s: speed at which body and path last met
    impacts: int  # times it met the surface
    events: int
    holds: int  # steps that had to be held ones


ROLL = dtype_of(Roll)
