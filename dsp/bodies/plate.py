"""Rectangular plates with any edges."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from . import acceleration
from .acceleration import Click
from .air import plate_mass
from .choices import EDGES
from .eigen import eigh
from .heard import BAFFLES, heard, loaded
from .material import Array, Material
from .modes import LOWEST_FREQUENCY, Indices, Modes, ascending, audible, path, require_choice, require_positive
from .near import critical_frequency, near_field
from .radiation.plate import Group, Loads, Rectangle
from .unheard import Felt, completed, with_unheard

RESERVE = 1.5  # beam products up to this times the highest wanted frequency make the series
LEAST_PRODUCTS = 400  # of which the series is made at least
MOST_PRODUCTS = 2200
MOST_FACTORS = 400  # beam modes along a side; k^4 of more would be lost in rounding
_RANK = 1e-12  # of the greatest singular value: smaller ones are 0
_ROUNDING = 1e-7  # of the highest frequency of a series: what lies lower is rounding
_MENDING = 3  # polynomials for each edge that is free or clamped; with more a long strip's lowest modes lose digits

_SIGN_AT = (0.17, 0.29)  # fractions of the sides: whose sign a mode's sound has

Corner = tuple[float, float]


def plate(
    material: Material,
    *,
    length: float,
    width: float,
    thickness: float,
    top: float,
    edges: tuple[str, str, str, str] = ("free", "free", "free", "free"),
    path_from: Corner = (0.0, 0.0),
    path_to: Corner = (1.0, 1.0),
    baffle: str = "free",
) -> Modes:
    """Return the modes of a thin rectangular plate (Kirchhoff).

    Parameters
    ----------
    material : Material
        Material of the body.
    length, width, thickness : float
        Sides along x and y, and thickness, m.
    top : float
        Highest frequency of a mode, Hz.
    edges : tuple of 4 str, default all "free"
        Edges at x = 0, x = length, y = 0 and y = width: each "free", "clamped" or "supported".
    path_from, path_to : tuple of 2 float, default (0, 0), (1, 1)
        Ends of the strike path, x and y as shares of the sides.
    baffle : {"free", "wall", "closed"}, default "free"
        Surroundings: air on both sides; a wall; a wall, closed behind.

    Returns
    -------
    Modes
        The modes from 1 Hz up to `top`.

    Raises
    ------
    ValueError
        An argument is out of range, or the body has no such mode; the text names it.

    Notes
    -----
    Ritz's method on D/2 int (lap w)^2 - 2 (1 - nu) (w_xx w_yy - w_xy^2) (Leissa, J. Sound Vib. 31, 1973), in products
    of the modes of the two beams with the same edges. Symmetrical edges split it by parity.
    """
    require_positive(length=length, width=width, thickness=thickness)
    for edge in edges:
        require_choice("edges", edge, EDGES)
    require_choice("baffle", baffle, BAFFLES)
    areal = material.density * thickness
    speed = math.sqrt(material.contact_modulus * thickness**3 / 12 / areal)  # sqrt(D / (rho h)), m^2/s
    wavenumber = math.sqrt(2 * math.pi * top / speed)
    along = _Beam(edges[0], edges[1], length, wavenumber)
    across = _Beam(edges[2], edges[3], width, wavenumber)
    blocks, complete = _solve(along, across, wavenumber, material.poisson_ratio)
    squares = np.concatenate([block.square for block in blocks])
    frequency = speed * np.sqrt(np.maximum(squares, 0)) / (2 * math.pi)
    frequency[frequency < _ROUNDING * frequency.max()] = 0.0  # rigid motions
    keep = audible(frequency, min(top, speed * complete / (2 * math.pi)))
    others = np.setdiff1d(np.flatnonzero(frequency >= LOWEST_FREQUENCY), keep)
    beyond, frequency = frequency[others], frequency[keep]

    groups = _groups(blocks, keep)
    waves = np.sqrt(2 * math.pi * frequency / speed)
    surface = Rectangle((length / 2, width / 2), areal, speed, along.value, across.value, groups, baffle)
    air = loaded(frequency, Loads(surface, frequency), plate_mass(areal, waves, frequency))
    order = ascending(air.frequency)  # the air may bring neighbours past each other

    span = math.hypot((path_to[0] - path_from[0]) * length, (path_to[1] - path_from[1]) * width)
    positions = path(waves[-1] * span)[:, None]
    points = np.concatenate([np.asarray(path_from) * (1 - positions) + np.asarray(path_to) * positions, [_SIGN_AT]])
    values = along.value(points[:, 0]), across.value(points[:, 1])
    shapes = _shapes(groups, *values) / math.sqrt(areal) * air.shrinking
    shapes, resistance = shapes[:, order], air.resistance[order]
    mass = areal * length * width
    rising = np.maximum.accumulate(air.frequency[order])  # equal ones may fall by rounding
    made = heard(material, rising, resistance, (shapes[:-1], shapes[-1]), mass)
    # The series' other modes are not exact, but yield together as much as the plate does, up to where it has enough.
    higher = Felt(beyond, (_shapes(_groups(blocks, others), *values) / math.sqrt(areal))[:-1])
    last = speed * RESERVE * complete / (2 * math.pi)
    felt = completed(Felt(made.frequency, made.strike), higher, last, 2 * top)
    made = with_unheard(made, felt, material.decay, top)
    clicks = plate_clicks(material, length=length, width=width, thickness=thickness, edges=edges, baffle=baffle)
    return replace(made, clicks=clicks)


def plate_clicks(
    material: Material, *, length: float, width: float, thickness: float, edges: Sequence[str] = ("free",),
    baffle: str = "free", **others: object,
) -> tuple[Click, ...]:  # fmt: skip
    """Return the clicks of a plate; arguments as of `plate`."""
    if baffle != "free":
        return ()
    areal = material.density * thickness
    mass = areal * length * width
    speed = math.sqrt(material.contact_modulus * thickness**3 / 12 / areal)
    whole = acceleration.rectangle(mass, length, width, length * width * thickness)
    critical, held = critical_frequency(areal, areal * speed**2), set(edges) != {"free"}
    return near_field(areal, whole, critical, held)


def _solve(along: "_Beam", across: "_Beam", wavenumber: float, nu: float) -> tuple[list["_Block"], float]:
    """Solve Ritz's eigenvalue problem, block by block; return the modes, and the square of the wavenumber up to which
    it has all."""
    estimate = along.square[:, None] + across.square
    ranked = np.sort(estimate, axis=None)
    least, most = (ranked[min(count, ranked.size) - 1] for count in (LEAST_PRODUCTS, MOST_PRODUCTS))
    # A limit in wavenumber, not in number, so that the two products of a square's doublets stay together.
    limit = (1 + 1e-9) * min(max(RESERVE * wavenumber**2, least), most)
    ix, iy = np.nonzero(estimate <= limit)
    classes = 2 * along.parity[ix] + across.parity[iy]
    blocks = []
    for group in np.unique(classes):
        member = classes == group
        jx, jy = ix[member], iy[member]
        x, y = np.ix_(jx, jx), np.ix_(jy, jy)
        mixed = along.curvature[x] * across.curvature.T[y]
        energy = nu * (mixed + mixed.T) + 2 * (1 - nu) * along.slopes[x] * across.slopes[y]
        energy += along.bends[x] * np.equal.outer(jy, jy) + np.equal.outer(jx, jx) * across.bends[y]
        if along.supported and across.supported:  # the products are modes; rounding would mix those of one frequency
            square, vector = np.diag(energy), np.eye(len(energy))
        else:
            _, vector = np.linalg.eigh(energy)
            # eigh is exact to rounding of the greatest value; what bends least is known far better from its shape.
            square = np.einsum("ij,ij->j", vector, energy @ vector)
        blocks.append(_Block(jx, jy, square, vector))
    # A vast plate's series ends early.
    return blocks, float(min(limit, along.square.max(), across.square.max()) / RESERVE)


def _groups(blocks: list["_Block"], keep: Indices) -> list[Group]:
    """Return the modes that are kept, of each block."""
    rank = np.full(sum(block.square.size for block in blocks), -1)
    rank[keep] = np.arange(keep.size)
    groups = []
    for block, first in zip(blocks, np.cumsum([0, *(block.square.size for block in blocks)]), strict=False):
        mode = rank[first : first + block.square.size]
        groups.append(Group(mode[mode >= 0], block.x, block.y, block.vector[:, mode >= 0]))
    return groups


def _shapes(groups: list[Group], value_x: Array, value_y: Array) -> Array:
    """Return the modes (points, n), from the beams' functions at the points (points, beam modes)."""
    shapes = np.empty((len(value_x), sum(group.mode.size for group in groups)))
    for group in groups:
        shapes[:, group.mode] = (value_x[:, group.x] * value_y[:, group.y]) @ group.vector
    return shapes


class _Block(NamedTuple):
    """The modes of one parity: beam products x, y (k,), fourth powers of wavenumbers (k,), their vectors (k, k)."""

    x: Indices
    y: Indices
    square: Array
    vector: Array


class _Beam:
    """Modes of a beam of unit stiffness and density, as Legendre series: the factors of a plate's shapes.

    At a free edge these have neither curvature nor shear, and at a clamped one no fourth derivative. A plate's shapes
    have some, so their series converges slowly. A few polynomials for each such edge mend that. They come first, and
    the modes are made orthogonal to them: so they are whole beside any number of modes.
    """

    def __init__(self, low: str, high: str, length: float, wavenumber: float) -> None:
        self.supported = low == high == "supported"
        resolved = min(math.sqrt(RESERVE) * wavenumber * length / math.pi + 4, MOST_FACTORS)
        degree = math.ceil(1.8 * resolved) + 14
        norm = 2 / (2 * np.arange(degree + 1) + 1)
        groups = [slice(0, None, 2), slice(1, None, 2)] if low == high else [slice(None)]  # even, odd
        kept = math.ceil(resolved / len(groups))
        mending = _MENDING * (2 - (low, high).count("supported")) // len(groups)

        square, series, parity = [], [], []
        for number, group in enumerate(groups):
            bubbles, fourth, modes = _ritz_beam(low, high, np.arange(degree + 1)[group], degree, kept)
            every = np.concatenate([bubbles[:mending], modes])
            series.append(np.linalg.qr((every * np.sqrt(norm)).T)[0].T / np.sqrt(norm))
            square.append(np.concatenate([np.zeros(mending), np.sqrt(fourth)]))
            parity.append(np.full(square[-1].size, number))
        scale = 2 / length  # from d/dxi, -1 <= xi <= 1, to d/dx
        self.square = np.concatenate(square) * scale**2  # k^2, and 0 for what must never be left out
        self.parity = np.concatenate(parity)
        self._series = np.concatenate(series) * math.sqrt(scale)  # int phi^2 dx = 1

        norm /= scale
        slope = legendre.legder(self._series, axis=1) * scale
        bend = legendre.legder(slope, axis=1) * scale
        self.slopes = slope * norm[:-1] @ slope.T  # int phi_i' phi_j'
        self.bends = bend * norm[:-2] @ bend.T  # int phi_i'' phi_j''
        self.curvature = bend * norm[:-2] @ self._series[:, :-2].T  # int phi_i'' phi_j

    def value(self, fraction: Array) -> Array:
        """Return the functions (len(fraction), n) at fractions of the length."""
        return legendre.legvander(2 * fraction - 1, self._series.shape[1] - 1) @ self._series.T


def _null_space(conditions: Array) -> Array:
    """Return unit vectors (n, k), across each other, that meet homogeneous conditions (m, k)."""
    _, sizes, vectors = np.linalg.svd(conditions)
    met: Array = vectors[int((sizes > _RANK * sizes[0]).sum()) :]
    return met


def _ritz_beam(low: str, high: str, orders: Indices, degree: int, kept: int) -> tuple[Array, Array, Array]:
    """Return the lowest modes of a beam on -1..1 from Legendre polynomials of the given orders.

    The basis is the cubics that satisfy the edges and the twice-integrated Legendre polynomials, which vanish
    with their slopes at both ends: their bending energies are orthogonal, so high orders cost no accuracy.
    Returns the series (n, degree + 1) of the latter, k^4 (n,) and the series of the modes, int phi^2 = 1.
    """
    cubic = orders[orders < 4]
    sign = (-1.0) ** cubic
    slope = cubic * (cubic + 1) / 2
    held = {"free": 0, "supported": 1, "clamped": 2}
    conditions = [sign, -sign * slope][: held[low]] + [np.ones_like(sign), slope][: held[high]]
    allowed = _null_space(np.array(conditions)) if conditions else np.eye(cubic.size)

    k = orders[(orders >= 2) & (orders <= degree - 2)]
    basis = np.zeros((len(allowed) + k.size, degree + 1))
    basis[: len(allowed), cubic] = allowed
    rows = len(allowed) + np.arange(k.size)
    basis[rows, k + 2] = 1 / ((2 * k + 1) * (2 * k + 3))
    basis[rows, k] = -2 / ((2 * k - 1) * (2 * k + 3))
    basis[rows, k - 2] = 1 / ((2 * k + 1) * (2 * k - 1))
    basis[rows] *= np.sqrt(k + 0.5)[:, None]  # each of unit bending energy

    norm = 2 / (2 * np.arange(degree + 1) + 1)
    inertia = basis * norm @ basis.T
    energy = np.eye(len(basis))
    bend = legendre.legder(basis[: len(allowed)], 2, axis=1)
    energy[: len(bend), : len(bend)] = bend * norm[:-2] @ bend.T
    # The largest 1 / (1 + k^4) are wanted: these keep every digit, and rigid motions do no harm.
    inverse, vector = eigh(inertia, energy + inertia)
    inverse, vector = inverse[: -kept - 1 : -1], vector[:, : -kept - 1 : -1]
    modes = (vector / np.sqrt(inverse)).T @ basis
    return basis[len(allowed) :], np.maximum(1 / inverse - 1, 0), modes
