"""Flat, thin, circular surfaces: free in air, or in a wall.

Their modes are J_m(lambda r) + c I_m(lambda r)/I_m(lambda), times cos(m theta). Free: the jump of pressure across the
disc, which falls to zero at its edge as a square root, is expanded in functions of which the Hankel transform is
j_l(x)/x, l = m + 2 n + 1; Galerkin's method makes the velocity that it causes that of the disc: A c = b, and b.c is the
impedance. In a wall: Rayleigh's integral over the Hankel transform of the mode, by Zernike's polynomials, whose is
J_l(x)/x. Time goes as exp(-i omega t).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..air import IMPEDANCE, Complex
from ..material import Array
from ..modes import Indices
from .quadrature import bessel, segment, spherical_bessel

_AT_ONCE = 8000  # places in the spectrum of which the Bessel functions are found together
_MARGIN = 2  # terms beyond those that the waves need


class Waves(NamedTuple):
    """Modes of one angular order: wavenumbers lambda times the radius (k,), the c above, the factor of both; k a."""

    order: int
    root: Array
    growing: Array
    scale: Array
    x: Array


def free_disc(families: Sequence[Waves], radius: float) -> list[Complex]:
    """Return the impedances (kg/s) of modes, both sides: of each family, and of many at once as that takes less
    time."""
    found: list[Complex] = []
    plans = [_Plan(waves) for waves in families]
    while plans:
        sizes = np.cumsum([plan.points.size for plan in plans])
        count = max(1, int(np.searchsorted(sizes, _AT_ONCE)))
        found += _solve(plans[:count], radius)
        plans = plans[count:]
    return found


class _Plan:
    """The integrals of a family's matrices: places s (k, p) in the spectrum, the first of them below x, and weights."""

    def __init__(self, waves: Waves) -> None:
        self.waves, x = waves, waves.x[:, None]
        terms = max(4, math.ceil((max(x.max(), waves.root.max()) - waves.order) / 2) + _MARGIN)
        self.degree = waves.order + 2 * np.arange(terms) + 1
        t, w = segment(0, math.pi / 2, 16 + 0.6 * x.max())
        low = x * np.sin(t)
        span = self.degree[-1] + 12.0
        y, wy = segment(0, math.sqrt(span), 16 + 0.6 * span)
        high = x + y**2
        self.below = t.size
        # sqrt(x^2 - s^2) - i s, and beyond x i (sqrt(s^2 - x^2) - s) without cancellation; static parts are known
        self.travelling = x * np.cos(t) * w * x * np.cos(t) / low
        evanescent = -(x**2) / (np.sqrt(high**2 - x**2) + high) / high * (2 * y * wy)
        self.rest = np.concatenate([np.broadcast_to(-x * np.cos(t) * w, low.shape), evanescent], axis=1)
        self.points = np.concatenate([low, high, waves.root[:, None]], axis=1)


def _solve(plans: Sequence[_Plan], radius: float) -> list[Complex]:
    found = []
    for plan, (b, jump) in zip(plans, _jumps(plans), strict=True):
        turn = _turn(plan.waves.order)
        found.append(2 * IMPEDANCE * radius**2 * turn * plan.waves.x * np.einsum("kn,nk->k", jump, b))
    return found


def _jumps(plans: Sequence[_Plan]) -> list[tuple[Array, Complex]]:
    """Return, for each family, the projections b (n, k), and the jumps of pressure c (k, n) over 2 rho c x."""
    count = 1 + max(int(plan.degree[-1]) for plan in plans)
    table = spherical_bessel(count, np.concatenate([plan.points.ravel() for plan in plans]))
    found: list[tuple[Array, Complex]] = []
    first = 0
    for plan in plans:
        degree = plan.degree
        mine = table[degree, first : first + plan.points.size].reshape(degree.size, *plan.points.shape)
        first += plan.points.size
        b = _projections(plan.waves, degree, mine[:, :, -1], 0.5)
        j = mine[:, :, :-1].transpose(1, 0, 2)
        travels = j[:, :, : plan.below]
        a = 1j * ((j * plan.rest[:, None]) @ j.transpose(0, 2, 1))
        a += (travels * plan.travelling[:, None]) @ travels.transpose(0, 2, 1)
        a += np.diag(1j * math.pi / (2 * (2 * degree + 1)))
        jump: Complex = np.asarray(np.linalg.solve(a, b.T[:, :, None] + 0j)[..., 0], np.complex128)
        found.append((b, jump))
    return found


def _turn(order: int) -> float:
    """Return int cos^2(m theta) over the circle."""
    return 2 * math.pi if order == 0 else math.pi


def _projections(waves: Waves, degree: Indices, whole: Array, half: float) -> Array:
    """Return int_0^1 of the modes times functions (n) of which the Hankel transform is J_(l + half)(x)/x: (n, k).

    half = 0.5: spherical Bessel functions j_l. The transforms at lambda (whole, over lambda), and at i lambda for I_m.
    """
    from scipy.special import ive

    root = waves.root
    projected: Array = waves.scale / root * whole
    if waves.growing.any():
        grown = ive(degree[:, None] + half, root) / ive(waves.order, root)
        if half:
            grown *= np.sqrt(math.pi / (2 * root))
        projected += waves.scale / root * waves.growing * (-1.0) ** np.arange(degree.size)[:, None] * grown
    return projected


def baffled_disc(waves: Waves, radius: float) -> Complex:
    """Return the impedances (kg/s) of the modes of a disc in a wall, on one of its sides.

    2 pi eps rho c a^2 int Phi(s)^2 s/sqrt(1 - (s/x)^2) ds, Phi the mode's Hankel transform.
    """
    order, x = waves.order, waves.x
    terms = max(8, math.ceil((waves.root.max() - order) / 2) + 12)
    degree = order + 2 * np.arange(terms) + 1
    whole = bessel(int(degree[-1]) + 1, waves.root)[degree]
    series = 2 * degree[:, None] * _projections(waves, degree, whole, 0.0)
    t, w = segment(0, math.pi / 2, 16 + 0.75 * x.max())
    low = np.outer(x, np.sin(t))
    reach = max(2.5 * waves.root.max(), 3 * x.max()) + 40
    y, wy = segment(0, math.sqrt(reach), 32 + 0.7 * reach)
    high = x[:, None] + y**2
    s = np.concatenate([low, high], axis=1)
    transform = np.einsum("nk,nks->ks", series, bessel(int(degree[-1]) + 1, s)[order + 1 :: 2]) / s
    weights = np.concatenate(
        [np.outer(x, w) * low + 0j, -1j * x[:, None] * high * 2 * wy / np.sqrt(2 * x[:, None] + y**2)], axis=1
    )
    whole_impedance = IMPEDANCE * radius**2 * _turn(order) * (weights * transform**2).sum(axis=1)
    return np.asarray(whole_impedance, np.complex128)
