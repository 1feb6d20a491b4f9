"""The surface that a body rolls on: a rough profile that never ends, never repeats and needs no memory.

The profile z(s) is a sum of octaves of smooth noise. Octave j has random heights on a lattice of spacing
`longest`/2^j, each a hash of its number, the octave and the seed, joined by Catmull-Rom cubics; its variance falls as
2^(-j (beta - 1)), so the power spectrum is flat up to about 1/(2 pi l) and falls as wavenumber^-beta beyond, l being
the correlation length. On top there may be a periodic corrugation.

Places are whole numbers of the finest lattice's `unit`, in 64 bits: a millimetre's roughness stays exact for millions
of kilometres. How much of an octave is heard is up to who reads: `gain`.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..native.jit import kernel
from ..numerics.checks import checked
from ..numerics.random import STEP, mixed

OCTAVES = 16

_LONGEST = 2.0
"""Spacing of the first lattice in correlation lengths: where beta = 2, the autocorrelation is 1/e at l."""

# The cubic through lattice heights 1 and 2, with slopes from 0 and 3; and the mean of its squared weights.
_CUBIC = 0.5 * np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]], np.float64)
_POWER = float(np.trace(_CUBIC.T @ (1 / (np.arange(4)[:, None] + np.arange(4) + 1)) @ _CUBIC))

CREST = math.sqrt(3.0 / _POWER) * 1.25
"""Greatest height of an octave over its rms height."""

_TO_UNIFORM = 2.0 * math.sqrt(3.0 / _POWER) * 2.0**-53
_HALF = 2.0**52

SURFACE = np.dtype(
    [
        ("unit", np.float64),  # m between places
        ("height", np.float64, OCTAVES),  # rms, m
        ("seed", np.uint64, OCTAVES),
        ("offset", np.int64, OCTAVES),  # places by which the lattices are moved against each other
        ("ripple", np.float64),  # amplitude of the corrugation, m
        ("turns", np.float64),  # of the corrugation, for each place
        # How much of each octave is read, and the cubic it is on.
        ("gain", np.float64, OCTAVES),
        ("ripple_gain", np.float64),
        ("cell", np.int64, OCTAVES),
        ("corner", np.float64, (OCTAVES, 4)),  # lattice heights around it
        ("cubic", np.float64, (4, OCTAVES)),
    ],
    align=True,
)
"""A surface as it is read."""


@kernel
def begin_surface(surface, roughness, correlation, slope, ripple, wavelength, seed):
    """Set a surface up: `roughness` is its rms height without the corrugation; lengths in m."""
    surface.unit = _LONGEST * correlation * 0.5 ** (OCTAVES - 1)
    total = 0.0
    share = 1.0
    for _ in range(OCTAVES):
        total += share
        share *= 2.0 ** (1.0 - slope)
    share = 1.0
    bits = mixed(np.uint64(seed) + STEP)
    for j in range(OCTAVES):
        surface.height[j] = roughness * math.sqrt(share / total)
        share *= 2.0 ** (1.0 - slope)
        bits += STEP
        surface.seed[j] = mixed(bits)
        surface.offset[j] = np.int64(surface.seed[j] >> np.uint64(31))
        surface.gain[j] = 1.0
        surface.cell[j] = np.iinfo(np.int64).min
    surface.ripple = ripple
    surface.ripple_gain = 1.0
    surface.turns = surface.unit / wavelength


@kernel
def _enter(surface, j, cell):
    """Put octave j on the cubic of a lattice cell."""
    following = cell == surface.cell[j] + 1
    surface.cell[j] = cell
    for corner in range(4):
        if following and corner < 3:
            surface.corner[j, corner] = surface.corner[j, corner + 1]
        else:
            bits = mixed(np.uint64(cell + corner) * STEP + surface.seed[j])
            surface.corner[j, corner] = (
                surface.height[j] * _TO_UNIFORM * (np.float64(np.int64(bits >> np.uint64(11))) - _HALF)
            )
    for power in range(4):
        value = 0.0
        for corner in range(4):
            value += _CUBIC[power, corner] * surface.corner[j, corner]
        surface.cubic[power, j] = value


@kernel
def height_at(surface, place):
    """The profile's height in m at a place; cheapest where places come one after the other."""
    z = 0.0
    for j in range(OCTAVES):
        if surface.gain[j] > 0.0:
            shifted = place + surface.offset[j]
            level = OCTAVES - 1 - j
            cell = shifted >> level
            if cell != surface.cell[j]:
                _enter(surface, j, cell)
            t = (shifted - (cell << level)) * 0.5**level
            cubic = surface.cubic[0, j] + t * (
                surface.cubic[1, j] + t * (surface.cubic[2, j] + t * surface.cubic[3, j])
            )
            z += surface.gain[j] * cubic
    if surface.ripple > 0.0:
        turns = surface.turns * place
        z += surface.ripple_gain * surface.ripple * math.cos(2.0 * math.pi * (turns - math.floor(turns)))
    return z


@kernel
def _begin(surface, roughness, correlation, slope, ripple, wavelength, seed):
    begin_surface(surface, roughness, correlation, slope, ripple, wavelength, seed)


@kernel
def _heights(surface, places, z):
    for i in range(len(places)):
        z[i] = height_at(surface, places[i])


def make_surface(
    roughness: float,
    correlation: float,
    slope: float = 2.0,
    ripple: float = 0.0,
    wavelength: float = 1.0,
    seed: int = 0,
) -> np.void:
    """A surface, as a SURFACE record.

    roughness: rms height in m, >= 0; correlation: length l in m, > 0; slope: beta of the power spectrum above 1/l, in
    (1, 5]; ripple, wavelength: amplitude (m, >= 0) and wavelength (m, > 0) of a corrugation. ValueError names what is
    out of range.
    """
    surface: np.void = np.zeros(1, SURFACE)[0]
    _begin(
        surface,
        float(checked("roughness", roughness, 0.0, strict=False)),
        float(checked("correlation", correlation, 0.0)),
        float(checked("slope", slope, 1.0, 5.0)),
        float(checked("ripple", ripple, 0.0, strict=False)),
        float(checked("wavelength", wavelength, 0.0)),
        int(checked("seed", seed, 0, 2.0**53, strict=False)),
    )
    return surface


def heights(surface: np.void, places: ArrayLike) -> NDArray[np.float64]:
    """Heights in m at places (whole numbers of surface["unit"] metres), of their shape."""
    where = np.atleast_1d(np.asarray(places, np.int64))
    z = np.empty(where.shape)
    _heights(surface, where.ravel(), z.reshape(-1))
    return z.reshape(np.shape(places))
