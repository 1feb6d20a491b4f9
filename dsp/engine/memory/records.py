"""The engine's records of contacts, of slides and of what rolls send to the sound, and of the spectral bank's tails."""

from typing import Annotated

import numpy as np

from ...contact.coupled_records import Coupled
from ...contact.pulse_record import Pulse
from ...friction.record import Friction
from ...native.typed import Record, View, View2D, View3D, dtype_of
from ...numerics.legendre import FINE
from ...resonator.sizes import REACH, ROWS
from ...schema_records import Steered, Traits
from .capacity import MODES, MODES_PER_OBJECT, MOST_CHANNELS, OBJECTS, RAMPS


class ContactPoint(Record):
    """The point at which an object is touched."""

    slot: int  # of an object; -1: none
    serial: int
    modes: int  # of it that the contact acts on, its first
    row: int  # of the shape table, the first of four
    weights: Annotated[View[float], 4]
    on_surface: int  # 1: at a point of the surface, 0: at a position on the strike path
    directed: int  # 1 + the row of `directed` that has its shapes there, along a direction; 0: along the normal
    give: float  # 1/kg: sum of phi^2 where a striker began to touch
    compliance: float  # m/N: the same of phi^2/omega^2, untuned
    next_roll: int  # of the list of rolls on the object


POINT = dtype_of(ContactPoint)


class Contact(Record):
    """A contact of an object with a striker, or with another object."""

    pulse: Pulse
    coupled: Coupled
    point: Annotated[View[ContactPoint], 2]  # on the object touched, and on the object that touches it, if one does
    kind: int  # of the gesture: its place in schema.GESTURES
    trait: Traits  # of the gesture
    direction: Annotated[View2D[float], 2, 3]  # in which it pushes either object, length 1; zeros: along the normal
    index: int  # its own place
    gesture: int  # its number, 0: none
    command: int  # number of the command that brought the striker
    number: int  # of the contact
    told: int  # touches of a coupled striker that have a number; the first has that of the contact
    touching: int  # 0: it waits for its beginning
    solver: int  # a Solver
    modes: int  # that a coupled contact counts for in the budget
    aside: int  # 1: it flies, and counts for nothing; 2: it has left, and is kept for a while
    light: int  # 1: what it touches is lighter than the striker
    unsettled: int  # 1: a coupled contact needs the receptance of the objects anew
    settled: int  # number of that receptance, of no other contact's nor of an earlier one
    solved: int  # 1: a coupled contact's `moments` over the coming sample are known
    moments: Annotated[View[float], FINE]  # N s
    ahead: int  # frames of this quantum for which a coupled roll has been solved
    led: int  # 1: it has been brought to the next one
    v_in: float  # m/s
    impulse: float  # N s: of a blow that is known by it, from which v_in follows; else 0
    m: float
    k: float
    mu: float
    a: float
    w: float  # mu v_in, where a restitution was given: each contact then has a mu of its own; else 0
    now: Steered  # what can be steered, gliding
    target: Steered  # to this
    level: float  # by which a gain that is requested counts: its make-up; of pieces, so that all sound alike; else 1
    start: int  # sample at or before the contact's beginning
    fraction: float  # from there to the beginning
    origin: float  # samples: when the gesture began
    elapsed: float  # s, from there to the contact
    forces: Annotated[View[float], 3]  # N: its means over the last samples, newest first, before the gesture's gain
    until: float  # samples: when it was stopped
    gone_at: float  # samples: when a striker that was released is forgotten
    begun: float  # samples: when it last began to touch
    reach: float  # m: how far the objects' ringing reaches
    debt: int  # steps of a coupled contact beyond those granted
    static: Annotated[View2D[float], 2, 2]  # static output of each object at left and right for a push of 1 N
    asleep: int  # 1: a rest whose objects are still; nothing of it is computed
    push: float  # N: on a coupled striker at the quantum's end, gliding
    push_target: float  # to this
    push_gap: float  # N: by which it is beyond that
    sound: int  # place of its striker among those that sound, -1: none
    sound_serial: int
    spot: np.uint64  # of its striker that touches, by which second pulses scatter; 0: not known yet
    voice: int  # that it drives, -1: none
    # A roll or a slide:
    roll: int
    rolled: float  # m until this quantum
    rolls: float  # m in it
    travel: float  # m: length of the object's strike path, 0: the body stays where it is
    # A bounce:
    has_weight: int  # 1: its weight acts in every contact
    spin: float  # energy in rotation, as the square of a velocity
    # A spin:
    turned: float  # s from its beginning to its last turn
    lasts: float  # s from its beginning to its end
    quickening: float  # n: t before its end its contacts' rate goes as t^-n
    tempo: float  # turns per s, times t^n, where gravity is 1
    swing: float  # m/s: velocity of contacts, times t^-n, at a gravity of 1 and a flat of a radius
    # A swarm:
    swarm: int  # its place among them
    # A bounce or a spin:
    random: np.uint64
    next: int


CONTACT = dtype_of(Contact)

SLID = 1024
"""Modes of an object that friction acts on."""


class Slide(Record):
    """The state of a slide besides its roll, which has the same place."""

    friction: Friction
    rows: Annotated[View2D[float], 2, ROWS * SLID]  # of velocity.py, for both objects
    modes: Annotated[View[int], 2]
    row: Annotated[View[int], 2]  # of their shape tables, as friction acts on them
    weights: Annotated[View2D[float], 2, 4]
    directed: int  # as its point's, of the object that it slides on
    moved: int  # 1: since it was settled
    stale: int  # 1: its modes are others than when it was settled, or were retuned
    along: float
    position: float
    spot: Annotated[View[float], 3]  # m: the point of the surface, where it is at one
    sweep: float  # m/s, gliding
    slip: float  # m/s: the driver's at the quantum's beginning
    laid: float  # share of the normal force that friction feels
    pull: float  # N: friction's mean
    press: int  # gesture whose force its friction feels; 0: its own
    pressed: int  # place of that contact, -1: none
    turned: float  # rad^2: of a swing on the contact in a sample, at 1 N, as light as its objects were when chosen
    feels: int  # 1: its friction lets it feel the modes of its objects, 2: it soon does; -1: it would not in any case


SLIDE = dtype_of(Slide)


class Through(Record):
    """Taps from a roll's force to an object's sound (resonator/fed.py), for as long as they stay what they are."""

    serial: int  # of the object
    retuned: int  # times its modes had got new coefficients
    modes: int  # on which the roll acts
    row: int  # the first of four rows of its mode shapes
    taps: Annotated[View3D[float], 4, 2, REACH + 1]  # of each of these rows, left and right


TAIL_MODES = MODES + MODES_PER_OBJECT
"""The modes of all tails: an object has one at most, and one may not fit at the end."""


class Tail(Record):
    """A tail of an object in the spectral bank."""

    first: int  # of its modes
    size: int
    end: int  # samples: when the block ends in which it was laid out
    gain: Annotated[View[float], 2]  # with which it is in there


class Tails(Record):
    """The tails of all objects."""

    entries: Annotated[View[Tail], OBJECTS]  # a ring
    first: int  # number of the oldest
    count: int
    top: int  # the mode after the newest
    y1: Annotated[View[float], TAIL_MODES]
    y2: Annotated[View[float], TAIL_MODES]
    a1: Annotated[View[float], TAIL_MODES]
    a2: Annotated[View[float], TAIL_MODES]
    balance: Annotated[View[float], TAIL_MODES]


ZONES = 4
"""Parts of a strike path in which it is known how loud an object is."""
BANDS = 10
"""Octaves of frequency, from LOWEST on, in which it is."""
LOWEST = 20.0
"""Hz."""


class Audible(Record):
    """How loud a blow on an object is, as long as its settings stay."""

    serial: int  # of the object
    tune: float
    decay: float
    damp: float
    # Of its modes in an octave: the mean square of output for an impulse of 1 N s in each zone, and on the whole,
    loud: Annotated[View2D[float], ZONES + 1, BANDS]
    gives: Annotated[View[float], BANDS]  # and 1/kg: the mean of sum phi^2,
    middle: Annotated[View[float], BANDS]  # and Hz: where most of that is


class Place(Record):
    """The gains with which an object is heard."""

    gain: Annotated[View[float], MOST_CHANNELS]  # of each channel, gliding
    before: Annotated[View[float], MOST_CHANNELS]  # at the quantum's beginning
    asked: Annotated[View[float], MOST_CHANNELS]  # that it glides to
    own: Annotated[View[float], MOST_CHANNELS]  # given to the object channel by channel
    has_own: int  # 1: these place it, not its pan
    loudest: float  # factor on its modes in the output


class Ramp(Record):
    """A ramp that runs or waits."""

    kind: int  # STEER, SET or GAIN: what it changes
    parameter: int  # its place in schema.STEERABLE or macros.ENGINE_SETTINGS, or commands.LEVEL
    place: int  # of the contact, or the slot of the object
    serial: int  # number of the command that brought that contact, or the object's serial
    begun: int  # 1: `first` is known
    begin: float  # samples
    end: float
    first: float  # the value at its beginning
    last: float  # and at its end
    curve: float  # as schema.CURVE


class RampList(Record):
    """Ramps in the order in which they came."""

    entries: Annotated[View[Ramp], RAMPS]
    count: int
