"""The events of each pair of bodies in a step: blows, and standing contacts that begin to move, change their motion, or
rest.

The points of a pair of bodies are one contact. A point that was not there in the last steps, neither in the axes of one
body nor in those of the other, is new; new points that close faster than `rest` are one blow at their middle. Its time
lies before the step's by depth over speed. Its effective mass along the normal n is 1/m = sum over both bodies of
1/M + (r x n) I^-1 (r x n), with the lever arm r from the centre of mass.

A pair that has touched for a while slips at the speed of one body over the other, and sweeps at that of the contact
over each body. It is reported anew only where the change can be heard. One that does neither lies: it is a rest, under
the force that the simulator reports.
"""

import math

from ....dsp.native.jit import kernel, noinline_kernel
from ....dsp.native.typed import View
from .grains import is_of_grains
from .microphones import MicrophoneState
from .motion import find_glide, follow, hop, weight_of
from .points import clear, into, lightness_at, longest_hop, remember, speed_of_impulse_at, take_point
from .slides import (
    RESTS,
    fainter_slide,
    is_masked,
    is_noticed,
    is_too_faint,
    motion_of,
    pressure_of,
    steer_load,
    steer_slide,
)
from .state import EVENTS, HEARD, HIT, LIE, LYING, MOVE, POINTS, REST, STEERED, STILL, UNHEARD, Pair, State
from .strips import is_still

_OPPOSITE = 0.1  # length of the mean of normals below which they are against each other
_STOOD = 0.03  # s after a blow, when it is not one of a bounce
_CALM, _CARRIED = 0.15, 2.0  # of the speed of its blow, and weights: what closes more slowly and is pushed less
_CALM_STEPS, _CALM_TIME = 3, 0.004  # is calm; it stays together if it is so for so many steps and so long (s)
_MOVES = 0.01  # m/s: a faster contact begins to move; one slower than RESTS rests
_LAID = 0.02  # s for which a contact has stayed before it lies
_LEAST_LOAD = 1e-4  # N
_SLIPS = 0.1  # m/s: what slips faster moves as soon as it touches, before it was followed
_BETWEEN = 0.01  # s between two reports of a contact: half the time constant by which a slide glides
_FALL = 1.05  # times the speed that gravity gives in a step, which is no blow either;
_LONGEST_FALL = 0.05  # s: of a step at most, as what is reported less often is reported as blows


@noinline_kernel
def take_step(state: State, microphones: MicrophoneState, points: int, time: float) -> int:
    """Look at a step of so many points at a time (s); the number of events, -1 for numbers that cannot be."""
    if not _is_whole(state, points):
        return -1
    span = time - state.time
    state.time = time
    state.steps += 1
    state.points = points
    find_glide(state.glide, span)
    state.happened = state.changed = 0
    for i in range(state.touching):
        clear(state.pairs[i])
    fall = state.gravity * min(span, _LONGEST_FALL)
    for n in range(points):
        take_point(state, n, span, fall, max(state.rest, _FALL * fall))
    for i in range(state.touching - 1, -1, -1):
        _step_pair(state, microphones, i, span)
    while state.heard > state.most:
        _hush(state, state.pairs[_faintest(state)])
        state.unheard += 1
    return state.happened


@kernel
def _faintest(state: State) -> int:
    """Return the number of the pair whose slide is the faintest."""
    found = -1
    for i in range(state.touching):
        heard = state.pairs[i].moves == HEARD
        if heard and (found < 0 or state.pairs[i].pressure < state.pairs[found].pressure):
            found = i
    return found


@kernel
def _is_whole(state: State, points: int) -> bool:
    """True if all that was reported is finite, and of bodies that there are."""
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


@noinline_kernel
def _step_pair(state: State, microphones: MicrophoneState, i: int, span: float) -> None:
    """Report what happened to a pair in this step; forget it where it touches no more."""
    pair = state.pairs[i]
    if pair.count == 0:
        _leave(state, i, span)
        return
    for k in range(3):
        pair.point[k] /= pair.count
    remember(state, pair)
    if pair.fresh > 0:
        _hit(state, pair)
        pair.landed, pair.calm = pair.speed / pair.fresh, 0
        pair.left, pair.hops, pair.hopping = pair.landed, 0.0, 0.0
        pair.stood, pair.begun = 0, state.time
    elif pair.settled == 0 or state.time - pair.begun > _STOOD or _is_calm(state, pair):
        pair.stood = 1
    follow(state, pair, span)
    if is_of_grains(state, pair.a, pair.b):
        return
    slip, sweep = pair.now[0], pair.now[1]
    fastest = max(slip, sweep)
    if pair.moves == STILL or pair.moves == LYING:
        if pair.stood == 1 and ((fastest > _MOVES and pair.settled == 2) or slip > _SLIPS):
            _end(state, pair)
            _begin(state, microphones, pair)
        elif pair.moves == LYING:
            if state.time - pair.told_at >= _BETWEEN:
                steer_load(state, pair)
        elif pair.stood == 1 and fastest < RESTS:
            _lay(state, pair)
    elif fastest < RESTS:
        _end(state, pair)
    elif state.time - pair.told_at < _BETWEEN:
        return
    elif pair.moves == UNHEARD:
        _begin(state, microphones, pair)
    elif is_too_faint(state, microphones, pair):
        _hush(state, pair)
    elif is_noticed(state, pair):
        steer_slide(state, pair)


@kernel
def _is_calm(state: State, pair: Pair) -> bool:
    """True if the bodies of a pair have neither closed nor opened for a while after their blow: they stay together."""
    moves = abs(pair.closes) > max(state.rest, _CALM * pair.landed) * pair.weight
    if moves or pair.force > _CARRIED * weight_of(state, pair):  # in the middle of a bounce it is pushed hardest
        pair.calm = 0
        return False
    if pair.calm == 0:
        pair.calm_since = state.time
    pair.calm += 1
    return pair.calm >= _CALM_STEPS and state.time - pair.calm_since >= _CALM_TIME


@kernel
def _begin(state: State, microphones: MicrophoneState, pair: Pair) -> None:
    """Begin the sound of a standing contact that moves, if one of its bodies rings, it is loud enough and there is room
    for it."""
    if state.rings[pair.a] == 0 and state.rings[pair.b] == 0:
        return
    if state.most == 0 and pair.moves == UNHEARD:
        return
    pair.pressure = pressure_of(state, microphones, pair)
    pair.told_at = pair.weighed_at = pair.heard_at = state.time
    if pair.moves == STILL:
        pair.moved_at = state.time
    if pair.pressure < state.faintest or is_masked(state, pair):
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
        state.loudest_unheard = max(state.loudest_unheard, pair.pressure)
        pair.moves = UNHEARD


@kernel
def _lay(state: State, pair: Pair) -> None:
    """Begin a rest, if the contact has stayed for a while, one of its bodies rings and there is room for it."""
    if state.most_rests == 0 or state.time - pair.begun < _LAID:
        return
    if pair.now[2] < _LEAST_LOAD or (state.rings[pair.a] == 0 and state.rings[pair.b] == 0):
        return
    if _is_still(state, pair, 0) or _is_still(state, pair, 1):
        return
    if state.lying >= state.most_rests and not _make_room_to_lie(state, pair):
        return
    state.sliding[pair.a] += 1
    state.sliding[pair.b] += 1
    pair.slide = state.made + 1
    number = _tell(state, pair, LIE)
    if number < 0:
        state.sliding[pair.a] -= 1
        state.sliding[pair.b] -= 1
        pair.slide = 0
        return
    event = state.events[number]
    lightness = lightness_at(state, pair.a, event.point, event.normal)
    event.mass = 1.0 / (lightness + lightness_at(state, pair.b, event.point, event.normal))
    contact = _nearest(state, pair, event.point)
    if pair.count > 2 and contact >= 0:  # a line touches in its middle too, feet do not
        for k in range(3):
            event.local[0, k] = into(state, pair.a, state.point[contact], k)
            event.local[1, k] = into(state, pair.b, state.point[contact], k)
    state.made += 1
    state.lying += 1
    state.lain += 1
    pair.moves, pair.load = LYING, event.motion[2]


@kernel
def _is_still(state: State, pair: Pair, side: int) -> bool:
    """True if one of a pair's bodies does not ring where it touches."""
    body = pair.b if side == 1 else pair.a
    return is_still(state.strip[body], state.edges[body], pair.local[side])


@kernel
def _make_room_to_lie(state: State, pair: Pair) -> bool:
    """End a rest of two bodies that are silent, if one of a pair sounds; false if there is none."""
    if not _sounds(state, pair):
        return False
    for i in range(state.touching):
        other = state.pairs[i]
        if other.moves == LYING and not _sounds(state, other):
            _end(state, other)
            return True
    return False


@kernel
def _sounds(state: State, pair: Pair) -> bool:
    """True if one of a pair's bodies was struck or slid so lately that it is heard."""
    return max(state.rung[pair.a], state.rung[pair.b]) > state.time


@kernel
def _make_room(state: State, pair: Pair) -> None:
    """End the faintest slide, if a contact that begins to move is louder by far."""
    faintest = fainter_slide(state, pair)
    if faintest >= 0:
        _hush(state, state.pairs[faintest])
        state.unheard += 1
        state.loudest_unheard = max(state.loudest_unheard, state.pairs[faintest].pressure)


@kernel
def _hush(state: State, pair: Pair) -> None:
    """Stop hearing a contact that moves, for now."""
    _end(state, pair)
    pair.moves = UNHEARD
    pair.told_at = state.time


@kernel
def _end(state: State, pair: Pair) -> None:
    """End the sound of a standing contact, if it moved or lay."""
    if pair.moves == HEARD or pair.moves == LYING:
        if pair.moves == HEARD:
            state.heard -= 1
        else:
            state.lying -= 1
        state.sliding[pair.a] -= 1
        state.sliding[pair.b] -= 1
        _tell(state, pair, REST)
    pair.moves = STILL
    pair.slide = pair.gesture = 0


@kernel
def _leave(state: State, i: int, span: float) -> None:
    """Forget a pair that does not touch in this step, unless it slides and may only have hopped."""
    pair = state.pairs[i]
    if state.time - pair.seen > longest_hop(state, pair, span):
        _end(state, pair)
        _forget(state, i)
    elif pair.settled > 0:
        hop(state, pair, span)
        if pair.moves == HEARD and state.time - pair.told_at >= _BETWEEN and is_noticed(state, pair):
            steer_slide(state, pair)


@noinline_kernel
def _hit(state: State, pair: Pair) -> None:
    """Report a blow: the new points that close, at their middle."""
    if state.time < state.settles:
        return
    count = pair.fresh
    length = 0.0
    for k in range(3):
        pair.fresh_point[k] /= count
        length += pair.fresh_normal[k] * pair.fresh_normal[k]
    length = math.sqrt(length)
    if length < _OPPOSITE * count:
        return
    for k in range(3):
        pair.fresh_normal[k] /= length
    lightness = lightness_at(state, pair.a, pair.fresh_point, pair.fresh_normal)
    lightness += lightness_at(state, pair.b, pair.fresh_point, pair.fresh_normal)
    mass = pair.mass / count
    if math.isnan(mass):
        mass = 1.0 / lightness
    pair.taken += mass * (state.lightness[pair.a] + state.lightness[pair.b])
    event = _tell(state, pair, HIT)
    if event < 0:
        return
    happened = state.events[event]
    happened.contact = _nearest(state, pair, pair.fresh_point)
    happened.time = state.time - pair.delay / count
    happened.speed = pair.speed / length  # along the mean normal: more than along each, where they differ
    happened.mass = mass
    happened.restitution = pair.restitution / count
    happened.impulse = 0.0
    if not math.isnan(pair.impulse):
        happened.impulse = pair.impulse * length / count
        happened.speed = speed_of_impulse_at(state, pair, happened.impulse, mass, happened.restitution)
    for k in range(3):
        happened.point[k] = pair.fresh_point[k]
        happened.normal[k] = pair.fresh_normal[k]
        happened.local[0, k] = into(state, pair.a, pair.fresh_point, k)
        happened.local[1, k] = into(state, pair.b, pair.fresh_point, k)


@kernel
def _nearest(state: State, pair: Pair, point: View[float]) -> int:
    """Return the contact of a pair that is nearest to a point."""
    found, least = -1, math.inf
    for n in range(state.points):
        first, second = state.pair[n, 0], state.pair[n, 1]
        if min(first, second) == pair.a and max(first, second) == pair.b:
            square = 0.0
            for k in range(3):
                away = state.point[n, k] - point[k]
                square += away * away
            if square < least:
                found, least = n, square
    return found


@noinline_kernel
def _tell(state: State, pair: Pair, kind: int) -> int:
    """Add an event; its number, -1 where there is no room."""
    if state.happened == EVENTS:
        return -1
    number = state.happened
    state.happened += 1
    event = state.events[number]
    event.kind = kind
    _sound(state, pair.a, kind)
    _sound(state, pair.b, kind)
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
def _sound(state: State, body: int, kind: int) -> None:
    """Keep a body sounding for as long as it rings, or on and on where it slides or lies."""
    if state.rings[body] == 1:
        state.until[body] = math.inf if state.sliding[body] > 0 else state.time + state.ringing[body]
        if kind in (HIT, MOVE):
            state.rung[body] = state.time + state.ringing[body]


@kernel
def _forget(state: State, i: int) -> None:
    """Remove a pair that touches no more; the last one takes its place."""
    gone = state.pairs[i]
    state.place[gone.a, gone.b] = 0
    state.touching -= 1
    last = state.touching
    if i != last:
        moved = state.pairs[last]
        state.place[moved.a, moved.b] = i + 1
        state.pairs[i] = moved
