"""The records of coupled contacts: a striker and what it meets, its touches, and contacts that are solved together."""

from typing import Annotated, Protocol

from ..native.typed import Record, View, View2D, View3D, dtype_of
from ..numerics.legendre import FINE
from .step_record import FREE_COUNT, GIVE_COUNT, NODES, PUSH_COUNT, SERIES_COUNT, Step

TOUCHES = 16
"""Touches in a sample that are kept apart; those beyond count with the last of them."""
KINKS = 32
"""Kinks of the surface in a sample, at most."""
GROUP = 32
"""Contacts that are solved together at most."""

_UNKNOWNS = GROUP * NODES


class Touch(Record):
    """A touch of a coupled striker, in one sample."""

    number: int  # of the striker's touches
    begin: float  # samples from the sample's beginning
    end: float
    speed: float  # m/s: at which striker and object met
    velocity: float  # m/s: of the striker then, towards the object
    impulse: float  # N s, in this sample


class Coupled(Record):
    """A striker and what it meets."""

    step: Step
    force: Annotated[View[float], NODES]  # N, at GAUSS of the step
    motion: Annotated[View[float], SERIES_COUNT]  # m: the compression without a force, from now to the sample's end
    answer: Annotated[View[float], SERIES_COUNT]  # m/(N sample): g times a sample's length
    whole: Annotated[View[float], GIVE_COUNT]  # its products over a step of a whole sample,
    known: int  # 1: where they are known
    power: Annotated[View[float], FINE]  # of the step's length
    moved: Annotated[View[float], FINE]  # m: motion[n] times power[n]
    free: Annotated[View[float], FREE_COUNT]  # its products over the step (power_series.py)
    series: Annotated[View[float], SERIES_COUNT]  # m: of the motion from the step's end on
    given: Annotated[View[float], FINE]  # m/(N sample): answer[n] times power[n]
    pushed: Annotated[View[float], PUSH_COUNT]  # its products
    impulse: Annotated[View[float], FINE]  # N samples^(n+1): int (eta - s)^n f ds over the step
    v: float  # the striker's velocity towards the object, m/s
    position: float  # the striker's, m: its compression of the object at rest
    period: float  # a sample, s
    wait: float  # samples until the contact begins, negative once it has
    m: float  # kg
    k: float
    mu: float
    a: float
    w: float  # mu v, where it is kept from touch to touch; 0: mu is
    slowest: float  # m/s: a slower touch gets the mu of this speed
    push: float  # constant force on the striker towards the object, N
    rest_force: float  # N: that of a striker at rest; the modes get what is beyond it
    swing: float  # rad/s: of the striker about the compression at which it rests; 0: it does not rest
    rest_compression: float  # m
    rise: float  # m per sample: how the surface rises under the striker
    bend: float  # m per sample^2: half of what that changes by
    kinks: int  # of the surface in this sample
    kink: int  # the next of them
    kink_at: Annotated[View[float], KINKS]  # samples from the sample's beginning
    kink_rise: Annotated[View[float], KINKS]  # by how much `rise` jumps there,
    kink_bend: Annotated[View[float], KINKS]  # and `bend`
    mass: float  # effective, of striker and modes in the first instant, kg
    tolerance: float
    next: float  # samples: the step to try
    last: float  # samples: the step before
    gained: float  # J: by how much the energy is above the least so far
    scale: float  # J: the greatest energy of the contact so far
    touching: int
    contacts: int
    approach: float  # m/s: the speed at which striker and object last met
    arrival: float  # m/s: the striker's velocity then
    touched: int  # touches in this sample
    touches: Annotated[View[Touch], TOUCHES]  # the first of them
    steps: int
    held: int  # steps with the force held


COUPLED = dtype_of(Coupled)


class Member(Protocol):
    """A record that holds a coupled contact, which others are solved together with."""

    coupled: Coupled


class CoupledGroup(Record):
    """Contacts that share objects, in one sample."""

    size: int
    member: Annotated[View[int], GROUP]  # places among the contacts
    known: Annotated[View[int], GROUP]  # `settled` of those whose answers to each other are known, 0: none
    gain: Annotated[View[float], GROUP]  # of the gestures then
    # m/(N sample): of the point of a row to the force of a column
    answer: Annotated[View3D[float], GROUP, GROUP, SERIES_COUNT]
    observed: Annotated[View2D[float], GROUP, FINE]  # m: how each point would move without them
    moments: Annotated[View2D[float], GROUP, FINE]  # N s: what `step_together` finds
    # Of a step:
    touching: int  # contacts that touch
    touches: Annotated[View[int], GROUP]  # places of these in the group
    given: Annotated[View[float], FINE]  # m/(N sample): an answer times powers of its length
    give: Annotated[View3D[float], GROUP, GROUP, GIVE_COUNT]  # the products of each (power_series.py)
    negligible: Annotated[View[float], GROUP]  # N: changes of a contact's force below it don't matter
    give_x: Annotated[View2D[float], _UNKNOWNS, _UNKNOWNS]  # m/N: what the forces take off
    give_v: Annotated[View2D[float], _UNKNOWNS, _UNKNOWNS]  # m/(s N)
    linear: Annotated[View2D[float], _UNKNOWNS, _UNKNOWNS + 1]
    f: Annotated[View[float], _UNKNOWNS]  # N: at the nodes
    end_x: Annotated[View[float], GROUP]  # m: compression at its end
    end_v: Annotated[View[float], GROUP]  # m/s
    ratio: Annotated[View[float], GROUP]  # to the longest step within the tolerance
    gained: Annotated[View[float], GROUP]  # J: energy of each contact
    sought: Annotated[View[int], GROUP]  # 1: the step's end is to be where this contact begins or ends
    event: Annotated[View[int], GROUP]
    path: Annotated[View[float], SERIES_COUNT]  # m: of one striker that flies


COUPLED_GROUP = dtype_of(CoupledGroup)
