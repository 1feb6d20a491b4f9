"""Boxes and cylinders as solids: their modes by polynomials over the whole body.

Rayleigh's and Ritz's method as of resonant ultrasound (W. M. Visscher, A. Migliori, T. M. Bell, R. A. Reinert, J.
Acoust. Soc. Am. 90, 1991): the displacement is a sum of polynomials across the body's section, orthonormal there, times
Legendre's along it. Three mirror planes part the problem in eight. It converges faster than any power of the degree.
"""

import math
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from ..bodies.material import Array, Material
from . import forms
from .polynomials import gauss
from .surface import Indices, MeshError, Surface

BOX, CYLINDER = "box", "cylinder"
SIDES = 64
"""Sides of a cylinder's surface."""

_TERMS, _FINE_TERMS = 850, 1300  # products of polynomials, about
_LEAST, _MOST = 6, 26  # degree along a side: a section that warps needs some
_THIN, _FLAT = 3, 0.5  # degree along the thinnest side, where it is below that share of the next one
_LEAST_ROUND, _MOST_ROUND = 5, 18  # degree across a round section
_SLENDER = 40.0  # over the shortest side: longer ones are not for polynomials


class Block(NamedTuple):
    """A box of edges along x, y and z (m), or a cylinder about z of a radius and a length (m), about the origin."""

    kind: str
    size: tuple[float, ...]

    @property
    def edges(self) -> tuple[float, float, float]:
        """The edges (m) of the box about it."""
        if self.kind == BOX:
            return self.size[0], self.size[1], self.size[2]
        return 2 * self.size[0], 2 * self.size[0], self.size[1]

    @property
    def volume(self) -> float:
        """The volume (m^3)."""
        return math.prod(self.size) if self.kind == BOX else math.pi * self.size[0] ** 2 * self.size[1]

    @property
    def surface(self) -> Surface:
        """The surface."""
        if self.kind == BOX:
            return forms.box(*self.edges)
        radius, half = self.size[0], self.size[1] / 2
        return forms.lathe([[0, -half], [radius, -half], [radius, half], [0, half]], SIDES)


class _Part(NamedTuple):
    """The modes (n,) of one symmetry: the columns of the section's and the length's terms that each direction takes,
    and the vectors (terms, n), one direction after the other."""

    columns: tuple[tuple[Indices, Indices], ...]
    vectors: Array


class _Section(NamedTuple):
    """Terms across a section: the powers (m, 2) of Legendre's polynomials, the matrix (m, m) that makes them
    orthonormal, and the half sides (2,) in m."""

    powers: Indices
    mixed: Array
    half: Array

    def at(self, x: Array, y: Array) -> tuple[Array, Array, Array]:
        """Return the terms (p, m) at places (p,) in m and their slopes along x and y."""
        (one, one_slope), (other, other_slope) = (
            legendre(each, half, int(self.powers.max())) for each, half in zip((x, y), self.half, strict=True)
        )
        i, j = self.powers.T
        pairs = (one[:, i] * other[:, j], one_slope[:, i] * other[:, j], one[:, i] * other_slope[:, j])
        value, along_x, along_y = (pair @ self.mixed for pair in pairs)
        return value, along_x, along_y


class Solution(NamedTuple):
    """Modes of a block: frequencies (n,) in Hz, ascending, its mass (kg) and volume (m^3), and where to find the mode's
    shape: parts by symmetry, and for each mode its part and column."""

    frequency: Array
    mass: float
    volume: float
    energy: Array
    degrees: tuple[int, int, int]
    section: _Section
    half: float
    parts: tuple[_Part, ...]
    of: Indices

    def at(self, points: Array) -> Array:
        """Return the shapes (points, 3, n) in kg^-1/2 at points of the body (points, 3)."""
        section = self.section.at(points[:, 0], points[:, 1])[0]
        along = legendre(points[:, 2], self.half, self.degrees[2])[0]
        every = [np.zeros((len(points), 3, part.vectors.shape[1])) for part in self.parts]
        for part, found in zip(self.parts, every, strict=True):
            begin = 0
            for axis, (across, length) in enumerate(part.columns):
                terms = (section[:, across, None] * along[:, None, length]).reshape(len(points), -1)
                end = begin + terms.shape[1]
                found[:, axis] = terms @ part.vectors[begin:end]
                begin = end
        return np.concatenate(every, axis=2)[:, :, self.of]


def solve(block: Block, material: Material, count: int, fine: bool = False) -> Solution:
    """Return a block's `count` lowest modes, rigid motions among them. MeshError if it is too slender."""
    degrees = degrees_of(block, _FINE_TERMS if fine else _TERMS)
    half = block.edges[2] / 2
    section, across = _section(block, degrees[:2])
    along = _along(half, degrees[2])
    parities = section.powers % 2
    own = np.arange(degrees[2] + 1) % 2
    squares, parts = [], []
    for parity in product((0, 1), repeat=3):
        columns = tuple(
            (
                np.flatnonzero((parities == [(parity[k] + (k == axis)) % 2 for k in range(2)]).all(axis=1)),
                np.flatnonzero(own == (parity[2] + (axis == 2)) % 2),
            )
            for axis in range(3)
        )
        values, vectors = np.linalg.eigh(_stiffness(columns, across, along, material))
        squares.append(values[:count] / material.density)
        parts.append(_Part(columns, vectors[:, :count] / math.sqrt(material.density)))
    every = np.concatenate(squares)
    lowest = np.argsort(every, kind="stable")[:count]
    frequency = np.sqrt(np.maximum(every[lowest], 0)) / (2 * np.pi)
    mass = material.density * block.volume
    energy = np.ones((1, len(lowest)))
    return Solution(frequency, mass, block.volume, energy, degrees, section, half, tuple(parts), lowest)


def require_stout(block: Block) -> None:
    """Raise MeshError if a block is too slender for polynomials."""
    if max(block.edges) > _SLENDER * min(block.edges):
        shown = " x ".join(f"{1e3 * each:.3g}" for each in block.edges)
        raise MeshError(f"a {block.kind} of {shown} mm: expected edges of which none is {_SLENDER:g} times another")


def degrees_of(block: Block, terms: int) -> tuple[int, int, int]:
    """Return degrees along x, y and z for about so many terms, whose waves are about as short along all sides; a round
    section has one degree for both. MeshError if the block is too slender for these."""
    require_stout(block)
    edges = np.array(block.edges)
    low = np.full(3, _LEAST if block.kind == BOX else _LEAST_ROUND)
    high = np.array([_MOST] * 3 if block.kind == BOX else [_MOST_ROUND, _MOST_ROUND, _MOST])
    if np.min(edges) < _FLAT * np.sort(edges)[1]:
        low[np.argmin(edges)] = _THIN
    found = low
    for step in np.geomspace(edges.max(), edges.max() / _MOST, 60):
        wanted = np.clip(np.ceil(edges / step).astype(int), low, high)
        x, y, z = wanted
        across = (x + 1) * (y + 1) if block.kind == BOX else (x + 1) * (x + 2) // 2
        if across * (z + 1) > terms:
            break
        found = wanted
    return int(found[0]), int(found[1]), int(found[2])


def legendre(x: Array, half: float, degree: int) -> tuple[Array, Array]:
    """Return Legendre's polynomials (n, degree + 1) on -half..half (m), of unit squares, at x (n,), and their
    slopes."""
    norm = np.sqrt((2 * np.arange(degree + 1) + 1) / (2 * half))
    values = np.asarray(np.polynomial.legendre.legvander(x / half, degree), np.float64)
    slopes = values[:, :-1] @ _slopes(degree) if degree else np.zeros_like(values)
    return values * norm, slopes * (norm / half)


@lru_cache(maxsize=64)
def _slopes(degree: int) -> Array:
    """Return the slopes (degree, degree + 1) of Legendre's polynomials, as sums of those of lower degrees."""
    rows, columns = np.arange(degree)[:, None], np.arange(degree + 1)
    found: Array = np.where((columns > rows) & ((columns - rows) % 2 == 1), 2.0 * rows + 1, 0.0)
    return found


def _along(half: float, degree: int) -> Array:
    """Return the integrals (2, 2, k, k) along the length of products of two terms: of each the value, or the slope."""
    nodes, weights = gauss(degree + 1)
    both = np.stack(legendre((2 * nodes - 1) * half, half, degree))
    return np.asarray(np.einsum("n,ina,jnb->ijab", weights * 2 * half, both, both))


def _section(block: Block, degrees: tuple[int, int]) -> tuple[_Section, Array]:
    """Return the terms across a section, and the integrals (3, 3, m, m) of products of two of them: of each the value,
    the slope along x, or that along y."""
    half, most = np.array(block.edges[:2]) / 2, max(degrees)
    powers = np.array(list(product(range(degrees[0] + 1), range(degrees[1] + 1))))
    nodes, weights = gauss(most + 1)
    if block.kind == BOX:
        x, y = (each.ravel() for each in np.meshgrid(*((2 * nodes - 1) * each for each in half), indexing="ij"))
        area = np.outer(weights, weights).ravel() * 4 * half[0] * half[1]
    else:
        powers = powers[powers.sum(axis=1) <= most]
        turns = 4 * (most + 1)
        angle = (np.arange(turns) + 0.5) * 2 * np.pi / turns
        radius = np.sqrt(nodes) * half[0]  # nodes of r^2: polynomials are even in r once the turn is summed
        x, y = (np.outer(radius, each(angle)).ravel() for each in (np.cos, np.sin))
        area = np.repeat(weights * np.pi * half[0] ** 2 / turns, turns)
    plain = _Section(powers, np.eye(len(powers)), half)
    # Those of other symmetries are orthogonal already, up to rounding: a triangle that mixes them would lose that.
    mixed = np.zeros((len(powers), len(powers)))
    values = plain.at(x, y)[0] * np.sqrt(area)[:, None]
    for parity in product((0, 1), repeat=2):
        own = np.flatnonzero((powers % 2 == parity).all(axis=1))
        own = own[np.argsort(powers[own].sum(axis=1), kind="stable")]
        mixed[np.ix_(own, own)] = np.linalg.inv(np.linalg.qr(values[:, own])[1])
    section = plain._replace(mixed=mixed)
    every = np.stack(section.at(x, y))
    weighed = every * area[:, None]
    integrals = np.stack([np.stack([one.T @ other for other in every]) for one in weighed])
    return section, integrals


def _stiffness(columns: tuple[tuple[Indices, Indices], ...], across: Array, along: Array, material: Material) -> Array:
    """Return the stiffness of the terms of one symmetry, for unit masses of unit density."""
    nu = material.poisson_ratio
    shear = material.youngs_modulus / (2 * (1 + nu))
    lame = 2 * shear * nu / (1 - 2 * nu)

    def pair(one: int, other: int, first: int, second: int) -> Array:
        """Return the integrals of slopes of two directions' terms, along the axes `first` and `second`."""
        section = across[(first + 1) % 3, (second + 1) % 3][np.ix_(columns[one][0], columns[other][0])]
        length = along[int(first == 2), int(second == 2)][np.ix_(columns[one][1], columns[other][1])]
        return np.kron(section, length)

    rows = [[lame * pair(i, j, i, j) + shear * pair(i, j, j, i) for j in range(3)] for i in range(3)]
    for axis in range(3):
        for way in range(3):
            rows[axis][axis] = rows[axis][axis] + shear * pair(axis, axis, way, way)
    return np.block(rows)
