"""The points at which bodies touch in a step: whose they are, how fast they close and slip, which of them are new."""

import math

from ....dsp.contact.law import speed_of_impulse
from ....dsp.native.jit import kernel, noinline_kernel
from ....dsp.native.typed import View
from .state import KEPT, PAIRS, Pair, State

MEMORY = 0.002
"""s, at least two steps: how long a point that is not reported is remembered."""

GRAZING = 0.25
"""Least share of its slip below which what slides closes without a blow: simulators lift what slides, by up to the
friction coefficient times the slip, and let it fall again (M. Anitescu, Math. Program. 105, 2006). A body that rocks as
it falls closes up to twice as fast."""

STAYED, BACK, CAME = range(3)
"""Ways in which a point is there: since the last steps, again, or anew."""

_ROCKS, _STEEPEST = 2.0, 1.0  # times the friction; the greatest share
_ALIGNED = 0.98  # cosine between two normals of one plane
_WHOLE, _ALIKE = 0.8, 1.05  # of the bodies' mass; times as fast as they sink, at most
_SUNK = 0.005  # m/s
_SINKS = 1e-4  # share of a way's square that lies along the normal, below which the way is as long as its face's
_BRIEF = 0.01  # s of flight that is no flight
_LIFTED = 1.1  # times as fast as its last blow left it, at least: no bounce does
_LONGEST_HOP = 0.15  # s that what slides may be without a contact
_SAME = 0.002  # m by which a point may move from step to step and stay the same
_SAME_SHARE = 0.1  # of the smaller body's half length, by which it may as well
_STILL = 0.01  # share of that: no other point is as near


@kernel
def clear(pair: Pair) -> None:
    """Forget the points of the step before."""
    pair.sank, pair.sinks = pair.sinks, 0.0
    if pair.sank < _SUNK:
        pair.taken = 0.0
    pair.count = pair.fresh = pair.followed = 0
    pair.swept[0] = pair.swept[1] = 0.0
    pair.weight = pair.slip = pair.force = pair.closes = pair.speed = pair.delay = pair.mass = pair.restitution = 0.0
    pair.hopping = pair.impulse = 0.0
    for k in range(3):
        pair.point[k] = pair.normal[k] = pair.fresh_point[k] = pair.fresh_normal[k] = 0.0


@kernel
def _find(state: State, a: int, b: int) -> int:
    """Find the number of a pair, which touches from now on if it did not; -1 where there is no room."""
    place = state.place[a, b] - 1
    if place >= 0 or state.touching == PAIRS:
        return place
    place = state.touching
    state.touching += 1
    state.place[a, b] = place + 1
    pair = state.pairs[place]
    pair.sinks = 0.0
    clear(pair)
    pair.a, pair.b = a, b
    pair.side = _struck(state, a, b)
    pair.begun = state.time
    pair.moves = pair.settled = pair.stood = pair.slide = pair.gesture = 0
    pair.known = pair.calm = 0
    pair.seen, pair.landed, pair.left = -math.inf, math.inf, math.inf
    for k in range(3):
        pair.now[k] = pair.said[k] = 0.0
    pair.sweep[0] = pair.sweep[1] = pair.fastest = pair.hops = pair.pushed = pair.over = 0.0
    pair.hopped_at = -math.inf
    return place


@kernel
def _struck(state: State, a: int, b: int) -> int:
    """Return the side of the body that is struck, or slid on: of the one that rings, the heavier one rather."""
    if state.rings[a] != state.rings[b]:
        return 0 if state.rings[a] == 1 else 1
    return 0 if state.lightness[a] <= state.lightness[b] else 1


@noinline_kernel
def take_point(state: State, n: int, span: float, fall: float, least: float) -> None:
    """Add a point of this step to its pair.

    fall: the speed (m/s) that gravity gives in the step; least: the least that is a blow's.
    """
    first, second = state.pair[n, 0], state.pair[n, 1]
    if first == second:
        return
    if state.lightness[first] == 0.0 and state.lightness[second] == 0.0:
        return
    sign = 1.0 if first < second else -1.0
    a, b = min(first, second), max(first, second)
    place = _find(state, a, b)
    if place < 0:
        state.left_out += 1
        return
    pair = state.pairs[place]
    if pair.count == 0:
        pair.flown = state.time - pair.seen - span
    pair.seen = state.time
    pair.count += 1
    pair.told = 0 if math.isnan(state.slip[n]) else 1
    point, normal = state.point[n], state.normal[n]
    approach, slip = _speeds(state, n, pair, sign)
    force = state.force[n]
    if math.isnan(force) and not math.isnan(state.impulse[n]):
        force = state.impulse[n] / span
    weight = force if force > 0.0 else 1e-9
    pair.weight += weight
    pair.slip += weight * slip
    pair.closes += weight * approach
    pair.force += force if force > 0.0 else 0.0
    for k in range(3):
        pair.point[k] += point[k]
        pair.normal[k] += sign * normal[k]
    pair.steepest = _steepest(state.friction[n])
    came = _find_before(state, pair, n, span, abs(approach) + slip)
    pair.sinks = max(pair.sinks, approach)
    gives = _gives(state, n)
    if came != STAYED and approach <= least:
        pair.hopping = max(pair.hopping, gives * approach)
    fresh = came != STAYED and approach > least and not _grazes(pair, approach, slip, fall, gives, came == BACK)
    fresh = fresh and not _sinks(pair, approach)
    if fresh and not _goes_on(state, pair, n, sign, span, approach):
        _add_new(state, pair, n, sign, span, approach)


@kernel
def _add_new(state: State, pair: Pair, n: int, sign: float, span: float, approach: float) -> None:
    """Add a new point to its pair's blow."""
    pair.fresh += 1
    pair.speed += approach
    depth = state.depth[n]
    pair.delay += min(depth / approach, span) if depth > 0.0 else 0.0
    pair.mass += state.mass[n]
    pair.restitution += state.restitution[n]
    pair.impulse += state.impulse[n]
    for k in range(3):
        pair.fresh_point[k] += state.point[n, k]
        pair.fresh_normal[k] += sign * state.normal[n, k]


@kernel
def _steepest(friction: float) -> float:
    """Return the share of its slip that a contact of a friction coefficient may close by, and slide; NaN: unknown."""
    return GRAZING if math.isnan(friction) else min(max(_ROCKS * friction, GRAZING), _STEEPEST)


@kernel
def _gives(state: State, n: int) -> float:
    """Return the share of its speed that a point's contact gives back, 0 where it is not known."""
    return state.elastic[n] if math.isnan(state.restitution[n]) else state.restitution[n]


@kernel
def _grazes(pair: Pair, approach: float, slip: float, fall: float, gives: float, back: bool) -> bool:
    """True if a new point is one of a slide: it closes more slowly than it slips by far, and its contact has stayed, or
    hardly flew, or lands faster than its last blow left it.

    A step ends after the landing, so what the simulator lifted falls for up to a step longer, and closes by up to
    `fall` faster; where that is most of it, it is a blow. An elastic contact gives back a share of the speed at which
    it landed, and is lifted once more: a body that slides on comes back to a place on which it slid, one that tumbles
    to others.
    """
    lifted = pair.steepest * max(slip, pair.fastest)
    bounced = _LIFTED * pair.hops if back else 0.0
    if approach >= lifted + min(fall, lifted) + bounced:
        return False
    if pair.stood == 0 and pair.flown < math.inf and approach > _LIFTED * pair.left:
        pair.stood = 1
    if pair.stood == 0 and pair.flown >= _BRIEF:
        return False
    if back:
        pair.hopping = max(pair.hopping, gives * approach)
    return True


@kernel
def _sinks(pair: Pair, approach: float) -> bool:
    """True if a new point closes only as the bodies still sink into each other, whose blow took all of their mass: a
    simulator takes some time to stop them, and others of their points come to touch meanwhile."""
    return pair.taken >= _WHOLE and approach <= _ALIKE * pair.sank


@noinline_kernel
def _goes_on(state: State, pair: Pair, n: int, sign: float, span: float, approach: float) -> bool:
    """True if a new point is where one of a pair's bodies has come to over a seam: it slips or rolls over another body,
    with a face in the same plane, far faster than it closes."""
    for i in range(state.touching):
        other = state.pairs[i]
        for side in range(4):
            one, its = (pair.b, pair.a) if side % 2 == 1 else (pair.a, pair.b)
            also, beside = (other.b, other.a) if side >= 2 else (other.a, other.b)
            if one != also or its == beside or state.lightness[its] > 0.0 or state.lightness[beside] > 0.0:
                continue
            fast = max(other.fastest, other.now[1])
            if state.time - other.seen > 1.5 * span or approach >= GRAZING * fast:
                continue
            turned = sign if (side % 2 == 1) == (side >= 2) else -sign
            smaller = _smaller(state, other)
            along = away = above = 0.0
            for k in range(3):
                way = state.point[n, k] - state.position[smaller, k] - other.arm[k]
                along += turned * state.normal[n, k] * other.facing[k]
                above += way * other.facing[k]
                away += way * way
            if along > _ALIGNED and abs(above) < _SAME and away < 4.0 * state.reach[one] * state.reach[one]:
                return True
    return False


@kernel
def _speeds(state: State, n: int, pair: Pair, sign: float) -> tuple[float, float]:
    """Return the closing speed and the slip of a point (m/s): as reported, or by its impulse, else by the motion of
    the bodies."""
    point, normal = state.point[n], state.normal[n]
    closing, aside = _rates(state, pair.a, pair.b, point, normal)
    approach, slip = state.approach[n], state.slip[n]
    if not math.isnan(state.impulse[n]):
        mass = state.mass[n]
        if math.isnan(mass):
            mass = 1.0 / (lightness_at(state, pair.a, point, normal) + lightness_at(state, pair.b, point, normal))
        approach = speed_of_impulse_at(state, pair, state.impulse[n], mass, state.restitution[n])
    return sign * closing if math.isnan(approach) else approach, aside if math.isnan(slip) else slip


@kernel
def _rates(state: State, a: int, b: int, point: View[float], normal: View[float]) -> tuple[float, float]:
    """Return the speed of one body against another at a point (m/s): along a normal, and across it."""
    closing = square = 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        rate = state.velocity[a, k] - state.velocity[b, k]
        rate += state.spin[a, i] * (point[j] - state.about[a, j]) - state.spin[a, j] * (point[i] - state.about[a, i])
        rate -= state.spin[b, i] * (point[j] - state.about[b, j]) - state.spin[b, j] * (point[i] - state.about[b, i])
        closing += rate * normal[k]
        square += rate * rate
    return closing, math.sqrt(max(square - closing * closing, 0.0))


@kernel
def lightness_at(state: State, body: int, point: View[float], normal: View[float]) -> float:
    """Return 1/M + (r x n) I^-1 (r x n) of a body (1/kg), at a point."""
    total = state.lightness[body]
    if total == 0.0:
        return 0.0
    for k in range(3):
        along = 0.0
        for i in range(3):
            j, m = (i + 1) % 3, (i + 2) % 3
            arm_j = point[j] - state.position[body, j]
            arm_m = point[m] - state.position[body, m]
            turning = arm_j * normal[m] - arm_m * normal[j]
            along += state.turn[body, 3 * i + k] * turning
        total += state.yielding[body, k] * along * along
    return total


@kernel
def speed_of_impulse_at(state: State, pair: Pair, impulse: float, mass: float, restitution: float) -> float:
    """Return the speed (m/s) of a blow of an impulse (N s) between two bodies: by the restitution of the pair, by that
    which is reported, NaN if none is, or by their contact law."""
    own = state.bounce[pair.a, pair.b]
    share = own - 1.0 if own > 0.0 else restitution
    if not math.isnan(share):
        return impulse / (mass * (1.0 + min(max(share, 0.0), 1.0)))
    support = state.support[pair.a, pair.b] - 1
    law = state.supports[support] if support >= 0 else state.law[state.material[pair.a], state.material[pair.b]]
    return speed_of_impulse(impulse, mass, law[1], 0.0)


@kernel
def remember(state: State, pair: Pair) -> None:
    """Remember where the bodies of a pair touch, for when they hop."""
    body = _smaller(state, pair)
    for k in range(3):
        pair.facing[k] = pair.normal[k] / pair.count
        pair.arm[k] = pair.point[k] - state.position[body, k]


@kernel
def slip_at(state: State, pair: Pair) -> float:
    """Return the speed at which the bodies of a pair slip where they touched last (m/s).

    That is as far from the centre of the smaller body as it was, in the world's axes: a ball that turns in the air is
    looked at below.
    """
    body = _smaller(state, pair)
    for k in range(3):
        pair.point[k] = state.position[body, k] + pair.arm[k]
    return _rates(state, pair.a, pair.b, pair.point, pair.facing)[1]


@kernel
def _smaller(state: State, pair: Pair) -> int:
    """Return the smaller body of a pair."""
    return pair.a if state.reach[pair.a] <= state.reach[pair.b] else pair.b


@kernel
def into(state: State, body: int, point: View[float], k: int) -> float:
    """Return component k of a point (m, in the world) in the axes of a body."""
    total = 0.0
    for i in range(3):
        total += state.turn[body, 3 * i + k] * (point[i] - state.position[body, i])
    return total


@kernel
def along(state: State, body: int, way: View[float], k: int) -> float:
    """Return component k of a direction in the world in the axes of a body."""
    total = 0.0
    for i in range(3):
        total += state.turn[body, 3 * i + k] * way[i]
    return total


@kernel
def _apart(state: State, a: int, b: int) -> float:
    """Return the speed of one body against another, but for their turning (m/s)."""
    total = 0.0
    for k in range(3):
        rate = state.velocity[a, k] - state.velocity[b, k]
        total += rate * rate
    return math.sqrt(total)


@kernel
def longest_hop(state: State, pair: Pair, span: float) -> float:
    """Return the longest time (s) for which a pair may be missing and still touch: what slides hops."""
    longest = max(MEMORY, 2.5 * span)
    if state.gravity > 0.0:
        leaves = pair.steepest * pair.fastest + _LIFTED * pair.hops
        longest = max(longest, min(2.0 * leaves / state.gravity, _LONGEST_HOP))
    return longest


@kernel
def _find_before(state: State, pair: Pair, n: int, span: float, rate: float) -> int:
    """Say whether a point STAYED since the last steps, but for the way it goes at a rate (m/s), by which a point closes
    and slips, and as its bodies move; came BACK to its place on one of them; or CAME; it is remembered.

    One that was there, or before a hop, shows how fast the contact moves over both bodies. Simulators report points in
    the same order from step to step: the one that was the same in the last step is looked at first.
    """
    point, time = state.point[n], state.time
    near = max(_SAME, _SAME_SHARE * min(state.reach[pair.a], state.reach[pair.b]))
    longest, memory = longest_hop(state, pair, span), max(MEMORY, 2.5 * span)
    order = (pair.count - 1) % KEPT
    on_a = into(state, pair.a, point, 0), into(state, pair.a, point, 1), into(state, pair.a, point, 2)
    on_b = into(state, pair.b, point, 0), into(state, pair.b, point, 1), into(state, pair.b, point, 2)
    found = pair.same[order]
    passed, ways = time - pair.kept_at[found], _ways(pair, found, on_a, on_b)
    here = found < pair.known and 0.0 < passed <= longest and min(ways) < (_STILL * near) ** 2
    if not here:
        rate += _apart(state, pair.a, pair.b)
        found, passed, ways = _nearest_of(pair, on_a, on_b, time, longest, near, rate)
    new = found < 0 or passed > memory
    back = new and _comes_back(pair, on_a, on_b, time, near)
    if found < 0:
        new = not _grows(pair, on_a, on_b, time, near)
        found = _room(pair)
    else:
        pace = 1.0 / passed
        pair.followed += 1
        pair.swept[0] += _over(state, pair.a, on_a, pair.kept[found, 0], state.normal[n], passed) * pace
        pair.swept[1] += _over(state, pair.b, on_b, pair.kept[found, 1], state.normal[n], passed) * pace
    pair.same[order], pair.was_new[found] = found, 1 if new else 0
    pair.kept_at[found] = time
    for k in range(3):
        pair.kept[found, 0, k], pair.kept[found, 1, k] = on_a[k], on_b[k]
    return (BACK if back else CAME) if new else STAYED


@noinline_kernel
def _nearest_of(
    pair: Pair,
    on_a: tuple[float, float, float],
    on_b: tuple[float, float, float],
    time: float,
    longest: float,
    near: float,
    rate: float,
) -> tuple[int, float, tuple[float, float]]:
    """Return the nearest of a pair's points, -1 if none is near: its number, the time since its report (s), and how
    far it has come on each body, squared (m^2)."""
    found, least, passed, ways = -1, math.inf, 0.0, (0.0, 0.0)
    for m in range(pair.known):
        before = time - pair.kept_at[m]
        if 0.0 < before <= longest:
            away = near + rate * before
            squares = _ways(pair, m, on_a, on_b)
            nearest = min(squares)
            if nearest < min(least, away * away):
                found, least, passed, ways = m, nearest, before, squares
    return found, passed, ways


@kernel
def _comes_back(
    pair: Pair, on_a: tuple[float, float, float], on_b: tuple[float, float, float], time: float, near: float
) -> bool:
    """True if a point is where one was before, on one of the bodies, no longer ago than a hop."""
    back = False
    for m in range(pair.known):
        if 0.0 < time - pair.kept_at[m] <= _LONGEST_HOP:
            back |= min(_ways(pair, m, on_a, on_b)) < near * near
    return back


@kernel
def _grows(
    pair: Pair, on_a: tuple[float, float, float], on_b: tuple[float, float, float], time: float, near: float
) -> bool:
    """True if a point lies beside one of this step that was there before: the patch of a contact grows."""
    grows = False
    for m in range(pair.known):
        if pair.kept_at[m] == time and pair.was_new[m] == 0:
            grows |= min(_ways(pair, m, on_a, on_b)) < near * near
    return grows


@kernel
def _over(
    state: State, body: int, here: tuple[float, float, float], there: View[float], normal: View[float], passed: float
) -> float:
    """Return how far a point has come over a body (m) in a time (s), but for its way along the normal, as what is soft
    sinks in; that is the one between both, as the body turns meanwhile."""
    sunk = square = 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        turned = state.spin[body, i] * normal[j] - state.spin[body, j] * normal[i]
        middle = normal[k] + 0.5 * passed * turned
        way = 0.0
        for m in range(3):
            way += state.turn[body, 3 * k + m] * (here[m] - there[m])
        sunk += way * middle
        square += middle * middle
    whole, off = _square(here, there), sunk * sunk / square
    return math.sqrt(max(whole - off, 0.0) if off > _SINKS * whole else whole)


@kernel
def _ways(
    pair: Pair, m: int, on_a: tuple[float, float, float], on_b: tuple[float, float, float]
) -> tuple[float, float]:
    """Return the squared distance (m^2) on each body between a point and a pair's point m as it was last reported."""
    return _square(on_a, pair.kept[m, 0]), _square(on_b, pair.kept[m, 1])


@kernel
def _room(pair: Pair) -> int:
    """Return the place among a pair's points of a new one: where there is none yet, or that of the oldest."""
    if pair.known < KEPT:
        pair.known += 1
        return pair.known - 1
    oldest = 0
    for m in range(1, KEPT):
        if pair.kept_at[m] < pair.kept_at[oldest]:
            oldest = m
    return oldest


@kernel
def _square(here: tuple[float, float, float], there: View[float]) -> float:
    """Return the square of the way between two points in the axes of a body (m^2)."""
    total = 0.0
    for k in range(3):
        away = here[k] - there[k]
        total += away * away
    return total
