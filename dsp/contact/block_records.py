"""The records of lasting contacts that are solved in blocks (block.py): their tables, and those solved together."""

from typing import Annotated

from ..native.jit import kernel
from ..native.typed import Record, View, View2D
from ..numerics.legendre import AHEAD, FINE, KEPT
from ..numerics.sums import AT_ONCE, BEYOND, line_of

TOGETHER = 4
"""Contacts that are solved together, at most."""

TERMS = KEPT
"""Legendre polynomials of which the force over a sample is a sum: the object's modes keep as many moments."""

SOFT_TERMS = 3
"""The same of contacts that are soft, which are solved several at a time (lanes.py)."""

LANES = 8
"""Of these as many at a time."""

TILE = 8
"""Samples within which they feel their forces as these are found, and after which all at once."""

POINTS = AT_ONCE
"""Points of the quadrature over a sample."""

LAID = 8
"""Samples over which the path of a body that rolls evenly is laid at once, at most."""

AT_BEGIN, AT_END = AHEAD * TERMS * TERMS, AHEAD * TERMS * TERMS * 3 // 2
"""Places in `later` of tables for a quarter of AHEAD samples at a quantum's ends."""


class Tables(Record):
    """The answer of one contact's point to the force of one of those that are solved together."""

    settled: int  # number of the receptance of the contact whose force it is, 0: none is known
    terms: int  # for which it is
    # m/(N s): what each moment adds to rows of later samples, from a line of the cache on, as `add_tables` reads it.
    # Of what moves, for a block amid the quantum, and at its ends.
    later: Annotated[View[float], 2 * AT_BEGIN + AT_ONCE]
    ends: Annotated[View[float], 2 * FINE]  # m/(N sample): the answers within a sample at these
    # m/(N sample): W of block.py, what each f_l takes off each v_l, with room for `put_few`
    within: Annotated[View2D[float], TERMS, AT_ONCE]
    missed: Annotated[View[float], TERMS]  # m/(N sample): by how much v_l comes out too small under a force that lasts


class Newton(Record):
    """Room for a step of Newton's method (terms.py)."""

    seen: Annotated[View[float], 2 * POINTS]  # m, m per sample: the way up to the points, and the rates there
    stiffness: Annotated[View[float], POINTS]  # N/m: the law's slopes there
    damping: Annotated[View[float], POINTS]  # N sample/m
    force: Annotated[View[float], POINTS]  # N
    found: Annotated[View[float], AT_ONCE]  # N: the law's terms
    slopes: Annotated[View[float], TERMS * TERMS]  # N sample/m: K, what each changes by as each v_l does
    matrix: Annotated[View2D[float], TERMS, AT_ONCE]


class Net(Record):
    """Contacts with one object, or with several that share contacts, that are solved together."""

    size: int
    terms: int  # of the forces
    stop: int  # frame up to which they may be solved,
    end: int  # and up to which they are
    begin: int  # at which their block began
    lasts: int  # 1: forces that last are not all those of bodies at rest, which are in no force here
    moves: int  # 1: a body moves over an object, so that its block ends early
    between: int  # 1: so near that tables go as lines between the quantum's ends
    rubs: int  # 1: friction acts on an object, too, sample by sample
    contact: Annotated[View[int], TOGETHER]  # places among the contacts
    block: Annotated[View[int], TOGETHER]  # and among the blocks
    objects: int
    object: Annotated[View[int], TOGETHER + 1]  # slots of those that they touch
    gain: Annotated[View[float], TOGETHER]  # factor on the force that the object gets, and
    share: Annotated[View[float], TOGETHER]  # another one, in this sample
    # The factor on what the force of the second one does to the point of the first one, in this sample
    ratio: Annotated[View2D[float], TOGETHER, TOGETHER]
    newton: Newton
    factored: int  # 1: the matrix below is, and goes with these slopes of the law (N sample/m)
    slopes: Annotated[View2D[float], TOGETHER, TERMS * TERMS]
    # The equations for all terms of the forces of several in a sample, and in the last column what they leave
    linear: Annotated[View2D[float], TOGETHER * TERMS, TOGETHER * TERMS + 1]


class Block(Record):
    """A lasting contact and its tables."""

    settled: int  # number of the receptance that the tables are of, 0: none
    tables: Annotated[View[Tables], TOGETHER]  # for the force of each member of the net, its own among them
    reached: float  # position at the quantum's end for which there are tables
    touch: int  # number of a blow's touch whose energy is kept account of
    gained: float  # J: by how much the energy is above the least so far
    scale: float  # J: the greatest V so far
    # While a block lasts:
    stored: float  # J: V before the sample
    # m: the point's motion without the forces to come, from half a line of the cache on: of each sample v_1, v_2, v_3
    # of the point, and its place at the end; the first end is its place now
    rows: Annotated[View[float], (AHEAD + 1) * TERMS + BEYOND + 2 * AT_ONCE]
    landing: float  # J: what lands with more, and harder than ever, ends the block
    leaves: int  # 1: the block ends where the contact does
    pushes: float  # N: the force at the end of the last sample
    free: Annotated[View[float], TERMS]  # m per sample: the v_l without a force,
    rate: Annotated[View[float], TERMS]  # and with all of them, or those of the last sample
    force: Annotated[View[float], TERMS]  # N: f_l
    before: Annotated[View[float], TERMS]  # and a sample before
    soft: int  # 1: forces go on as lines rather than rates
    moments: Annotated[View[float], TERMS]  # N s: of F, as far as the object gets it, and of friction beside it
    # The path over some samples, its v_l one sample after the other, and the coming one of these:
    path: Annotated[View[float], LAID * TERMS]  # m per sample
    at: int
    laid: int  # 0: a body has not rolled evenly over the coming one
    steeper: Annotated[View[float], LAID + 1]  # m: what kinks add to its rise in a sample, by the sample's beginning,
    rounder: Annotated[View[float], LAID + 1]  # m: and to half of what that changes by
    even: int  # 1: the body rolls evenly
    pace: float  # m in a sample, if it does
    per_pace: float  # 1/m
    # Where it was on its path before what is laid:
    piece: int
    last_piece: int  # that the laid samples reach
    along: float  # m
    t: float  # s
    s: float  # m


class Lanes(Record):
    """Soft contacts that are solved together, a column for each; names as in Coupled, Block and Tables."""

    slot: Annotated[View[int], LANES]  # of their objects
    contact: Annotated[View[int], LANES]  # places among the contacts
    block: Annotated[View[int], LANES]  # and among the blocks
    ended: Annotated[View[int], LANES]  # frame up to which they are solved, where that is over; -1: they go on
    idle: Annotated[View[float], LANES]  # 1: the lane is not needed
    k: Annotated[View[float], LANES]
    mu: Annotated[View[float], LANES]  # samples/m
    a: Annotated[View[float], LANES]
    # x^(a - 1) is the product of the root of x, of x and of its square, of each where it is 1:
    root: Annotated[View[float], LANES]
    single: Annotated[View[float], LANES]
    double: Annotated[View[float], LANES]
    springs: Annotated[View[float], LANES]  # k/(a + 1)
    rest: Annotated[View[float], LANES]  # N: at rest
    period: Annotated[View[float], LANES]  # s
    moving: Annotated[View[float], LANES]  # J samples^2/m^2: half of the effective mass
    lightness: Annotated[View[float], LANES]  # 1/kg
    pushed: Annotated[View[float], LANES]  # m: in a sample, by the constant force
    faster: Annotated[View[float], LANES]  # m/s: and by how much faster
    landing: Annotated[View[float], LANES]
    within: Annotated[View2D[float], SOFT_TERMS**2, LANES]
    position: Annotated[View[float], LANES]
    v: Annotated[View[float], LANES]
    now: Annotated[View[float], LANES]  # m: compression
    gained: Annotated[View[float], LANES]
    scale: Annotated[View[float], LANES]
    stored: Annotated[View[float], LANES]
    touching: Annotated[View[int], LANES]
    contacts: Annotated[View[int], LANES]
    # What moments of a force do to the rows of the samples after it, and those of a tile so far:
    later: Annotated[View2D[float], (TILE - 1) * SOFT_TERMS**2, LANES]
    felt: Annotated[View2D[float], TILE * SOFT_TERMS, LANES]
    # Of a sample:
    rows: Annotated[View2D[float], SOFT_TERMS, LANES]  # the point's motion
    path: Annotated[View2D[float], SOFT_TERMS, LANES]
    free: Annotated[View2D[float], SOFT_TERMS, LANES]
    rate: Annotated[View2D[float], SOFT_TERMS, LANES]
    force: Annotated[View2D[float], SOFT_TERMS, LANES]
    before: Annotated[View2D[float], SOFT_TERMS, LANES]
    moments: Annotated[View2D[float], SOFT_TERMS, LANES]  # N s
    done: Annotated[View[float], LANES]  # above 0: Newton's method has ended
    taken: Annotated[View[int], LANES]  # 1: the sample is taken


@kernel
def motion_of(block: Block) -> View[float]:
    """Return the rows of the point's motion, one sample's after the other's."""
    return block.rows[line_of(block.rows) + AT_ONCE // 2 :]
