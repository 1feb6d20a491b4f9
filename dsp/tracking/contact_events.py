"""What happened to each pair of bodies in a step: blows, and standing contacts that begin to move, do so otherwise, or
rest.

The points of a pair of bodies are one contact. A point that was not there in the last steps, neither in the axes of one
body nor in those of the other, is new; new points that close faster than `rest` are one blow at their middle. Its time
lies before the step's by depth over speed. Its effective mass along the normal n is 1/m = sum over both bodies of
1/M + (r x n) I^-1 (r x n), with the lever arm r from the centre of mass.

A pair that has touched for a while slips at the speed of one body over the other, and sweeps at that of the contact
over each body. What is told of it changes only where that can be heard.
"""

import math

from ..native.jit import kernel, noinline_kernel
from .blows import faintest_at
from .points import clear, into, longest_hop, slip_at, take_point
from .slides import RESTS, fainter_slide, is_noticed, is_too_faint, motion_of, pressure_of, steer_slide
from .state import EVENTS, HEARD, HIT, MOVE, POINTS, REST, STEERED, STILL, UNHEARD

_STOOD = 0.03  # s after a blow, when it is not one of a bounce
_SMOOTH = 0.005  # s: time constant of slip and sweep
_SMOOTH_FORCE = 0.1  # s: of the force
_SMOOTH_PLACE = 0.05  # s: of the place
_REMEMBERED = 0.2  # s: time constant with which a fast slip is forgotten
_MOVES = 0.01  # m/s: a faster contact begins to move; one slower than RESTS rests
_SLIPS = 0.1  # m/s: what slips faster moves as soon as it touches, before it was followed
_BETWEEN = 0.01  # s between two times that a contact is told: half the time constant by which a slide glides
_STAYS_AT = 0.1  # share of its sweep over one body, at which a contact that is slower over the other stays there
_FALL = 1.05  # times the speed that gravity gives in a step, which is no blow either


@noinline_kernel
def take_step(state, microphones, points, time):
    """Look at a step of so many points at a time (s); the number of events, -1 for numbers that cannot be."""
    if not _is_whole(state, points):
        return -1
    span = time - state.time
    state.time = time
    state.steps += 1
    state.points = points
    _glide(state.glide, span)
    state.happened = state.changed = 0
    for i in range(state.touching):
        clear(state.pairs[i])
    least = max(state.rest, _FALL * state.gravity * span)
    for n in range(points):
        take_point(state, n, span, least)
    for i in range(state.touching - 1, -1, -1):
        _step_pair(state, microphones, i, span)
    return state.happened


@kernel
def _is_whole(state, points):
    """True if all that was told is finite, and of bodies that there are."""
    if points > POINTS:
        return False
    x = y = z = w = 0.0  # sums that the processor follows side by side
    for n in range(state.bodies):
        for row in range(3):
            x += state.turn[n, row]
            y += state.turn[n, 3 + row]
            z += state.turn[n, 6 + row]
            w += state.position[n, row] + (state.velocity[n, row] + state.spin[n, row])
    for n in range(points):
        for side in range(2):
            if not 0 <= state.pair[n, side] < state.bodies:
                return False
        x += state.point[n, 0] + state.normal[n, 0]
        y += state.point[n, 1] + state.normal[n, 1]
        z += state.point[n, 2] + state.normal[n, 2]
    return math.isfinite(x + y + z + w)


@kernel
def _glide(glide, span):
    """Find how far a contact's motion, its place and its force glide in a time (s)."""
    glide.share, glide.near = -math.expm1(-span / _SMOOTH), -math.expm1(-span / _SMOOTH_PLACE)
    glide.remembered = math.exp(-span / _REMEMBERED)
    glide.harder, glide.softer = -math.expm1(-span / _SMOOTH_FORCE), math.exp(-span / _SMOOTH_FORCE)


@noinline_kernel
def _step_pair(state, microphones, i, span):
    """Tell what happened to a pair in this step; forget it where it touches no more."""
    pair = state.pairs[i]
    if pair.count == 0:
        _leave(state, i, span)
        return
    for k in range(3):
        pair.point[k] /= pair.count
        pair.facing[k] = pair.normal[k] / pair.count
    if pair.fresh > 0:
        _hit(state, pair)
        pair.stood, pair.begun = 0, state.time
    elif pair.settled == 0 or state.time - pair.begun > _STOOD:
        pair.stood = 1
    _follow(state, pair, span)
    slip, sweep = pair.now[0], pair.now[1]
    fastest = max(slip, sweep)
    if pair.moves == STILL:
        if pair.stood == 1 and ((fastest > _MOVES and pair.settled == 2) or slip > _SLIPS):
            _begin(state, microphones, pair)
    elif fastest < RESTS:
        _end(state, pair)
    elif state.time - pair.told_at < _BETWEEN:
        return
    elif pair.moves == UNHEARD:
        _begin(state, microphones, pair)
    elif is_too_faint(state, microphones, pair):
        _hush(state, pair)
    elif is_noticed(pair):
        steer_slide(state, pair)


@kernel
def _begin(state, microphones, pair):
    """A standing contact moves, and is heard if one of its bodies rings, it is loud enough and there is room for it."""
    if state.rings[pair.a] == 0 and state.rings[pair.b] == 0:
        return
    pair.pressure = pressure_of(state, microphones, pair)
    pair.told_at = pair.weighed_at = pair.heard_at = state.time
    if pair.pressure < faintest_at(state, state.time):
        if pair.moves == STILL:
            state.faint += 1
        pair.moves = UNHEARD
        return
    if state.heard >= state.most:
        _make_room(state, pair)
    if state.heard < state.most:
        state.heard += 1
        pair.moves = HEARD
        state.sliding[pair.a] += 1
        state.sliding[pair.b] += 1
        state.made += 1
        state.begun += 1
        pair.slide = state.made
        _tell(state, pair, MOVE)
    elif pair.moves == STILL:
        state.unheard += 1
        pair.moves = UNHEARD


@kernel
def _make_room(state, pair):
    """End the faintest slide, if a contact that begins to move is louder by far."""
    faintest = fainter_slide(state, pair)
    if faintest >= 0:
        _hush(state, state.pairs[faintest])
        state.unheard += 1


@kernel
def _hush(state, pair):
    """A contact that moves is heard no more, for now."""
    _end(state, pair)
    pair.moves = UNHEARD
    pair.told_at = state.time


@kernel
def _end(state, pair):
    """A standing contact moves no more, if it did."""
    if pair.moves == HEARD:
        state.heard -= 1
        state.sliding[pair.a] -= 1
        state.sliding[pair.b] -= 1
        _tell(state, pair, REST)
    pair.moves = STILL
    pair.slide = pair.gesture = 0


@kernel
def _leave(state, i, span):
    """A pair does not touch in this step: forget it, unless it slides and may only have hopped."""
    pair = state.pairs[i]
    if state.time - pair.seen > longest_hop(state, pair, span):
        _end(state, pair)
        _forget(state, i)
    elif pair.settled > 0:
        _hop(state, pair)
        if pair.moves == HEARD and state.time - pair.told_at >= _BETWEEN and is_noticed(pair):
            steer_slide(state, pair)


@kernel
def _hop(state, pair):
    """Find how a contact that hops slips on: as its bodies move where it was last, or as it was told; nothing presses
    it.

    One that stays at its place on one body sweeps over the other as fast as it slips.
    """
    pair.now[2] *= state.glide.softer
    if pair.told == 1:
        return
    share = state.glide.share
    slip = slip_at(state, pair)
    pair.now[0] += share * (slip - pair.now[0])
    for side in range(2):
        if pair.sweep[1 - side] < _STAYS_AT * pair.sweep[side]:
            pair.sweep[side] += share * (slip - pair.sweep[side])
    pair.now[1] = max(pair.sweep[0], pair.sweep[1])


@kernel
def _follow(state, pair, span):
    """Find how a contact slips and sweeps, and how hard it is pressed, smoothed."""
    passed = state.time - pair.last if pair.settled > 0 else span
    pair.last = state.time
    glide = state.glide
    if passed != span:  # there was a hop
        glide = state.hop
        _glide(glide, passed)
    share, near = glide.share, glide.near
    for side in range(2):
        for k in range(3):
            at = into(state, pair.a if side == 0 else pair.b, pair.point, k)
            pair.local[side, k] += (near if pair.settled > 0 else 1.0) * (at - pair.local[side, k])
        if pair.followed > 0:
            swept = pair.swept[side] / pair.followed
            pair.sweep[side] += (share if pair.settled > 1 else 1.0) * (swept - pair.sweep[side])
    slip = pair.slip / pair.weight
    if pair.settled == 0:
        pair.now[0] = slip
    pair.fastest = max(slip, pair.fastest * glide.remembered)
    pair.now[0] += share * (slip - pair.now[0])
    if pair.settled < 2:
        pair.settled = 2 if pair.followed > 0 else 1
        if pair.followed == 0:  # it is likely to go over the larger body
            pair.sweep[0 if state.reach[pair.a] >= state.reach[pair.b] else 1] = pair.now[0]
    pair.now[1] = max(pair.sweep[0], pair.sweep[1])
    weight = _weight(state, pair)
    force = pair.force if pair.force > 0.0 else weight
    if pair.now[2] == 0.0:
        pair.now[2] = weight if weight > 0.0 else force
    pair.now[2] += state.glide.harder * (force - pair.now[2])


@kernel
def _weight(state, pair):
    """The weight (N) of the lighter body of a pair."""
    lightness = max(state.lightness[pair.a], state.lightness[pair.b])
    return state.gravity / lightness if lightness > 0.0 else 0.0


@noinline_kernel
def _hit(state, pair):
    """Tell a blow: the new points that close, at their middle."""
    count = pair.fresh
    length = 0.0
    for k in range(3):
        pair.fresh_point[k] /= count
        length += pair.fresh_normal[k] * pair.fresh_normal[k]
    length = math.sqrt(length)
    if length == 0.0:
        return
    for k in range(3):
        pair.fresh_normal[k] /= length
    lightness = _lightness(state, pair.a, pair) + _lightness(state, pair.b, pair)
    mass = pair.mass / count
    if math.isnan(mass):
        mass = 1.0 / lightness
    event = _tell(state, pair, HIT)
    if event < 0:
        return
    happened = state.events[event]
    happened.contact = _nearest(state, pair)
    happened.time = state.time - pair.delay / count
    happened.speed = pair.speed / count
    happened.mass = mass
    happened.restitution = pair.restitution / count
    for k in range(3):
        happened.point[k] = pair.fresh_point[k]
        happened.normal[k] = pair.fresh_normal[k]
        happened.local[0, k] = into(state, pair.a, pair.fresh_point, k)
        happened.local[1, k] = into(state, pair.b, pair.fresh_point, k)


@kernel
def _nearest(state, pair):
    """The contact of a pair that is nearest to its blow."""
    found, least = -1, math.inf
    for n in range(state.points):
        first, second = state.pair[n, 0], state.pair[n, 1]
        if min(first, second) == pair.a and max(first, second) == pair.b:
            square = 0.0
            for k in range(3):
                away = state.point[n, k] - pair.fresh_point[k]
                square += away * away
            if square < least:
                found, least = n, square
    return found


@kernel
def _lightness(state, body, pair):
    """1/M + (r x n) I^-1 (r x n) of a body (1/kg), at the point of a blow."""
    total = state.lightness[body]
    if total == 0.0:
        return 0.0
    for k in range(3):
        along = 0.0
        for i in range(3):
            j, m = (i + 1) % 3, (i + 2) % 3
            arm_j = pair.fresh_point[j] - state.position[body, j]
            arm_m = pair.fresh_point[m] - state.position[body, m]
            turning = arm_j * pair.fresh_normal[m] - arm_m * pair.fresh_normal[j]
            along += state.turn[body, 3 * i + k] * turning
        total += state.yielding[body, k] * along * along
    return total


@noinline_kernel
def _tell(state, pair, kind):
    """Add an event; its number, -1 where there is no room."""
    if state.happened == EVENTS:
        return -1
    number = state.happened
    state.happened += 1
    event = state.events[number]
    event.kind = kind
    _sound(state, pair.a)
    _sound(state, pair.b)
    event.a, event.b, event.side = pair.a, pair.b, pair.side
    event.slide, event.gesture = pair.slide, pair.gesture
    event.time = state.time
    if kind != HIT:
        pair.told_at = state.time
    length = 0.0
    for k in range(3):
        length += pair.normal[k] * pair.normal[k]
    for k in range(3):
        event.point[k] = pair.point[k]
        event.normal[k] = pair.normal[k] / math.sqrt(length) if length > 0.0 else 0.0
        event.local[0, k], event.local[1, k] = pair.local[0, k], pair.local[1, k]
        if kind != HIT:
            pair.said[k] = pair.now[k]
    for parameter in range(len(STEERED)):
        event.motion[parameter] = motion_of(state, pair, parameter)
        if kind == MOVE:
            pair.steered[parameter] = event.motion[parameter]
    return number


@kernel
def _sound(state, body):
    """A body sounds, for as long as it rings, or on and on where it slides."""
    if state.rings[body] == 1:
        state.until[body] = math.inf if state.sliding[body] > 0 else state.time + state.ringing[body]


@kernel
def _forget(state, i):
    """A pair touches no more; the last one takes its place."""
    gone = state.pairs[i]
    state.place[gone.a, gone.b] = 0
    state.touching -= 1
    last = state.touching
    if i != last:
        moved = state.pairs[last]
        state.place[moved.a, moved.b] = i + 1
        state.pairs[i] = moved
