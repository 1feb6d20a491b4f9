"""Radiation efficiencies of closed bodies, in closed form.

The efficiency is sigma in W = sigma rho c <v^2>, W the power radiated per area and <v^2> the mean square velocity.
"""

import math

import numpy as np

from ...numerics.bessel import bessel, derivatives, spherical_bessel, spherical_yn_table, yn_table
from ..material import Array
from ..modes import Indices


def sphere_efficiency(order: int | Indices, x: Array) -> Array:
    """Return the radiation efficiency of a sphere's spherical harmonics of order n, at x = k a: 1/(x^2 |h_n'(x)|^2)."""
    count = int(np.max(order, initial=0)) + 2
    slopes = (derivatives(table(count, x), x, spherical=True) for table in (spherical_bessel, spherical_yn_table))
    j, y = (each[order] if np.ndim(order) == 0 else each[order, np.arange(x.size)] for each in slopes)
    return np.asarray(1 / (x**2 * (j**2 + _finite(y) ** 2)))


def cylinder_efficiency(order: int, x: Array) -> Array:
    """Return the radiation efficiency of a long cylinder's cos m theta, at x = k a: 2/(pi x |H_m'(x)|^2)."""
    efficiency: Array = 2 / (math.pi * x * radial_function(order, x))
    return efficiency


def radial_function(order: int, x: Array) -> Array:
    """Return |H_m'(x)|^2; where it overflows, so large that nothing radiates."""
    j, y = (derivatives(table(order + 2, x), x)[order] for table in (bessel, yn_table))
    return np.asarray(j**2 + _finite(y) ** 2)


def _finite(value: Array) -> Array:
    return np.nan_to_num(np.minimum(np.abs(value), 1e150), nan=1e150)
