"""The motions of a rectangular section whose bar twists: it turns, warps along the bar, and is distorted in its plane.

Where the angle theta changes along x, to the second order of the section's sides over the wave's length, a point moves
by

    u = phi theta' along the bar,    (v, w) = (-z, y) theta + d theta'' in the section.

phi is Saint-Venant's warping (Timoshenko and Goodier, Theory of Elasticity, art. 109). d is what is left to the section
by two things: the warping stretches the bar, which narrows there by Poisson's ratio, and the shear stress changes along
x, which pulls at the section as its turning masses do. With them, the speed of waves is that of the solid to that
order: derived here. Each of the section's motions has an unknown of its own along the bar, as the warping has in S. U.
Benscoter's theory (J. Appl. Mech. 21, 1954), so that it holds near the ends, too, where theta'' is not what it is in a
wave. The two parts of d have one each.

Across the grain, a material of a shear modulus of its own counts as an isotropic one of that.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from .material import Array

MOTIONS = 4
"""The number of motions of a section: it turns, it warps, and it is distorted in two ways."""
_DEGREE = 7  # of the polynomials in the section
_SERIES = np.arange(1.0, 40.0, 2.0)  # Saint-Venant's falls as n^-5
_ODD, _EVEN = np.arange(1, _DEGREE + 1, 2), np.arange(0, _DEGREE + 1, 2)
_STEP = 1e-4  # of a thickness, by which a section is differentiated
_STIFFEST = 0.49  # Poisson's ratio
_LEAST = 1e-3  # of its size: at 0 a stretched bar narrows nowhere, and one of both distortions is none
_NODES = 12  # of the sections between which those of a carved bar are found
_TERMS = {"u": (_ODD, _ODD), "v": (_EVEN, _ODD), "w": (_ODD, _EVEN)}  # in y and z, of a twist


class Constants(NamedTuple):
    """Integrals over sections of width 1, of products of two motions a and b, (p, 4, 4) each.

    With unknowns f(x): 1/2 int e f' stretch f' + f' slope f' + 2 f' mixed f + f value f is the elastic energy over the
    shear modulus, e Young's modulus over that; 1/2 int f. mass f. the kinetic one over the density. changing (p, 2):
    those of the warping and its derivative by the thickness, and of that squared, by which a carved bar is stretched.
    """

    stretch: Array
    slope: Array
    mixed: Array
    value: Array
    mass: Array
    changing: Array


def constants(ratio: Array, poisson_ratio: float) -> Constants:
    """Return the constants of sections by their thickness over their width (p,)."""
    nu = min(math.copysign(max(abs(poisson_ratio), _LEAST), poisson_ratio), _STIFFEST)
    low, high = float(ratio.min()), float(ratio.max())
    if high - low < 1e-9 * high:
        return Constants(*(np.broadcast_to(each, (len(ratio), *each.shape)) for each in _section(low, nu)))
    turns = np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)
    found = [_section((low + high + turn * (high - low)) / 2, nu) for turn in turns]
    at = np.polynomial.chebyshev.chebvander((2 * ratio - low - high) / (high - low), _NODES - 1)
    onto = at @ np.linalg.inv(np.polynomial.chebyshev.chebvander(turns, _NODES - 1))
    return Constants(*(np.tensordot(onto, np.stack(each), 1) for each in zip(*found, strict=True)))


@lru_cache(maxsize=64)
def _section(ratio: float, nu: float) -> Constants:
    """Return the constants of one section."""
    lame, plane = 2 * nu / (1 - 2 * nu), 1 / (1 - 2 * nu)  # Lamé's first modulus, and that with the second, over G
    turning, warping, bent = _fields(ratio, nu)
    u = np.outer([0, 1, 0, 0], warping)
    v, w = (np.stack([turning[i], 0 * turning[i], bent[0][i], bent[1][i]]) for i in (0, 1))

    def product(one: Array, other: Array, first: str, second: str) -> Array:
        return np.asarray(one @ _integrals(ratio, first, second) @ other.T)

    stretch = product(u, u, "u", "u")
    narrowed = product(u, v, "u", "vy") + product(u, w, "u", "wz")  # what the section's own stretch does along u
    mass = stretch + product(v, v, "v", "v") + product(w, w, "w", "w")
    across = product(v, w, "vy", "wz")
    shear = product(v, w, "vz", "wy")
    both = product(v, v, "vy", "vy") + product(w, w, "wz", "wz")
    value = (lame + 2) * both + lame * (across + across.T) + shear + shear.T
    value += product(v, v, "vz", "vz") + product(w, w, "wy", "wy")
    value += product(u, u, "uy", "uy") + product(u, u, "uz", "uz")
    mixed = 2 * nu * plane * narrowed + product(v, u, "v", "uy") + product(w, u, "w", "uz")
    slope = 4 * nu**2 * plane * stretch + mass - stretch
    # Polynomials stiffen a thin section's twist a little, as they can't follow the stress at its edges.
    slope[0, 0] += _saint_venant(ratio) - (slope[0, 0] + 2 * mixed[0, 1] + value[1, 1])
    change = _warping_change(ratio)
    same = _integrals(ratio, "u", "u")
    return Constants(stretch, slope, mixed, value, mass, np.array([warping @ same @ change, change @ same @ change]))


def _saint_venant(ratio: float) -> float:
    """Return Saint-Venant's constant of torsion of a section of width 1 (Timoshenko and Goodier, art. 109)."""
    long, short = max(1.0, ratio), min(1.0, ratio)
    series = float((np.tanh(_SERIES * np.pi / 2 * long / short) / _SERIES**5).sum())
    return long * short**3 / 3 * (1 - 192 / np.pi**5 * short / long * series)


Pair = tuple[Array, Array]


def _fields(ratio: float, nu: float) -> tuple[Pair, Array, tuple[Pair, Pair]]:
    """Return the series of a section that turns (v, w), its warping u, and both ways in which it is distorted (v, w).

    The first way is what both causes do together in a long wave, the second how one differs from the other.
    """
    lame, plane = 2 * nu / (1 - 2 * nu), 1 / (1 - 2 * nu)

    def of(first: str, second: str) -> Array:
        return _integrals(ratio, first, second)

    turning, driven, warping = _turning(ratio)
    polar = turning[0] @ of("v", "v") @ turning[0] + turning[1] @ of("w", "w") @ turning[1]
    speed = 1 - driven @ warping / polar  # squared, over that of shear

    stiffness = np.block([
        [(lame + 2) * of("vy", "vy") + of("vz", "vz"), lame * of("vy", "wz") + of("vz", "wy")],
        [lame * of("wz", "vy") + of("wy", "vz"), (lame + 2) * of("wz", "wz") + of("wy", "wy")],
    ])  # fmt: skip
    own = np.concatenate(turning)
    heavy = np.concatenate([of("v", "v") @ turning[0], of("w", "w") @ turning[1]])
    stretched = -2 * nu * plane * np.concatenate([of("vy", "u") @ warping, of("wz", "u") @ warping])
    sheared = np.concatenate([of("v", "uy") @ warping, of("w", "uz") @ warping]) + (1 - speed) * heavy
    # Its own turning strains nothing: that is held.
    found = np.linalg.solve(stiffness + np.outer(heavy, heavy) / polar, np.stack([stretched, sheared], axis=1)).T
    found -= np.outer(found @ heavy / polar, own)
    size = len(turning[0])
    weigh = np.concatenate([np.diag(of("v", "v")), np.diag(of("w", "w"))])
    long = found.sum(axis=0)
    other = found[0] - long * ((found[0] * weigh) @ long / ((long * weigh) @ long))
    first, second = ((each[:size], each[size:]) for each in (long, other))
    return turning, warping, (first, second)


def _turning(ratio: float) -> tuple[Pair, Array, Array]:
    """Return the series of a section that turns, what drives its warping, and the warping."""
    turning = -_series("v", (0, 1), ratio / 2), _series("w", (1, 0), 0.5)
    of = [_integrals(ratio, *each) for each in (("uy", "v"), ("uz", "w"), ("uy", "uy"), ("uz", "uz"))]
    driven = -(of[0] @ turning[0] + of[1] @ turning[1])
    return turning, driven, np.asarray(np.linalg.solve(of[2] + of[3], driven), np.float64)


def _warping_change(ratio: float) -> Array:
    """Return the series of the warping's derivative by the thickness, at a place that stays."""
    step = _STEP * ratio
    series = [_turning(ratio + sign * step)[2] for sign in (-1, 0, 1)]
    values, slopes, weights, nodes = _polynomials()
    norm = np.arange(_DEGREE + 1)[:, None] + 0.5
    moved = norm * (values.T * (weights * nodes)) @ slopes  # zeta times the slope
    moving = np.kron(np.eye(len(_ODD)), moved[np.ix_(_ODD, _ODD)]) @ series[1] / ratio
    return np.asarray((series[2] - series[0]) / (2 * step) - moving)


def _series(of: str, orders: tuple[int, int], scale: float) -> Array:
    """Return the series of a term P_k(eta) P_l(zeta), eta and zeta in -1..1, times a scale."""
    y, z = _TERMS[of]
    return np.kron(y == orders[0], z == orders[1]) * scale


def _integrals(ratio: float, first: str, second: str) -> Array:
    """Return the integrals over a section of products of two of its terms: of u, v or w, or of a slope, as `uy`."""
    whole, powers = _plain(first, second)
    return whole * (0.5 ** (1 - powers[0]) * (0.5 * ratio) ** (1 - powers[1]))


def _polynomials() -> tuple[Array, Array, Array, Array]:
    """Return Legendre's polynomials and their slopes at the nodes of a quadrature over -1..1, its weights and nodes."""
    nodes, weights = legendre.leggauss(_DEGREE + 1)
    slopes = np.stack([legendre.legval(nodes, legendre.legder(row)) for row in np.eye(_DEGREE + 1)], axis=1)
    values = np.asarray(legendre.legvander(nodes, _DEGREE), np.float64)
    return values, np.asarray(slopes, np.float64), weights, nodes


@lru_cache(maxsize=64)
def _plain(first: str, second: str) -> tuple[Array, tuple[int, int]]:
    """Return the same over -1..1 in both directions, and how many slopes are taken along each."""
    values, slopes, weights, _ = _polynomials()
    parts, powers = [], []
    for number, axis in enumerate("yz"):
        one, other = (slopes if axis in each[1:] else values for each in (first, second))
        parts.append(one[:, _TERMS[first[0]][number]].T * weights @ other[:, _TERMS[second[0]][number]])
        powers.append((axis in first[1:]) + (axis in second[1:]))
    return np.asarray(np.kron(*parts), np.float64), (powers[0], powers[1])
