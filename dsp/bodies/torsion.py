"""Bars of rectangular section that twist."""

import math
from collections.abc import Callable

import numpy as np

from .bending import Motion, Series, motion_of
from .eigen import eigh
from .material import Array, Material
from .ritz import basis, converged, quadrature, terms_for

_SERIES = np.arange(1.0, 40.0, 2.0)[:, None]  # Saint-Venant's series falls as n^-5


def torsion(
    material: Material,
    length: float,
    clamped: bool,
    top: float,
    width: float,
    depth: Callable[[Array], tuple[Array, Array]],
    kinks: tuple[float, ...] = (),
) -> Motion:
    """Return the modes of a bar that twists, up to `top` (Hz), free or clamped at -1; an angle theta is its unknown.

    depth: the thickness (m) and its derivative along -1..1, at points there, smooth between `kinks`. Ritz's method with
    Legendre polynomials on 1/2 int G J theta'^2 + E Gamma chi'^2, masses rho I theta^2 + rho Gamma chi^2: J is
    Saint-Venant's constant (Timoshenko and Goodier, Theory of Elasticity, art. 109), I the polar moment,
    Gamma = w^3 t^3/144. The section's points move along the bar by y z chi, chi = -(w^2 - t^2)/(w^2 + t^2) theta',
    which is Vlasov's warping where t is small against w, and none in a square.
    """
    half = length / 2
    thinnest = depth(np.zeros(1))[0]
    terms = terms_for(half * _wavenumber(material, width, thinnest, top))
    nodes, weights = quadrature(4 * terms, kinks)
    thickness, slope = depth(nodes)
    constant, polar, warping, gamma = _section(width, thickness)
    bent = -4 * width**2 * thickness * slope / (width**2 + thickness**2) ** 2  # the derivative of `warping`
    # Theta is kept times half the length, so that the unknown is a length and x is in -1..1.
    theta, twist, change = basis(nodes, terms, clamped, derivatives=2)
    rate = warping[:, None] * change + bent[:, None] * twist
    gj = weights * material.shear_modulus * constant / half**3
    eg = weights * material.youngs_modulus * gamma / half**5
    mass = weights * material.density * polar / half
    warp = weights * material.density * gamma * warping**2 / half**3
    eigenvalue, vector = eigh(
        twist.T * gj @ twist + rate.T * eg @ rate,
        theta.T * mass @ theta + twist.T * warp @ twist,
    )
    kept = converged(terms, 0 if clamped else 1)
    return motion_of(
        Series(
            np.sqrt(np.maximum(eigenvalue[kept], 0)) / (2 * math.pi),
            vector[:, kept] / half,
            lambda positions: basis(2 * positions - 1, terms, clamped)[0],
            lambda positions: basis(2 * positions - 1, terms, clamped)[1] / half,
        ),
        top,
        terms + 1,
        lambda highest: _wavenumber(material, width, thinnest, highest),
    )


def _section(width: float, thickness: Array) -> tuple[Array, Array, Array, Array]:
    """Return Saint-Venant's constant (m^4), polar moment (m^4), -chi/theta' and Gamma (m^6), each (p,)."""
    long, short = np.maximum(width, thickness), np.minimum(width, thickness)
    series = (np.tanh(_SERIES * math.pi / 2 * long / short) / _SERIES**5).sum(axis=0)
    constant = long * short**3 / 3 * (1 - 192 / math.pi**5 * short / long * series)
    polar = width * thickness * (width**2 + thickness**2) / 12
    warping = (width**2 - thickness**2) / (width**2 + thickness**2)
    return constant, polar, warping, (width * thickness) ** 3 / 144


def _wavenumber(material: Material, width: float, thickness: Array, frequency: float) -> float:
    """Return the wavenumber (rad/m) of a section's torsional wave at a frequency (Hz)."""
    constant, polar, warping, gamma = (float(value[0]) for value in _section(width, thickness))
    square = (2 * math.pi * frequency) ** 2
    gamma *= warping**2
    b = material.shear_modulus * constant - material.density * gamma * square
    c = 4 * material.youngs_modulus * gamma * material.density * polar * square
    # E Gamma k^4 + b k^2 = rho I omega^2
    return math.sqrt(2 * material.density * polar * square / (b + math.sqrt(b**2 + c)))
