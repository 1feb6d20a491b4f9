"""Corners of walls in finite cells: where walls meet, a share of the stiffness across them is taken off, as they yield
there. One law says the share in large cells, another that in small ones at inner edges."""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array, Material
from .polynomials import products
from .rays import Points

_BENT = 0.01  # of a cell's volume, with normals over 45 degrees from the first direction: where sheets meet
_AT_ONCE = 256  # points of a cell


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
    """
    from scipy.linalg.blas import dsyrk

    nu = material.poisson_ratio
    mu = material.youngs_modulus / (2 * (1 + nu))
    lame = 2 * mu * nu / (1 - 2 * nu)
    half = np.zeros((3 * (degree + 1) ** 3,) * 2, order="F")
    for begin in range(0, len(own.weights), _AT_ONCE):
        some = own.part(begin, begin + _AT_ONCE)
        share = np.sqrt(some.weights / (lame + 2 * mu)) / side
        slopes = products(some.places, degree)[1]
        across = np.einsum("inm,ni->nm", slopes, 2 * mu * share[:, None] * some.normals)
        scaled = np.empty((*across.shape, 3))
        for axis in range(3):
            scaled[:, :, axis] = across * some.normals[:, axis, None]
            scaled[:, :, axis] += slopes[axis] * (lame * share)[:, None]
        half = dsyrk(1.0, scaled.reshape(len(share), -1).T, beta=1.0, c=half, overwrite_c=1)
    held: Array = half + np.triu(half, 1).T
    return held
