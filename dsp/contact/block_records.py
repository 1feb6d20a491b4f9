"""The records of lasting contacts that are solved in blocks (block.py): their tables, and those solved together."""

from typing import Annotated

from ..native.jit import kernel
from ..native.typed import Record, View, View2D
from ..numerics.legendre import AHEAD, FINE
from ..numerics.sums import AT_ONCE, BEYOND, DELAYED, line_of
from .block_sizes import FORCES, LAID, LINEAR, MOMENTS_AHEAD, MOST_PARTS, MOTIONS, NODES_PER_PART

TOGETHER = 4
"""Contacts that are solved together, at most."""

ROWS = 5 * MOST_PARTS - 1
"""Rows of the free motion, at most. The displacement at each node; of each part the tilt of its rate's line of least
squares (block_nodes.TILT); the displacement between parts; the means of P_2 and so on, as far as moments are felt,
times the rate; and the displacement at the sample's end."""


class Linear(Record):
    """A rest as a line about its load, by forces at the nodes: the first ones of all samples, then the second ones."""

    settled: int  # number of the receptance that the tables are of, 0: none
    calm: int  # 1: it swung little in the last quantum
    load: float  # N: that they are of
    stiffness: float  # N/m
    along: Annotated[View[float], 2]  # N/m: what the way over a sample adds to the forces beyond the stiffness,
    tilted: Annotated[View[float], 2]  # and the mean of its rate times P_1
    free: Annotated[View[float], 2 * AHEAD]  # N: the forces if none acted before
    force: Annotated[View[float], 2 * AHEAD]  # N
    # Of forces to those that there would be, as `put_convolved` has them.
    answers: Annotated[View[float], 4 * (AHEAD + AT_ONCE)]
    ends: Annotated[View[float], 2 * AHEAD]  # m/N: what a force does to y at the end of its sample and of later ones,
    tilts: Annotated[View[float], 2 * AHEAD]  # and to the mean of the rate times P_1


class Tables(Record):
    """The answer of one contact's point to the force of one of those that are solved together."""

    settled: int  # number of the receptance of the contact whose force it is, 0: none is known
    # m/(N s): what each moment adds to rows of later samples, from a line of the cache on, as `add_tables` reads it.
    # Of what moves, for a block amid the quantum, and at its ends (block_tables.py).
    later: Annotated[View[float], MOMENTS_AHEAD * AHEAD * ROWS + AT_ONCE]
    ends: Annotated[View[float], 2 * FINE]  # m/(N sample): the answers within a sample at these
    # What each force takes off at all nodes, one after the other: m/N, then of the rate, m/(N sample).
    give: Annotated[View[float], FORCES * MOTIONS]
    # m/N: what each takes off the compression's course in the work that moments do, one moment after the other.
    travel: Annotated[View[float], MOMENTS_AHEAD * FORCES]
    give_all: Annotated[View[float], MOTIONS]  # all forces together
    # m/N: by how much compression and rate at the nodes come out too small under a force that lasts, as series end, and
    # the compression's course, as in `travel`.
    missed: Annotated[View[float], MOTIONS]
    missed_travel: Annotated[View[float], MOMENTS_AHEAD]


class Net(Record):
    """Contacts with one object, or with several that share contacts, that are solved together."""

    size: int
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
    # Of several, the factor on what the force of the second one does to the point of the first one, in this sample
    ratio: Annotated[View2D[float], TOGETHER, TOGETHER]
    # Newton's equations for all forces in a part of a sample, and in the last column what they leave
    linear: Annotated[View2D[float], TOGETHER * NODES_PER_PART, TOGETHER * NODES_PER_PART + 1]


class Block(Record):
    """A lasting contact and its tables."""

    settled: int  # number of the receptance that the tables are of, 0: none
    parts: int  # of a sample that they are for, 0: the contact is too stiff
    tables: Annotated[View[Tables], TOGETHER]  # for the force of each member of the net, its own among them
    reached: float  # position at the quantum's end for which there are tables
    linear: Linear  # a rest alone that swings little
    touch: int  # number of a blow's touch whose energy is kept account of
    # While a block lasts:
    gained: float  # J: by how much the energy is above the least so far
    scale: float  # J: the greatest V so far
    springs: float  # N/m^a: V = springs x^(a + 1)
    landing: float  # J: what lands with more, and harder than ever, ends the block
    kept: float  # J: `gained` before the sample
    stored: float  # J: V then
    left: float  # J: V after it
    most: float  # J: `scale` after it
    # m: the point's motion without the forces to come, from half a line of the cache on; the first end at its place now
    rows: Annotated[View[float], (AHEAD + 1) * ROWS + BEYOND + 2 * AT_ONCE]
    force: Annotated[View[float], FORCES]  # N
    before: Annotated[View[float], FORCES]  # a sample before
    last: Annotated[View[float], FORCES]
    # The path over some samples, one after the other, and the coming one of these:
    height: Annotated[View[float], LAID * FORCES]  # m: at the nodes, against the sample's beginning,
    slope: Annotated[View[float], LAID * FORCES]  # m per sample
    rise: Annotated[View[float], LAID]  # m: and at the sample's end
    at: int
    laid: int  # 0: a body has not rolled evenly over the coming one
    steeper: Annotated[View[float], LAID * MOST_PARTS + 1]  # m: what its kinks add to its rise in a part, by the part's
    rounder: Annotated[View[float], LAID * MOST_PARTS + 1]  # m: beginning, and to half of what that changes by
    leaves: int  # 1: the block ends where the contact does
    edge: float  # share of the force at its end by which that of a sample may be mended, where a body lands or leaves
    even: int  # 1: the body rolls evenly
    pace: float  # m in a part of the sample, if it does
    per_pace: float  # 1/m
    # Where it was on its path before what is laid:
    piece: int
    last_piece: int  # that the laid samples reach
    along: float  # m
    t: float  # s
    s: float  # m
    end: float  # m: compression then
    solved: int  # 1: so Newton's method has ended
    travel: Annotated[View[float], MOMENTS_AHEAD]  # m: means of P_l x' over the sample, with the force at rest
    free: Annotated[View[float], MOTIONS]  # compression and rate with no force but that at rest,
    seen: Annotated[View[float], MOTIONS]  # and with those of the others,
    v: Annotated[View[float], FORCES]  # m per sample
    moments: Annotated[View[float], MOMENTS_AHEAD]  # N s: of F, as far as the object gets it, and of friction beside it
    # Of the samples since all those to come felt one, as many as go together: two moments of each
    recent: Annotated[View[float], 2 * DELAYED]


@kernel
def forces_of(block: Block) -> int:
    """Return the number of unknown forces in a sample of a block."""
    return NODES_PER_PART * block.parts


@kernel
def rows_of(block: Block) -> int:
    """Return the number of rows that a block has."""
    return rows_for(block.parts)


@kernel
def rows_for(parts: int) -> int:
    """Return the number of rows for so many parts of a sample, or for LINEAR."""
    return 2 if parts == LINEAR else 5 * parts - 1


@kernel
def motion_of(block: Block) -> View[float]:
    """Return the rows of the point's motion, one sample's after the other's.

    Those of one part fill half a line of the cache: a line begins with what DELAYED samples do to those after them.
    """
    return block.rows[line_of(block.rows) + AT_ONCE // 2 :]


@kernel
def moments_of(block: Block) -> int:
    """Return the number of moments of a force that the samples after it feel."""
    return block.parts + 1


@kernel
def weigh_all(net: Net, size: int) -> None:
    """Set the factors on what the forces of contacts of a net, of a size, do to each other's points."""
    for i in range(size):
        for j in range(size):
            net.ratio[i, j] = net.gain[j] * net.share[j] / net.gain[i]
