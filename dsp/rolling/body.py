"""A body that rolls over a rough surface: its normal motion, event by event, and the force it gives.

The lowest point of the body would follow the path of path.py; while it does not, it flies: y'' = -g, until the path
catches it. The contacts are heard: where path and body overlap by x, they push each other apart by the contact law, m
y'' = f(x, x') - m g (contact_step.py). A kink of the path, passed in contact, jumps x' by the speed times the jump in
slope: a micro-impact; where the path falls away faster than the body, it leaves. A body that has come to rest on a flat
path gives its weight, which nobody hears: the force that is handed on is f - m g.

A flight ends by a quadratic, piece of the path by piece. Contacts go by the collocation step of collocation.py, with
steps as long as its error allows. All of it is in seconds and metres: no sampling rate, quantum or block cuts a step.
A roll that asks for more than EVENTS steps a second gets coarser ones, whose energy can't grow.
"""

import math

from ..contact.law import compression_at
from ..contact.step_record import NODES
from ..native.jit import kernel, noinline_kernel
from ..native.typed import View2D
from ..numerics.legendre import KEPT
from ..schema import SPEED
from .contact_step import path_at, step_contact
from .moments import add_quadratic
from .path import AHEAD, PIECES, extend_path, restart_path
from .roll_record import Roll

EVENTS = 120_000.0
"""Flights and steps a second that a roll may need for long, divided by its coarseness."""

_BURST = 200.0  # events that it may need at once
_LONGEST = 5e-4  # s: of a flight or a step, after which speed and gravity are looked at
_ROOM = 1.01  # of the path over a step, which ends before it does
_FIRST = 1e-5  # s: the first step to try
_BEGIN = 0.05  # of a contact's time scale: the first step to try in it
_BEGIN_BRIEF = 0.2  # the same where brief steps may err by more
_GLIDE = SPEED.glide  # s: time constant of speed, mass and gravity
_FADE = 0.005  # s: time constant with which a roll that stopped is left
_STOPPED = 0.02  # share of its speed at which it has
_GONE = 1e-5  # -100 dB
_SLOWEST = 1e-9  # m/s
_SMALL = 1e-7  # share of a goal that isn't glided any more
_STIFFEST = 2e5  # rad/s: a body that swings faster on its contact is as good as one that doesn't
_LEAST_PACE = 0.2  # share of its speed that a lopsided body keeps
_MOST_LIFT = 0.9  # share of its weight that a lopsided body loses or gains
_MOST_EVENTS = 4096  # for one call


@kernel
def begin_roll(roll: Roll, place: int, k: float, mu: float, a: float, corners: float, coarseness: float) -> None:
    """Put a body at rest on a surface at a place, rolling; roll.target says how.

    There speed (m/s), radius (m), mass (kg), gravity (m/s^2) > 0, friction, asymmetry, roughness and patch (m) >= 0.
    k (N/m^a), mu (s/m) >= 0, a >= 1; corners: 0 if it is round; coarseness >= 1: factor on the shortest wavelength that
    it feels.
    """
    target = roll.target
    roll.top_speed = target.speed
    roll.v = roll.modulated_speed = max(target.speed, _SLOWEST)
    roll.path.radius = target.radius
    roll.m = target.mass
    roll.g = roll.modulated_gravity = target.gravity
    roll.k = k
    roll.stiffness = 0.0
    roll.mu = mu
    roll.a = a
    roll.energy_share = 1.0 / (a + 1.0)
    roll.path.speed = roll.v
    roll.path.corners = corners
    roll.path.roughness = target.roughness
    roll.path.patch = target.patch
    roll.path.coarseness = coarseness
    roll.angle = 0.5 * math.pi
    roll.s = roll.t = roll.since = roll.span = roll.given = roll.debt = 0.0
    roll.fade = 1.0
    roll.mobility = roll.brief = 0.0
    roll.ended = roll.impacts = roll.events = roll.holds = 0
    roll.along = 0.0
    roll.piece = -1
    roll.path.begin = place


@noinline_kernel
def steer(roll: Roll) -> None:
    """Bring speed, mass and gravity, after an event, nearer to their targets."""
    roll.path.roughness, roll.path.patch = roll.target.roughness, roll.target.patch
    roll.top_speed = max(roll.top_speed, roll.target.speed)
    slowed = min(roll.target.friction * roll.g * roll.span, roll.target.speed)
    roll.target.speed -= slowed
    roll.v = max(roll.v - slowed, _SLOWEST)
    roll.debt = max(roll.debt + 1.0 - EVENTS / roll.path.coarseness * roll.span, 0.0)
    stopped = roll.target.speed == 0.0 and roll.v <= max(_STOPPED * roll.top_speed, _SLOWEST)
    if stopped or roll.fade < 1.0:
        goal = 0.0 if stopped else 1.0
        roll.fade = _nearer(roll.fade, goal, -math.expm1(-roll.span / _FADE))
        roll.ended = 1 if stopped and roll.fade < _GONE else 0
    loaded = roll.m != roll.target.mass or roll.g != roll.target.gravity or roll.stiffness == 0.0
    if roll.v == roll.target.speed and not loaded:
        return
    near = -math.expm1(-roll.span / _GLIDE)
    roll.v = max(_nearer(roll.v, roll.target.speed, near), _SLOWEST)
    if not loaded:
        return
    roll.m = _nearer(roll.m, roll.target.mass, near)
    roll.g = _nearer(roll.g, roll.target.gravity, near)
    weigh(roll)


@kernel
def weigh(roll: Roll) -> None:
    """Find the compression at rest, the square of the swing's frequency there, and the stiffness, which counts up to a
    bound."""
    stiffest = roll.m * roll.g / (roll.a * roll.g / (_STIFFEST * _STIFFEST)) ** roll.a
    roll.stiffness = min(roll.k, stiffest)
    roll.rest_compression = compression_at(roll.m * roll.g, roll.stiffness, roll.a)
    roll.swing = roll.a * roll.g / roll.rest_compression
    roll.lightness = 1.0 / roll.m


@kernel
def _nearer(value: float, goal: float, share: float) -> float:
    """Move a value a share of its way to a goal, or all of it where little is left."""
    value += share * (goal - value)
    return goal if abs(goal - value) < _SMALL * abs(goal) else value


@kernel
def modulate(roll: Roll) -> None:
    """Modulate a lopsided body's speed and weight: its energy is (7/10) m v^2 and m g times the height of its centre of
    mass."""
    radius = roll.path.radius
    square = roll.v * roll.v
    if roll.target.asymmetry == 0.0:
        roll.modulated_speed = roll.path.speed = roll.v
        roll.modulated_gravity = roll.g
        return
    roll.angle += roll.modulated_speed * roll.span / radius
    roll.angle -= 2.0 * math.pi * math.floor(roll.angle / (2.0 * math.pi))
    high = roll.target.asymmetry * math.cos(roll.angle)
    aside = roll.target.asymmetry * math.sin(roll.angle)
    least = _LEAST_PACE * _LEAST_PACE * square
    swung = square - 10.0 / 7.0 * roll.g * radius * high
    roll.modulated_speed = math.sqrt(max(swung, least))
    # The centre of mass falls with angle'^2 cos + angle'' sin: over a whole turn that comes to nothing.
    falling = 5.0 / 7.0 * roll.g * aside * aside if swung > least else 0.0
    lift = roll.modulated_speed * roll.modulated_speed / radius * high + falling
    roll.modulated_gravity = roll.g - min(max(lift, -_MOST_LIFT * roll.g), _MOST_LIFT * roll.g)
    roll.path.speed = roll.modulated_speed


@kernel
def look_ahead(roll: Roll, seconds: float) -> float:
    """Extend the path ahead of the body; return the time in s for which it is ready, at most `seconds`."""
    path = roll.path
    begun = roll.piece >= 0
    anew = not begun or roll.target.radius != path.radius
    level = incline = 0.0
    if anew:
        path.radius = roll.target.radius
        if begun:
            level, incline = path_at(roll)
        roll.along = restart_path(path, path.begin, roll.piece, roll.along)
        extend_path(path, 1)
        # The body is on the piece on which the way along the path ends.
        roll.piece = 0
        while roll.along > path.length[roll.piece & (PIECES - 1)]:
            roll.along -= path.length[roll.piece & (PIECES - 1)]
            roll.piece += 1
            extend_path(path, roll.piece + 1)
    extend_path(path, roll.piece + AHEAD)
    if anew:
        # On another path the body keeps its distance and its rate, or begins at rest.
        if not begun:
            # Put the body where its contact carries its weight.
            roll.y = -roll.rest_compression
            roll.w = 0.0
            roll.touching = 1
            roll.next = _FIRST
            for i in range(NODES):
                roll.step.f[i] = roll.m * roll.g
        new_level, new_incline = path_at(roll)
        roll.y += new_level - level
        roll.w += roll.modulated_speed * (new_incline - incline)
    length = -roll.along
    for i in range(roll.piece, path.made):
        length += path.length[i & (PIECES - 1)]
        if length > seconds * roll.modulated_speed:
            return seconds
    return length / roll.modulated_speed


@kernel
def share_of(roll: Roll) -> float:
    """Return the share of a roll's force that drives the object: what is left of one that has stopped."""
    return roll.fade


@kernel
def next_event(roll: Roll) -> None:
    """Advance the body by one event: a flight or a part of one, or a step in contact."""
    steer(roll)
    modulate(roll)
    least = roll.path.coarseness / EVENTS if roll.debt > _BURST else 0.0
    wanted = min(max(roll.next, least), _LONGEST) if roll.touching == 1 else _LONGEST
    longest = min(0.999 * look_ahead(roll, _ROOM * wanted), _LONGEST)
    roll.since = roll.t
    if roll.touching == 1:
        step_contact(roll, longest, least)
    else:
        _fly(roll, longest)
    roll.t += roll.span
    roll.s += roll.modulated_speed * roll.span
    weight = roll.m * roll.g
    for i in range(NODES):
        roll.force[i] = share_of(roll) * (roll.force[i] - weight)
    roll.events += 1


@kernel
def _fly(roll: Roll, longest: float) -> None:
    """Fly until the path is met, or for the longest time."""
    path = roll.path
    v, g = roll.modulated_speed, roll.modulated_gravity
    rises = roll.mobility * roll.m * roll.g  # the speed at which an unloaded surface does
    roll.span = 0.0
    for i in range(NODES):
        roll.force[i] = 0.0
    for _ in range(PIECES):
        piece = roll.piece & (PIECES - 1)
        end = (path.length[piece] - roll.along) / v
        left = longest - roll.span
        time = min(end, left)
        met = False
        # A flight stays above the line between a piece's ends, the path below `swell` above its own: it is enough that
        # the gaps at both ends are larger.
        level, incline = path_at(roll)
        gap, bend, passed = roll.y - level, path.curvature[piece], v * time
        swell = 0.125 * max(-bend, 0.0) * passed * passed
        rise = time * (roll.w - rises - 0.5 * g * time)
        if not (gap > swell and gap + rise - passed * (incline + 0.5 * bend * passed) > swell):
            gap, fall = max(gap, 0.0), g + v * v * bend
            # The time until gap + rate t - fall t^2/2 is 0, infinite if never.
            rate = roll.w - rises - v * incline
            square = rate * rate + 2.0 * fall * gap
            if square < 0.0 or (fall <= 0.0 and rate >= 0.0):
                meeting = math.inf
            else:
                root = math.sqrt(square)
                if rate > 0.0:
                    meeting = (rate + root) / fall
                elif root - rate == 0.0:
                    meeting = 0.0
                else:
                    meeting = 2.0 * gap / (root - rate)
            met = meeting <= time
            time = meeting if met else time
        roll.y += time * (roll.w - rises - 0.5 * g * time)
        roll.w -= g * time
        roll.along += v * time
        roll.span += time
        if met:
            roll.y, incline = path_at(roll)
            # Begin a contact.
            v_in = v * incline + rises - roll.w
            roll.touching = 1
            roll.v_in = v_in
            roll.impacts += 1
            speed = math.sqrt(v_in * v_in + roll.g * roll.rest_compression)
            time = (roll.m / (roll.stiffness * speed ** (roll.a - 1.0))) ** (1.0 / (roll.a + 1.0))
            time *= _BEGIN_BRIEF if roll.brief > 0.0 else _BEGIN
            roll.next = time / max(1.0, roll.mu * speed) ** (1.0 / (roll.a + 1.0))
            for i in range(NODES):
                roll.step.f[i] = 0.0
            return
        if left <= end:
            return
        roll.piece += 1
        roll.along = 0.0


@kernel
def fill_roll(roll: Roll, origin: float, rate: float, moments: View2D[float]) -> None:
    """Fill in the moments (N s) of the force over each frame.

    moments: (frames, KEPT) float64. Frame n is the sample from origin + n/rate to
    origin + (n + 1)/rate, in s since the roll began. Call it for one stretch after the other.
    """
    frames = len(moments)
    for n in range(frames):
        for i in range(KEPT):
            moments[n, i] = 0.0
    end = origin + frames / rate
    for _ in range(_MOST_EVENTS):
        stop = roll.since + roll.span
        add_quadratic(roll.force, roll.since, roll.span, roll.given, min(stop, end), origin, rate, moments)
        roll.given = max(roll.given, min(stop, end))
        if stop >= end or roll.ended == 1:
            break
        next_event(roll)


@kernel
def is_even(roll: Roll) -> bool:
    """True if nothing changes a body's speed, its weight, or how rough its path is."""
    target, path = roll.target, roll.path
    speeds = roll.v == target.speed == roll.modulated_speed == path.speed and target.speed > 0.0
    loads = roll.m == target.mass and roll.g == target.gravity == roll.modulated_gravity and roll.stiffness > 0.0
    ways = path.radius == target.radius and path.roughness == target.roughness and path.patch == target.patch
    return speeds and loads and ways and target.friction == target.asymmetry == 0.0 and roll.fade == 1.0
