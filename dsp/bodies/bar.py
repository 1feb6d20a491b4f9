"""Bars, rods, tubes and tines in bending, thick ones too."""

import math
from collections.abc import Callable
from functools import lru_cache, partial

import numpy as np
from numpy.polynomial import legendre

from .material import Array, Material
from .modes import Modes, audible, path, read_only, require_choice, require_positive

ENDS = ("free", "cantilever")
MOST_TERMS = 160  # of the Ritz series, for the deflection and for the rotation each
_TERMS_PER_RADIAN, _MORE_TERMS = 1.25, 12  # of the half bar's waves: a Ritz series needs pi terms per wave at least
_CONVERGED = 0.6  # share of the modes of a Ritz series that mean something

Section = tuple[Array, Array, float]
"""Area (m^2) and second moment (m^4) at points x in -1..1 of a bar, and the shear coefficient."""


def bar(
    material: Material,
    *,
    length: float,
    top: float,
    width: float | None = None,
    thickness: float | None = None,
    undercut: float = 0.0,
    undercut_span: float = 0.6,
    diameter: float | None = None,
    wall: float | None = None,
    ends: str = "free",
    pickups: tuple[float, float] = (0.03, 0.96),
) -> Modes:
    """A Timoshenko bar, free at both ends or a cantilever (clamped at position 0), bending in one plane.

    Lengths in m, top in Hz. The section is either `width` by `thickness` (the bar bends along its thickness) or round,
    of an outer `diameter` and a `wall` (solid without). `undercut`: the fraction of the thickness carved away at the
    middle, in a parabola over the middle fraction `undercut_span` of the length, as in tuned bars. Strike path and
    pickups: fractions of the length. ValueError names what is out of range.

    Ritz's method on 1/2 int E I psi'^2 + kappa G A (w' - psi)^2, masses rho A and rho I (Timoshenko 1921), with
    Legendre polynomials for the deflection w and the rotation psi; kappa by Cowper (1966).
    """
    require_positive(length=length, width=width, thickness=thickness, diameter=diameter, wall=wall)
    require_choice("ends", ends, ENDS)
    if not 0 <= undercut < 1 or not 0 < undercut_span <= 1:
        raise ValueError(f"undercut = {undercut}, undercut_span = {undercut_span}: expected in [0, 1) and (0, 1]")

    if width is not None and thickness is not None and diameter is None:
        section = partial(_carved_section, width, thickness, undercut, undercut_span, material.poisson_ratio)
    elif diameter is not None and width is None and thickness is None:
        section = partial(_round_section, diameter, wall, material.poisson_ratio)
    else:
        raise ValueError("section: expected width and thickness, or diameter")

    half = length / 2
    thinnest = section(np.zeros(1))
    waves = half * _wavenumber(material, thinnest, top)
    terms = min(MOST_TERMS, math.ceil(_TERMS_PER_RADIAN * waves) + _MORE_TERMS)
    clamped = ends == "cantilever"
    frequency, vector, mass = _solve(material, section, half, terms, clamped)
    rigid = 0 if clamped else 2
    converged = slice(rigid, rigid + math.ceil(_CONVERGED * terms))
    keep = audible(frequency[converged], top)
    frequency, shapes = frequency[converged][keep], vector[: terms + 1, converged][:, keep]
    positions = path(2 * half * _wavenumber(material, thinnest, frequency[-1]))
    return Modes(
        frequency=frequency,
        decay=material.decay(frequency),
        strike=_basis(2 * positions - 1, terms + 1, clamped)[0] @ shapes,
        pickup=_basis(2 * np.asarray(pickups) - 1, terms + 1, clamped)[0] @ shapes,
        mass=mass,
    )


def _solve(
    material: Material, section: Callable[[Array], Section], half: float, terms: int, clamped: bool
) -> tuple[Array, Array, float]:
    """Ritz's eigenvalue problem of a bar of length 2 `half` (m).

    Returns all its frequencies (Hz), the series of w and psi (2 terms + 1, modes) in `_basis`, and the mass (kg).
    """
    from scipy.linalg import eigh

    nodes, weights = _quadrature(4 * terms)
    area, moment, kappa = section(nodes)
    w, slope = _basis(nodes, terms + 1, clamped)
    psi, bend = _basis(nodes, terms, clamped)  # one degree less, so that thin bars can be free of shear

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
    return np.sqrt(np.maximum(eigenvalue, 0)) / (2 * np.pi), vector, float(weights @ area) * material.density * half


@lru_cache(maxsize=MOST_TERMS)  # all there can be, 1 MB; to find them takes as long as the modes
def _quadrature(points: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss and Legendre in -1..1, read-only."""
    nodes, weights = legendre.leggauss(points)
    read_only(nodes, weights)
    return nodes, weights


def _carved_section(width: float, thickness: float, undercut: float, span: float, nu: float, x: Array) -> Section:
    depth = thickness * (1 - undercut * np.maximum(0, 1 - (x / span) ** 2))
    return width * depth, width * depth**3 / 12, 10 * (1 + nu) / (12 + 11 * nu)


def _round_section(diameter: float, wall: float | None, nu: float, x: Array) -> Section:
    bore = 0.0 if wall is None else diameter - 2 * wall
    if bore < 0:
        raise ValueError(f"wall = {wall}: expected at most half the diameter, {diameter / 2}")
    area = math.pi / 4 * (diameter**2 - bore**2)
    moment = math.pi / 64 * (diameter**4 - bore**4)
    ratio = (bore / diameter) ** 2
    kappa = 6 * (1 + nu) * (1 + ratio) ** 2 / ((7 + 6 * nu) * (1 + ratio) ** 2 + (20 + 12 * nu) * ratio)
    return np.full_like(x, area), np.full_like(x, moment), kappa


def _wavenumber(material: Material, section: Section, frequency: float) -> float:
    """The larger wavenumber (rad/m) of Timoshenko's dispersion relation for a section at a frequency (Hz)."""
    (area,), (moment,), kappa = section
    e, rho, kg = material.youngs_modulus, material.density, kappa * material.shear_modulus
    square = (2 * np.pi * frequency) ** 2
    b = rho * moment * (1 + e / kg) * square
    c = rho * area * square - rho**2 * moment / kg * square**2
    return math.sqrt((b + math.sqrt(b**2 + 4 * e * moment * c)) / (2 * e * moment))


def _basis(x: Array, terms: int, clamped: bool) -> tuple[Array, Array]:
    """Values and derivatives (len(x), terms) of normalised Legendre polynomials, zero at -1 where clamped."""
    degree = np.arange(terms + 1)
    scale = np.diag(np.sqrt(degree + 0.5))
    if clamped:
        scale = (np.eye(terms + 1) + np.eye(terms + 1, k=-1))[:, :terms]  # P_k + P_(k+1) vanishes at -1
        scale = scale * np.sqrt(degree[:terms] + 0.5)
    value = np.asarray(legendre.legvander(x, terms) @ scale, np.float64)
    slope = np.asarray(legendre.legvander(x, terms - 1) @ legendre.legder(scale), np.float64)
    return value[:, :terms], slope[:, :terms]
