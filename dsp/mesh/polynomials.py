"""Polynomials of a cell: Lagrange's on Lobatto's nodes, and Gauss points, on 0 to 1."""

from functools import lru_cache

import numpy as np

from ..bodies.material import Array


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


def lagrange(x: Array, degree: int) -> tuple[Array, Array]:
    """Return values and derivatives (n, degree + 1) at x (n,) of the polynomials that are 1 at one node."""
    powers = np.linalg.inv(np.vander(lobatto(degree), increasing=True))  # (power, node)
    monomials = np.vander(x, degree + 1, increasing=True)
    slopes = np.zeros_like(monomials)
    slopes[:, 1:] = monomials[:, :-1] * np.arange(1, degree + 1)
    return monomials @ powers, slopes @ powers


def products(at: Array, degree: int) -> tuple[Array, Array]:
    """Return values (n, m) and gradients (3, n, m) at places (n, 3) of a cell of all products of three, m = (degree +
    1)^3."""
    values, slopes = zip(*(lagrange(at[:, axis], degree) for axis in range(3)), strict=True)

    def product(x: Array, y: Array, z: Array) -> Array:
        return np.asarray(
            (x[:, :, None, None] * y[:, None, :, None] * z[:, None, None, :]).reshape(len(at), (degree + 1) ** 3)
        )

    gradients = [product(*(slopes[k] if k == axis else values[k] for k in range(3))) for axis in range(3)]
    return product(*values), np.stack(gradients)
