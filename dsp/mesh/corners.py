"""Corners of walls in finite cells: where walls meet, a share of the stiffness across them is taken off, as they yield
there. One law says the share in large cells, another that in small ones at inner edges."""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array, Material
from .polynomials import integrals, moments
from .rays import Points

_BENT = 0.01  # of a cell's volume, with normals over 45 degrees from the first direction: where sheets meet


class Law(NamedTuple):
    """The share of the stiffness across walls that stays where they meet in a cell: a factor times a power of
    thickness/side, below a bound of it."""

    factor: float
    power: float
    most: float


WHERE_BENT = Law(3.0, 3, 0.3)
AT_EDGES = Law(0.4, 2, 1.0)
"""The laws of large cells, rims and outer edges among them, and of small ones at inner edges. At these a corner in
plane strain then yields as the solid does, in the mean over where it lies in its cell. At a rim nothing has to yield,
and a curved wall must not; but large cells are too stiff where it curves."""


def is_bent(weights: Array, normals: Array) -> bool:
    """True if sheets meet at an angle in a cell, by the normals (n, 3) at its points."""
    first = np.linalg.eigh(np.einsum("p,pi,pj->ij", weights, normals, normals))[1][:, 2]
    return bool(weights[(normals @ first) ** 2 < 0.5].sum() > _BENT * weights.sum())


def held_across(own: Points, side: float, degree: int, material: Material) -> Array:
    """Return the stiffness (3 m, 3 m) by which a cell's polynomials resist where sheets may yield: that of the stress
    along their normals (n, 3), which is none in a thin sheet.

    Where it is left, sheets that meet don't bend near their edge: the curvature of each would stretch the other across.
    That stress is sum_ij a_ij d u_j / d x_i with a_ij = lame (i = j) + 2 mu n_i n_j; its square takes the moments of
    all products of two of the six a_ij.
    """
    nu = material.poisson_ratio
    mu = material.youngs_modulus / (2 * (1 + nu))
    lame = 2 * mu * nu / (1 - 2 * nu)
    first, second = np.triu_indices(3)
    stress = 2 * mu * own.normals[:, first] * own.normals[:, second] + lame * (first == second)
    one, other = np.triu_indices(len(first))
    share = own.weights[:, None] / ((lame + 2 * mu) * side**2)
    of = moments(own.places, share * stress[:, one] * stress[:, other], degree)
    number = np.zeros((3, 3), np.int64)
    number[first, second] = number[second, first] = np.arange(len(first))
    product = np.zeros((len(first),) * 2, np.int64)
    product[one, other] = product[other, one] = np.arange(len(one))
    count = (degree + 1) ** 3
    held = np.zeros((count, 3, count, 3))
    for j in range(3):
        for m in range(j, 3):
            for i in range(3):
                for k in range(3):
                    held[:, j, :, m] += integrals(of[product[number[i, j], number[k, m]]], degree, (i, k))
            held[:, m, :, j] = held[:, j, :, m].T
    return held.reshape(3 * count, 3 * count)
