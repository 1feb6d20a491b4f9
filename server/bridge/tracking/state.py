"""The tracker's memory: the bodies, what a simulator tells of a step, the pairs that touch, and what happened."""

import numpy as np

BODIES = 512
POINTS = 8_192
"""Points of contact in one step."""
PAIRS = 2_048
"""Pairs of bodies that touch at once."""
EVENTS = 4_096
"""Events of one step, and changes."""
MATERIALS = 64
"""Materials of bodies."""
OCTAVES = 21
"""Contact times for which it is known how loud a blow is: s, by octaves up to 1."""
KEPT = 16
"""Points of a pair that are remembered, to know a new one."""

HIT, MOVE, REST, DONE = range(4)
"""Kinds of events: a blow; a standing contact begins to slip or to sweep; it does so no more; nothing is left to do."""

STEERED = ("speed", "sweep", "force", "position")
"""The parameters of a slide that a standing contact steers."""

STILL, UNHEARD, HEARD = range(3)
"""State of a standing contact: it neither slips nor sweeps, it moves untold, or it moves and is told."""

TOGETHER = 16
"""Blows of one step on the same bodies that share them: of more each is taken alone."""

TOLD = ("depth", "approach", "slip", "force", "mass", "restitution", "friction")
"""Quantities that a simulator may tell of a point, NaN where it does not."""

_PAIR = np.dtype(
    [
        ("a", np.int64),
        ("b", np.int64),
        ("begun", np.float64),  # s
        ("seen", np.float64),  # s: when it was told last
        ("last", np.float64),  # s: when its slip and sweep were found last
        ("stood", np.int64),  # 1: it began without a blow, or has stayed: it may graze
        ("flown", np.float64),  # s for which none of its points touched before this step
        ("steepest", np.float64),  # share of its slip by which it may close, and slide
        ("landed", np.float64),  # m/s: the approach of its last blow, and
        ("left", np.float64),  # the speed at which it left
        ("calm", np.int64),  # steps for which it neither closes nor opens
        ("calm_since", np.float64),  # s
        ("fastest", np.float64),  # m/s: its slip, or what is left of a faster one of late
        ("moves", np.int64),  # STILL, UNHEARD or HEARD
        ("pressure", np.float64),  # Pa rms: of its slide, as it was last estimated
        ("weighed_at", np.float64),  # s: when that was
        ("heard_at", np.float64),  # s: when its slide began
        ("moved_at", np.float64),  # s: when it began to move
        # The points that were told of late, in the axes of each body: so many.
        ("known", np.int64),
        ("kept", np.float64, (KEPT, 2, 3)),
        ("kept_at", np.float64, KEPT),
        ("was_new", np.int64, KEPT),  # 1: it was new when it was told last
        ("same", np.int64, KEPT),  # which of these a step's points were, in the order in which they were told
        # The points of this step.
        ("count", np.int64),
        ("followed", np.int64),  # of them, those that were there in the step before
        ("swept", np.float64, 2),  # m/s: how fast these move over each body, all together
        ("settled", np.int64),  # 1: it was there in a step before, 2: it is known how fast it sweeps
        ("point", np.float64, 3),
        ("normal", np.float64, 3),
        ("weight", np.float64),
        ("slip", np.float64),
        ("force", np.float64),
        ("closes", np.float64),  # m/s, times the weight
        # Of the last step that had any: the mean of their normals, and the way to them from the smaller body's centre.
        ("facing", np.float64, 3),
        ("arm", np.float64, 3),
        ("told", np.int64),  # 1: the simulator told how fast the last of them slips
        # The points that are new, and close fast enough to be heard.
        ("fresh", np.int64),
        ("fresh_point", np.float64, 3),
        ("fresh_normal", np.float64, 3),
        ("speed", np.float64),
        ("delay", np.float64),
        ("mass", np.float64),
        ("restitution", np.float64),
        ("hopped_at", np.float64),  # s: when it was last told no more for a while
        ("pushed", np.float64),  # N s: its force over a time (s) that the smoothed force knows nothing of yet
        ("over", np.float64),
        # The contact's place in the axes of each body, and its speed over them.
        ("local", np.float64, (2, 3)),
        ("sweep", np.float64, 2),
        ("now", np.float64, 3),  # slip (m/s), sweep (m/s), force (N), smoothed
        ("said", np.float64, 3),  # the same, as it was told last
        ("told_at", np.float64),  # s: when that was, or when it was last found to be unheard
        ("side", np.int64),  # 0: a is struck, or slid on; 1: b is
        # The slide that it is heard as: its number, 0: none; its gesture's number in an engine, 0: it is in none; and
        # what was told of it last.
        ("slide", np.int64),
        ("gesture", np.int64),
        ("steered", np.float64, len(STEERED)),
    ],
    align=True,
)

_GLIDE = np.dtype([(name, np.float64) for name in ("span", "share", "near", "remembered", "harder")])
"""A time (s), and the shares by which a contact goes on in it: its motion, its place, its fastest slip, its force."""

EVENT = np.dtype(
    [
        ("kind", np.int64),
        ("a", np.int64),
        ("b", np.int64),
        ("side", np.int64),  # of the body that is struck, or slid on
        ("contact", np.int64),  # of this step, the nearest to a blow
        # Of a contact that moves: the number of its slide, its gesture in an engine, its random numbers.
        ("slide", np.int64),
        ("gesture", np.int64),
        ("seed", np.int64),
        ("time", np.float64),
        ("point", np.float64, 3),  # m, in the world
        ("normal", np.float64, 3),  # from a to b
        ("local", np.float64, (2, 3)),  # the point in the axes of each body, from its centre of mass
        ("speed", np.float64),  # m/s: of the approach
        ("mass", np.float64),  # kg: effective, along the normal
        ("restitution", np.float64),  # NaN: not told
        # Of a contact that moves, as a slide takes it: its motion, its law, its radius and the width of its patch (m),
        # and the place 0 to 1 on the strike path of the body that slides.
        ("motion", np.float64, len(STEERED)),
        ("stiffness", np.float64),
        ("exponent", np.float64),
        ("radius", np.float64),
        ("patch", np.float64),
        ("by_place", np.float64),
    ],
    align=True,
)
"""Something that happened between a pair of bodies, a before b by their numbers."""

CHANGE = np.dtype(
    [
        ("slide", np.int64),
        ("gesture", np.int64),
        ("parameter", np.int64),  # a place in STEERED
        ("value", np.float64),
    ],
    align=True,
)
"""A new value of a slide's parameter."""

BLOW = np.dtype(
    [
        ("a", np.int64),
        ("b", np.int64),
        ("side", np.int64),  # of the body that is struck
        ("contact", np.int64),  # of this step, the nearest
        ("heard", np.int64),  # 1: it is to be heard
        ("rings", np.int64),  # 1: what is struck rings, and the blow is one that an engine takes
        ("time", np.float64),  # s
        ("point", np.float64, 3),  # m, in the world
        ("normal", np.float64, 3),  # from a to b
        ("speed", np.float64),  # m/s: of the approach
        ("mass", np.float64),  # kg: effective, along the normal
        ("restitution", np.float64),
        ("impulse", np.float64),  # N s: of a rigid blow
        ("pressure", np.float64),  # Pa rms at the microphone that hears it best
        # The engine's values: places 0 to 1 on the strike paths of both, the speed, and the law, in which `left`, a
        # restitution above 0, takes the place of the dissipation.
        ("place", np.float64, 2),
        ("met", np.float64),
        ("stiffness", np.float64),
        ("exponent", np.float64),
        ("dissipation", np.float64),
        ("left", np.float64),
    ],
    align=True,
)
"""A blow between a pair of bodies."""

STATE = np.dtype(
    [
        ("time", np.float64),  # s: of the last step
        ("steps", np.int64),  # taken
        ("rest", np.float64),  # m/s: a slower approach is no blow
        ("gravity", np.float64),  # m/s^2
        ("settles", np.float64),  # s: up to when no blow is told
        ("bodies", np.int64),
        # Of each body: its centre of mass, its axes (rows of a rotation matrix), and the velocity of its point `about`.
        ("position", np.float64, (BODIES, 3)),
        ("turn", np.float64, (BODIES, 9)),
        ("velocity", np.float64, (BODIES, 3)),
        ("spin", np.float64, (BODIES, 3)),
        ("about", np.float64, (BODIES, 3)),
        ("lightness", np.float64, BODIES),  # 1/kg; 0: it is held
        ("yielding", np.float64, (BODIES, 3)),  # 1/(kg m^2): inverse moments of inertia about its axes
        ("rings", np.int64, BODIES),  # 1: it is heard
        ("reach", np.float64, BODIES),  # m: half of its greatest length
        ("edges", np.float64, (BODIES, 3)),  # m: of the box around it
        ("strip", np.int64, (BODIES, 3)),  # its object's strike path, as in strips.py
        ("round", np.float64, BODIES),  # m: radius of its side, 0 for one with edges
        ("material", np.int64, BODIES),
        ("loudness", np.float64, (BODIES, OCTAVES)),  # Pa rms at 1 m of a blow of 1 N s
        ("ringing", np.float64, BODIES),  # s for which it is heard after a blow
        ("sliding", np.int64, BODIES),  # its slides
        ("until", np.float64, BODIES),  # s: up to when it sounds
        # Of each pair of materials: the stiffness of a contact of a radius of 1 m, dissipation, exponent.
        ("law", np.float64, (MATERIALS, MATERIALS, 3)),
        ("surface", np.int64, (MATERIALS, MATERIALS)),  # 1 and the number of theirs, 0: it is not known
        ("bounce", np.float64, (BODIES, BODIES)),  # 1 and the restitution of a pair, 0: its own
        ("slides_so", np.int8, (BODIES, BODIES)),  # 1: a pair slides as it was told to
        # Of each point of contact of this step, so many.
        ("points", np.int64),
        ("pair", np.int32, (POINTS, 2)),
        ("point", np.float64, (POINTS, 3)),
        ("normal", np.float64, (POINTS, 3)),
        *((name, np.float64, POINTS) for name in TOLD),
        # Pairs that touch, the first `touching` of `pairs`; `place` has their numbers plus 1.
        ("touching", np.int64),
        ("glide", _GLIDE),  # in this step
        ("hop", _GLIDE),
        ("pairs", _PAIR, PAIRS),
        ("place", np.int16, (BODIES, BODIES)),
        ("most", np.int64),  # standing contacts that are heard as they slip or sweep
        ("heard", np.int64),  # of them, those there are
        ("unheard", np.int64),  # those that have found no room
        ("left_out", np.int64),  # points of pairs that found no room
        ("happened", np.int64),
        ("events", EVENT, EVENTS),
        ("changed", np.int64),
        ("changes", CHANGE, EVENTS),
        # Blows of this step, `order` by their loudness; what was heard of late; and what became of all.
        ("struck", np.int64),
        ("blows", BLOW, EVENTS),
        # Of blows on the same bodies, to share them: see shared_blows.py.
        ("opens", np.float64, (TOGETHER, TOGETHER)),
        *((name, np.float64, TOGETHER) for name in ("rate", "missing", "part")),
        ("order", np.int64, EVENTS),
        ("most_blows", np.int64),
        ("heard_blows", np.int64),
        ("heard_at", np.float64, EVENTS),  # a ring, from `oldest` on
        ("oldest", np.int64),
        ("faintest", np.float64),  # Pa rms
        ("masked", np.float64),  # share of what was heard of late, below which nothing is heard
        ("loudest", np.float64),  # Pa rms
        ("loudest_at", np.float64),  # s
        ("seed", np.int64),  # of slides
        ("made", np.int64),  # slides since the beginning, or since it began anew
        ("begun", np.int64),  # all slides
        ("hits", np.int64),
        ("faint", np.int64),
        ("over_budget", np.int64),
    ],
    align=True,
)
"""The whole memory. `pair` numbers bodies; `normal` leads from the first of them to the second."""


def new_state(rest: float, gravity: float) -> np.ndarray:
    """Return a new state, (1,) of STATE: nothing touches, and nobody hears it. rest: m/s; gravity: m/s^2."""
    state = np.zeros(1, STATE)
    state["rest"], state["gravity"] = rest, gravity
    state["turn"][:] = np.eye(3).ravel()
    state["until"] = state["loudest_at"] = -np.inf
    for name in TOLD:
        state[name][:] = np.nan
    return state
