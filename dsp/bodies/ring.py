"""Rings, tube walls, glasses and bowls: walls that bend around their circumference."""

import math
from typing import NamedTuple

import numpy as np

from .material import Array, Material
from .modes import MOST_MODES, Indices, Modes, audible, path, require_positive

CANTILEVER = np.array([1.8751040687, 4.6940911330, 7.8547574382])
"""Roots of cos(b) cosh(b) = -1: a wall held at its foot and free at its rim bends as a cantilever along its height."""


class Doublets(NamedTuple):
    """How a body is not quite round: see `doublets`."""

    split: float
    imperfection: float


def ring(
    material: Material,
    *,
    radius: float,
    thickness: float,
    length: float,
    top: float,
    split: float = 0.0,
    imperfection: float = 20.0,
    pickups: tuple[float, float] = (13.0, -49.0),
) -> Modes:
    """A free ring or tube wall in in-plane bending, its radial displacement cos n theta, n >= 2.

    radius (of the middle line), thickness (radial) and length (axial) in m, top in Hz; the strike path is half the
    circumference from angle 0, the pickups are angles in degrees; split and imperfection as in `doublets`. ValueError
    names what is out of range. omega = n (n^2 - 1)/sqrt(n^2 + 1) sqrt(E h^2/(12 rho R^4)) (Hoppe 1871), lowered by
    shear and rotation where waves are short.
    """
    require_positive(radius=radius, thickness=thickness, length=length)
    order = np.arange(2.0, MOST_MODES + 2)
    mass = 2 * math.pi * radius * thickness * length * material.density
    frequency = _bending(material, radius, thickness, order)
    return _around(material, frequency, order, Doublets(split, imperfection), (mass, mass / 2), top, pickups)


def glass(
    material: Material,
    *,
    radius: float,
    height: float,
    thickness: float,
    top: float,
    rows: int = 1,
    split: float = 0.0,
    imperfection: float = 20.0,
    pickups: tuple[float, float] = (13.0, -49.0),
) -> Modes:
    """A wine glass or bowl, held at its foot: cos n theta around it, a cantilever's shape m up its wall.

    Lengths in m, top in Hz; rows: the number of m, 1 to 3; the strike path is half the rim from angle 0, the pickups
    are angles at the rim in degrees; split and imperfection as in `doublets`. ValueError names what is out of range.
    omega = omega_ring(n) sqrt(1 + b_m^4/(n^2 - 1)^2 (R/H)^4): for n = 2, m = 1 this is French's formula (Am. J. Phys.
    51, 1983), whose factor 4/3 is 1.875^4/9 rounded. Stretching of the wall is left out, as there.
    """
    require_positive(radius=radius, height=height, thickness=thickness)
    if not 1 <= rows <= CANTILEVER.size:
        raise ValueError(f"rows = {rows}: expected 1 to {CANTILEVER.size}")
    order, row = (grid.ravel() for grid in np.meshgrid(np.arange(2.0, MOST_MODES + 2), CANTILEVER[:rows]))
    mass = 2 * math.pi * radius * thickness * height * material.density
    frequency = _bending(material, radius, thickness, order)
    frequency *= np.sqrt(1 + row**4 / (order**2 - 1) ** 2 * (radius / height) ** 4)
    # A cantilever's tip moves by twice the rms of its length, whatever its mode.
    return _around(material, frequency, order, Doublets(split, imperfection), (mass, mass / 8), top, pickups)


def doublets(frequency: Array, order: Array, split: float, imperfection: float) -> tuple[Array, Indices, Array]:
    """The modes cos and sin of n theta of a nearly round body, from those of the round one.

    frequency (Hz) and order n (k,); split: relative difference of frequency within a pair; imperfection: angle
    (degrees) of the nodal lines to the strike path. Returns frequencies, indices into (k,), and phases p (rad) such
    that the shape is cos(n theta - p). A round body (split 0) and n = 0 have one member each, that which the strike
    excites.
    """
    which = np.arange(frequency.size)
    if split == 0:
        return frequency, which, np.zeros_like(frequency)
    pairs = which[order > 0]
    turn = order * math.radians(imperfection)
    lower = np.where(order > 0, 1 - split / 2, 1.0)
    return (
        np.concatenate([frequency * lower, frequency[pairs] * (1 + split / 2)]),
        np.concatenate([which, pairs]),
        np.concatenate([turn, turn[pairs] + math.pi / 2]),
    )


def _bending(material: Material, radius: float, thickness: float, order: Array) -> Array:
    """Frequencies (Hz) of a ring, lowered by shear and rotation where the waves are short.

    That is the lower branch of Timoshenko's bar to first order in (k h)^2, k = n / R, for a rectangle's 5/6.
    """
    hoppe = order * (order**2 - 1) / np.sqrt(order**2 + 1) * thickness / radius**2
    hoppe *= math.sqrt(material.youngs_modulus / (12 * material.density)) / (2 * math.pi)
    shear = material.youngs_modulus / (5 / 6 * material.shear_modulus)
    return hoppe / np.sqrt(1 + (order * thickness / radius) ** 2 / 12 * (1 + shear))


def _around(
    material: Material,
    frequency: Array,
    order: Array,
    members: Doublets,
    masses: tuple[float, float],
    top: float,
    pickups: tuple[float, float],
) -> Modes:
    """The modes of a wall, from the frequencies of its orders; masses (kg): its own, and of radial motion alone."""
    mass, modal_mass = masses
    frequency, which, phase = doublets(frequency, order, *members)
    keep = audible(frequency, top)
    frequency, order, phase = frequency[keep], order[which[keep]], phase[keep]
    # An inextensible wall also moves along its circumference, by 1/n of its radial motion.
    peak = 1 / np.sqrt(modal_mass * (1 + 1 / order**2))

    def shape(angle: Array) -> Array:
        return np.asarray(peak * np.cos(np.outer(angle, order) - phase), np.float64)

    return Modes(
        frequency=frequency,
        decay=material.decay(frequency),
        strike=shape(math.pi * path(math.pi * order.max())),
        pickup=shape(np.radians(pickups)),
        mass=mass,
    )
