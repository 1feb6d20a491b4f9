"""Flat, thin, circular surfaces: free in air, or in a wall.

Their modes are J_m(lambda r) + c I_m(lambda r)/I_m(lambda), times cos(m theta). Free: the jump of pressure across the
disc, which falls to zero at its edge as a square root, is expanded in functions of which the Hankel transform is
j_l(x)/x, l = m + 2 n + 1; Galerkin's method makes the velocity that it causes that of the disc: A c = b, and b.c is the
impedance. In a wall: Rayleigh's integral over the Hankel transform of the mode, by Zernike's polynomials, whose is
J_l(x)/x. Time goes as exp(-i omega t).
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...numerics.bessel import bessel, ine, spherical_bessel, spherical_ine
from ..air import IMPEDANCE, Complex
from ..material import Array
from ..modes import Indices, read_only
from .quadrature import segment

_MARGIN = 2  # terms beyond those that the waves need


class Waves(NamedTuple):
    """Modes of one angular order: wavenumbers lambda times the radius (k,), the c above, the factor of both."""

    order: int
    root: Array
    growing: Array
    scale: Array


def free_disc(waves: Waves, x: Array, radius: float) -> Complex:
    """Return the impedances (kg/s) of modes, both sides, at places x = k a (p,): (p, k)."""
    b, jump, _ = _jumps(waves, x)
    whole = 2 * IMPEDANCE * radius**2 * _turn(waves.order) * x[:, None] * (jump * b).sum(axis=1)
    return np.asarray(whole, np.complex128)


def _jumps(waves: Waves, x: Array) -> tuple[Array, Complex, Indices]:
    """Return the projections b (n, k), the jumps of pressure c (p, n, k) over 2 rho c x, and the degrees (n,)."""
    order, root, x = waves.order, waves.root, x[:, None]
    terms = max(4, math.ceil((max(x.max(), root.max()) - order) / 2) + _MARGIN)
    degree = order + 2 * np.arange(terms) + 1
    t, w = segment(0, math.pi / 2, 16 + 0.6 * x.max())
    low = x * np.sin(t)
    span = degree[-1] + 12.0
    y, wy = segment(0, math.sqrt(span), 16 + 0.6 * span)
    high = x + y**2
    # sqrt(x^2 - s^2) - i s, and beyond x i (sqrt(s^2 - x^2) - s) without cancellation; static parts are known
    travelling = x * np.cos(t) * w * x * np.cos(t) / low
    evanescent = -(x**2) / (np.sqrt(high**2 - x**2) + high) / high * (2 * y * wy)
    rest = np.concatenate([np.broadcast_to(-x * np.cos(t) * w, low.shape), evanescent], axis=1)

    places = np.concatenate([low, high], axis=1)
    table = spherical_bessel(int(degree[-1]) + 1, np.append(places, root))[degree]
    b = _projections(waves, degree, table[:, places.size :], 0.5)
    j = table[:, : places.size].reshape(degree.size, *places.shape).transpose(1, 0, 2)
    travels = j[:, :, : t.size]
    a = 1j * ((j * rest[:, None]) @ j.transpose(0, 2, 1))
    a += (travels * travelling[:, None]) @ travels.transpose(0, 2, 1)
    a += np.diag(1j * math.pi / (2 * (2 * degree + 1)))
    jump = np.linalg.solve(a, np.broadcast_to(b + 0j, (len(x), *b.shape)))
    return b, np.asarray(jump, np.complex128), degree


def _turn(order: int) -> float:
    """Return int cos^2(m theta) over the circle."""
    return 2 * math.pi if order == 0 else math.pi


def _projections(waves: Waves, degree: Indices, whole: Array, half: float) -> Array:
    """Return int_0^1 of the modes times functions (n) of which the Hankel transform is J_(l + half)(x)/x: (n, k).

    half = 0.5: spherical Bessel functions j_l. The transforms at lambda (whole, over lambda), and at i lambda for I_m.
    """
    root = waves.root
    projected: Array = waves.scale / root * whole
    if waves.growing.any():
        grown = _grown(waves.order, root.tobytes(), degree.size, half)
        projected += waves.scale / root * waves.growing * (-1.0) ** np.arange(degree.size)[:, None] * grown
    return projected


@lru_cache(maxsize=1024)  # 10 kB each at most; waves are requested at one place after the other
def _grown(order: int, roots: bytes, degrees: int, half: float) -> Array:
    """Return I_(l + half)/I_m at roots, of the degrees l of an order m (degrees, k); read-only."""
    root, degree = np.frombuffer(roots), order + 2 * np.arange(degrees)[:, None] + 1
    grown: Array = (spherical_ine if half else ine)(degree, root) / ine(order, root)
    read_only(grown)
    return grown


def baffled_disc(waves: Waves, x: Array, radius: float) -> Complex:
    """Return the impedances (kg/s) of the modes of a disc in a wall, on one of its sides, at places x = k a (p,): (p,
    k).

    2 pi eps rho c a^2 int Phi(s)^2 s/sqrt(1 - (s/x)^2) ds, Phi the mode's Hankel transform.
    """
    order, root, x = waves.order, waves.root, x[:, None]
    terms = max(8, math.ceil((root.max() - order) / 2) + 12)
    degree = order + 2 * np.arange(terms) + 1
    whole = bessel(int(degree[-1]) + 1, root)[degree]
    series = 2 * degree[:, None] * _projections(waves, degree, whole, 0.0)
    t, w = segment(0, math.pi / 2, 16 + 0.75 * x.max())
    low = x * np.sin(t)
    reach = max(2.5 * root.max(), 3 * x.max()) + 40
    y, wy = segment(0, math.sqrt(reach), 32 + 0.7 * reach)
    high = x + y**2
    s = np.concatenate([low, high], axis=1)
    table = bessel(int(degree[-1]) + 1, s)[order + 1 :: 2].reshape(terms, -1)
    transform = (series.T @ table).reshape(-1, *s.shape) / s
    weights = np.concatenate([x * w * low + 0j, -1j * x * high * 2 * wy / np.sqrt(2 * x + y**2)], axis=1)
    whole_impedance = IMPEDANCE * radius**2 * _turn(order) * np.einsum("ps,kps->pk", weights, transform**2)
    return np.asarray(whole_impedance, np.complex128)
