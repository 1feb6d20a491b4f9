"""The records of coupled plates, and how much there is room for."""

from typing import Annotated

import numpy as np

from ..native.typed import Record, View, View2D, dtype_of, f32
from ..sizes import CAPACITY, MOST_COUPLED, MOST_SCATTERED

MOST_ORDERS = 96
"""Angular orders of a grid's functions, and of its stress functions."""
SHEETS = CAPACITY.sheets
TABLE_VALUES = CAPACITY.sheet_tables
SPACE = 65_536
"""Values of float32 in each array that a force is computed in."""
LEVELS = 2
"""Grids of a plate: of all of its coupled modes, and of half of them."""

FAINT = 1e-18
"""Numbers of float32 below are 0, in a grid's tables and fields: the square of the least is no denormal yet."""


class Grid(Record):
    """A polar grid on a plate: its tables, as places in those of all grids, and sizes.

    Function i is a radial shape of an angular order, with a mode cos and, from order 1 on, a mode sin. Functions lie in
    the order of these orders, and in each by frequency: the first `count` are coupled.
    """

    orders: int  # of functions that are coupled
    stresses: int  # of stress functions
    points: int  # radii, a multiple of LANES
    angles: int  # of the first quarter of the circle
    first: Annotated[View[int], MOST_ORDERS]  # function of each order
    count: Annotated[View[int], MOST_ORDERS]
    row: Annotated[View[int], MOST_ORDERS]  # of the first of them in `shapes`
    stress: Annotated[View[int], MOST_ORDERS]  # first stress function of each order; one more
    strain: Annotated[View[int], MOST_ORDERS]  # of a dome: value of `bent` where each order begins
    shapes: int  # (functions, 3 points): curvatures a, b and c
    stretch: int  # (stress functions, points): weights of the strain's integral
    cosine: Annotated[View[int], 2]  # of even and odd orders: (angles, orders)
    sine: Annotated[View[int], 2]
    stress_cosine: Annotated[View[int], 2]
    stress_sine: Annotated[View[int], 2]
    bent: int  # linear strains of a dome: of each order (its stress functions, its functions)
    domed: int  # 1: there are some


class Sheet(Record):
    """A plate whose modes can be coupled, and how they are.

    Its modes are the first of its object: those of cosines of all functions, then those of sines from order 1 on, which
    are coupled, then the others.
    """

    functions: int
    plain: int  # the first of them, of order 0, which have no sine
    modes: int  # coupled or not
    rungs: int  # modes that exchange energy with those above or below them, and with which they do so
    ladder: Annotated[View[int], MOST_SCATTERED]  # these, by frequency
    below: float  # modes below the first of them
    span: float  # modes of a block, which exchange energy with those of the next, over those below
    start: Annotated[View[int], LEVELS]  # of each grid: the first that exchanges energy,
    free: Annotated[View[int], LEVELS]  # and the first that is not coupled
    mixing: Annotated[View[float], 2]  # their rate by the energy of a mode: 1/(J^2 s), for each mode below, and 1/(J s)
    mixes: int  # samples from one exchange to the next
    highest: float  # Hz: of its coupled modes
    every: int  # samples from one look at the grid to the next
    growth: float  # c0 over the energy
    least: float  # J: energy below which coupling is not heard
    grids: Annotated[View[Grid], LEVELS]
    # Now:
    coupled: int  # 1: its modes are coupled
    waits: int  # 1: they are not, as too many plates' are
    level: int  # the grid that they are on
    turn: int  # samples since that was looked at
    retuned: int  # times its object had got new coefficients as those here were made
    scale: float  # samples of modes over what they were without the gains of gestures
    strained: float  # displacements over those that strain the plate of the tables as much
    tension: float  # factor on the energy that it holds then
    leaves: int  # 1: it falls asleep: the force of stretching fades
    left: int  # samples of that yet
    share: float  # of the force that there is still: 1 until then
    psi: float  # sqrt(2 V + c0)
    truth: float  # that of the grid, as last looked at
    c0: float  # J
    energy: float  # J: of its modes and of what is stretched, as last looked at
    held: int  # 1 while a hand bends a dome more than it swings
    given: float  # of what modes lose: how much of it they may get back
    mixed: int  # samples since the last exchange
    drawn: np.uint64  # state of its random numbers
    owed: float  # J: that losses took of modes at rest where stretching holds them, and which they are still to get
    looked: int  # times that the grid was looked at since it was coupled, up to 3
    gradient: Annotated[View2D[float], 4, MOST_COUPLED]  # of psi by displacements: now, as last looked at, and before
    seen: Annotated[View2D[float], 2, MOST_SCATTERED]  # a mode's velocity by its last two samples
    pushed: Annotated[View[float], MOST_SCATTERED]  # change of its last but one by a change of velocity
    moved: Annotated[View[float], MOST_SCATTERED]  # displacement by its last
    fades: Annotated[View2D[float], 3, MOST_SCATTERED]  # of a coupled mode: decay, 1/s; of twice its energy, what a
    # sample took of that of v, and of that of its last sample
    drained: Annotated[View[float], MOST_COUPLED]  # share in what psi gets where it is far behind the grid's
    follows: float  # s in which psi follows the grid's
    bends: Annotated[View2D[float], 2, MOST_SCATTERED]  # output left and right as a steady force of 1 bends a mode
    smoothing: Annotated[View[float], 3]  # of what is heard of bending: a two-pole recursion, and its input's factor
    bent: Annotated[View2D[float], 2, 2]  # output of bending, left and right: now and a sample ago


class Space(Record):
    """Room in which a force is computed."""

    place: Annotated[View[f32], 3 * MOST_COUPLED + 64]  # displacements: cosines, sines, and cosines with other sign
    answer: Annotated[View[f32], 2 * MOST_COUPLED + 64]  # gradient of the stretching energy
    waves: Annotated[View[f32], SPACE]
    parts: Annotated[View[f32], SPACE]
    fields: Annotated[View[f32], SPACE]
    bends: Annotated[View[f32], SPACE]
    strains: Annotated[View[f32], SPACE]
    sums: Annotated[View[f32], 4 * MOST_COUPLED]
    speeds: Annotated[View[float], MOST_SCATTERED]  # of modes that exchange energy


GRID, SHEET, SPACES = dtype_of(Grid), dtype_of(Sheet), dtype_of(Space)
