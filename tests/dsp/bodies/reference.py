"""Bodies that the tests share, and what is known of them otherwise."""

import math

import numpy as np
from numpy.polynomial import legendre
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from carom.dsp import bodies
from carom.dsp.bodies import Material

STEEL = Material("steel", 7850, 2e11, 0.3, 5, 3e-8)
GLASSY = Material("nu = 0.225", 2500, 7e10, 0.225, 1, 1e-7)
HEAVY = Material("steel that no air moves", 7850e9, 2e20, 0.3, 5, 3e-8)
"""A material with the frequencies of STEEL without air."""
FREE_ROOTS = [brentq(lambda x: math.cos(x) * math.cosh(x) - 1, x - 1, x + 1) for x in np.pi * np.arange(1.5, 8)]


def euler_bernoulli(material, roots, length, thickness):
    speed = math.sqrt(material.youngs_modulus / (12 * material.density)) * thickness
    return np.square(roots) / (2 * math.pi * length**2) * speed


def plate_unit(material, thickness, side):
    """Return the Hz of lambda^2 = 1."""
    rigidity = material.contact_modulus * thickness**3 / 12
    return math.sqrt(rigidity / (material.density * thickness)) / (2 * math.pi * side**2)


def free_plate(sides, poisson, wavenumber):
    """Return the squares of the wavenumbers (1/m^2) of a free rectangular plate's modes up to one, by plain Legendre
    polynomials.

    Ritz's method with as many for each side (m) as resolve its waves, and 20 more.
    """
    counts = [math.ceil(wavenumber * side / 2) + 20 for side in sides]
    (slope_x, bend_x, curve_x), (slope_y, bend_y, curve_y) = map(_legendre, sides, counts)
    mixed = np.einsum("ik,lj->ijkl", curve_x, curve_y)
    twist = np.einsum("ik,jl->ijkl", slope_x, slope_y)
    bent = np.einsum("ik,jl->ijkl", bend_x, np.eye(counts[1])) + np.einsum("ik,jl->ijkl", np.eye(counts[0]), bend_y)
    energy = bent + poisson * (mixed + mixed.transpose(2, 3, 0, 1)) + 2 * (1 - poisson) * twist
    found = np.sqrt(np.maximum(np.linalg.eigvalsh(energy.reshape(2 * (math.prod(counts),))), 0))[3:]
    return found[found <= wavenumber**2]


def _legendre(side, count):
    """Return int P_i' P_k', int P_i'' P_k'' and int P_i'' P_k of orthonormal Legendre polynomials over a side (m)."""
    values = np.diag(np.sqrt((2 * np.arange(count) + 1) / side))
    slope, bend = (legendre.legder(values, order, axis=1) * (2 / side) ** order for order in (1, 2))
    norm = side / (2 * np.arange(count) + 1)
    return slope * norm[:-1] @ slope.T, bend * norm[:-2] @ bend.T, bend * norm[:-2] @ values[:, :-2].T


def integral_along(modes):
    """Return int_0^1 phi_i phi_j over the strike path, by an interpolating spline."""
    x = np.linspace(0, 1, 2001)
    value = CubicSpline(np.linspace(0, 1, len(modes.strike)), modes.strike)(x)
    return simpson(value[:, :, None] * value[:, None, :], x=x, axis=0)


EVERY = {
    "bar": lambda material=STEEL, **more: bodies.bar(material, length=0.5, width=0.03, thickness=0.008, **more),
    "undercut": lambda material=STEEL, **more: bodies.bar(
        material, length=0.4, width=0.05, thickness=0.02, undercut=0.75, **more
    ),
    "tube": lambda material=STEEL, **more: bodies.bar(material, length=1.4, diameter=0.038, wall=0.0015, **more),
    "tine": lambda material=STEEL, **more: bodies.bar(
        material, length=0.2, width=0.01, thickness=0.001, ends="cantilever", **more
    ),
    "string": lambda material=STEEL, **more: bodies.string(material, length=0.62, diameter=0.001, tension=670, **more),
    "plate": lambda material=STEEL, **more: bodies.plate(material, length=0.4, width=0.3, thickness=0.003, **more),
    "clamped plate": lambda material=STEEL, **more: bodies.plate(
        material,
        length=0.3,
        width=0.2,
        thickness=0.002,
        edges=("clamped", "free", "supported", "clamped"),
        **more,
    ),
    "disc": lambda material=STEEL, **more: bodies.disc(material, radius=0.2, thickness=0.003, split=0.004, **more),
    "clamped disc": lambda material=STEEL, **more: bodies.disc(
        material, radius=0.1, thickness=0.001, edge="clamped", **more
    ),
    "membrane": lambda material=STEEL, **more: bodies.membrane(
        material, radius=0.15, thickness=2e-4, fundamental=900, **more
    ),
    "ring": lambda material=STEEL, **more: bodies.ring(
        material, radius=0.06, thickness=0.003, length=0.01, split=0.002, **more
    ),
    "glass": lambda material=STEEL, **more: bodies.glass(
        material, radius=0.04, height=0.08, thickness=0.001, rows=3, split=0.002, **more
    ),
    "can": lambda material=STEEL, **more: bodies.can(
        material, radius=0.02, height=0.05, thickness=5e-4, split=0.002, **more
    ),
    "listed": lambda **more: bodies.listed(
        frequency=[300.0, 100.0, 200.0], t60=[1, 3, 2], modal_mass=[3.0, 1.0, 2.0], mass=8, **more
    ),
}
"""Every shape, with enough modes to be demanding, and doublets where it has them."""
