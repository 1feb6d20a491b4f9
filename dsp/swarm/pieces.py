"""The pieces of what breaks: their masses, which sum to its own, and their bounces until they lie still.

As many pieces have a mass m as m^-b, over three decades. Of hollow bodies that hit a wall b is 1.35 (an estimate,
after F. K. Wittel, F. Kun, H. J. Herrmann and B. H. Kroeplin, Phys. Rev. Lett. 93, 2004), of flat sheets, which break
out of their plane as well, 1.17 (R. P. Linna, J. A. Astroem and J. Timonen, Phys. Rev. E 72, 2005; 1.5 within it).
What the whole hits takes its momentum: it stops the whole, and pieces fly apart from there, up and down alike, at up
to half of its speed. They fall on what lies below, and clatter. Each has its numbers from (seed, piece, bounce,
channel) alone.

As a piece comes free it lets go of the strain that it held. Cracks branch where the stress is A/sqrt(r), a distance r
from where they began (A: TOUGHNESS), so that r is as wide as a piece. A sheet of thickness h that is bent to that
stress holds A^2/(6 E r) for its volume: for a disc of radius R, r = 2 R, it is pi R h A^2/E/12. The strain goes as the
crack runs round the piece, which rings by that alone.

A flat piece touches the floor with its corners, of which fragments of sheets have four in the mean (G. Domokos, D. J.
Jerolmack, F. Kun and J. Toeroek, PNAS 117, 2020): here those of a square. One that lands stops only itself: at a small
angle a square's corner meets the floor with a seventh of its mass. The opposite corner gets 5/7 of the change,
downwards, so that it slaps the floor soon, up to twice as fast, as a disc's rim does (Goyal, Papadopoulos and
Sullivan, J. Dynamic Systems, Measurement, and Control 120, 1998); the two beside it are lifted by 1/7 of the change.
So a piece goes on from corner to corner, as polygons do that spin like a coin (T. Baranyai and P. L. Varkonyi,
Imperfections, impacts, and the singularity of Euler's disk, 2017). At small angles all corners fly as free bodies do
between blows. A corner that does not bounce rests, alone or with one beside it, and the others fall about it. A piece
that would turn over meanwhile lands at an angle at random, with its energy.

Along the floor it flies with what is left of half of the speed. A blow's friction brakes the corner, by its coefficient
times the push or by what stops the corner. The middle is above the corner: so it turns the piece, as one that trips
does. A turn about the vertical is not followed: each blow finds the piece turned at random. Corners that rest are
braked by the weight that they carry.

Where others lie a piece lands on one of these. Pieces of n in all that fly to all sides have, at a time, the density
n/(2 pi r^2) about each other in the mean, where r is the rms of their ways: as friction brakes these from the start.
What lies there passes the blow on to the floor, and rings by it as a free plate that is struck anywhere, along its
normal.

It bends as well, and rings by what its blows leave it (ringing.py).
"""

import math

from ..native.jit import kernel
from ..native.typed import View2D
from ..numerics.constants import STANDARD_GRAVITY
from ..numerics.elementary import exp, log
from ..schema import MOST_PIECES
from .record import ONE_SIZE, SIZES, Swarm
from .ringing import kept_by
from .times import FORM, GAP, MAGNITUDE, OTHER, VARIETY, uniform

_DECADES = 1000.0
_THROWN = 0.5
BOUNCES = 128
"""Bounces of a piece at most."""
CRACKING = 0.03
"""s: for which what breaks cracks (estimated)."""
JUNCTIONS = 3
"""Cracks that set a piece free, each heard."""
CRACKS = 0.25
"""Share of the energy of what hits that bends it at most (estimated); a third of it at most throws the pieces."""
TOUGHNESS = 70.0
"""J/m^2: A^2/E of cracks that branch (glass: A of 2.3 MPa m^(1/2), an estimate after ASTM C1678)."""
STRONGEST = 0.1
"""Share in the strongest crack of what all let go."""
_ROUND = math.log(2.0 * math.pi / math.sqrt(12.0) / 1500.0)
"""ln of the rms width (s/m) of the time in which a crack runs round a piece, for its radius: at 1500 m/s, as cracks do
in glass at most (an estimate, after H. Schardin, 1959)."""
SLOWEST = 0.03
"""m/s: a slower corner stays where it lands, unheard."""
TILT = math.sqrt(0.5)
"""Cosine of the angle at which a piece's modes are struck, as they are stated."""
MIDDLE = math.sqrt(0.5)
"""Share in which a blow along the normal, anywhere on a piece, moves a free square's modes in the mean (rms): they are
stated at TILT and at a corner, where their shape is twice its rms value."""
SPUN = 6.0
"""m R^2/I of a square about its diagonal, with its corners a distance R from its middle."""
_CORNER = math.sqrt(0.5 * math.pi)  # of a square, in the radius of a disc of its area
_NARROW, _COVERED = 1e-12, 40.0  # m^2; times: of a floor that is covered for sure
_AT_ONCE = 1e-9  # s: corners that land within it do so together
_HALF = math.sqrt(2.0) - 1.0  # the tangent of half of 45 degrees
_DENSITY, _FLAT = 2500.0, 0.1  # kg/m^3, and the thickness of the usual piece in its radius (estimated)


@kernel
def break_up(
    swarm: Swarm, whole: float, count: int, speed: float, height: float, usual: float, steepness: float
) -> None:
    """Break a mass (kg) that hit at a speed (m/s), up to a height (m), into pieces as thick as one of a usual mass.

    steepness: b, above 1.
    """
    total, rest = 0.0, 1.0 - steepness
    least = 1.0 - exp(rest * math.log(_DECADES))
    swarm.pieces, swarm.hit, swarm.height = min(max(count, 1), MOST_PIECES), speed, height
    for p in range(swarm.pieces):
        swarm.mass_of[p] = exp(log(1.0 - uniform(swarm, p, MAGNITUDE) * least) / rest)
        total += swarm.mass_of[p]
    swarm.smallest = size_of(swarm, whole / total)
    swarm.finer = (SIZES - 1) * 3.0 / math.log(_DECADES)
    swarm.usual = usual
    swarm.wide = exp(log(usual / (math.pi * _DENSITY * _FLAT)) / 3.0) / math.sqrt(usual)
    swarm.whole = whole
    for p in range(swarm.pieces):
        swarm.mass_of[p] *= whole / total
        up, above = _thrown(swarm, p)
        highest = above + 0.5 * max(up, 0.0) * up / STANDARD_GRAVITY
        _tilt(swarm, p, p, highest)
        falls = math.sqrt(max(up * up + 2.0 * STANDARD_GRAVITY * (above - _high(swarm, p)), 0.0))
        swarm.fall_of[p], swarm.turn_of[0, p], swarm.turn_of[1, p] = falls, 0.0, 0.0
        swarm.slide_of[p] = math.sqrt(max(_THROWN * speed * _THROWN * speed - up * up, 0.0))
        swarm.next_of[p] = (up + falls) / STANDARD_GRAVITY
        swarm.bounced[p] = 0


@kernel
def _thrown(swarm: Swarm, p: int) -> tuple[float, float]:
    """Return how fast a piece flies up (m/s; below 0: down) as it comes free, and how high it is then (m)."""
    return _THROWN * swarm.hit * (2.0 * uniform(swarm, p, GAP) - 1.0), swarm.height * uniform(swarm, p, VARIETY)


@kernel
def piece_below(swarm: Swarm, p: int, time: float) -> int:
    """Return the piece on which a piece lands at a time (s), of those that lie on the floor by then; -1: on none."""
    u = _THROWN * swarm.hit * math.sqrt(2.0 / 3.0)
    brakes = swarm.friction * STANDARD_GRAVITY
    since = time if brakes * time < u else u / brakes
    reach = (u - 0.5 * brakes * since) * since
    covered = 0.5 * swarm.wide * swarm.wide * swarm.whole / max(reach * reach, _NARROW)
    chance = 1.0 - exp(-min(covered, _COVERED))
    share = uniform(swarm, number_of(swarm, p), MAGNITUDE) / chance
    if share >= 1.0:
        return -1
    below, left = 0, share * swarm.whole - swarm.mass_of[0]
    while left > 0.0 and below < swarm.pieces - 1:
        below += 1
        left -= swarm.mass_of[below]
    up, above = _thrown(swarm, below)
    lies = STANDARD_GRAVITY * time > up + math.sqrt(up * up + 2.0 * STANDARD_GRAVITY * above)
    return below if lies and below != p else -1


@kernel
def freed_by_cracks(swarm: Swarm, whole: float, speed: float) -> float:
    """Return the energy (J) that the cracks of what hit let go: its pieces are as thick as the usual one."""
    edges = 0.0
    for p in range(swarm.cracked):
        edges += math.pi * _radius(swarm, p)
    thick = _FLAT * swarm.wide * math.sqrt(swarm.usual)
    freed: float = min(CRACKS * 0.5 * whole * speed * speed, TOUGHNESS * edges * thick / 12.0)
    return freed


@kernel
def _tilt(swarm: Swarm, p: int, number: int, highest: float) -> None:
    """Lay a piece at an angle at random, with its corners up to `highest` (m) below its middle.

    All directions of its normal are alike: cosines are even, down to the least that leaves it so low. Its first corner
    is the lowest one and lands, within 45 degrees of where the piece goes down.
    """
    t, radius = _HALF * uniform(swarm, number, FORM), _CORNER * _radius(swarm, p)
    sine = min(highest / radius, 1.0)
    less = uniform(swarm, number, OTHER) * sine * sine / (1.0 + math.sqrt(1.0 - sine * sine))  # than a cosine of 1
    scale = radius * math.sqrt(less * (2.0 - less)) / (1.0 + t * t)
    swarm.tilt_of[0, p], swarm.tilt_of[1, p] = (1.0 - t * t) * scale, 2.0 * t * scale
    swarm.corner_of[p] = 0


@kernel
def _at(values: View2D[float], p: int, corner: int) -> float:
    """Return what a piece has at a corner of a tilt or a turn: the first two are on its axes, opposite the others."""
    value: float = values[corner & 1, p]
    return value if corner < 2 else -value


@kernel
def _add_at(values: View2D[float], p: int, corner: int, more: float) -> None:
    """Add to what a piece has at a corner of a tilt or a turn."""
    values[corner & 1, p] += more if corner < 2 else -more


@kernel
def _high(swarm: Swarm, p: int) -> float:
    """Return how high (m) the middle of a piece is as a corner lands: as much as that is deeper."""
    return _at(swarm.tilt_of, p, swarm.corner_of[p] & 3)


@kernel
def _flat(swarm: Swarm, p: int) -> float:
    """Return the cosine of the angle at which a piece lies."""
    x, y, radius = swarm.tilt_of[0, p], swarm.tilt_of[1, p], _CORNER * _radius(swarm, p)
    return math.sqrt(max(1.0 - (x * x + y * y) / (radius * radius), 0.0))


@kernel
def landing_of(swarm: Swarm, p: int) -> tuple[float, float, float]:
    """Return how fast a piece's corner meets the floor (m/s), the mass (kg) with which it does, and the cosine of the
    angle at which the piece lies."""
    flat = _flat(swarm, p)
    v = max(swarm.fall_of[p] + flat * _at(swarm.turn_of, p, swarm.corner_of[p] & 3), 0.0)
    return v, swarm.mass_of[p] / (1.0 + SPUN * flat * flat), flat


@kernel
def bounce_piece(swarm: Swarm, p: int, restitution: float) -> None:
    """Advance a piece of which a corner lands, with a restitution, to the next landing of a corner, if any."""
    v, mass, flat = landing_of(swarm, p)
    corner, middle = swarm.corner_of[p] & 3, _high(swarm, p)
    left = restitution if v > SLOWEST else 0.0
    stays = left == 0.0 and swarm.fall_of[p] + flat * _at(swarm.turn_of, p, corner) >= 0.0
    given = (1.0 + left) * v * mass / swarm.mass_of[p]
    swarm.fall_of[p] -= given
    _add_at(swarm.turn_of, p, corner, -SPUN * flat * given)
    if stays:
        _brake(swarm, p, swarm.friction * given)
    else:
        # Stop the corner of a piece along the floor, or slow it by a change (m/s) of the piece's speed if that is less.
        most = swarm.friction * given
        arm, along = middle / (_CORNER * _radius(swarm, p)), 2.0 * math.pi * uniform(swarm, number_of(swarm, p), GAP)
        u, w = swarm.slide_of[p] * math.cos(along), swarm.slide_of[p] * math.sin(along)
        x, y = u - arm * swarm.turn_of[0, p], w - arm * swarm.turn_of[1, p]
        speed = math.sqrt(x * x + y * y)
        if speed != 0.0:
            less = min(most, speed / (1.0 + SPUN * arm * arm)) / speed
            swarm.turn_of[0, p] += SPUN * arm * less * x
            swarm.turn_of[1, p] += SPUN * arm * less * y
            u, w = u - less * x, w - less * y
            swarm.slide_of[p] = math.sqrt(u * u + w * w)
    held = _hold(swarm, p, flat, v) if stays else 0
    swarm.bounced[p] += 1
    x, y, fall = swarm.turn_of[0, p], swarm.turn_of[1, p], swarm.fall_of[p]
    energy = 0.5 * (fall * fall + (x * x + y * y) / SPUN) + STANDARD_GRAVITY * middle
    lift = STANDARD_GRAVITY / (SPUN * flat * flat + max(_count(held), 1))
    # The time (s) until the next corner of a piece lands, and which: of those that do so at once the fastest.
    soonest, found, fastest, landed = math.inf, 0, 0.0, swarm.corner_of[p] & 3
    for other in range(4):
        if held >> other & 1 == 1:
            continue
        gap = max(_high(swarm, p) - _at(swarm.tilt_of, p, other), 0.0) if other != landed else 0.0
        down = swarm.fall_of[p] + flat * _at(swarm.turn_of, p, other)
        pull = STANDARD_GRAVITY - _count(held) * lift
        if held >> (other ^ 2) & 1 == 1:
            pull += SPUN * flat * flat * lift
        lands = math.sqrt(down * down + 2.0 * pull * gap)  # m/s
        after = math.inf
        if down > 0.0:
            after = 2.0 * gap / (down + lands)
        elif pull > 0.0:
            after = (lands - down) / pull
        if after < soonest - _AT_ONCE or (after < soonest + _AT_ONCE and lands > fastest):
            soonest, found, fastest = after, other, lands
    time, corner = soonest, found
    if 2.0 * (1.0 + SPUN) * energy < SLOWEST * SLOWEST or time == math.inf or swarm.bounced[p] == BOUNCES:
        swarm.next_of[p] = math.inf
        return
    # Move a piece that flies for a time (s) meanwhile, or falls about the corners that rest.
    slower = SPUN * flat * lift * time
    _brake(swarm, p, swarm.friction * _count(held) * lift * time)
    swarm.fall_of[p] += (STANDARD_GRAVITY - _count(held) * lift) * time
    for axis in range(2):
        swarm.tilt_of[axis, p] += flat * swarm.turn_of[axis, p] * time
    for resting in range(4):
        if held >> resting & 1 == 1:
            _add_at(swarm.turn_of, p, resting, -slower)
            _add_at(swarm.tilt_of, p, resting, -0.5 * flat * slower * time)
    swarm.corner_of[p] = corner | held << 2
    if _flat(swarm, p) == 0.0:
        # The time (s) after which a piece lands that turns over before, at an angle at random.
        turn = math.sqrt(x * x + y * y)
        _tilt(swarm, p, number_of(swarm, p), _high(swarm, p))
        falls = math.sqrt(max(fall * fall + 2.0 * STANDARD_GRAVITY * (middle - _high(swarm, p)), 0.0))
        swarm.fall_of[p], swarm.turn_of[0, p], swarm.turn_of[1, p] = falls, turn, 0.0
        time = (falls - fall) / STANDARD_GRAVITY
    swarm.next_of[p] += time


@kernel
def _brake(swarm: Swarm, p: int, less: float) -> None:
    """Subtract so many m/s from a piece's speed along the floor, until it stops."""
    swarm.slide_of[p] = max(swarm.slide_of[p] - less, 0.0)


@kernel
def _count(held: int) -> int:
    """Return how many corners rest."""
    return (held & 1) + (held >> 1 & 1) + (held >> 2 & 1) + (held >> 3)


@kernel
def _hold(swarm: Swarm, p: int, flat: float, v: float) -> int:
    """Return which corners rest after one has landed at a speed (m/s) and stays, as a bit of each: one beside it that
    rested goes on to, if it is hardly moved. The piece then turns about the edge between both."""
    corner, before = swarm.corner_of[p] & 3, swarm.corner_of[p] >> 2
    for side in (1, 3):
        other = (corner + side) & 3
        if before == 1 << other and v <= SLOWEST:
            turns = _at(swarm.turn_of, p, corner), _at(swarm.turn_of, p, other)
            swing = (swarm.fall_of[p] * flat - (turns[0] + turns[1]) / SPUN) / (flat * flat + 2.0 / SPUN)
            swarm.fall_of[p] = swing * flat
            _add_at(swarm.turn_of, p, corner, -swing - turns[0])
            _add_at(swarm.turn_of, p, other, -swing - turns[1])
            return before | 1 << corner
    return 1 << corner


@kernel
def _radius(swarm: Swarm, p: int) -> float:
    """Return the radius (m) of a piece."""
    radius: float = swarm.wide * math.sqrt(swarm.mass_of[p])
    return radius


@kernel
def piece_beside(swarm: Swarm, u: float) -> int:
    """Return the piece beside a crack at a share `u` of all their edges: these are as long as the root of a mass."""
    total = 0.0
    for p in range(swarm.cracked):
        total += math.sqrt(swarm.mass_of[p])
    p, left = 0, u * total - math.sqrt(swarm.mass_of[0])
    while left > 0.0 and p < swarm.cracked - 1:
        p += 1
        left -= math.sqrt(swarm.mass_of[p])
    return p


@kernel
def bend_piece(
    swarm: Swarm, p: int, mass: float, width: float, flat: float, given: float, below: int
) -> tuple[float, float, float]:
    """Return the factor on the momentum of a piece's blow that moves its modes, in their direction, and those of the
    piece below it, if there is one (else -1); by how much ln of its width is less, and the restitution that they leave.

    mass, width, given: as it would meet the floor if it were rigid, in kg, ln of s, and in m v. Its modes have
    frequencies as the inverse of its mass, and masses as that; flat: the cosine of the angle at which it lies, as they
    are stated at TILT.
    """
    piece, toward = swarm.mass_of[p], flat / TILT
    mass_ratio, at = toward * toward * swarm.bending * mass / piece, width + log(swarm.usual / piece)
    other_ratio, there = 0.0, at
    if below >= 0:
        other = swarm.mass_of[below]
        other_ratio, there = MIDDLE * MIDDLE * swarm.bending * mass / other, width + log(swarm.usual / other)
    kept, shorter, bent = kept_by(swarm.bend, swarm.bends, (mass_ratio, other_ratio), (at, there), given, swarm.a)
    left = (given - 1.0) * math.sqrt(1.0 - given * given * bent * kept)
    return math.sqrt(kept), shorter, left


@kernel
def freed_within(swarm: Swarm, piece: float) -> float:
    """Return ln of the rms width (s) of the time in which a crack runs round a piece of a mass (kg)."""
    width: float = _ROUND + log(swarm.wide * math.sqrt(piece))
    return width


@kernel
def heard_above(flat: float) -> float:
    """Return the share of a piece's click that is heard above a floor, by the cosine of the angle at which it lies.

    A body of radius a that moves is a dipole, loudest at k a = 1, and its image in the floor moves the other way: at a
    height h both are 2 sin(k h) of one, straight above; 2 h/a of it at most, and not more than one.
    """
    return min(1.0, 2.0 * _CORNER * math.sqrt(max(1.0 - flat * flat, 0.0)))


@kernel
def number_of(swarm: Swarm, p: int) -> int:
    """Return the number of a piece's next blow, for its random numbers."""
    return MOST_PIECES + p * BOUNCES + swarm.bounced[p]


@kernel
def piece_of(number: int) -> int:
    """Return the piece that a blow's number belongs to."""
    return (number - MOST_PIECES) // BOUNCES


@kernel
def size_at(swarm: Swarm, c: int) -> float:
    """Return ln of a size, in that of the usual grain: of a grain's, and from SIZES on of a click's."""
    if c >= SIZES and swarm.finer <= ONE_SIZE:
        return swarm.smallest
    size: float = swarm.smallest + (c if c < SIZES else 3 * (c - SIZES) + 1) / swarm.finer
    return size


@kernel
def size_of(swarm: Swarm, mass: float) -> float:
    """Return ln of the size of a grain of a mass (kg), in that of the usual grain."""
    ratio: float = log(mass / swarm.m) / 3.0
    return ratio
