"""The pieces of what breaks: their masses, which sum to its own, and their bounces until they lie still.

As many pieces have a mass m as m^-1.5, over three decades (O. Oddershede, P. Dimon and J. Bohr, Phys. Rev. Lett. 71,
1993: exponents from 1.1 of slabs to 1.6 of balls). They fly up at up to half the speed at which the whole hit, fall on
what lies below, and bounce: a piece leaves with a random share of the speed that its contact leaves it, as it turns.
Each has its numbers from (seed, piece, bounce, channel) alone.
"""

import math

from ..native.jit import kernel
from ..numerics.constants import STANDARD_GRAVITY
from ..numerics.elementary import log
from ..schema import MOST_PIECES
from .record import SIZES, Swarm
from .times import GAP, MAGNITUDE, OTHER, uniform

_DECADES = 1000.0
_LEAST = 1.0 - 1.0 / math.sqrt(_DECADES)
_THROWN = 0.5
BOUNCES = 64
"""Bounces of a piece at most."""
CRACKING = 0.03
"""s: for which what breaks cracks (estimated)."""
JUNCTIONS = 3
"""Cracks that set a piece free, each heard."""
CRACKS = 0.25
"""Share of the energy of what hits that its cracks have; as much at most throws the pieces."""
STRONGEST = 0.1
"""Share of that in the strongest crack."""
CRACK = 0.1
"""Mass that moves at a crack, in that of a piece (estimated)."""
_SLOWEST = 0.03  # m/s: a slower piece lies still
_TURNING = 0.7  # share of its speed that a piece may keep for itself, as it turns


@kernel
def break_up(swarm: Swarm, whole: float, count: int, speed: float, height: float) -> None:
    """Break a mass (kg) that hit at a speed (m/s), at a height (m), into pieces."""
    total = 0.0
    swarm.pieces = min(max(count, 1), MOST_PIECES)
    for p in range(swarm.pieces):
        share = 1.0 - uniform(swarm, p, MAGNITUDE) * _LEAST
        swarm.mass_of[p] = 1.0 / (share * share)
        total += swarm.mass_of[p]
    swarm.smallest = size_of(swarm, whole / total)
    swarm.finer = (SIZES - 1) * 3.0 / math.log(_DECADES)
    for p in range(swarm.pieces):
        swarm.mass_of[p] *= whole / total
        up = _THROWN * speed * uniform(swarm, p, GAP)
        swarm.speed_of[p] = math.sqrt(up * up + 2.0 * STANDARD_GRAVITY * height)
        swarm.next_of[p] = (up + swarm.speed_of[p]) / STANDARD_GRAVITY
        swarm.bounced[p] = 0


@kernel
def bounce_piece(swarm: Swarm, p: int, restitution: float) -> None:
    """Advance a piece that has landed to its next bounce, with what its contact leaves it of its speed, if any."""
    left = 1.0 - _TURNING * uniform(swarm, number_of(swarm, p), OTHER)
    swarm.speed_of[p] *= restitution * left
    swarm.bounced[p] += 1
    if swarm.speed_of[p] < _SLOWEST or swarm.bounced[p] == BOUNCES:
        swarm.next_of[p] = math.inf
    else:
        swarm.next_of[p] += 2.0 * swarm.speed_of[p] / STANDARD_GRAVITY


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
def number_of(swarm: Swarm, p: int) -> int:
    """Return the number of a piece's next blow, for its random numbers."""
    return MOST_PIECES + p * BOUNCES + swarm.bounced[p]


@kernel
def size_of(swarm: Swarm, mass: float) -> float:
    """Return ln of the size of a grain of a mass (kg), in that of the usual grain."""
    ratio: float = log(mass / swarm.m) / 3.0
    return ratio
