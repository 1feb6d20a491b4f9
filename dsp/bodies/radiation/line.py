"""Slender bodies, bars, rods and tubes, as lines that move across their length.

R = (rho c k b/(2 pi)) int_0^pi |V(k cos t)|^2 S(k b sin t) dt, V(q) = int phi exp(-i q x) dx: t is the angle to the
axis, S the resistance per length, over rho c b, of an endless line of that section. A free bar's modes carry no net
momentum: the integral knows. Waves slower than sound radiate from the ends: there the air that moves along with a flat
bar is that of a rectangle. Of a thick bar S is that of its section (`thick`).
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ...numerics.bessel import spherical_bessel
from ..air import DENSITY, IMPEDANCE, Load, wavenumber
from ..material import Array
from ..ritz import legendre_at
from .closed import cylinder_efficiency
from .quadrature import segment
from .rectangle import far_rectangle, jump_terms, side
from .strip_table import MASS, REACH, RESISTANCE
from .thick import swaying

_NEGLIGIBLE = 24  # orders above the argument, from which on spherical Bessel functions are less than 1e-9
_LEAST = 1e-9  # rad/m
_FAST = 2.5  # times the speed of sound: slower modes of flat bars are those of a rectangle
_MARGIN, _MOST_TERMS = 6, 450  # terms beyond those that the waves need, and of the largest rectangle
_ASPECTS = (0.0, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
_ADDED = (1.0, 1.14, 1.21, 1.36, 1.51, 1.70, 1.98, 2.23)
"""Added area of a rectangle that moves across its width w = 2 b, over pi b^2, by thickness over width (Brennen, A
review of added mass and fluid inertial forces, 1982)."""


class Outline(NamedTuple):
    """A bar's section as the air feels it.

    Half its width (or its radius), m; at places along the bar the area (m^2) that it displaces, and the area of the
    air that moves along with it. aspect: its thickness, along which it moves, over its width, on average.
    """

    half_width: float
    displaced: Array
    added: Array
    is_round: bool
    aspect: float = 0.0


def added_of(aspect: float) -> float:
    """Return the air that moves along with a section of a thickness over its width, over that of a flat strip of its
    width."""
    return float(np.interp(aspect, _ASPECTS, _ADDED))


def rectangular(width: float, depth: Array) -> Outline:
    """Return the outline of a bar that moves across its width, `depth` (m) thick at places along it."""
    added = np.interp(depth / width, _ASPECTS, _ADDED) * math.pi * (width / 2) ** 2
    return Outline(width / 2, width * depth, added, False, float(np.mean(depth)) / width)


def on_edge(width: float, depth: Array) -> Outline:
    """Return the outline of the same bar as it moves along its width, its edges foremost."""
    added = np.interp(width / depth, _ASPECTS, _ADDED) * math.pi * (depth / 2) ** 2
    return Outline(float(depth.max()) / 2, width * depth, added, False, width / float(np.mean(depth)))


def tubular(diameter: float, bore: float, x: Array) -> Outline:
    """Return the outline of a tube or rod at places x; the air in its bore moves along."""
    area = np.full_like(x, math.pi / 4 * diameter**2)
    return Outline(diameter / 2, area, area + math.pi / 4 * bore**2, True)


class Bar(NamedTuple):
    """Modes of a bar at nodes x (p,) in -1..1 of a quadrature of weights (p,).

    Shapes and their slopes by length (p, n), mass-normalised: polynomials of fewer than `terms` terms. Half the length
    in m.
    """

    nodes: Array
    weights: Array
    terms: int
    shapes: Array
    slopes: Array
    half: float
    outline: Outline


def mass_of(bar: Bar, frequency: Array) -> Array:
    """Return the air's share of a bar's modal masses at frequencies (Hz): an endless bar's, by the waves that run along
    it."""
    share = bar.weights[:, None] * bar.half
    steep = _mean_square(bar, bar.slopes) / _mean_square(bar, bar.shapes) - wavenumber(frequency) ** 2
    along = np.sqrt(np.abs(steep)) * bar.outline.half_width
    moved = np.where(steep > 0, 1 / (1 + math.pi / 4 * along), _strip_mass(along))  # slower than sound, or faster
    mass: Array = DENSITY * (share * bar.outline.added[:, None] * bar.shapes**2).sum(axis=0) * moved
    return mass


def load_of(bar: Bar, frequency: Array) -> Load:
    """Return the air's load on a bar's modes at frequencies (Hz)."""
    k = wavenumber(frequency)
    resistance = np.empty_like(k)
    octave = np.floor(np.log2(np.maximum(k, _LEAST)))
    for each in np.unique(octave):
        mine = octave == each
        resistance[mine] = _resistance(bar, bar.shapes[:, mine], k[mine])
    if not bar.outline.is_round:
        wave = np.sqrt(_mean_square(bar, bar.slopes) / _mean_square(bar, bar.shapes))
        shortest = np.maximum(wave, k)
        terms = (shortest * bar.half + _MARGIN) * (shortest * bar.outline.half_width + _MARGIN)
        for i in np.flatnonzero((k < _FAST * wave) & (terms < _MOST_TERMS)):
            resistance[i] = _of_rectangle(bar, bar.shapes[:, i], float(k[i]), float(shortest[i]))
    return Load(resistance, mass_of(bar, frequency))


def _mean_square(bar: Bar, values: Array) -> Array:
    mean: Array = bar.half * (bar.weights @ values**2)
    return mean


def _of_rectangle(bar: Bar, shape: Array, k: float, wave: float) -> float:
    """Return the resistance of a mode that is not much faster than sound: its ends radiate, and a line does not know
    them.

    The air that moves along does so as about a flat rectangle, as wide and as long, and fades at the ends: exact where
    the bar is thin. The air that the bar displaces does not fade there: it is a line. Each wave along the bar radiates
    by so much more than of the flat one as an endless bar's does.
    """
    half_width, displaced, added, _, aspect = bar.outline
    counts = [math.ceil(wave * half) + _MARGIN for half in (bar.half, half_width)]
    fading = shape * (1 + (added / added.max() - 1) / (1 + (k * half_width) ** 2))
    series = legendre_at(bar.nodes, bar.terms).T @ (bar.weights * fading)
    series *= np.arange(bar.terms) + 0.5

    def along(at: Array) -> Array:
        return np.asarray(legendre_at(2 * at - 1, bar.terms) @ series)[:, None]

    def across(at: Array) -> Array:
        return np.ones((at.size, 1))

    b = jump_terms(counts[0], along, bar.half)
    c = jump_terms(counts[1], across, half_width)
    parts = {(odd, 0): b[odd::2, None] * c[None, 0::2] for odd in (0, 1)}
    largest = max((part**2).sum() for part in parts.values())
    parts = {odd: part for odd, part in parts.items() if (part**2).sum() > 1e-12 * largest}
    far = far_rectangle(k, side(bar.half, counts[0]), side(half_width, counts[1]), parts)
    x = k * half_width * far.cosine
    low = 1 / (1 + x**2)
    dipole = displaced.max() + added.max()
    share = displaced.max() / dipole * low
    flat = _strip_resistance(x)
    pushed = flat - 1j * math.pi * x * _strip_mass(x)  # by an endless strip of unit velocity
    endless = pushed / np.abs(pushed) * half_width**2 * np.sqrt(math.pi / 2 * flat / x**3)
    line = _spectrum(bar, (shape * displaced / displaced.max())[:, None], _bessel(bar.terms, far.x[None]))
    power = sum(
        np.abs((1 - share) * fades + share * line[odd][0] * endless) ** 2 for odd, fades in far.amplitude.items()
    )
    excess = (dipole / (math.pi * half_width**2)) ** 2 - 1
    return float(2 * IMPEDANCE * k * (far.weights * power * (1 + excess * low**2)) @ swaying(x, aspect))


def _bessel(terms: int, phase: Array) -> Array:
    """Return spherical Bessel functions of q half (n, d), of as many orders as count: (terms at most, n, d)."""
    return spherical_bessel(min(terms, math.ceil(phase.max()) + _NEGLIGIBLE), phase)


def _resistance(bar: Bar, shapes: Array, k: Array) -> Array:
    half_width, displaced, added, is_round, aspect = bar.outline
    angle, weights = segment(0, math.pi / 2, 16 + 0.8 * bar.half * k.max())
    x = np.outer(k * half_width, np.sin(angle))
    phase = np.outer(k * bar.half, np.cos(angle))
    dipole = displaced + added
    varies = not is_round and dipole.min() < dipole.max() * (1 - 1e-9)
    most = bar.nodes.size // 2 if varies else bar.terms
    bessel = _bessel(most, phase)
    even, odd = _spectrum(bar, shapes, bessel[: bar.terms])
    if is_round:
        power = (even**2 + odd**2) * _round_resistance(x)
    else:
        largest = dipole.max()
        low = 1 / (1 + x**2)
        if varies:
            other = _spectrum(bar, shapes * (dipole / largest)[:, None], bessel)
            even, odd = even + (other[0] - even) * low, odd + (other[1] - odd) * low
        excess = (largest / (math.pi * half_width**2)) ** 2 - 1
        power = (even**2 + odd**2) * _strip_resistance(x) * (1 + excess * low**2) * swaying(x, aspect)
    resistance: Array = IMPEDANCE * k * half_width / math.pi * (power @ weights)
    return resistance


def _spectrum(bar: Bar, shapes: Array, bessel: Array) -> tuple[Array, Array]:
    """Return the even and the odd part of V (n, d), from spherical Bessel functions of q half (terms, n, d), which
    Legendre series become."""
    terms = len(bessel)
    legendre = legendre_at(bar.nodes, terms) * bar.weights[:, None]
    degree = np.arange(terms)[:, None]
    series = (2 * degree + 1) * (-1.0) ** (degree // 2) * (legendre.T @ shapes)
    even, odd = (np.einsum("dn,dnp->np", series[side::2], bessel[side::2]) for side in (0, 1))
    return bar.half * even, bar.half * odd


@cache
def _tables() -> tuple[Array, Array, Array, Array]:
    """Return ln x, and there ln of the resistances of a flat strip and of a cylinder, and the strip's mass."""
    x = np.geomspace(*REACH, len(RESISTANCE))
    return np.log(x), np.log(RESISTANCE), np.log(math.pi * cylinder_efficiency(1, x)), np.array(MASS)


def _strip_resistance(x: Array) -> Array:
    """Return the resistance of an endless flat strip that moves along its normal, per length and over rho c b, at x = k
    b."""
    grid, strip, _, _ = _tables()
    return _interpolated(x, grid, strip, math.pi**2 / 8, 4.0)


def _round_resistance(x: Array) -> Array:
    """Return the resistance of an endless cylinder that moves across itself, per length and over rho c a, at x = k
    a."""
    grid, _, cylinder, _ = _tables()
    return _interpolated(x, grid, cylinder, math.pi**2 / 2, math.pi)


def _interpolated(x: Array, grid: Array, logarithm: Array, low: float, high: float) -> Array:
    """Interpolate linearly in logarithms; low x^3 and `high` beyond the table's ends."""
    at = np.log(np.maximum(x, 1e-12))
    within = np.exp(np.interp(at, grid, logarithm))
    return np.where(at < grid[0], low * x**3, np.where(at > grid[-1], high, within))


def _strip_mass(x: Array) -> Array:
    """Return the air's mass on an endless flat strip, over rho pi b^2."""
    grid, _, _, mass = _tables()
    return np.interp(np.log(np.maximum(x, 1e-12)), grid, mass, 1.0, 0.0)
