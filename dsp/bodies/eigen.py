"""The modes of two quadratic forms: scipy's own solver keeps Python's lock, and other threads have to answer."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def eigh(stiffness: Array, inertia: Array) -> tuple[Array, Array]:
    """Return the eigenvalues (n,), ascending, and vectors (n, n) of K x = lambda M x, x^T M x = 1.

    Both symmetrical (n, n), the inertia positive definite: with M = L L^T, of L^-1 K L^-T (LAPACK's dsygvd does so,
    too). numpy gives up Python's lock at each step. LinAlgError where the inertia is not positive definite.
    """
    lower = np.linalg.cholesky(inertia)
    reduced = np.linalg.solve(lower, np.linalg.solve(lower, stiffness).T)
    square, vector = np.linalg.eigh((reduced + reduced.T) / 2)
    return square, np.linalg.solve(lower.T, vector)
