"""The record of bodies that are solved in the lanes of registers (block_lanes.py)."""

from typing import Annotated

from ..native.typed import Record, View, View2D
from ..numerics.sums import AT_ONCE
from .block_sizes import LAID, NODES_PER_PART

LANES = AT_ONCE
"""Contacts at a time."""
MOMENTS = 2
"""Moments of a force that later samples feel, of a sample of one part."""
ROWS = 4
"""Rows of the free motion in a sample of one part: places and tilts."""
TILT, END = 2, 3
"""Tilt and place at the sample's end, of these rows."""
HEIGHT, SLOPE, RISE = ROWS, ROWS + NODES_PER_PART, ROWS + 2 * NODES_PER_PART
"""Height and slope of the path at both nodes, and its rise: lines behind the rows."""
LINES = RISE + 1


class Lanes(Record):
    """Contacts that are solved together, a column for each; names as in Coupled, Block and Tables."""

    slot: Annotated[View[int], LANES]  # of their objects
    contact: Annotated[View[int], LANES]  # places among the contacts
    block: Annotated[View[int], LANES]  # and among the blocks
    ended: Annotated[View[int], LANES]  # frame up to which they are solved, where that is over; -1: they go on
    idle: Annotated[View[float], LANES]  # 1: the lane is not needed
    k: Annotated[View[float], LANES]
    mu: Annotated[View[float], LANES]
    rest: Annotated[View[float], LANES]  # N: at rest
    mass: Annotated[View[float], LANES]
    period: Annotated[View[float], LANES]
    rate: Annotated[View[float], LANES]  # 1/s
    lightness: Annotated[View[float], LANES]  # 1/kg
    pushed: Annotated[View[float], LANES]  # m: in a sample, by the constant force
    faster: Annotated[View[float], LANES]  # m/s: and by how much faster
    springs: Annotated[View[float], LANES]
    landing: Annotated[View[float], LANES]
    give: Annotated[View2D[float], 2 * NODES_PER_PART**2, LANES]  # of each force: at both nodes, then their rates
    course: Annotated[View2D[float], MOMENTS * NODES_PER_PART, LANES]
    held: Annotated[View2D[float], 2 * NODES_PER_PART, LANES]
    position: Annotated[View[float], LANES]
    v: Annotated[View[float], LANES]
    now: Annotated[View[float], LANES]  # m: compression
    gained: Annotated[View[float], LANES]
    scale: Annotated[View[float], LANES]
    stored: Annotated[View[float], LANES]
    touches: Annotated[View[int], LANES]  # 1: they touch, as in Coupled
    contacts: Annotated[View[int], LANES]
    steps: Annotated[View[int], LANES]
    # Of a tile, sample after sample:
    lines: Annotated[View2D[float], LAID * LINES, LANES]
    felt: Annotated[View2D[float], LAID * MOMENTS, LANES]  # N s: the moments that later samples feel
    answers: Annotated[View2D[float], LAID * MOMENTS * ROWS, LANES]  # of each moment, so many samples later
    # Of a sample:
    line: Annotated[View2D[float], LINES, LANES]
    free: Annotated[View2D[float], 2 * NODES_PER_PART, LANES]
    found: Annotated[View2D[float], NODES_PER_PART, LANES]  # N: the forces,
    force: Annotated[View2D[float], NODES_PER_PART, LANES]  # those a sample before,
    before: Annotated[View2D[float], NODES_PER_PART, LANES]  # and another one before that
    travel: Annotated[View2D[float], MOMENTS, LANES]
    moments: Annotated[View2D[float], MOMENTS, LANES]
    done: Annotated[View[float], LANES]  # above 0: Newton's method has ended
    as_most: Annotated[View[int], LANES]  # 1: the step is as most are
