"""The records of swarms, and of the tables of their blows' pulses."""

from typing import Annotated

import numpy as np

from ..native.typed import Record, View, View2D, dtype_of, f32
from ..schema import MOST_PIECES
from ..sizes import CAPACITY

SWARMS = 16
"""Swarms that can go on at once."""
CHANNELS = 9
"""Random numbers of a blow."""
PLACES = 8
"""Places on an object at which the blows of a swarm fall."""
SIZES = 24
"""Sizes of grains that sound each by itself, where they differ."""
CLICKS = 8
"""Sizes of pieces that click each by itself: every third of SIZES."""
SOUNDS = SIZES + CLICKS
ONE_SIZE = 1e-9
"""Sizes per unit of ln, where all grains sound as the usual one."""
KNOTS = 16
"""Changes of a swarm that are kept until its blows have come so far."""
PULSES = 8
"""Contact laws by their exponents, and drops, whose pulses have tables at once."""
OCTAVES = 12
"""Octaves of a pulse's width that a table has."""
FORMS = 65
"""Dissipations at which a pulse's width, middle and momentum are known."""
TABLE = CAPACITY.pulse_values
"""Values of float32 in the tables of all pulses."""
DISSIPATIONS = 16
"""Forms of pulses in a table, by what they lose."""
MOST_NODES, POINTS = 600, 12_100
"""The nodes of a form, and the points of its spectrum, at most."""
MOST_LENGTH, MOST_ORDERS, MOST_TURNS = 1_024, 800, 32_768
"""Values in a row of a table; orders of its Fourier series; places in a turn, by lengths and places between samples."""
BANDS = 40
"""Half octaves of frequency by which modes are summed, for how an object yields."""
WIDTHS = 20
"""Widths of pulses, octaves apart, for which it is known how an object yields."""

MOST_BENDS = 12
"""Modes of a grain that are known."""
BATCH = 32
"""Blows that are drawn together, a multiple of LANES."""

BACK = 6
"""Samples of a grid before a quantum at which the force is computed."""
FORCES = 80
"""Samples of force that are computed for a quantum: those before it, 64, and some after it, a multiple of LANES."""
GRID = 1_040
"""Samples of a place's grid: those of a quantum, and of the longest pulse, which begins LOOK (swarms.py) after it."""


class PulseTable(Record):
    """The table of one family of pulses: widths, dissipations, places between samples.

    Octave o of the width holds `dissipations` blocks of `block` values. A block has STEPS + 1 widths, each with
    phases + 1 rows of `length` values, of which number `lead` is at the pulse's middle.
    """

    dissipations: int
    first: Annotated[View[int], OCTAVES]  # value of the octave in `table`
    block: Annotated[View[int], OCTAVES]
    phases: Annotated[View[int], OCTAVES]
    length: Annotated[View[int], OCTAVES]
    lead: Annotated[View[int], OCTAVES]
    width: Annotated[View[float], FORMS]  # ln of the rms width, in L/v
    middle: Annotated[View[float], FORMS]  # of the impulse, from the contact's beginning, in rms widths
    momentum: Annotated[View[float], FORMS]  # 1 + restitution: in m v
    size: int  # values in all
    # Of which the values are made: forms, as sums of impulses at times about their middle, in rms widths.
    nodes: int
    points: int  # of their spectra
    times: Annotated[View2D[float], DISSIPATIONS, MOST_NODES]
    impulses: Annotated[View2D[float], DISSIPATIONS, MOST_NODES]
    orders: Annotated[View[int], OCTAVES]  # of a row's Fourier series
    weight: Annotated[View2D[float], OCTAVES, MOST_ORDERS]  # of an order: the bump's spectrum


class PulseWork(Record):
    """Memory in which the values of a table are made."""

    even: Annotated[View[float], POINTS]
    odd: Annotated[View[float], POINTS]
    cosine: Annotated[View[float], MOST_TURNS]
    sine: Annotated[View[float], MOST_TURNS]
    order: Annotated[View[f32], 2 * MOST_LENGTH]  # an order's cosine and sine at the samples of a row


class Pulses(Record):
    """The tables of pulses."""

    tables: Annotated[View[PulseTable], PULSES]
    left: Annotated[View[int], PULSES]  # swarms that have had a table and don't need it any more
    work: PulseWork
    values: Annotated[View[f32], TABLE]


class Knot(Record):
    """The law of a swarm's blows from a time on."""

    time: float  # s from the swarm's beginning
    reached: float  # blows of its own that are to have come by then: the integral of the rate
    rate: float  # 1/s
    slope: float  # 1/s^2: of the rate
    excitation: float  # share of the blows that others set off
    memory: float  # s: for which a blow does so
    scale: float  # m/s, J or m: of speeds, the highest energy, or of drops' sizes
    steepness: float  # exponent of the power law of energies, or of how many are above a speed
    span: float  # ln of the ratio of the highest to the least energy
    variety: float  # ln of the ratio of the largest grain to the usual one


class Swarm(Record):
    """A swarm on an object."""

    used: int
    slot: int  # of its object
    flow: float  # kg/s: of its blows at the beginning of this quantum
    law: int  # of its blows, as schema.Gesture.swarms
    table: int  # of its pulses
    random: Annotated[View[np.uint64], CHANNELS]  # where the numbers of a channel begin
    index: int  # of the next blow
    time: float  # s: of the last one
    reached: float  # the integral of the rate, of blows of its own, there
    excited: float  # 1/s: rate of blows that are set off, there
    memory: float  # s: for which that one sets off others
    knots: Annotated[View[Knot], KNOTS]
    count: int  # of them
    piece: int  # of a step's course that its blows have come to
    duration: float  # s: of a step; else 0
    lead: float  # samples: from a blow's own time to when it is heard
    every: int  # frames in a sample of its grids
    log_rate: float  # ln of the rate of these samples
    places: int
    position: Annotated[View[float], PLACES]  # along the strike path
    retuned: int  # of the object, for which `mobility` is known; -1: for none
    spread: float  # of the places, as a share of the strike path
    centre: float  # position about which they are
    together: float  # the square of the mean share by which blows are heard: of their mass, in a stream
    beyond: float  # of the farthest drops: the square of their distance, in that of the nearest, less 1
    spot: Annotated[View[float], 3]  # m: the point of the surface where all of them are, if it is at one
    busy: Annotated[View[int], PLACES]  # samples of the grids that hold something
    sounds: Annotated[View[int], PLACES]  # 1: there is a force at the place in this quantum
    mobility: Annotated[View2D[float], PLACES, WIDTHS]  # 1/kg: sum of phi^2 of the modes that a pulse of a width moves
    slow: Annotated[View[float], PLACES]  # s/kg: sum of phi^2/omega, by which a stream of blows moves a place
    m: float  # kg: of the usual grain
    k: float
    light: float  # ln of m/k
    mu: float
    a: float
    w: float  # mu v, where a restitution was given; else 0
    grid: Annotated[View2D[f32], PLACES, GRID]
    force: Annotated[View2D[float], PLACES + 1, FORCES]  # N s: by one number a frame, and of all places
    sized: int  # 1: its grains sound by their sizes
    smallest: float  # ln of the smallest of these, in the usual grain's
    finer: float  # sizes per unit of ln
    size_grid: Annotated[View2D[f32], SOUNDS, GRID]  # and from SIZES on the clicks of pieces
    size_busy: Annotated[View[int], SOUNDS]
    voice: Annotated[View[int], SOUNDS]  # that sounds, -1: none yet
    store: float  # J: that its blows may still spend
    pieces: int  # that fall; 0: it is of another kind
    cracked: int  # pieces that its cracks set free; 0: it has none
    mass_of: Annotated[View[float], MOST_PIECES]  # kg
    fall_of: Annotated[View[float], MOST_PIECES]  # m/s, at which the middle of each falls as a corner lands next
    tilt_of: Annotated[View2D[float], 2, MOST_PIECES]  # m, by which corners on two axes are deeper then
    turn_of: Annotated[View2D[float], 2, MOST_PIECES]  # m/s, at which they go down about the middle, as it lies flat
    slide_of: Annotated[View[float], MOST_PIECES]  # m/s, at which each goes along the floor
    next_of: Annotated[View[float], MOST_PIECES]  # s, when it lands; inf: it lies still
    corner_of: Annotated[View[int], MOST_PIECES]  # that does, and 4 times a bit of each that rests until then
    friction: float  # coefficient, of pieces on the floor
    whole: float  # kg: of all pieces
    hit: float  # m/s: at which what broke hit
    height: float  # m: up to which its pieces began
    hard: float  # as k, where a piece lands on another
    wide: float  # m/sqrt(kg): a piece's radius over the root of its mass
    usual: float  # kg: of the usual piece
    bends: int  # modes of the usual grain which ring
    bend: Annotated[View[float], MOST_BENDS]  # Hz
    bending: float  # the usual grain's mass over the modal mass of each
    bent: Annotated[View[float], WIDTHS]  # of the usual grain: m M of its own modes, for a pulse of a width
    bounced: Annotated[View[int], MOST_PIECES]
    spare: float  # blows that may be contacts of their own now
    spared: float  # s: when that was
    bar: float  # ln of the momentum (N s) that such a blow must have
    blows: int  # so far
    impulse: float  # N s: given in this quantum
    energy: float  # J: of its blows, so far
    coming: float  # J: of those that may still act


class Blows(Record):
    """Blows of one swarm that are drawn together, by one law: the first `count` are some."""

    count: int
    number: Annotated[View[int], BATCH]  # for random numbers
    gap: Annotated[View[float], BATCH]  # in the integral of the rate
    time: Annotated[View[float], BATCH]  # s from the swarm's beginning
    rate: Annotated[View[float], BATCH]  # 1/s: of blows then
    place: Annotated[View[int], BATCH]
    v: Annotated[View[float], BATCH]  # m/s
    mass: Annotated[View[float], BATCH]  # kg
    light: Annotated[View[float], BATCH]  # ln of m/k
    loss: Annotated[View[float], BATCH]  # w/(1 + w)
    width: Annotated[View[float], BATCH]  # ln of the rms width (s)
    heard: Annotated[View[float], BATCH]  # of a drop: its share by its distance; of a piece: its momentum in m v
    alike: Annotated[View[float], BATCH]  # of the momentum, moves a grain's modes
    toward: Annotated[View[float], BATCH]  # of that, moves a piece's, by the angle at which it lies
    below: Annotated[View[int], BATCH]  # the piece on which a piece lands; -1: none
    shorter: Annotated[View[float], BATCH]  # by so much ln of the width is less then
    ratio: Annotated[View[float], BATCH]  # of the mass that the object leaves it
    momentum: Annotated[View[float], BATCH]  # N s
    at: Annotated[View[float], BATCH]  # samples: its middle


PULSE_TABLE, PULSE_WORK, SWARM = dtype_of(PulseTable), dtype_of(PulseWork), dtype_of(Swarm)
