"""Thin surfaces between two parallel edges, free in air: the flat strip, and the open cylinder.

The unknown is the jump of pressure across the surface, which falls to zero at the edges as a square root. It is
expanded in psi_n(z) = sqrt(1 - z^2) U_n(z), -1 < z < 1, whose transform is pi (n + 1) (-i)^n J_(n+1)(x)/x. The velocity
that a jump makes is v^ = Y(x) p^ in the spectrum; Galerkin's method makes it that of the surface: A c = b,
b_n = int phi psi_n dz, and c.b is the impedance. Time goes as exp(-i omega t).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...numerics.bessel import bessel, derivatives, ine, kne_table, yn_table
from ..air import IMPEDANCE, Complex
from ..material import Array
from ..modes import Indices
from .quadrature import segment

Profile = Callable[[Array], Array]
"""Places z in -1..1 across the surface -> velocity there."""

_TOGETHER = 32  # modes that are computed at once
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

    waves = _waves(x, terms, 60.0)
    return _solve(x, terms, waves, np.concatenate([travelling(waves.low), evanescent(waves.high)]), profile)


def open_cylinder(order: Indices, k: Array, radius: float, half: float, profile: Profile) -> Complex:
    """Return the impedances (kg/s) of a thin cylinder of length 2 `half`, its ends open, that moves radially by profile
    cos(m theta), for orders m (n,) at wave numbers k (n,).

    Both its sides radiate, one to the other around the edges. Lengths in m, k = omega/c. The order m may be 0.
    """
    found = np.empty(k.size, np.complex128)
    for first in range(0, k.size, _TOGETHER):
        some = slice(first, first + _TOGETHER)
        found[some] = _cylinder(order[some], k[some] * half, radius / half, profile)
    return IMPEDANCE * np.where(order == 0, 2 * math.pi, math.pi) * radius * half * found


def _cylinder(order: Indices, x: Array, slim: float, profile: Profile) -> Complex:
    """Return c.b for orders (n,) at x = k half (n,), slim the radius over `half`. What goes on inside and outside is
    computed for all at once."""
    terms = [10 + int(each / 3) for each in x]
    waves = [_waves(each, count, 40 + 30 / slim) for each, count in zip(x, terms, strict=True)]
    low = [np.sqrt(each**2 - given.low**2) * slim for each, given in zip(x, waves, strict=True)]
    high = [np.sqrt(given.high**2 - each**2) * slim for each, given in zip(x, waves, strict=True)]
    kernels = (_at_once(_inner_outer, order, low), _at_once(_inner_outer_evanescent, order, high))
    return np.array(
        [
            _solve(each, count, given, np.concatenate(kernel) / slim, profile)
            for each, count, given, *kernel in zip(x, terms, waves, *kernels, strict=True)
        ]
    )


def _at_once(kernel: Callable[[Indices, Array], Complex], order: Indices, radial: list[Array]) -> list[Complex]:
    """Return a kernel at lists of radial wavenumbers, one for each order."""
    sizes = [each.size for each in radial]
    return np.split(kernel(np.repeat(order, sizes), np.concatenate(radial)), np.cumsum(sizes)[:-1])


class _Waves(NamedTuple):
    """Wavenumbers s across the surface: nodes and weights of integrals from 0 to x, and from x on."""

    low: Array
    low_weights: Array
    high: Array
    high_weights: Array


def _waves(x: float, terms: int, reach: float) -> _Waves:
    t, w = segment(0, math.pi / 2, 24 + x)
    y, wy = segment(0, math.sqrt(terms + reach), 80 + 0.6 * (terms + reach))
    return _Waves(x * np.sin(t), w * x * np.cos(t), x + y**2, 2 * y * wy)


def _solve(x: float, terms: int, waves: _Waves, kernel: Complex, profile: Profile) -> complex:
    """Return c.b of the kernel 2 x rho c Y, which goes as i s for large s, given at the waves."""
    n = np.arange(terms)
    angle, weights = segment(0, math.pi, 4 * terms + 40)
    b = (np.sin(np.outer(n + 1, angle)) * np.sin(angle) * weights) @ profile(np.cos(angle))

    s = np.concatenate([waves.low, waves.high])
    j = bessel(terms + 1, s)[1:] / s * (n + 1)[:, None]
    moments = (j * ((kernel - 1j * s) * np.concatenate([waves.low_weights, waves.high_weights]))) @ j.T
    even = (n[:, None] + n) % 2 == 0
    sign = np.where(even, (-1.0) ** ((n[:, None] - n) // 2), 0.0)
    a = (math.pi * sign * moments + 1j * math.pi * np.diag(n + 1) / 2) / (2 * x)
    return complex(np.linalg.solve(a, b) @ b)


def _inner_outer(order: Indices, r: Array) -> Complex:
    """Return pi r^2 J_m'(r) H_m'(r) of orders (n,): the inside and the outside of a cylinder, of radial wavenumbers r
    (n,) over its radius."""
    count, place = int(order.max()) + 2, np.arange(r.size)
    near = (order > _UNIFORM) & (r < order / 2)
    j = derivatives(bessel(count, r), r)[order, place]
    far = np.where(near, order, r)
    y = derivatives(yn_table(count, far), far)[order, place]
    both = np.where(near, np.sqrt(np.maximum(order**2 - r**2, 0)) / math.pi, r**2 * j * y)
    return np.asarray(math.pi * (r**2 * j**2 + 1j * both), np.complex128)


def _inner_outer_evanescent(order: Indices, r: Array) -> Complex:
    """Return the same at i r: -2 i r^2 I_m'(r) K_m'(r)."""
    exact, r = np.minimum(order, _UNIFORM), np.maximum(r, 1e-9)
    around = np.stack([np.abs(exact - 1), exact + 1])
    i = ine(around, r).mean(axis=0)
    k = kne_table(int(around.max()) + 1, r)[around, np.arange(r.size)].mean(axis=0)
    return np.asarray(1j * np.where(order > _UNIFORM, np.sqrt(order**2 + r**2), 2 * r**2 * i * k), np.complex128)
