"""The tracker's memory: the bodies, what a simulator reports of a step, the pairs that touch, and what happened."""

from typing import Annotated

import numpy as np

from ....dsp.native.typed import Record, View, View2D, View3D, dtype_of, i8, i16, i32

BODIES = 512
POINTS = 8_192
"""Points of contact in one step."""
PAIRS = 2_048
"""Pairs of bodies that touch at once."""
EVENTS = 4_096
"""Events of one step, and changes."""
MATERIALS = 64
"""Materials of bodies."""
SUPPORTS = 8
"""Supports whose laws pairs may have."""
GRAINS = 8
"""Kinds of grains."""
HEAPS = 64
"""Bodies that grains hit, of all kinds."""
OCTAVES = 21
"""Contact times for which it is known how loud a blow is: s, by octaves up to 1."""
KEPT = 16
"""Points of a pair that are remembered, to know a new one."""

HIT, MOVE, REST, LIE, DONE = range(5)
"""Kinds of events: a blow; a standing contact begins to slip or to sweep; it does so no more, or lies no more; it
begins to lie, at rest under a load; nothing is left to do."""

STEERED = ("speed", "sweep", "force", "position", "x", "y", "z")
"""The parameters of a slide that a standing contact steers: its place is a position, or the point of a surface."""

POSITION, AT = STEERED.index("position"), STEERED.index("x")

LOAD = len(STEERED)
CHANGING = (*STEERED, "load")
"""The parameters of what a standing contact steers: those of a slide, and that of a rest."""

STILL, UNHEARD, HEARD, LYING = range(4)
"""State of a standing contact: it neither slips nor sweeps, it moves unreported, it moves and is reported, or it lies
and is reported."""

TOGETHER = 16
"""Blows of one step on the same bodies that share them: of more each is taken alone."""

TOLD = ("depth", "approach", "slip", "force", "mass", "restitution", "friction", "impulse")
"""Quantities that a simulator may report of a point, NaN where it does not."""


class Pair(Record):
    """A pair of bodies that touch."""

    a: int
    b: int
    begun: float  # s
    seen: float  # s: when it was reported last
    last: float  # s: when its slip and sweep were found last
    stood: int  # 1: it began without a blow, or has stayed: it may graze
    flown: float  # s for which none of its points touched before this step
    steepest: float  # share of its slip by which it may close, and slide
    landed: float  # m/s: the approach of its last blow, and
    left: float  # the speed at which it left
    calm: int  # steps for which it neither closes nor opens
    calm_since: float  # s
    fastest: float  # m/s: its slip, or what is left of a faster one of late
    hops: float  # m/s: what its contact gave back of its fastest landing of late that was no blow
    hopping: float  # m/s: and of that of this step
    moves: int  # STILL, UNHEARD, HEARD or LYING
    pressure: float  # Pa rms: of its slide, as it was last estimated
    weighed_at: float  # s: when that was
    heard_at: float  # s: when its slide began
    moved_at: float  # s: when it began to move
    # The points that were reported of late, in the axes of each body: so many.
    known: int
    kept: Annotated[View3D[float], KEPT, 2, 3]
    kept_at: Annotated[View[float], KEPT]
    was_new: Annotated[View[int], KEPT]  # 1: it was new when it was reported last
    same: Annotated[View[int], KEPT]  # which of these a step's points were, in the order in which they were reported
    # The points of this step.
    count: int
    followed: int  # of them, those that were there in the step before
    swept: Annotated[View[float], 2]  # m/s: how fast these move over each body, all together
    settled: int  # 1: it was there in a step before, 2: it is known how fast it sweeps
    point: Annotated[View[float], 3]
    normal: Annotated[View[float], 3]
    weight: float
    slip: float
    force: float
    closes: float  # m/s, times the weight
    sinks: float  # m/s: the fastest of this step's points
    sank: float  # m/s: and of the last step's
    taken: float  # share of the bodies' mass that the blows of this landing took
    # Of the last step that had any: the mean of their normals, and the way to them from the smaller body's centre.
    facing: Annotated[View[float], 3]
    arm: Annotated[View[float], 3]
    told: int  # 1: the simulator reported how fast the last of them slips
    # The points that are new, and close fast enough to be heard.
    fresh: int
    fresh_point: Annotated[View[float], 3]
    fresh_normal: Annotated[View[float], 3]
    speed: float
    delay: float
    mass: float
    restitution: float
    impulse: float  # N s: of new points, NaN where one is not reported by it
    hopped_at: float  # s: when it was last left out for a while
    pushed: float  # N s: its force over a time (s) that the smoothed force knows nothing of yet
    over: float
    # The contact's place in the axes of each body, and its speed over them.
    local: Annotated[View2D[float], 2, 3]
    sweep: Annotated[View[float], 2]
    now: Annotated[View[float], 3]  # slip (m/s), sweep (m/s), force (N), smoothed
    said: Annotated[View[float], 3]  # the same, as it was sent last
    told_at: float  # s: when that was, or when it was last found to be unheard
    side: int  # 0: a is struck, or slid on; 1: b is
    # The slide or the rest that it is heard as: its number, 0: none; its gesture's number in an engine, 0: it is in
    # none; and what was sent of it last.
    slide: int
    gesture: int
    steered: Annotated[View[float], len(STEERED)]
    load: float


_PAIR = dtype_of(Pair)


class Glide(Record):
    """A time (s), and the shares by which a contact goes on in it."""

    span: float
    share: float  # of its motion
    near: float  # of its place
    remembered: float  # of its fastest slip
    harder: float  # of its force


class PairEvent(Record):
    """Something that happened between a pair of bodies, a before b by their numbers."""

    kind: int
    a: int
    b: int
    side: int  # of the body that is struck, or slid on
    contact: int  # of this step, the nearest to a blow
    # Of a contact that moves or lies: the number of its slide or rest, its gesture in an engine, its random numbers.
    slide: int
    gesture: int
    seed: int
    time: float
    point: Annotated[View[float], 3]  # m, in the world
    normal: Annotated[View[float], 3]  # from a to b
    local: Annotated[View2D[float], 2, 3]  # the point in the axes of each body, from its centre of mass
    speed: float  # m/s: of the approach
    mass: float  # kg: effective, along the normal
    restitution: float  # NaN: not given
    impulse: float  # N s: of a blow that is reported by it; else 0
    # Of a contact that moves or lies, as a slide takes it: its motion, its law, its radius and the width of its patch
    # (m), and the place 0 to 1 on the strike path of the body that slides.
    motion: Annotated[View[float], len(STEERED)]
    stiffness: float
    exponent: float
    radius: float
    patch: float
    by_place: float


class Change(Record):
    """A new value of a parameter of a slide or of a rest."""

    slide: int
    gesture: int
    parameter: int  # a place in CHANGING
    value: float


CHANGE = dtype_of(Change)


class Blow(Record):
    """A blow between a pair of bodies."""

    a: int
    b: int
    side: int  # of the body that is struck
    contact: int  # of this step, the nearest
    heard: int  # 1: it is to be heard
    rings: int  # 1: what is struck rings, and the blow is one that an engine takes
    time: float  # s
    point: Annotated[View[float], 3]  # m, in the world
    normal: Annotated[View[float], 3]  # from a to b
    local: Annotated[View2D[float], 2, 3]  # the point in the axes of each body
    facing: Annotated[View2D[float], 2, 3]  # the normal in the axes of each body, outward of it
    speed: float  # m/s: of the approach
    mass: float  # kg: effective, along the normal
    restitution: float
    impulse: float  # N s: of a rigid blow
    pressure: float  # Pa rms at the microphone that hears it best
    # The engine's values: places 0 to 1 on the strike paths of both, the speed, and the law, in which `left`, a
    # restitution above 0, takes the place of the dissipation.
    place: Annotated[View[float], 2]
    met: float
    stiffness: float
    exponent: float
    dissipation: float
    left: float


BLOW = dtype_of(Blow)


class Heap(Record):
    """The blows of one kind of grains on one body since they were reported last."""

    kind: int
    body: int
    both: int  # 1: they are of grains of the kind on each other
    count: float
    impulse: float  # N s: all of them
    energy: float  # J: m v^2/2
    momentum: float  # N s: m v
    exponent: float  # of the last one's law
    # Weighed by m v: the effective mass (kg), the stiffness, the place on the body's strike path and its square, and
    # the point in its axes.
    mass: float
    stiffness: float
    place: float
    square: float
    point: Annotated[View[float], 3]


class State(Record):
    """The whole memory. `pair` numbers bodies; `normal` leads from the first of them to the second."""

    time: float  # s: of the last step
    steps: int  # taken
    rest: float  # m/s: a slower approach is no blow
    gravity: float  # m/s^2
    settles: float  # s: up to when no blow is sent
    bodies: int
    # Of each body: its centre of mass, its axes (rows of a rotation matrix), and the velocity of its point `about`.
    position: Annotated[View2D[float], BODIES, 3]
    turn: Annotated[View2D[float], BODIES, 9]
    velocity: Annotated[View2D[float], BODIES, 3]
    spin: Annotated[View2D[float], BODIES, 3]
    about: Annotated[View2D[float], BODIES, 3]
    lightness: Annotated[View[float], BODIES]  # 1/kg; 0: it is held
    yielding: Annotated[View2D[float], BODIES, 3]  # 1/(kg m^2): inverse moments of inertia about its axes
    rings: Annotated[View[int], BODIES]  # 1: it is heard
    reach: Annotated[View[float], BODIES]  # m: half of its greatest length
    edges: Annotated[View2D[float], BODIES, 3]  # m: of the box around it
    strip: Annotated[View2D[int], BODIES, 3]  # its object's strike path, as in strips.py
    round: Annotated[View[float], BODIES]  # m: radius of its side, 0 for one with edges
    flat: Annotated[View[int], BODIES]  # 1: its side ends at two faces, across its axis z
    surfaced: Annotated[View[int], BODIES]  # 1: its object has a surface, in its axes, and is touched at points of it
    skin: Annotated[View[int], BODIES]  # address of the triangles of that surface, as in skins.py,
    skin_faces: Annotated[View[int], BODIES]  # and how many
    material: Annotated[View[int], BODIES]
    loudness: Annotated[View2D[float], BODIES, OCTAVES]  # Pa rms at 1 m of a blow of 1 N s
    ringing: Annotated[View[float], BODIES]  # s for which it is heard after a blow
    sliding: Annotated[View[int], BODIES]  # its slides and rests
    until: Annotated[View[float], BODIES]  # s: up to when it sounds
    rung: Annotated[View[float], BODIES]  # s: the same, by its blows and slides alone
    # Of each pair of materials: the stiffness of a contact of a radius of 1 m, dissipation, exponent.
    law: Annotated[View3D[float], MATERIALS, MATERIALS, 3]
    surface: Annotated[View2D[int], MATERIALS, MATERIALS]  # 1 and the number of theirs, 0: it is not known
    # Grains: of each body the number of its kind, 0: it is none; of each kind the body that sounds for it, -1: none
    # does. Their blows, by kind and body, since they were sent last, and when that was.
    grain: Annotated[View[int], BODIES]
    sounds: Annotated[View[int], GRAINS + 1]
    piled: int
    heaps: Annotated[View[Heap], HEAPS]
    told_at: float
    due: int  # 1: they are to be sent after this step
    grains: int  # blows of grains since the beginning
    bounce: Annotated[View2D[float], BODIES, BODIES]  # 1 and the restitution of a pair, 0: its own
    support: Annotated[View2D[i8], BODIES, BODIES]  # 1 and the number of a support whose law a pair has, 0: its own
    supports: Annotated[View2D[float], SUPPORTS, 3]  # the laws of these: stiffness, dissipation, exponent
    slides_so: Annotated[View2D[i8], BODIES, BODIES]  # 1: a pair slides as it was set to
    # Of each point of contact of this step, so many.
    points: int
    pair: Annotated[View2D[i32], POINTS, 2]
    point: Annotated[View2D[float], POINTS, 3]
    normal: Annotated[View2D[float], POINTS, 3]
    depth: Annotated[View[float], POINTS]
    approach: Annotated[View[float], POINTS]
    slip: Annotated[View[float], POINTS]
    force: Annotated[View[float], POINTS]
    mass: Annotated[View[float], POINTS]
    restitution: Annotated[View[float], POINTS]
    friction: Annotated[View[float], POINTS]
    impulse: Annotated[View[float], POINTS]
    elastic: Annotated[View[float], POINTS]  # the greatest restitution of the simulator's contact, where none is given
    # Pairs that touch, the first `touching` of `pairs`; `place` has their numbers plus 1.
    touching: int
    glide: Glide  # in this step
    hop: Glide
    pairs: Annotated[View[Pair], PAIRS]
    place: Annotated[View2D[i16], BODIES, BODIES]
    most: int  # standing contacts that are heard as they slip or sweep
    heard: int  # of them, those there are
    unheard: int  # those that have found no room
    most_rests: int  # standing contacts that are sent as they lie
    lying: int  # of them, those there are
    lain: int  # all that have begun
    left_out: int  # points of pairs that found no room
    happened: int
    events: Annotated[View[PairEvent], EVENTS]
    changed: int
    changes: Annotated[View[Change], EVENTS]
    # Blows of this step, `order` by their loudness; what was heard of late; and what became of all.
    struck: int
    blows: Annotated[View[Blow], EVENTS]
    # Of blows on the same bodies, to share them: see shared_blows.py.
    opens: Annotated[View2D[float], TOGETHER, TOGETHER]
    rate: Annotated[View[float], TOGETHER]
    missing: Annotated[View[float], TOGETHER]
    part: Annotated[View[float], TOGETHER]
    order: Annotated[View[int], EVENTS]
    most_blows: int
    heard_blows: int
    heard_at: Annotated[View[float], EVENTS]  # a ring, from `oldest` on
    oldest: int
    faintest: float  # Pa rms
    masked: float  # share of what was heard of late, below which nothing is heard
    loudest: float  # Pa rms
    loudest_at: float  # s
    seed: int  # of slides
    made: int  # slides and rests since the beginning, or since it began anew
    begun: int  # all slides
    hits: int
    faint: int
    over_budget: int
    loudest_unheard: float  # Pa rms: of the loudest that was left out, as too many came at once


STATE = dtype_of(State)


def new_state(rest: float, gravity: float) -> np.ndarray:
    """Return a new state, (1,) of STATE: nothing touches, and nobody hears it. rest: m/s; gravity: m/s^2."""
    state = np.zeros(1, STATE)
    state["rest"], state["gravity"] = rest, gravity
    state["turn"][:] = np.eye(3).ravel()
    state["until"] = state["rung"] = state["loudest_at"] = -np.inf
    state["told_at"], state["sounds"] = np.nan, -1
    for name in TOLD:
        state[name][:] = np.nan
    return state
