"""Shear coefficients of bars' sections, by which a bar that bends is the solid body to the second order of its depth
over the wave's length (J. R. Hutchinson, "Shear Coefficients for Timoshenko Beam Theory", J. Appl. Mech. 68, 2001).

Those of G. R. Cowper (J. Appl. Mech. 33, 1966) know the static shear alone: bars come out too low, by 0.7 % at the
fifth mode of one of 240 x 30 x 10 mm. Hutchinson's hold how a section widens where it is pressed, too: a wide bar is
stiffer, in waves that are not much longer than it is wide. In a strip it would get stiffer without end, and in short
waves too stiff; so from a bar on that is twice as wide as it is deep the coefficient stays as it is there. Such bars
are stiffer by what a thin strip is, of G. Kirchhoff's plate with free edges, times Hutchinson's share of it in a bar
that is not thin: frequencies are within 0.3 % of the solid body's, and within 0.8 % where half a wave is as long as the
bar is wide.
"""

import math
from functools import cache

import numpy as np

from .material import Array, Material

_TERMS = np.arange(1.0, 25.0)[:, None]  # the series falls as n^-4 at least
_LEAST = 1.06  # of 1/coefficient
_WIDEST = 4.0  # from there on the coefficient is at its bound, and the series loses its digits
_PLAIN = 1.2  # 1/coefficient of a rectangle that does not widen
_FINE_TERMS = np.arange(1.0, 400.0)[:, None]
_WIDTHS = np.geomspace(0.5, 60.0, 80)  # over the depth
_PHASES = np.linspace(0.0, 40.0, 201)  # of a wave over the width, rad
_HALVINGS = 50  # of an interval in which a root lies
_TINY = 1e-12  # keeps a quotient finite, and a root below 1


def rectangles_shear(material: Material, width: Array) -> Array:
    """Return the coefficients (p,) of rectangles that bend along their depth, by their widths over it (p,)."""
    inverse = np.maximum(_inverse(material.poisson_ratio, np.minimum(width, _WIDEST), _TERMS), _LEAST)
    return np.asarray(1 / (_PLAIN + (inverse - _PLAIN) * _softness(material)))


def strips_stiffness(material: Material, width: Array, depth: Array, wavenumber: Array) -> Array:
    """Return the factors (p, n) on the bending stiffness of rectangles, of a width and depths (p,) in m, in waves of
    some wavenumbers (p, n), rad/m, beyond what their shear coefficients say: 1 where those hold."""
    ratio, nu = (width / depth)[:, None], material.poisson_ratio
    inverse, share = (np.interp(ratio, _WIDTHS, each) for each in _shares(nu))
    bound = np.maximum(np.interp(np.minimum(ratio, _WIDEST), _WIDTHS, _shares(nu)[0]), _LEAST)
    if material.shear is not None or not (inverse < bound).any():
        return np.ones_like(wavenumber)
    strip = np.interp(wavenumber * width[:, None], _PHASES, _strips(nu))
    known = (1 + nu) / 6 * (wavenumber * depth[:, None]) ** 2 * (_PLAIN - bound)
    return np.where(inverse < bound, np.maximum(1 + share * strip - known, 1.0), 1.0)


@cache
def _shares(nu: float) -> tuple[Array, Array]:
    """Return 1/coefficient of rectangles of _WIDTHS without a bound, and the share of a thin strip's stiffening that
    they have in long waves."""
    inverse = _inverse(nu, _WIDTHS, _FINE_TERMS)
    return inverse, (_PLAIN - inverse) * (1 + nu) ** 2 / (_WIDTHS * max(nu, _TINY)) ** 2


@cache
def _strips(nu: float) -> Array:
    """Return by how much a thin strip is stiffer than a bar, as a share, in waves of _PHASES.

    With Omega = omega sqrt(rho h/D)/q^2, a^2 = 1 + Omega, b^2 = 1 - Omega and c = q B/2, edges are free where (a^2 -
    nu)(b^2 - 2 + nu) b tanh(b c) = (b^2 - nu)(a^2 - 2 + nu) a tanh(a c) (Kirchhoff 1850); a bar has Omega^2 = 1 - nu^2.
    """
    c = np.maximum(_PHASES, 1e-3) / 2
    low, high = np.full_like(c, math.sqrt(1 - nu**2) * (1 - 1e-9)), np.full_like(c, 1 - _TINY)
    for _ in range(_HALVINGS):
        omega = 0.5 * (low + high)
        a, b = np.sqrt(1 + omega), np.sqrt(1 - omega)
        left = (a**2 - nu) * (b**2 - 2 + nu) * b * np.tanh(b * c)
        below = left < (b**2 - nu) * (a**2 - 2 + nu) * a * np.tanh(a * c)
        low, high = np.where(below, omega, low), np.where(below, high, omega)
    return np.asarray(low**2 / (1 - nu**2) - 1)


def _inverse(nu: float, width: Array, terms: Array) -> Array:
    """Return 1/coefficient of rectangles by their widths over their depth (p,)."""
    square = width**2
    waves = terms * np.pi / width
    series = (16 * nu**2 * width**5 * (waves - np.tanh(waves)) / ((terms * np.pi) ** 5 * (1 + nu))).sum(axis=0)
    bulk = 4 / 45 * (-12 - 15 * nu + 5 * nu * square) + series
    return np.asarray(-(9 / 4 * bulk + nu * (1 - square)) / (2 * (1 + nu)))


def tubes_shear(material: Material, bore: float) -> float:
    """Return the coefficient of a round section by its bore over its diameter."""
    nu, r = material.poisson_ratio, bore**2

    def inverse(nu: float) -> float:
        each = 7 + 34 * r + 7 * r**2, 12 + 48 * r + 12 * r**2, 4 + 16 * r + 4 * r**2
        return (each[0] + nu * each[1] + nu**2 * each[2]) / (6 * (1 + r) ** 2 * (1 + nu) ** 2)

    return 1 / (inverse(0.0) + (inverse(nu) - inverse(0.0)) * _softness(material))


def _softness(material: Material) -> float:
    """Return the shear modulus over that of an isotropic body: how a section widens hangs on the other moduli."""
    return 2 * (1 + material.poisson_ratio) * material.shear_modulus / material.youngs_modulus
