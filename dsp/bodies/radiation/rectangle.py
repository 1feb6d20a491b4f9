"""Rectangular surfaces, flat and thin: free in air, or in a wall.

Free: the jump of pressure across the surface falls to zero at the edges as a square root. It is expanded in products of
psi_p(z) = sqrt(1 - z^2) U_p(z) along both sides, whose transform is pi (p + 1) (-i)^p J_(p+1)(x)/x; Galerkin's method
makes the velocity that it causes that of the plate: M c = b, and b.c is the impedance. In a wall: Rayleigh's integral
over Legendre series of the velocity. The four parities part. Time goes as exp(-i omega t).
"""

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from ...kept import Kept
from ...numerics.bessel import bessel, spherical_bessel
from ..air import Complex
from ..material import Array
from ..modes import read_only
from .quadrature import panels, segment

_REACH = 20.0  # beyond the terms: from there on products of Bessel functions are taken as their means, by Debye
_TAIL, _FARTHEST = 32, 1e4  # nodes of that part, and how far it goes
_PANEL = 10.0  # of the grid of wavenumbers, for the rule's 16 nodes

Parts = Mapping[tuple[int, int], Array]
"""Coefficients for each pair of parities (x, y), 0 even and 1 odd: (terms of that parity along x, along y, modes)."""


class Side(NamedTuple):
    """A side of a rectangle: half its length (m), terms along it, and products of transforms at a grid of x.

    products: for each parity (terms, terms, x), without (-i)^p, the weights of the grid included, for half a length
    of 1.
    """

    half: float
    terms: int
    x: Array
    products: tuple[Array, Array]


def side(half: float, terms: int) -> Side:
    """Return the side's table, which serves all frequencies."""
    found = _kept.get(terms)
    if found is None:
        found = _grid(terms)
        _kept.put(terms, found)
    return Side(half, terms, *found)


_Grid = tuple[Array, tuple[Array, Array]]
_kept: Kept[int, _Grid] = Kept(16_000_000, lambda grid: sum(each.nbytes for each in grid[1]))


def _grid(terms: int) -> _Grid:
    """Return the grid and the products of a side with so many terms; read-only."""
    reach = terms + _REACH
    unit, share = panels(math.ceil(reach / _PANEL))
    near, near_weights = reach * unit, reach * share
    y, w = segment(math.log(reach), math.log(_FARTHEST * reach), _TAIL)
    far = np.exp(y)
    transform = _transforms(terms, near)
    size, angle = _debye(terms, far)
    weights = np.concatenate([near_weights, w * far])
    products = []
    for odd in (0, 1):
        own, large, turn = transform[odd::2], size[odd::2], angle[odd::2]
        mean = large[:, None] * large * np.cos(turn[:, None] - turn) / 2
        products.append(np.concatenate([own[:, None] * own, mean], axis=2) * weights)
    grid = np.concatenate([near, far])
    read_only(grid, *products)
    return grid, (products[0], products[1])


def _debye(terms: int, x: Array) -> tuple[Array, Array]:
    """Return `_transforms` for x beyond the terms, as amplitudes and angles of cosines (Debye): (terms, x) each."""
    n = np.arange(1, terms + 1)[:, None]
    root = np.sqrt(x**2 - n**2)
    size = math.pi * n / x * np.sqrt(2 / (math.pi * root))
    angle = root - n * np.arccos(n / x) + math.pi * ((n - 1) // 2)  # the terms' signs
    return size, angle


def _transforms(terms: int, x: Array) -> Array:
    """Return pi (p + 1) J_(p+1)(x)/x, the signs of a parity's terms included: (terms, *x.shape)."""
    p = np.arange(terms).reshape(-1, *(1,) * x.ndim)
    safe = np.maximum(x, 1e-9)
    found: Array = (-1.0) ** (p // 2) * math.pi * (p + 1) * bessel(terms + 1, safe)[1:] / safe
    return found


def jump_terms(terms: int, values: Callable[[Array], Array], half: float) -> Array:
    """Return int f psi_p of functions of fractions of the side, (points) -> (points, n), by length: (terms, n)."""
    at, psi = _jumps(terms)
    projected: Array = half * psi @ values(at)
    return projected


@lru_cache(maxsize=128)  # 0.3 MB each at most
def _jumps(terms: int) -> tuple[Array, Array]:
    """Return fractions of a side, and psi_p there times the weights of an integral over it; read-only."""
    t, w = segment(0, math.pi, 4 * terms + 60)
    psi = np.sin(np.outer(np.arange(1, terms + 1), t)) * np.sin(t) * w
    at = (1 + np.cos(t)) / 2
    read_only(at, psi)
    return at, psi


def legendre_terms(terms: int, values: Callable[[Array], Array], half: float) -> Array:
    """Return Legendre series of functions of fractions of the side, whose transforms are sums of j_p: (terms, n)."""
    z, w = segment(-1, 1, 4 * terms + 60)
    basis = legendre.legvander(z, terms - 1) * w[:, None]
    p = np.arange(terms)
    series: Array = half * (2 * p[:, None] + 1) * (-1.0) ** (p // 2)[:, None] * (basis.T @ values((1 + z) / 2))
    return series


class Far(NamedTuple):
    """The far field of a mode by its waves along x, k_x = k sin u: k_x half the side (m,), cos u (m,), weights (m,),
    and for each parity along x amplitudes (m,), of whose squares, weighted, the sum is the real part of the impedance.
    The phase is that of the jump's transform."""

    x: Array
    cosine: Array
    weights: Array
    amplitude: Mapping[int, Complex]


def free_rectangle(k: float, along: Side, across: Side, projected: Parts) -> Complex:
    """Return the impedances, over 2 rho c k, of modes given by their `jump_terms`, at k = omega/c."""
    total: Complex = np.zeros(next(iter(projected.values())).shape[2], np.complex128)
    for flat, jump, _ in _jumped(k, along, across, projected).values():
        total += (flat * jump).sum(axis=0)
    return total


def far_rectangle(k: float, along: Side, across: Side, projected: Parts) -> Far:
    """Return the far field of one mode that is even across, given by its `jump_terms`."""
    rays = _rays(k, along.half, across.half)
    amplitude = {}
    for (odd_x, odd_y), (_, jump, (x, y)) in _jumped(k, along, across, projected).items():
        if odd_y:
            raise ValueError("expected a mode that is even across")
        field = ((x.T @ jump.reshape(len(x), -1))[:, None] @ y)[:, 0]
        size = np.sqrt((rays.v_weights * rays.v_cosine**2 * np.abs(field) ** 2).sum(axis=1))
        amplitude[odd_x] = size * np.exp(1j * np.angle(field[:, 0]))
    return Far(rays.x, rays.u_cosine, rays.u_weights * k**3 * rays.u_cosine**3 / math.pi**2, amplitude)


def _jumped(
    k: float, along: Side, across: Side, projected: Parts
) -> dict[tuple[int, int], tuple[Array, Complex, tuple[Array, Array]]]:
    """Return for each pair of parities the modes' terms (p q, modes), their jumps' (p q, modes), and the transforms of
    the terms along x (p, m) and y (m, q, n) at the rays."""
    kz = np.sqrt(np.maximum((along.x[:, None] / along.half) ** 2 + (across.x / across.half) ** 2 - k**2, 0))
    rays = _rays(k, along.half, across.half)
    field_x = along.half * _transforms(along.terms, rays.x)
    field_y = across.half * _transforms(across.terms, rays.y)
    weights_x, weights_y = rays.u_weights * k**3 * rays.u_cosine**3, rays.v_weights * rays.v_cosine**2
    found = {}
    for (odd_x, odd_y), b in projected.items():
        p, q, _ = b.shape
        x, y = field_x[odd_x::2][:p], field_y[odd_y::2][:q].transpose(1, 0, 2)
        pairs_x = (x[:, None] * x * weights_x).reshape(p * p, -1)
        pairs_y = ((y * weights_y) @ y.transpose(0, 2, 1)).reshape(-1, q * q)
        near_x, near_y = (
            each.products[odd][:n, :n].reshape(n * n, -1) for each, odd, n in ((along, odd_x, p), (across, odd_y, q))
        )
        near = along.half * across.half * (near_x @ kz @ near_y.T)
        matrix = (pairs_x @ pairs_y + 1j * near) / math.pi**2
        matrix = matrix.reshape(p, p, q, q).transpose(0, 2, 1, 3).reshape(p * q, p * q)
        flat = b.reshape(p * q, -1)
        jump = np.asarray(np.linalg.solve(matrix, flat + 0j), np.complex128)
        found[odd_x, odd_y] = flat, jump, (x, y)
    return found


def walled_rectangle(k: float, halves: tuple[float, float], series: Parts) -> Array:
    """Return the resistances, over rho c, of modes given by their `legendre_terms`, on one side: k^2/(4 pi^2) int
    |V|^2."""
    rays = _rays(k, *halves)
    terms = [2 * max(part.shape[axis] for part in series.values()) for axis in (0, 1)]
    field_x, field_y = spherical_bessel(terms[0], rays.x), spherical_bessel(terms[1], rays.y)
    total = np.zeros(next(iter(series.values())).shape[2])
    for (odd_x, odd_y), part in series.items():
        p, q, modes = part.shape
        x, y = field_x[odd_x::2][:p], field_y[odd_y::2][:q].transpose(1, 2, 0)
        velocity = y @ (x.T @ part.reshape(p, -1)).reshape(-1, q, modes)
        total += rays.u_weights * rays.u_cosine @ (rays.v_weights @ velocity**2)
    resistance: Array = k**2 / math.pi**2 * total
    return resistance


class _Rays(NamedTuple):
    """Waves that leave a rectangle through a quarter of a half space: k_x = k sin u, k_y = k cos u sin v.

    Weights and cosines of u (m,) and v (n,); k_x and k_y times half the sides, x (m,) and y (m, n).
    """

    u_weights: Array
    u_cosine: Array
    v_weights: Array
    v_cosine: Array
    x: Array
    y: Array


def _rays(k: float, half_x: float, half_y: float) -> _Rays:
    u, u_weights = segment(0, math.pi / 2, 10 + 0.7 * k * half_x)
    v, v_weights = segment(0, math.pi / 2, 10 + 0.7 * k * half_y)
    y = k * half_y * np.outer(np.cos(u), np.sin(v))
    return _Rays(u_weights, np.cos(u), v_weights, np.cos(v), k * half_x * np.sin(u), y)
