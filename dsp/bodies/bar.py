"""Bars, rods, tubes and tines in bending, thick ones too."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import legendre

from .material import Material
from .modes import Array, Modes, audible, path, require_choice, require_positive

ENDS = ("free", "cantilever")
MOST_TERMS = 160  # of the Ritz series, for the deflection and for the rotation each


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

    Lengths in m. The section is either `width` by `thickness` (the bar bends along its thickness) or round,
    of an outer `diameter` and a `wall` (solid without). `undercut`: the fraction of the thickness carved away
    at the middle, in a parabola over the middle fraction `undercut_span` of the length, as tuned bars have
    it. Strike path and pickups: fractions of the length.

    Ritz's method on 1/2 int E I psi'^2 + kappa G A (w' - psi)^2, masses rho A and rho I (Timoshenko 1921),
    with Legendre polynomials for the deflection w and the rotation psi; kappa by Cowper (1966).
    """
    require_positive(length=length, width=width, thickness=thickness, diameter=diameter, wall=wall)
    require_choice("ends", ends, ENDS)
    if not 0 <= undercut < 1 or not 0 < undercut_span <= 1:
        raise ValueError(f"undercut = {undercut}, undercut_span = {undercut_span}: expected in [0, 1) and (0, 1]")

    def section(x: Array) -> tuple[Array, Array, float]:
        """Area (m^2) and second moment (m^4) at the points x in -1..1, and the shear coefficient."""
        if width is not None and thickness is not None and diameter is None:
            depth = thickness * (1 - undercut * np.maximum(0, 1 - (x / undercut_span) ** 2))
            return width * depth, width * depth**3 / 12, _rectangle_shear(material.poisson_ratio)
        if diameter is not None and width is None and thickness is None:
            return _round_section(diameter, wall, material.poisson_ratio, x)
        raise ValueError("section: expected width and thickness, or diameter")

    half = length / 2
    thinnest = section(np.zeros(1))
    waves = half * _wavenumber(material, thinnest, top)
    terms = min(MOST_TERMS, math.ceil(1.25 * waves) + 12)  # a Ritz series needs pi terms a wave at least
    nodes, weights = legendre.leggauss(4 * terms)
    area, moment, kappa = section(nodes)
    clamped = ends == "cantilever"
    w, slope = _basis(nodes, terms + 1, clamped)
    psi, bend = _basis(nodes, terms, clamped)  # one degree less, so that thin bars can be free of shear

    # psi is kept times half, so that both unknowns are lengths and x is in -1..1
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

    from scipy.linalg import eigh

    eigenvalue, vector = eigh(stiffness, inertia)
    frequency = np.sqrt(np.maximum(eigenvalue, 0)) / (2 * np.pi)
    rigid = 0 if clamped else 2
    converged = slice(rigid, rigid + math.ceil(0.6 * terms))  # above, a Ritz series says little
    keep = audible(frequency[converged], top)
    frequency, shapes = frequency[converged][keep], vector[: terms + 1, converged][:, keep]
    positions = path(2 * half * _wavenumber(material, thinnest, frequency[-1]))
    return Modes(
        frequency=frequency,
        decay=material.decay(frequency),
        strike=_basis(2 * positions - 1, terms + 1, clamped)[0] @ shapes,
        pickup=_basis(2 * np.asarray(pickups) - 1, terms + 1, clamped)[0] @ shapes,
        mass=float(weights @ area) * material.density * half,
    )


def _rectangle_shear(nu: float) -> float:
    return 10 * (1 + nu) / (12 + 11 * nu)


def _round_section(diameter: float, wall: float | None, nu: float, x: Array) -> tuple[Array, Array, float]:
    bore = 0.0 if wall is None else diameter - 2 * wall
    if bore < 0:
        raise ValueError(f"wall = {wall}: expected at most half the diameter, {diameter / 2}")
    area = math.pi / 4 * (diameter**2 - bore**2)
    moment = math.pi / 64 * (diameter**4 - bore**4)
    ratio = (bore / diameter) ** 2
    kappa = 6 * (1 + nu) * (1 + ratio) ** 2 / ((7 + 6 * nu) * (1 + ratio) ** 2 + (20 + 12 * nu) * ratio)
    return np.full_like(x, area), np.full_like(x, moment), kappa


def _wavenumber(material: Material, section: tuple[Array, Array, float], frequency: float) -> float:
    """The larger wavenumber (rad/m) of Timoshenko's dispersion relation for a section at a frequency (Hz)."""
    (area,), (moment,), kappa = section
    e, rho, kg = material.youngs_modulus, material.density, kappa * material.shear_modulus
    square = (2 * np.pi * frequency) ** 2
    b = rho * moment * (1 + e / kg) * square
    c = rho * area * square - rho**2 * moment / kg * square**2
    return math.sqrt((b + math.sqrt(b**2 + 4 * e * moment * c)) / (2 * e * moment))


def _basis(x: Array, terms: int, clamped: bool) -> tuple[np.ndarray, np.ndarray]:
    """Values and derivatives (len(x), terms) of normalised Legendre polynomials, zero at -1 where clamped."""
    degree = np.arange(terms + 1)
    scale = np.diag(np.sqrt(degree + 0.5))
    if clamped:
        scale = (np.eye(terms + 1) + np.eye(terms + 1, k=-1))[:, :terms]  # P_k + P_(k+1) vanishes at -1
        scale = scale * np.sqrt(degree[:terms] + 0.5)
    value = legendre.legvander(x, terms) @ scale
    slope = legendre.legvander(x, terms - 1) @ legendre.legder(scale)
    return value[:, :terms], slope[:, :terms]
