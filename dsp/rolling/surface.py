"""The surface that a body rolls on: a rough profile that never ends, never repeats and needs no memory.

The profile z(s) is a sum of octaves of smooth noise. Octave j has random heights on a lattice of spacing
`longest`/2^j, each a hash of its number, the octave and the seed, joined by Catmull-Rom cubics; its variance falls as
2^(-j (beta - 1)), so the power spectrum is flat up to about 1/(2 pi l) and falls as wavenumber^-beta beyond, l being
the correlation length. The octaves are higher in some places than in others (`variation.py`). On top there may be a
periodic corrugation.

Places are whole numbers of the finest lattice's `unit`, in 64 bits: a millimetre's roughness stays exact for millions
of kilometres. The reader chooses how much of an octave is heard: `gain`.
"""

import math
from ctypes import c_int64, c_void_p
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..native.jit import c_function, carray, kernel
from ..native.typed import Record, View, dtype_of
from ..numerics.checks import checked
from ..numerics.random import STEP, mixed
from ..resonator.simd import LANES, add_product, dot
from .lattice import TO_HEIGHT, cubic_weights, drawn
from .variation import MOST_VARIATION, Variation, begin_variation, local_roughness

OCTAVES = 16

BLOCK = 64
"""Points that are read at once."""

TAPS = 8
"""Lattice heights that LANES points lie between, where each cell holds two of them; five where it holds LANES."""

_CELLS = np.array([2, 4, 8, 16, 32])  # points in a cell, of octaves that are read by weights
_TABLES = int(np.maximum(_CELLS // LANES, 1).sum())

_LONGEST = 2.0
"""Spacing of the first lattice in correlation lengths: where beta = 2, the autocorrelation is 1/e at l."""


class Profile(Record):
    """A surface as a preset has it."""

    roughness: float  # m: rms height
    correlation: float  # m: its length
    slope: float  # of its spectrum
    ripple: float  # m: amplitude
    wavelength: float  # m, of the ripple
    variation: float  # dB: how far the rms height varies from place to place
    variation_length: float  # m


PROFILE = dtype_of(Profile)


class Surface(Record):
    """A surface as it is read."""

    unit: float  # m between places
    height: Annotated[View[float], OCTAVES]  # rms, m
    seed: Annotated[View[np.uint64], OCTAVES]
    offset: Annotated[View[int], OCTAVES]  # places by which the lattices are moved against each other
    ripple: float  # amplitude of the corrugation, m
    turns: float  # of the corrugation, for each place
    variation: Variation  # of the octaves' heights
    # The share of each octave that is read, and room for the lattice heights of one, a block of points long.
    gain: Annotated[View[float], OCTAVES]
    ripple_gain: float
    corner: Annotated[View[float], BLOCK + TAPS]
    # Of octaves with 2 to BLOCK/2 points in a cell: the weights of the lattice's heights, for LANES points at a
    # time, and the points' stride for which they are made.
    weights: Annotated[View[float], _TABLES * TAPS * LANES]
    made_for: int


SURFACE = dtype_of(Surface)


@kernel
def begin_surface(surface: Surface, profile: Profile, seed: int) -> None:
    """Set a surface up by a PROFILE."""
    slope = profile.slope
    surface.unit = _LONGEST * profile.correlation * 0.5 ** (OCTAVES - 1)
    total = 0.0
    share = 1.0
    for _ in range(OCTAVES):
        total += share
        share *= 2.0 ** (1.0 - slope)
    share = 1.0
    bits = mixed(np.uint64(seed) + STEP)
    for j in range(OCTAVES):
        surface.height[j] = profile.roughness * math.sqrt(share / total)
        share *= 2.0 ** (1.0 - slope)
        bits += STEP
        surface.seed[j] = mixed(bits)
        surface.offset[j] = int(np.int64(surface.seed[j] >> np.uint64(31)))
        surface.gain[j] = 1.0
    surface.ripple = profile.ripple
    surface.ripple_gain = 1.0
    surface.made_for = 0
    surface.turns = surface.unit / profile.wavelength
    begin_variation(surface.variation, profile.variation, profile.variation_length, surface.unit, seed)


@kernel
def _enter(surface: Surface, j: int, cell: int, count: int) -> None:
    """Put octave j's heights at `count` points of its lattice, from a cell's first corner on, into `corner`."""
    corner, seed, scale = surface.corner, surface.seed[j], surface.height[j] * TO_HEIGHT
    for c in range(count):
        corner[c] = scale * drawn(seed, cell + c)


@kernel
def _cubic(corner: View[float], c: int) -> tuple[float, float, float, float]:
    """Return the cubic of a cell, between corners c + 1 and c + 2, by its power series in [0, 1]."""
    a0, a1, a2, a3 = corner[c], corner[c + 1], corner[c + 2], corner[c + 3]
    return a1, 0.5 * (a2 - a0), a0 - 2.5 * a1 + 2.0 * a2 - 0.5 * a3, 0.5 * (a3 - a0) + 1.5 * (a1 - a2)


@kernel
def _octave_at(surface: Surface, j: int, place: int) -> float:
    """Return the octave j's height (m) at a place."""
    level = OCTAVES - 1 - j
    shifted = place + surface.offset[j]
    cell = shifted >> level
    for c in range(4):
        surface.corner[c] = surface.height[j] * TO_HEIGHT * drawn(surface.seed[j], cell + c)
    c0, c1, c2, c3 = _cubic(surface.corner, 0)
    t = (shifted - (cell << level)) / (1 << level)
    return c0 + t * (c1 + t * (c2 + t * c3))


@kernel
def _ripple_at(surface: Surface, place: int) -> float:
    """Return the corrugation's height (m) at a place."""
    turns = surface.turns * place
    return surface.ripple * math.cos(2.0 * math.pi * (turns - math.floor(turns)))


@kernel
def read_heights(
    surface: Surface, place: int, stride: int, gains: View[float], ripple_gain: float, z: View[float]
) -> None:
    """Read the profile's heights (m) at BLOCK points from a place on, `stride` places, a power of 2, from each other.

    Meanwhile the octaves' gains and the corrugation's go evenly to others. A block begins where the last one ended;
    where it does not, `made_for` is to be 0.
    """
    if surface.made_for != stride:
        # Make the weights of the lattices' heights at points from a place on.
        surface.made_for = stride
        for j in range(OCTAVES):
            level = OCTAVES - 1 - j
            points = (1 << level) // stride
            if not 1 < points < BLOCK:
                continue
            table = _table_of(points)
            shifted = place + surface.offset[j]
            for i in range(max(points, LANES)):
                row = (table + i // LANES) * TAPS * LANES + i % LANES
                if i % LANES == 0:
                    first = (shifted + i * stride) >> level
                for tap in range(TAPS):
                    surface.weights[row + tap * LANES] = 0.0
                cell = (shifted + i * stride) >> level
                t = (shifted + i * stride - (cell << level)) / (1 << level)
                row += (cell - first) * LANES
                w0, w1, w2, w3 = cubic_weights(t)
                surface.weights[row], surface.weights[row + LANES] = w0, w1
                surface.weights[row + 2 * LANES], surface.weights[row + 3 * LANES] = w2, w3
    for i in range(BLOCK):
        z[i] = 0.0
    c0 = c1 = c2 = c3 = c4 = 0.0
    for j in range(OCTAVES):
        gain, rise = surface.gain[j], (gains[j] - surface.gain[j]) / BLOCK
        surface.gain[j] = gains[j]
        if gain == 0.0 and rise == 0.0:
            continue
        level = OCTAVES - 1 - j
        shifted = place + surface.offset[j]
        cell, last = shifted >> level, (shifted + (BLOCK - 1) * stride) >> level
        if cell == last:
            # Add octave j over a block that lies in one of its cells: a power series in the points' number.
            t, step = (shifted - (cell << level)) / (1 << level), stride / (1 << level)
            _enter(surface, j, cell, 4)
            b0, b1, b2, b3 = _cubic(surface.corner, 0)
            a0, a1 = b0 + t * (b1 + t * (b2 + t * b3)), step * (b1 + t * (2.0 * b2 + 3.0 * t * b3))
            a2, a3 = step * step * (b2 + 3.0 * t * b3), step * step * step * b3
            gain += rise
            c0, c1, c2 = c0 + gain * a0, c1 + (gain * a1 + rise * a0), c2 + (gain * a2 + rise * a1)
            c3, c4 = c3 + (gain * a3 + rise * a2), c4 + rise * a3
            continue
        points = (1 << level) // stride
        if points >= BLOCK:
            # Add octave j, of whose cells a block meets two at most.
            step = stride / (1 << level)
            since = (shifted - (cell << level)) / (1 << level)
            _enter(surface, j, cell, 5)
            a0, a1, a2, a3 = _cubic(surface.corner, 0)
            b0, b1, b2, b3 = _cubic(surface.corner, 1)
            for i in range(BLOCK):
                t = since + i * step
                here = a0 + t * (a1 + t * (a2 + t * a3))
                u = t - 1.0
                there = b0 + u * (b1 + u * (b2 + u * b3))
                z[i] += (gain + (i + 1) * rise) * (here if t < 1.0 else there)
        elif points > 1:
            # Add octave j, of whose cells a block meets many, by weights: its points lie alike in each block.
            _enter(surface, j, cell, last - cell + 4)
            table, repeats = _table_of(points), max(points // LANES, 1) - 1
            for g in range(BLOCK // LANES):
                c = ((shifted + g * LANES * stride) >> level) - cell
                at = (table + (g & repeats)) * TAPS * LANES
                b = dot(surface.corner, c, 0, (1.0,))
                if points >= LANES:
                    heights = dot(surface.weights, at, LANES, (b[0], b[1], b[2], b[3], b[4]))
                else:
                    heights = dot(surface.weights, at, LANES, b)
                add_product(z, g * LANES, heights, _gains(gain, rise, g * LANES))
        elif points == 1:
            # Add octave j, of whose cells each holds one point of a block, all at one place in their cells.
            _enter(surface, j, cell, BLOCK + 3)
            weights = cubic_weights((shifted - (cell << level)) / (1 << level))
            for g in range(BLOCK // LANES):
                heights = dot(surface.corner, g * LANES, 1, weights)
                add_product(z, g * LANES, heights, _gains(gain, rise, g * LANES))
        else:
            for i in range(BLOCK):
                z[i] += (gain + (i + 1) * rise) * _octave_at(surface, j, place + i * stride)
    for i in range(BLOCK):
        z[i] += c0 + i * (c1 + i * (c2 + i * (c3 + i * c4)))
    if surface.variation.spread > 0.0:
        # The heights are as rough as the surface is there: as at the block's ends, and evenly from one to the other.
        local = local_roughness(surface.variation, place)
        rise = (local_roughness(surface.variation, place + BLOCK * stride) - local) / BLOCK
        for i in range(BLOCK):
            z[i] *= local + i * rise
    gain, rise = surface.ripple_gain, (ripple_gain - surface.ripple_gain) / BLOCK
    surface.ripple_gain = ripple_gain
    if surface.ripple > 0.0:
        for i in range(BLOCK):
            z[i] += (gain + (i + 1) * rise) * _ripple_at(surface, place + i * stride)


@kernel
def _gains(gain: float, rise: float, begin: int) -> tuple[float, float, float, float, float, float, float, float]:
    """Return an octave's gains at LANES points of a block from one on."""
    if rise == 0.0:
        return gain, gain, gain, gain, gain, gain, gain, gain
    first = gain + (begin + 1) * rise
    return (
        first, first + rise, first + 2.0 * rise, first + 3.0 * rise,
        first + 4.0 * rise, first + 5.0 * rise, first + 6.0 * rise, first + 7.0 * rise,
    )  # fmt: skip


@kernel
def _table_of(points: int) -> int:
    """Return the first of the tables, one for LANES points, of octaves that have so many points in a cell."""
    table = 0
    for n in range(len(_CELLS)):
        if _CELLS[n] == points:
            return table
        table += max(_CELLS[n] // LANES, 1)
    return table


@c_function(None, c_void_p, c_void_p, c_int64)
def _begin(surface: int, profile: int, seed: int) -> None:
    begin_surface(carray(surface, (1,), SURFACE)[0], carray(profile, (1,), PROFILE)[0], seed)


@c_function(None, c_void_p, c_void_p, c_void_p, c_int64)
def _read(surface: int, places: int, values: int, count: int) -> None:
    z: View[float] = carray(values, (count,), np.float64)
    _heights(carray(surface, (1,), SURFACE)[0], carray(places, (count,), np.int64), z)


@kernel
def _heights(surface: Surface, places: View[int], z: View[float]) -> None:
    for i in range(len(places)):
        z[i] = 0.0
        for j in range(OCTAVES):
            if surface.gain[j] > 0.0:
                z[i] += surface.gain[j] * _octave_at(surface, j, places[i])
        z[i] *= local_roughness(surface.variation, places[i])
        z[i] += surface.ripple_gain * _ripple_at(surface, places[i])


def make_surface(
    roughness: float,
    correlation: float,
    slope: float = 2.0,
    ripple: float = 0.0,
    wavelength: float = 1.0,
    variation: float = 0.0,
    variation_length: float = 0.05,
    seed: int = 0,
) -> np.void:
    """Make a rough surface that neither ends nor repeats.

    Parameters
    ----------
    roughness : float
        Rms height, m, at least 0.
    correlation : float
        Correlation length l, m, above 0.
    slope : float, default 2
        Slope beta of the power spectrum above 1/l, 1 to 5.
    ripple, wavelength : float, default 0, 1
        Amplitude and wavelength of a corrugation, m.
    variation : float, default 0
        Standard deviation of the local roughness, 0 to 12 dB.
    variation_length : float, default 0.05
        Length over which it changes, m.
    seed : int, default 0
        Seed of the heights.

    Returns
    -------
    SURFACE record
        The surface.

    Raises
    ------
    ValueError
        An argument is out of range; the text names it.
    """
    surface = np.zeros(1, SURFACE)
    profile = np.zeros(1, PROFILE)
    profile[0] = (
        checked("roughness", roughness, 0.0, strict=False),
        checked("correlation", correlation, 0.0),
        checked("slope", slope, 1.0, 5.0),
        checked("ripple", ripple, 0.0, strict=False),
        checked("wavelength", wavelength, 0.0),
        checked("variation", variation, 0.0, MOST_VARIATION, strict=False),
        checked("variation_length", variation_length, 0.0),
    )
    seed = int(checked("seed", seed, 0, 2.0**53, strict=False))
    _begin(surface.ctypes.data, profile.ctypes.data, seed)
    made: np.void = surface[0]
    return made


def heights(surface: np.void, places: ArrayLike) -> NDArray[np.float64]:
    """Return the heights of a surface.

    Parameters
    ----------
    surface : SURFACE record
        As `make_surface` returns it.
    places : int or array
        Places, in units of `surface["unit"]` metres.

    Returns
    -------
    array
        float64 of the same shape, m.
    """
    where = np.ascontiguousarray(places, np.int64)
    z = np.empty(np.shape(places))
    _read(np.asarray(surface).ctypes.data, where.ctypes.data, z.ctypes.data, z.size)
    return z
