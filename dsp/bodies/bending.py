"""Bars in bending, thick ones too."""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from .eigen import eigh
from .material import Array, Material
from .ritz import basis, converged, quadrature, terms_for
from .shearing import strips_stiffness

_LEAST = 1e-300  # keeps a quotient finite


class Section(NamedTuple):
    """Area (m^2), second moment (m^4) and shear coefficient (p,) at points of a bar; and of a rectangle its width and
    depth (m)."""

    area: Array
    moment: Array
    shear: Array
    width: Array | None = None
    depth: Array | None = None


class Motion(NamedTuple):
    """Modes of one kind of a bar's motion.

    frequency (n,) in Hz, ascending. shape: positions (p,) in 0..1 -> (p, n), mass-normalised: a deflection in kg^-1/2,
    or an angle of twist in kg^-1/2 / m; slope: its derivative by the length. terms: of the series of both.
    wavenumber (rad/m): that of the shortest wave.
    """

    frequency: Array
    shape: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    terms: int
    wavenumber: float
    beyond: "Beyond"


class Beyond(NamedTuple):
    """Exact modes above those of a Motion: frequency (k,) in Hz and shape as there, and where they end (Hz)."""

    frequency: Array
    shape: Callable[[Array], Array]
    last: float


def bending(
    material: Material,
    length: float,
    clamped: bool,
    top: float,
    section: Callable[[Array], Section],
    kinks: tuple[float, ...] = (),
) -> Motion:
    """Return the modes of a bar that bends in one plane, up to `top` (Hz), of sections at points in -1..1; free or
    clamped at -1.

    kinks: the points in -1..1 between which sections change smoothly, ascending. Ritz's method on 1/2 int E I psi'^2
    + kappa G A (w' - psi)^2, masses rho A and rho I (Timoshenko 1921), with Legendre polynomials for the deflection w
    and the rotation psi.
    """
    thinnest = section(np.zeros(1))
    terms = terms_for(length / 2 * _wavenumber(material, thinnest, top))
    points = quadrature(4 * terms, kinks)
    frequency, vector = _solve(material, points, section(points[0]), length / 2, (terms, clamped))
    kept = converged(terms, 0 if clamped else 2)
    return motion_of(
        Series(
            frequency[kept],
            vector[: terms + 1, kept],
            lambda positions: basis(2 * positions - 1, terms + 1, clamped)[0],
            lambda positions: basis(2 * positions - 1, terms + 1, clamped)[1] * (2 / length),
        ),
        top,
        terms + 2,
        lambda highest: _wavenumber(material, thinnest, highest),
    )


class Series(NamedTuple):
    """Exact modes of a Ritz series: frequency (k,) in Hz, ascending, vector (t, k), and the terms that it is for.

    values, slopes: positions (p,) in 0..1 -> the terms there and their derivatives by the length (p, t).
    """

    frequency: Array
    vector: Array
    values: Callable[[Array], Array]
    slopes: Callable[[Array], Array]


def motion_of(series: Series, top: float, terms: int, wavenumber: Callable[[float], float]) -> Motion:
    """Return the motion of a series' modes up to `top` (Hz); wavenumber: rad/m of the shortest wave at a frequency
    (Hz)."""
    frequency, vector, values, slopes = series
    count = int((frequency <= top).sum())

    def shape(modes: slice, positions: Array) -> Array:
        return np.asarray(values(positions) @ vector[:, modes])

    return Motion(
        frequency[:count],
        partial(shape, slice(count)),
        lambda positions: slopes(positions) @ vector[:, :count],
        terms,
        wavenumber(float(frequency[count - 1])) if count else 0.0,
        Beyond(frequency[count:], partial(shape, slice(count, None)), float(frequency[-1])),
    )


def _solve(
    material: Material, points: tuple[Array, Array], section: Section, half: float, series: tuple[int, bool]
) -> tuple[Array, Array]:
    """Solve Ritz's eigenvalue problem of a bar of length 2 `half` (m), by its sections at the points of a quadrature.

    series: how many terms, and whether they are clamped at -1. Return all its frequencies (Hz), and the series of w
    and psi (2 terms + 1, modes) in `basis`.
    """
    nodes, weights = points
    terms, clamped = series
    area, moment, kappa = section[:3]
    w, slope = basis(nodes, terms + 1, clamped)
    psi, bend = basis(nodes, terms, clamped)  # one degree less, so that thin bars can be free of shear

    # Psi is kept times half, so that both unknowns are lengths and x is in -1..1.
    ei = weights * material.youngs_modulus * moment / half**3
    kga = weights * kappa * material.shear_modulus * area / half
    stiffness = np.block(
        [
            [slope.T * kga @ slope, -slope.T * kga @ psi],
            [-psi.T * kga @ slope, bend.T * ei @ bend + psi.T * kga @ psi],
        ]
    )
    inertia = np.zeros_like(stiffness)
    inertia[: terms + 1, : terms + 1] = w.T * (weights * material.density * area * half) @ w
    inertia[terms + 1 :, terms + 1 :] = psi.T * (weights * material.density * moment / half) @ psi
    eigenvalue, vector = eigh(stiffness, inertia)
    square = np.maximum(eigenvalue, 0)
    turned = psi @ vector[terms + 1 :]
    bent = ei[:, None] * (bend @ vector[terms + 1 :]) ** 2
    # What the moment changes by along the bar, times the weights: the shear force and the section's own turning.
    change = kga[:, None] * (slope @ vector[: terms + 1] - turned)
    change += (weights * material.density * moment / half)[:, None] * square * turned
    square = square + _widening(material, section, square, bent, change**2 / (ei[:, None] * half**2))
    return np.sqrt(square) / (2 * np.pi), vector


def _widening(material: Material, section: Section, square: Array, bent: Array, changing: Array) -> Array:
    """Return by how much the squares of angular frequencies (n,) rise as a wide section can't curve across; 0 for one
    that is no rectangle.

    bent: twice the energy of bending (p, n) at points, by weights; changing: the same of its moment's derivative. A
    section twists where the moment changes: waves count as long as those that change as much, as at free ends less
    does.
    """
    if section.width is None or section.depth is None:
        return np.zeros_like(square)
    waves = _local_waves(material, section, square)
    share = changing.sum(axis=0) / np.maximum((bent * waves**2).sum(axis=0), _LEAST)
    waves *= np.sqrt(np.minimum(share, 1))
    stiffer = strips_stiffness(material, section.width, section.depth, waves)
    return np.asarray((bent * (stiffer - 1)).sum(axis=0))


def _local_waves(material: Material, section: Section, square: Array) -> Array:
    """Return the wavenumbers (p, n), rad/m, of a bar's sections (p,) by the squares of angular frequencies (n,)."""
    area, moment, kappa = (each[:, None] for each in section[:3])
    depth = moment / area * (1 + material.youngs_modulus / (kappa * material.shear_modulus))
    bent = square * material.density * area / (material.youngs_modulus * moment)
    # q^4 = bent (1 + depth q^2): Timoshenko's to the first order
    return np.sqrt(0.5 * (bent * depth + np.sqrt((bent * depth) ** 2 + 4 * bent)))


def _wavenumber(material: Material, section: Section, frequency: float) -> float:
    """Return the larger wavenumber (rad/m) of Timoshenko's dispersion relation for a section at a frequency (Hz)."""
    (area,), (moment,), (kappa,) = section[:3]
    e, rho, kg = material.youngs_modulus, material.density, kappa * material.shear_modulus
    square = (2 * np.pi * frequency) ** 2
    b = rho * moment * (1 + e / kg) * square
    c = rho * area * square - rho**2 * moment / kg * square**2
    return math.sqrt((b + math.sqrt(b**2 + 4 * e * moment * c)) / (2 * e * moment))
