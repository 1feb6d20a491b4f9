"""Polynomials of a cell: Lagrange's on Lobatto's nodes, Legendre's, and Gauss points, on 0 to 1.

A product of two of Lagrange's, or of their slopes, is a sum of Legendre's. So all integrals of such products over a
part of a cell follow from the part's moments, by Legendre's polynomials in each direction: (2 degree + 1)^3 numbers,
however many points the part is met by.
"""

import math
from functools import lru_cache

import numpy as np

from ..bodies.material import Array

_AT_ONCE = 4_096  # places of which moments are taken


@lru_cache(maxsize=16)
def gauss(count: int) -> tuple[Array, Array]:
    """Return nodes and weights (count,) of Gauss and Legendre on 0 to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return (nodes + 1) / 2, weights / 2


@lru_cache(maxsize=16)
def lobatto(degree: int) -> Array:
    """Return the nodes (degree + 1,) of Lobatto on 0 to 1."""
    inner = np.polynomial.legendre.Legendre.basis(degree).deriv().roots().real
    nodes: Array = (np.sort(np.r_[-1, inner, 1]) + 1) / 2
    return nodes


def cube_of(at: Array) -> Array:
    """Return all places (n^3, 3) whose coordinates are among some (n,)."""
    places: Array = np.stack(np.meshgrid(at, at, at, indexing="ij"), axis=-1).reshape(-1, 3)
    return places


def lagrange(x: Array, degree: int) -> tuple[Array, Array]:
    """Return values and derivatives (n, degree + 1) at x (n,) of the polynomials that are 1 at one node."""
    powers = np.linalg.inv(np.vander(lobatto(degree), increasing=True))  # (power, node)
    monomials = np.vander(x, degree + 1, increasing=True)
    slopes = np.zeros_like(monomials)
    slopes[:, 1:] = monomials[:, :-1] * np.arange(1, degree + 1)
    return monomials @ powers, slopes @ powers


def products(at: Array, degree: int) -> Array:
    """Return values (n, m) at places (n, 3) of a cell of all products of three, m = (degree + 1)^3."""
    x, y, z = (lagrange(at[:, axis], degree)[0] for axis in range(3))
    return np.asarray((x[:, :, None, None] * y[:, None, :, None] * z[:, None, None, :]).reshape(len(at), -1))


def moments(at: Array, weights: Array, degree: int) -> Array:
    """Return the integrals (..., k, k, k) of Legendre's polynomials in x, y and z, k = 2 degree + 1, by places (n, 3)
    of a cell and their weights (n, ...)."""
    count, many = 2 * degree + 1, weights.shape[1:]
    found = np.zeros((count**2, count * math.prod(many)))
    for begin in range(0, len(at), _AT_ONCE):
        some = at[begin : begin + _AT_ONCE]
        x, y, z = (np.polynomial.legendre.legvander(2 * some[:, axis] - 1, 2 * degree) for axis in range(3))
        both = (x[:, :, None] * y[:, None]).reshape(len(some), count**2)
        weighed = weights[begin : begin + _AT_ONCE].reshape(len(some), -1, 1) * z[:, None]
        found += both.T @ weighed.reshape(len(some), -1)
    return np.ascontiguousarray(np.moveaxis(found.reshape(count, count, *many, count), (0, 1), (-3, -2)))


@lru_cache(maxsize=16)
def _as_legendre(degree: int) -> Array:
    """Return the shares (2, 2, (degree + 1)^2, k) of Legendre's polynomials in products of two of Lagrange's: of each
    the value, or the slope."""
    nodes, weights = gauss(2 * degree + 1)
    both = np.stack(lagrange(nodes, degree))
    legendre = np.polynomial.legendre.legvander(2 * nodes - 1, 2 * degree) * (2 * np.arange(2 * degree + 1) + 1)
    shares: Array = np.einsum("n,ina,jnb,nk->ijabk", weights, both, both, legendre)
    return shares.reshape(2, 2, -1, 2 * degree + 1)


def integrals(of: Array, degree: int, slopes: tuple[int, int] | None = None) -> Array:
    """Return the integrals (m, m) of all products of two of a cell's polynomials, by its moments (k, k, k).

    slopes: the axes along which the first and the second one's slope is taken; None: their values.
    """
    shares = _as_legendre(degree)
    first, second = slopes or (3, 3)
    x, y, z = (shares[int(axis == first), int(axis == second)] for axis in range(3))
    n, k = degree + 1, len(of)
    found = (x @ of.reshape(k, k * k)).reshape(n * n, k, k)
    found = np.matmul(np.matmul(y, found), z.T).reshape(n, n, n, n, n, n)
    return np.ascontiguousarray(found.transpose(0, 2, 4, 1, 3, 5)).reshape(n**3, n**3)
