"""Radiation efficiencies of closed bodies, in closed form.

The efficiency is sigma in W = sigma rho c <v^2>, W the power radiated per area and <v^2> the mean square velocity.
"""

import math

import numpy as np

from ..material import Array
from ..modes import Indices


def sphere_efficiency(order: int | Indices, x: Array) -> Array:
    """Return the radiation efficiency of a sphere's spherical harmonics of order n, at x = k a: 1/(x^2 |h_n'(x)|^2)."""
    from scipy.special import spherical_jn, spherical_yn

    square = spherical_jn(order, x, True) ** 2 + _finite(spherical_yn(order, x, True)) ** 2
    efficiency: Array = 1 / (x**2 * square)
    return efficiency


def cylinder_efficiency(order: int, x: Array) -> Array:
    """Return the radiation efficiency of a long cylinder's cos m theta, at x = k a: 2/(pi x |H_m'(x)|^2)."""
    efficiency: Array = 2 / (math.pi * x * radial_function(order, x))
    return efficiency


def radial_function(order: int, x: Array) -> Array:
    """Return |H_m'(x)|^2; where it overflows, so large that nothing radiates."""
    from scipy.special import jvp, yvp

    with np.errstate(invalid="ignore"):  # two infinities
        square: Array = jvp(order, x) ** 2 + _finite(yvp(order, x)) ** 2
    return square


def _finite(value: Array) -> Array:
    return np.nan_to_num(np.minimum(np.abs(value), 1e150), nan=1e150)
