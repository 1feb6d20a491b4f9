"""The pieces of what breaks: their masses, which sum to its own, and their bounces until they lie still.

As many pieces have a mass m as m^-b, over three decades. Of hollow bodies that hit a wall b is 1.35 (F. K. Wittel, F.
Kun, H. J. Herrmann and B. H. Kroeplin, Phys. Rev. Lett. 93, 2004, as recalled), of flat sheets, which break out of
their plane as well, 1.17 (R. P. Linna, J. A. Astroem and J. Timonen, Phys. Rev. E 72, 2005; 1.5 within it). What the
whole hits takes its momentum: it stops the whole, and pieces fly apart from there, up and down alike, at up to half of
its speed. They fall on what lies below, and clatter. Each has its numbers from (seed, piece, bounce, channel) alone.

As a piece comes free it lets go of the strain that it held. Cracks branch where the stress is A/sqrt(r), a distance r
from where they began (A: TOUGHNESS), so that r is as wide as a piece. A sheet of thickness h that is bent to that
stress holds A^2/(6 E r) for its volume: for a disc of radius R, r = 2 R, it is pi R h A^2/E/12. The strain goes as the
crack runs round the piece, which rings by that alone.

A flat piece that lands on its rim stops only that: at a small angle a disc's rim meets the floor with a fifth of its
mass, and the opposite one gets 0.6 of the change, downwards, so that it slaps the floor soon, up to twice as fast
(Goyal, Papadopoulos and Sullivan, J. Dynamic Systems, Measurement, and Control 120, 1998). At small angles both rims
fly as free bodies do between the blows of either, and a rim falls at 1.6 g while the other one rests. One that would
turn over meanwhile lands at an angle at random, with its energy.

It bends as well, and rings by what its blows leave it (ringing.py).
"""

import math

from ..native.jit import kernel
from ..numerics.constants import STANDARD_GRAVITY
from ..numerics.elementary import exp, log
from ..schema import MOST_PIECES
from .record import SIZES, Swarm
from .ringing import bent_by, kept_by
from .times import GAP, MAGNITUDE, OTHER, VARIETY, uniform

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
"""J/m^2: A^2/E of cracks that branch (glass: A of 2.3 MPa m^(1/2), as recalled of ASTM C1678's constants)."""
STRONGEST = 0.1
"""Share in the strongest crack of what all let go."""
_ROUND = math.log(2.0 * math.pi / math.sqrt(12.0) / 1500.0)
"""ln of the rms width (s/m) of the time in which a crack runs round a piece, for its radius: at 1500 m/s, as cracks do
in glass at most (H. Schardin, 1959, as recalled)."""
SLOWEST = 0.03
"""m/s: a slower rim stays where it lands, unheard."""
TILT = math.sqrt(0.5)
"""Cosine of the angle at which a piece's modes are struck, as they are told."""
_SPUN = 4.0  # m R^2/I of a disc about its diameter
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
    swarm.pieces = min(max(count, 1), MOST_PIECES)
    for p in range(swarm.pieces):
        swarm.mass_of[p] = exp(log(1.0 - uniform(swarm, p, MAGNITUDE) * least) / rest)
        total += swarm.mass_of[p]
    swarm.smallest = size_of(swarm, whole / total)
    swarm.finer = (SIZES - 1) * 3.0 / math.log(_DECADES)
    swarm.usual = usual
    swarm.wide = exp(log(usual / (math.pi * _DENSITY * _FLAT)) / 3.0) / math.sqrt(usual)
    for p in range(swarm.pieces):
        swarm.mass_of[p] *= whole / total
        up = _THROWN * speed * (2.0 * uniform(swarm, p, GAP) - 1.0)
        above = height * uniform(swarm, p, VARIETY)
        highest = above + 0.5 * max(up, 0.0) * up / STANDARD_GRAVITY
        tilt = uniform(swarm, p, OTHER) * min(_radius(swarm, p), highest)
        falls = math.sqrt(max(up * up + 2.0 * STANDARD_GRAVITY * (above - tilt), 0.0))
        swarm.fall_of[p], swarm.turn_of[p], swarm.gap_of[p] = falls, 0.0, 2.0 * tilt
        swarm.next_of[p] = (up + falls) / STANDARD_GRAVITY
        swarm.bounced[p] = 0


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
def landing_of(swarm: Swarm, p: int) -> tuple[float, float, float]:
    """Return how fast a piece's rim meets the floor (m/s), the mass (kg) with which it does, and the cosine of the
    angle at which the piece lies."""
    sine = 0.5 * swarm.gap_of[p] / _radius(swarm, p)
    flat = math.sqrt(max(1.0 - sine * sine, 0.0))
    return max(swarm.fall_of[p] + flat * swarm.turn_of[p], 0.0), swarm.mass_of[p] / (1.0 + _SPUN * flat * flat), flat


@kernel
def flow_of(swarm: Swarm) -> float:
    """Return how many kilograms a second land: each rim flies for 2 v/g."""
    total = 0.0
    for p in range(swarm.pieces):
        if swarm.next_of[p] < math.inf:
            v, mass, _ = landing_of(swarm, p)
            total += mass * 0.5 * STANDARD_GRAVITY / max(v, SLOWEST)
    return total


@kernel
def bounce_piece(swarm: Swarm, p: int, restitution: float) -> None:
    """Advance a piece of which a rim lands, with a restitution, to the next landing of a rim, if any."""
    v, mass, flat = landing_of(swarm, p)
    left = restitution if v > SLOWEST else 0.0
    given = (1.0 + left) * v * mass / swarm.mass_of[p]
    fall, turn, gap = swarm.fall_of[p] - given, swarm.turn_of[p] - _SPUN * flat * given, swarm.gap_of[p]
    up, down = max(-fall - flat * turn, 0.0), fall - flat * turn
    up = up if left > 0.0 or v == 0.0 else 0.0
    swarm.bounced[p] += 1
    pull = STANDARD_GRAVITY if up > 0.0 else 2.0 * _SPUN / (1.0 + _SPUN) * STANDARD_GRAVITY
    lands = math.sqrt(down * down + 2.0 * pull * gap)  # m/s, at which the other rim does
    if max(up, lands) < SLOWEST or swarm.bounced[p] == BOUNCES:
        swarm.next_of[p] = math.inf
        return
    later = 2.0 * gap / (down + lands) if down > 0.0 else (lands - down) / pull
    again = 2.0 * up / STANDARD_GRAVITY if up > 0.0 else math.inf
    time = min(later, again)
    if up == 0.0:
        energy = fall * fall + turn * turn / _SPUN + STANDARD_GRAVITY * gap
        swarm.gap_of[p] = 0.0
        swarm.fall_of[p] = swarm.turn_of[p] = math.sqrt(energy / (1.0 + 1.0 / _SPUN))
    else:
        above = (up - 0.5 * STANDARD_GRAVITY * time) * time
        above = above if later <= again else gap - (down + 0.5 * STANDARD_GRAVITY * time) * time
        swarm.gap_of[p] = max(above, 0.0)
        swarm.fall_of[p], swarm.turn_of[p] = fall + STANDARD_GRAVITY * time, -turn if later <= again else turn
        if above > 2.0 * _radius(swarm, p):
            time = _turn_over(swarm, p, 0.5 * gap, fall, turn)
    swarm.next_of[p] += time


@kernel
def _turn_over(swarm: Swarm, p: int, middle: float, fall: float, turn: float) -> float:
    """Return the time (s) after which a piece lands that turns over before, at an angle at random.

    middle, fall: where its middle is (m), and how fast it falls (m/s); turn: m/s, of a rim about the middle.
    """
    tilt = _radius(swarm, p) * uniform(swarm, number_of(swarm, p), OTHER)
    falls = math.sqrt(max(fall * fall + 2.0 * STANDARD_GRAVITY * (middle - tilt), 0.0))
    swarm.gap_of[p] = 2.0 * tilt
    swarm.fall_of[p], swarm.turn_of[p] = falls, abs(turn)
    time: float = (falls - fall) / STANDARD_GRAVITY
    return time


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
    swarm: Swarm, p: int, mass: float, width: float, flat: float, given: float
) -> tuple[float, float, float]:
    """Return the factor on the momentum of a piece's blow that moves its modes as its blows do, by how much ln of their
    width is less, and the restitution that they leave it.

    mass, width, given: as it would meet the floor if it were rigid, in kg, ln of s, and in m v. Its modes have
    frequencies as the inverse of its mass, and masses as that; flat: the cosine of the angle at which it lies, as they
    are told at TILT.
    """
    piece, toward = swarm.mass_of[p], flat / TILT
    mass_ratio, at = toward * toward * swarm.bending * mass / piece, width + log(swarm.usual / piece)
    kept, shorter, bent = kept_by(swarm.bend, swarm.bends, mass_ratio, at, given, swarm.a)
    left = (given - 1.0) * math.sqrt(1.0 - given * given * bent * kept)
    return math.sqrt(kept) * toward, shorter, left


@kernel
def freed_within(swarm: Swarm, piece: float) -> float:
    """Return ln of the rms width (s) of the time in which a crack runs round a piece of a mass (kg)."""
    width: float = _ROUND + log(swarm.wide * math.sqrt(piece))
    return width


@kernel
def bent_by_crack(swarm: Swarm, mass: float, piece: float, width: float) -> float:
    """Return m M of a crack of a mass and a width (ln of s) beside a piece, where M is the mobility of its modes."""
    mass_ratio, at = swarm.bending * mass / piece, width + log(swarm.usual / piece)
    bent: float = bent_by(swarm.bend, swarm.bends, mass_ratio, at)
    return bent


@kernel
def number_of(swarm: Swarm, p: int) -> int:
    """Return the number of a piece's next blow, for its random numbers."""
    return MOST_PIECES + p * BOUNCES + swarm.bounced[p]


@kernel
def piece_of(number: int) -> int:
    """Return the piece that a blow's number belongs to."""
    return (number - MOST_PIECES) // BOUNCES


@kernel
def size_of(swarm: Swarm, mass: float) -> float:
    """Return ln of the size of a grain of a mass (kg), in that of the usual grain."""
    ratio: float = log(mass / swarm.m) / 3.0
    return ratio
