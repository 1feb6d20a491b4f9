"""Solid spheres, free in air."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from . import acceleration
from .acceleration import Click
from .air import IMPEDANCE, wavenumber
from .heard import heard
from .material import Array, Material
from .modes import MOST_MODES, Indices, Modes, ascending, require_positive
from .radiation.closed import sphere_efficiency

_STEP = 0.05  # of y between two looks for a sign's change: the roots of an order lie 0.068 and more apart
_LEAST = 0.5  # y below which there is no root: the lowest is above 2
_MOST = math.sqrt(8 * MOST_MODES)  # y below which there are more modes than are kept: shear waves alone have y^2/8
_SLOWEST = 0.89  # y/n below which an order has no root: its lowest is a Rayleigh wave that runs around the sphere
_BEYOND = 40  # orders between the highest that is wanted and the first of the recurrence of Bessel functions
_LOOKS = 8  # at a root, whose error is then that of rounding


def sphere(material: Material, *, radius: float, top: float) -> Modes:
    """Return the modes of a solid elastic sphere, struck along its normal.

    Parameters
    ----------
    material : Material
        Material of the body.
    radius : float
        Radius a, m.
    top : float
        Highest frequency of a mode, Hz.

    Returns
    -------
    Modes
        The modes from 1 Hz up to `top`. A small sphere has none; only its click is heard.

    Raises
    ------
    ValueError
        An argument is out of range; the text names it.

    Notes
    -----
    Spheroidal modes of orders n = 0, 1, 2, ...: a blow at the pole moves those that are symmetric about it, with
    u_r = U(r) P_n. With x = omega a/c_l and y = omega a/c_t the surface is free of forces where T11 T43 = T13 T41,

        T11 = (n^2 - n - y^2/2) j_n(x) + 2 x j_{n+1}(x),  T13 = n (n + 1) ((n - 1) j_n(y) - y j_{n+1}(y)),
        T41 = (n - 1) j_n(x) - x j_{n+1}(x),              T43 = (n^2 - 1 - y^2/2) j_n(y) + y j_{n+1}(y)

    (H. Lamb, Proc. London Math. Soc. 13, 1882; A. C. Eringen and E. S. Suhubi, Elastodynamics II, 1975, 8.14). The
    striking point does not matter, and the sphere is heard alike from all sides.
    """
    require_positive(radius=radius)
    shear = math.sqrt(material.shear_modulus / material.density)
    ratio = math.sqrt((1 - 2 * material.poisson_ratio) / (2 - 2 * material.poisson_ratio))  # c_t/c_l
    roots, orders = _roots(ratio, min(2 * math.pi * top * radius / shear, _MOST))
    frequency = roots * shear / (2 * math.pi * radius)
    mass = material.density * 4 / 3 * math.pi * radius**3
    shape = _at_pole(orders, ratio, roots) / math.sqrt(mass)
    efficiency = sphere_efficiency(orders, wavenumber(frequency) * radius)
    area = 4 * math.pi * radius**2
    resistance = IMPEDANCE * area * efficiency * shape**2 / (2 * orders + 1)
    made = heard(material, frequency, resistance, (shape[None], shape), mass)
    return replace(made, clicks=sphere_clicks(material, radius=radius))


def sphere_clicks(material: Material, *, radius: float) -> tuple[Click, ...]:
    """Return the click of a sphere; arguments as of `sphere`."""
    return (acceleration.sphere(material.density * 4 / 3 * math.pi * radius**3, radius),)


class _Wave(NamedTuple):
    """j_n and j_{n+1} at z, each over the root of the sum of their squares."""

    n: Indices
    z: Array
    at: Array
    above: Array

    def of(self, orders: Indices) -> "_Wave":
        """Select, from waves of all orders from 0 on, (orders, k), that of the order given for each z, (k,)."""
        places = orders, np.arange(self.z.size)
        return _Wave(orders, self.z, self.at[places], self.above[places])


def _waves(count: int, z: Array) -> _Wave:
    """Return the waves of so many orders from 0 on, (count, k), at z (k,).

    j_{n+1}/j_n follows from the ratio of the next order, which is stable, and neither overflows nor vanishes (W.
    Gautschi, SIAM Review 9, 1967).
    """
    ratios = np.empty((count, z.size))
    now = np.zeros(z.size)
    for n in range(count + _BEYOND, -1, -1):
        now = 1 / ((2 * n + 3) / z - now + 1e-300)  # not by 0, where j_n is
        if n < count:
            ratios[n] = now
    signs = np.where(np.vstack([np.sin(z), ratios[:-1]]) < 0, -1.0, 1.0)
    at = np.cumprod(signs, axis=0) / np.hypot(1.0, ratios)
    return _Wave(np.arange(count)[:, None], z, at, at * ratios)


def _terms(of_pressure: _Wave, of_shear: _Wave) -> tuple[Array, Array, Array, Array]:
    """Return T11, T13, T41 and T43."""
    n, x, j, above = of_pressure
    _, y, s, s_above = of_shear
    return (
        (n * n - n - y**2 / 2) * j + 2 * x * above,
        n * (n + 1) * ((n - 1) * s - y * s_above),
        (n - 1) * j - x * above,
        (n * n - 1 - y**2 / 2) * s + y * s_above,
    )


def _determinant(of_pressure: _Wave, of_shear: _Wave) -> Array:
    """Return a determinant that is 0 where a mode is; one that breathes, of order 0, has no wave of shear."""
    t11, t13, t41, t43 = _terms(of_pressure, of_shear)
    return np.where(of_pressure.n == 0, t11, t11 * t43 - t13 * t41)


def _roots(ratio: float, highest: float) -> tuple[Array, Indices]:
    """Return the lowest roots y up to `highest`, at which modes are, and their orders."""
    if highest <= _LEAST:
        return np.empty(0), np.empty(0, np.intp)
    count = int(highest / _SLOWEST) + 2
    grid = np.arange(_LEAST, highest + _STEP, _STEP)
    found = _determinant(_waves(count, ratio * grid), _waves(count, grid))
    orders, places = np.nonzero(found[:, 1:] * found[:, :-1] < 0)

    def determinant(y: Array) -> Array:
        return _determinant(_waves(count, ratio * y).of(orders), _waves(count, y).of(orders))

    ends = (grid[places], found[orders, places]), (grid[places + 1], found[orders, places + 1])
    y = _between(determinant, *ends)
    kept = ascending(y)
    kept = kept[y[kept] <= highest][:MOST_MODES]
    return y[kept], orders[kept]


def _between(function: Callable[[Array], Array], old: tuple[Array, Array], new: tuple[Array, Array]) -> Array:
    """Return the roots between places (k,) at which a function has values of opposite signs: the Illinois method.

    old, new: places and values (M. Dowell and P. Jarratt, BIT 11, 1971).
    """
    (x0, f0), (x1, f1) = old, new
    for _ in range(_LOOKS):
        x = x1 - f1 * (x1 - x0) / (f1 - f0)
        f = function(x)
        same = f * f1 >= 0
        x0, f0 = np.where(same, x0, x1), np.where(same, 0.5 * f0, f1)
        x1, f1 = x, f
    return x1


def _at_pole(orders: Indices, ratio: float, y: Array) -> Array:
    """Return the radial motion at the pole of modes whose mean squares over the volume are 1.

    U = n j - x j_{n+1} + c n (n + 1) s, at the surface and with s = j_n(y); c is the share of the shear wave. The
    integrals of U^2 r^2 and n (n + 1) V^2 r^2, V being the motion along the surface, add up to differentials.
    """
    count = int(orders.max(initial=0)) + 1
    pressure, shear = (_waves(count, z).of(orders) for z in (ratio * y, y))
    t11, t13, t41, t43 = _terms(pressure, shear)
    with np.errstate(divide="ignore", invalid="ignore"):
        c = np.where(np.abs(t13) > np.abs(t43), -t11 / t13, -t41 / t43)
    c = np.where(orders == 0, 0.0, c)
    n, both = orders, orders * (orders + 1)
    (_, x, j, above), (_, _, s, s_above) = pressure, shear
    slope, s_slope = n * j - x * above, n * s - y * s_above  # z j_n'(z), twice
    square = j * slope + _square(pressure)
    square += c**2 * both * (s * (s + s_slope) + _square(shear)) + 2 * c * both * j * s
    radial: Array = (slope + c * both * s) / np.sqrt(3 * square / (2 * n + 1))
    return radial


def _square(wave: _Wave) -> Array:
    """Return z^2 times the integral of j_n(z r)^2 r^2 from 0 to 1: z^2 (j_n^2 - j_{n-1} j_{n+1})/2."""
    n, z, at, above = wave
    return 0.5 * z * (z * (at**2 + above**2) - (2 * n + 1) * at * above)
