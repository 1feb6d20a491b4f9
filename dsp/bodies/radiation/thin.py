"""Thin surfaces between two parallel edges, free in air: the flat strip, and the open cylinder.

The unknown is the jump of pressure across the surface, which falls to zero at the edges as a square root. It is
expanded in psi_n(z) = sqrt(1 - z^2) U_n(z), -1 < z < 1, whose transform is pi (n + 1) (-i)^n J_(n+1)(x)/x. The velocity
that a jump makes is v^ = Y(x) p^ in the spectrum; Galerkin's method makes it that of the surface: A c = b,
b_n = int phi psi_n dz, and c.b is the impedance. Time goes as exp(-i omega t).
"""

import math
from collections.abc import Callable

import numpy as np

from ...numerics.bessel import bessel, derivatives, ine, kne, yn_table
from ..air import IMPEDANCE, Complex
from ..material import Array
from .quadrature import segment

Profile = Callable[[Array], Array]
"""Places z in -1..1 across the surface -> velocity there."""

_UNIFORM = 30  # order from which Debye's leading terms serve where Y_n and K_n might overflow; they err by 1/n^2


def strip(x: float, profile: Profile = np.ones_like) -> complex:
    """Return the impedance of a flat strip moving along its normal, both sides, per length and over rho c b, at x = k
    b.

    b is half the width. The real part radiates; the air's mass per length is -Im/x rho b^2.
    """
    terms = 14 + int(x)

    def travelling(s: Array) -> Complex:
        return np.asarray(np.sqrt(x**2 - s**2), np.complex128)

    def evanescent(s: Array) -> Complex:
        return np.asarray(1j * np.sqrt(s**2 - x**2), np.complex128)

    return _solve(x, terms, 60.0, (travelling, evanescent), profile)


def open_cylinder(order: int, k: float, radius: float, half: float, profile: Profile) -> complex:
    """Return the impedance (kg/s) of a thin cylinder of length 2 `half`, its ends open, moving radially by profile
    cos(m theta).

    Both its sides radiate, one to the other around the edges. Lengths in m, k = omega/c. The order m may be 0.
    """
    x, slim = k * half, radius / half
    terms = 10 + int(x / 3)

    def travelling(s: Array) -> Complex:
        return _inner_outer(order, np.sqrt(x**2 - s**2) * slim) / slim

    def evanescent(s: Array) -> Complex:
        return _inner_outer_evanescent(order, np.sqrt(s**2 - x**2) * slim) / slim

    ratio = _solve(x, terms, 40 + 30 / slim, (travelling, evanescent), profile)
    return IMPEDANCE * (2 * math.pi if order == 0 else math.pi) * radius * half * ratio


def _solve(
    x: float,
    terms: int,
    reach: float,
    kernel: tuple[Callable[[Array], Complex], Callable[[Array], Complex]],
    profile: Profile,
) -> complex:
    """Return c.b of the kernel 2 x rho c Y, which goes as i s for large s, given for s < x and for s > x."""
    n = np.arange(terms)
    angle, weights = segment(0, math.pi, 4 * terms + 40)
    b = (np.sin(np.outer(n + 1, angle)) * np.sin(angle) * weights) @ profile(np.cos(angle))

    t, w = segment(0, math.pi / 2, 24 + x)
    low, low_weights = x * np.sin(t), w * x * np.cos(t)
    y, w = segment(0, math.sqrt(terms + reach), 80 + 0.6 * (terms + reach))
    high, high_weights = x + y**2, 2 * y * w
    s = np.concatenate([low, high])
    travelling, evanescent = kernel
    rest = np.concatenate([travelling(low), evanescent(high)]) - 1j * s
    j = bessel(terms + 1, s)[1:] / s * (n + 1)[:, None]
    moments = (j * (rest * np.concatenate([low_weights, high_weights]))) @ j.T
    even = (n[:, None] + n) % 2 == 0
    sign = np.where(even, (-1.0) ** ((n[:, None] - n) // 2), 0.0)
    a = (math.pi * sign * moments + 1j * math.pi * np.diag(n + 1) / 2) / (2 * x)
    return complex(np.linalg.solve(a, b) @ b)


def _inner_outer(order: int, r: Array) -> Complex:
    """Return pi r^2 J_m'(r) H_m'(r): the inside and the outside of a cylinder, of radial wavenumber r over its
    radius."""
    j = derivatives(bessel(order + 2, r), r)[order]
    if order > _UNIFORM:
        near = r < order / 2
        y = _slope_of_y(order, np.where(near, order, r))
        both = np.where(near, np.sqrt(np.maximum(order**2 - r**2, 0)) / math.pi, r**2 * j * y)
    else:
        both = r**2 * j * _slope_of_y(order, r)
    return np.asarray(math.pi * (r**2 * j**2 + 1j * both), np.complex128)


def _slope_of_y(order: int, r: Array) -> Array:
    slope: Array = derivatives(yn_table(order + 2, r), r)[order]
    return slope


def _inner_outer_evanescent(order: int, r: Array) -> Complex:
    """Return the same at i r: -2 i r^2 I_m'(r) K_m'(r)."""
    if order > _UNIFORM:
        return np.asarray(1j * np.sqrt(order**2 + r**2), np.complex128)
    r = np.maximum(r, 1e-9)
    i = (ine(abs(order - 1), r) + ine(order + 1, r)) / 2
    k = (kne(abs(order - 1), r) + kne(order + 1, r)) / 2
    return np.asarray(2j * r**2 * i * k, np.complex128)
