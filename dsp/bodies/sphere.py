"""Solid spheres, free in air."""

import math
from dataclasses import replace

import numpy as np

from . import acceleration
from .heard import heard
from .material import Array, Material
from .modes import MOST_MODES, Modes, require_positive
from .radiation.air import IMPEDANCE, wavenumber
from .radiation.closed import sphere_efficiency

_STEP = 0.02  # of k a between two looks for a sign's change: neighbouring roots lie 0.5 and more apart
_LEAST = 0.5  # k a below which there is no root: the lowest is above 2
_NODES = 96  # of the quadrature along the radius


def sphere(material: Material, *, radius: float, top: float) -> Modes:
    """A solid elastic sphere, struck along its normal; radius in m, top in Hz. ValueError if it is out of range.

    Spheroidal modes of orders n = 0, 1, 2, ...: a blow at the pole moves those that are symmetric about it, with
    u_r = U(r) P_n. With x = omega a/c_l and y = omega a/c_t the surface is free of forces where T11 T43 = T13 T41,

        T11 = (n^2 - n - y^2/2) j_n(x) + 2 x j_{n+1}(x),  T13 = n (n + 1) ((n - 1) j_n(y) - y j_{n+1}(y)),
        T41 = (n - 1) j_n(x) - x j_{n+1}(x),              T43 = (n^2 - 1 - y^2/2) j_n(y) + y j_{n+1}(y)

    (H. Lamb, Proc. London Math. Soc. 13, 1882; A. C. Eringen and E. S. Suhubi, Elastodynamics II, 1975, 8.14). Where it
    is struck does not matter, and it is heard alike all around. A small one has no mode that is heard, but its click.
    """
    require_positive(radius=radius)
    shear = math.sqrt(material.shear_modulus / material.density)
    ratio = math.sqrt((1 - 2 * material.poisson_ratio) / (2 - 2 * material.poisson_ratio))  # c_t/c_l
    highest = 2 * math.pi * top * radius / shear
    found = [(y, n) for n in range(int(1.2 * highest) + 3) for y in _roots(n, ratio, highest)]
    found = sorted(found)[:MOST_MODES]
    roots, orders = np.array([y for y, _ in found]), np.array([n for _, n in found], np.int64)
    frequency = roots * shear / (2 * math.pi * radius)
    mass = material.density * 4 / 3 * math.pi * radius**3
    shape = np.array([_at_pole(n, ratio, y) for y, n in found]) / math.sqrt(mass)
    efficiency = [
        float(sphere_efficiency(int(n), np.array(wavenumber(f) * radius)))
        for n, f in zip(orders, frequency, strict=True)
    ]
    area = 4 * math.pi * radius**2
    resistance = IMPEDANCE * area * np.array(efficiency) * shape**2 / (2 * orders + 1)
    made = heard(material, frequency, resistance, (shape[None], shape), mass)
    return replace(made, clicks=(acceleration.sphere(mass, radius),))


def _bessel(n: int, z: Array) -> tuple[Array, Array]:
    """j_n and j_{n+1}."""
    from scipy.special import spherical_jn

    return spherical_jn(n, z), spherical_jn(n + 1, z)


def _terms(n: int, ratio: float, y: Array) -> tuple[Array, Array, Array, Array]:
    """T11, T13, T41 and T43."""
    x = ratio * y
    (j, above), (s, s_above) = _bessel(n, x), _bessel(n, y)
    return (
        (n * n - n - y**2 / 2) * j + 2 * x * above,
        n * (n + 1) * ((n - 1) * s - y * s_above),
        (n - 1) * j - x * above,
        (n * n - 1 - y**2 / 2) * s + y * s_above,
    )


def _roots(n: int, ratio: float, highest: float) -> list[float]:
    """The y up to `highest` at which modes of order n are."""
    from scipy.optimize import brentq

    def determinant(y: Array) -> Array:
        t11, t13, t41, t43 = _terms(n, ratio, y)
        return t11 if n == 0 else t11 * t43 - t13 * t41

    if highest <= _LEAST:
        return []
    grid = np.arange(_LEAST, highest + _STEP, _STEP)
    sign = np.sign(determinant(grid))
    places = np.flatnonzero(sign[1:] * sign[:-1] < 0)
    found = [brentq(determinant, grid[i], grid[i + 1], xtol=1e-12) for i in places]
    return [y for y in found if y <= highest]


def _at_pole(n: int, ratio: float, y: float) -> float:
    """The radial motion at the pole of a mode whose mean square over the volume is 1."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    r = np.append(0.5 * (nodes + 1), 1.0)
    t11, t13, t41, t43 = (float(each) for each in _terms(n, ratio, np.array(y)))
    share = 0.0 if n == 0 else (-t11 / t13 if abs(t13) > abs(t43) else -t41 / t43)
    (j, above), (s, s_above) = _bessel(n, ratio * y * r), _bessel(n, y * r)
    radial = (n * j - ratio * y * r * above + share * n * (n + 1) * s) / r
    along = (j + share * ((n + 1) * s - y * r * s_above)) / r
    square = (radial**2 + n * (n + 1) * along**2)[:-1] @ (0.5 * weights * r[:-1] ** 2)
    return float(radial[-1] / math.sqrt(3 * square / (2 * n + 1)))
