"""Bars of rectangular section that twist."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from .bending import Motion, Series, motion_of
from .eigen import eigh
from .material import Array, Material
from .ritz import basis, converged, quadrature, terms_for
from .twisting import MOTIONS, Constants, constants


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
    Legendre polynomials for each of the section's motions (`twisting`): it turns, warps and is distorted. A clamp holds
    them all.
    """
    half = length / 2 / width  # all lengths are over the width here
    waves = partial(_wavenumber, material, width, constants(depth(np.zeros(1))[0] / width, material.poisson_ratio))
    terms = terms_for(length / 2 * waves(top))
    nodes, weights = quadrature(4 * terms, kinks)
    thickness, change = depth(nodes)
    section = _carved(material, constants(thickness / width, material.poisson_ratio), change / width / half)
    # One term less for all but the angle, so that slender bars can be free of shear.
    series = [basis(nodes, terms if motion else terms + 1, clamped) for motion in range(MOTIONS)]
    eigenvalue, vector = eigh(*_forms(material, section, series, weights * half, half))
    kept = converged(terms, 0 if clamped else 1)
    speed = math.sqrt(material.shear_modulus / material.density)
    return motion_of(
        Series(
            np.sqrt(np.maximum(eigenvalue[kept], 0)) * speed / (2 * math.pi * width),
            vector[: terms + 1, kept] / math.sqrt(material.density * width**5),
            lambda positions: basis(2 * positions - 1, terms + 1, clamped)[0],
            lambda positions: basis(2 * positions - 1, terms + 1, clamped)[1] * (2 / length),
        ),
        top,
        terms + 2,
        waves,
    )


def _forms(
    material: Material, section: Constants, series: list[list[Array]], weights: Array, half: float
) -> tuple[Array, Array]:
    """Return the quadratic forms of stiffness, over the shear modulus, and inertia, over the density.

    series: of each motion, values and derivatives (p, terms) at points in -1..1 of a bar of length 2 `half`; weights
    (p,): of their quadrature along it.
    """
    axial = _axial(material, section)
    stiffness, inertia = [], []
    for i, (value, slope) in enumerate(series):
        rows = []
        for j, (other, other_slope) in enumerate(series):
            along = slope.T * (weights / half**2 * axial[:, i, j]) @ other_slope
            one = slope.T * (weights / half * section.mixed[:, i, j]) @ other
            two = value.T * (weights / half * section.mixed[:, j, i]) @ other_slope
            rows.append(along + one + two + value.T * (weights * section.value[:, i, j]) @ other)
        stiffness.append(rows)
        inertia.append([value.T * (weights * section.mass[:, i, j]) @ other for j, (other, _) in enumerate(series)])
    return np.block(stiffness), np.block(inertia)


def _carved(material: Material, section: Constants, change: Array) -> Constants:
    """Return the constants of sections with what the warping stretches as it changes with the thickness over the width,
    by its derivative along the bar (p,)."""
    stiff = material.youngs_modulus / material.shear_modulus * section.changing
    mixed, value = section.mixed.copy(), section.value.copy()
    mixed[:, 1, 1] += stiff[:, 0] * change
    value[:, 1, 1] += stiff[:, 1] * change**2
    return section._replace(mixed=mixed, value=value)


def _axial(material: Material, section: Constants) -> Array:
    """Return what weighs the slopes of the section's motions along the bar (p, 4, 4), over the shear modulus."""
    return np.asarray(material.youngs_modulus / material.shear_modulus * section.stretch + section.slope)


def _wavenumber(material: Material, width: float, section: Constants, frequency: float) -> float:
    """Return the largest wavenumber (rad/m) of the waves of twist at a frequency (Hz), by the constants of a section
    (1, 4, 4)."""
    square = (2 * math.pi * frequency * width) ** 2 * material.density / material.shear_modulus
    # k^2 axial + i k (mixed^T - mixed) + value - square mass is singular.
    lead = np.linalg.inv(_axial(material, section)[0])
    mixed = section.mixed[0]
    whole = np.block(
        [
            [np.zeros((MOTIONS, MOTIONS)), np.eye(MOTIONS)],
            [-lead @ (section.value - square * section.mass)[0], -1j * lead @ (mixed.T - mixed)],
        ]
    )
    found = np.linalg.eigvals(whole)
    running = found.real[np.abs(found.imag) < 1e-6 * np.abs(found)]
    return float(running.max()) / width
