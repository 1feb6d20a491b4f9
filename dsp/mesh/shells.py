"""Shell elements for thin walls: flat triangles of six unknowns a corner.

They bend by Kirchhoff's theory at discrete points (DKT: J.-L. Batoz, K.-J. Bathe, L.-W. Ho, Int. J. Numer. Methods
Eng. 15, 1980), and stretch by the optimal membrane with drilling freedoms (C. Felippa, Comput. Methods Appl. Mech.
Eng. 192, 2003).
"""

from typing import Any, NamedTuple

import numpy as np

from ..bodies.material import Array, Material
from .cleaning import edges_of
from .creases import held
from .fronts import Elements, Factor
from .grading import changes
from .lanczos import RESIDUAL, followed, lowest
from .rounding import quartered
from .surface import Surface, faces_of

_STRETCH = 1.5  # Felippa's alpha_b
_DRILL = ((1, 2, 1, 0, 1, -1, -1, -1, -2), (-2, -1, -1, 1, 1, 2, -1, 0, 1), (1, -1, 0, -1, -2, -1, 2, 1, 1))
_LUMPED = 0.57  # of the mass: at the corners, which lowers; the rest raises. Plates want 0.5, cans 0.8
_LEAF = 64
_UNKNOWNS = 6  # of a corner
_SPARE = 10  # modes beyond those wanted, of a shell that leads to a finer one
_LEADS = 3e-2  # of a vector: the residual of those
_SHIFT = 0.1  # of a wave's frequency along the body, times the wall over its length


class Solution(NamedTuple):
    """Modes of a shell: frequencies (n,) in Hz, displacements (points, 3, n) in kg^-1/2 at the corners, mass in kg.
    sheared (n,): by how much of them they are too high at most, for want of shear. coarse (k,): the lowest frequencies
    by triangles of twice the side, if they are known."""

    frequency: Array
    displacement: Array
    surface: Surface
    mass: float
    sheared: Array
    coarse: Array = np.zeros(0)

    @property
    def energy(self) -> Array:
        """The share (1, n) of the one material in the energy that bends the shell."""
        return np.ones((1, len(self.frequency)))

    def at(self, points: Array) -> Array:
        """Return the shapes (points, 3, n) at points of the surface, between the corners of the nearest triangle."""
        from .nearest import Nearest

        face, share = Nearest(self.surface).to(points)
        found: Array = np.einsum("pc,pckn->pkn", share, self.displacement[self.surface.faces[face]])
        return found


class _System(NamedTuple):
    """The equations of a shell: its surface, the factor of its stiffness and `shift` (1/s^2) times its mass, the mass
    (kg) between the displacements of its P points, sparse, and their moments of inertia (P,) in kg m^2."""

    surface: Surface
    factor: Factor
    moved: Any
    turned: Array
    shift: float

    def weigh(self, x: Array) -> Array:
        """Return the mass times vectors (unknowns, n)."""
        each = x.reshape(len(self.turned), _UNKNOWNS, -1)
        found = np.empty(each.shape)
        found[:, :3] = (self.moved @ each[:, :3].reshape(len(each), -1)).reshape(len(each), 3, -1)
        np.multiply(self.turned[:, None, None], each[:, 3:], out=found[:, 3:])
        return found.reshape(x.shape)

    def lowest(self, count: int, residual: float = RESIDUAL) -> tuple[Array, Array]:
        """Return the lowest eigenvalues (count,) in 1/s^2 and vectors (unknowns, count)."""
        return lowest(self.factor.solve, self.weigh, _UNKNOWNS * len(self.turned), self.shift, count, residual)

    def solution(self, values: Array, vectors: Array, wall: float, material: Material) -> Solution:
        """Return the modes of eigenvalues (n,) and vectors (unknowns, n)."""
        shapes = vectors.reshape(len(self.surface.points), _UNKNOWNS, -1)[:, :3]
        turns = np.sqrt(np.maximum(values, 0))
        sheared = _sheared(turns, wall, material)
        return Solution(turns / (2 * np.pi), shapes, self.surface, float(self.moved.sum()), sheared)


def solve_twice(surface: Surface, wall: float, material: Material, count: int) -> Solution:
    """Return the `count` lowest modes of a shell of a wall (m), rigid motions among them, by its triangles and by their
    quarters: errors go with the square of the sides, so that the two give the rest. The triangles' modes lead to those
    of the quarters."""
    system, finer = (_system(each, wall, material) for each in (surface, quartered(surface)))
    values, vectors = system.lowest(count + _SPARE, _LEADS)
    start = _between(surface, vectors)
    coarse = system.solution(values, vectors, wall, material)
    values, vectors = followed(finer.factor.solve, finer.weigh, finer.shift, start, count)
    fine = finer.solution(values, vectors, wall, material)
    areas = np.repeat(faces_of(surface).areas / 3, 3)
    masses = material.density * wall * np.bincount(surface.faces.ravel(), areas, len(surface.points))
    there = fine.displacement[: len(masses)]
    shares = np.tensordot(masses[:, None, None] * coarse.displacement, there, ((0, 1), (0, 1))) ** 2
    frequency = fine.frequency - changes(coarse.frequency, fine.frequency, shares) / 3
    return fine._replace(frequency=frequency, coarse=coarse.frequency)


def _between(surface: Surface, vectors: Array) -> Array:
    """Return vectors (unknowns, n) of a surface's triangles at the corners of their quarters, too. A side bends as a
    beam does, by the turns at its ends."""
    each = vectors.reshape(len(surface.points), _UNKNOWNS, -1)
    one, other = edges_of(surface.faces)[0].T
    middles = (each[one] + each[other]) / 2
    along = (surface.points[other] - surface.points[one])[:, None]
    bent = np.cross((each[one] - each[other])[:, 3:].transpose(0, 2, 1), along) / 8
    middles[:, :3] += bent.transpose(0, 2, 1)
    return np.vstack([each, middles]).reshape(-1, vectors.shape[1])


def solve(surface: Surface, wall: float, material: Material, count: int) -> Solution:
    """Return the `count` lowest modes of a shell of a wall (m), rigid motions among them."""
    system = _system(surface, wall, material)
    return system.solution(*system.lowest(count), wall, material)


def _system(surface: Surface, wall: float, material: Material) -> _System:
    """Return the equations of a shell."""
    from scipy.sparse import csr_array

    length = float(np.ptp(surface.points, axis=0).max())
    speed = np.sqrt(material.youngs_modulus / material.density)
    shift = float((2 * np.pi * _SHIFT * speed * wall / length**2) ** 2)
    total, (moved, turned) = stiffness(surface, wall, material), masses(surface, wall, material)
    for axis in range(3):
        total[:, axis::_UNKNOWNS, axis::_UNKNOWNS] += shift * moved
    for unknown in np.arange(3 * _UNKNOWNS).reshape(3, _UNKNOWNS)[:, 3:].ravel():
        total[:, unknown, unknown] += shift * turned
    faces, count = surface.faces, len(surface.points)
    elements = Elements(faces, surface.points[faces].mean(axis=1), _UNKNOWNS, count)
    rows, columns = (np.broadcast_to(each, moved.shape).ravel() for each in (faces[:, :, None], faces[:, None]))
    between = csr_array((moved.ravel(), (rows, columns)), shape=(count, count))
    at_points = np.asarray(np.bincount(faces.ravel(), np.repeat(turned, 3), count), np.float64)
    return _System(surface, Factor(elements, total, _LEAF), between, at_points, shift)


def _sheared(turns: Array, wall: float, material: Material) -> Array:
    """Return by how much less modes of angular frequencies (n,) in 1/s have by Mindlin's plates (J. Appl. Mech. 18,
    1951), which give to shear, if they bend alone: their waves are as short as can be, then."""
    nu = material.poisson_ratio
    square = wall * turns * np.sqrt(12 * (1 - nu**2) * material.density / material.youngs_modulus)  # (k wall)^2
    found: Array = square / 24 * 2 / (5 / 6 * (1 - nu))
    return found


def masses(surface: Surface, wall: float, material: Material) -> tuple[Array, Array]:
    """Return the mass (e, 3, 3) of triangles between the displacements of their corners, in kg, and their moment of
    inertia (e,) at each corner, in kg m^2."""
    shares = (1 - _LUMPED) * (np.ones((3, 3)) + np.eye(3)) / 12 + _LUMPED * np.eye(3) / 3
    each = material.density * wall * faces_of(surface).areas
    return each[:, None, None] * shares, each * wall**2 / 36


def stiffness(surface: Surface, wall: float, material: Material) -> Array:
    """Return the stiffness (e, 18, 18) of triangles, in three displacements and three turns a corner."""
    corners = surface.points[surface.faces]
    along = corners[:, 1] - corners[:, 0]
    normal = np.cross(along, corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(normal, axis=1)
    normal /= twice[:, None]
    along /= np.linalg.norm(along, axis=1)[:, None]
    axes = np.stack([along, np.cross(normal, along), normal], axis=1)  # local = axes @ global
    flat = np.einsum("eij,eaj->eai", axes[:, :2], corners - corners[:, :1])
    nu = material.poisson_ratio
    plane = material.contact_modulus * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    count = len(flat)
    own = np.zeros((count, 3, 6, 3, 6))
    membrane = stretching(flat, twice / 2, wall * plane, nu).reshape(count, 3, 3, 3, 3)
    bent = bending(flat, twice / 2, _rigidity(surface, wall, plane, axes)).reshape(count, 3, 3, 3, 3)
    for part, which in ((membrane, (0, 1, 5)), (bent, (2, 3, 4))):
        for p, row in enumerate(which):
            for q, column in enumerate(which):
                own[:, :, row, :, column] += part[:, :, p, :, q]
    turn = np.zeros((count, 6, 6))
    turn[:, :3, :3] = turn[:, 3:, 3:] = axes
    return np.asarray(np.einsum("epi,eapbq,eqj->eaibj", turn, own, turn, optimize=True).reshape(count, 18, 18))


def _rigidity(surface: Surface, wall: float, plane: Array, axes: Array) -> Array:
    """Return the rigidity (e, 3, 3) of triangles with axes (e, 3, 3), which bend less beside sharp edges."""
    share, across = held(surface, wall)
    x, y = np.einsum("eai,ei->ae", axes[:, :2], across)
    curved = np.stack([x * x, y * y, x * y], axis=1)
    more = (plane[0, 0] * share / (1 - share))[:, None, None]
    return np.asarray(wall**3 / 12 * (plane + more * curved[:, :, None] * curved[:, None]))


def bending(flat: Array, area: Array, rigidity: Array) -> Array:
    """Return the stiffness (e, 9, 9) of triangles with corners (e, 3, 2) and a rigidity (e, 3, 3), in w and two turns a
    corner."""
    count = len(flat)
    x, y = flat[..., 0], flat[..., 1]
    slopes = np.zeros((count, 6, 2, 9))  # of w at three corners and three middles of sides, by the unknowns
    for a in range(3):
        slopes[:, a, 0, 3 * a + 2] = -1
        slopes[:, a, 1, 3 * a + 1] = 1
    for middle, (i, j) in enumerate(((0, 1), (1, 2), (2, 0))):
        side = flat[:, j] - flat[:, i]
        length = np.linalg.norm(side, axis=1)
        s = side / length[:, None]
        n = np.stack([-s[:, 1], s[:, 0]], axis=1)
        both = slopes[:, i] + slopes[:, j]
        along, across = (np.einsum("ec,ecf->ef", each, both) for each in (s, n))
        cubic = -0.25 * along
        cubic[:, 3 * j] += 1.5 / length
        cubic[:, 3 * i] -= 1.5 / length
        slopes[:, 3 + middle] = s[:, :, None] * cubic[:, None] + n[:, :, None] * (0.5 * across)[:, None]
    b = np.stack([y[:, 1] - y[:, 2], y[:, 2] - y[:, 0], y[:, 0] - y[:, 1]], axis=1) / (2 * area)[:, None]
    c = np.stack([x[:, 2] - x[:, 1], x[:, 0] - x[:, 2], x[:, 1] - x[:, 0]], axis=1) / (2 * area)[:, None]
    total = np.zeros((count, 9, 9))
    for at in ((0.5, 0.5, 0.0), (0.0, 0.5, 0.5), (0.5, 0.0, 0.5)):
        grow = np.zeros((count, 6, 2))
        for a in range(3):
            grow[:, a, 0], grow[:, a, 1] = (4 * at[a] - 1) * b[:, a], (4 * at[a] - 1) * c[:, a]
        for middle, (i, j) in enumerate(((0, 1), (1, 2), (2, 0))):
            grow[:, 3 + middle, 0] = 4 * (at[j] * b[:, i] + at[i] * b[:, j])
            grow[:, 3 + middle, 1] = 4 * (at[j] * c[:, i] + at[i] * c[:, j])
        along_x = np.einsum("ea,eacf->ecf", grow[..., 0], slopes)
        along_y = np.einsum("ea,eacf->ecf", grow[..., 1], slopes)
        curved = np.stack([along_x[:, 0], along_y[:, 1], along_x[:, 1] + along_y[:, 0]], axis=1)
        total += np.einsum("eif,eij,ejg->efg", curved, rigidity, curved, optimize=True) * (area / 3)[:, None, None]
    return total


def stretching(flat: Array, area: Array, stiffness: Array, nu: float) -> Array:
    """Return the stiffness (e, 9, 9) of triangles with corners (e, 3, 2), in two displacements and a turn a corner."""
    x = flat[:, :, None, 0] - flat[:, None, :, 0]  # x[:, i, j] = x_i - x_j
    y = flat[:, :, None, 1] - flat[:, None, :, 1]
    basic = _basic(x, y)
    total: Array = np.einsum("efi,ij,egj->efg", basic, stiffness, basic, optimize=True) / area[:, None, None]
    higher, hierarchical = _higher(x, y, area, stiffness)
    share = 0.75 * max((1 - 4 * nu**2) / 2, 0.01)
    return np.asarray(total + share * np.einsum("eaf,eab,ebg->efg", hierarchical, higher, hierarchical, optimize=True))


def _basic(x: Array, y: Array) -> Array:
    """Return the forces (e, 9, 3) at the corners of each constant stress, per thickness."""
    rows = np.zeros((len(x), 9, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        zero, yjk, xkj = np.zeros(len(x)), y[:, j, k], x[:, k, j]
        rows[:, 3 * i] = np.stack([yjk, zero, xkj], axis=1)
        rows[:, 3 * i + 1] = np.stack([zero, xkj, yjk], axis=1)
        turn = [
            yjk * (y[:, i, k] - y[:, j, i]),
            xkj * (x[:, k, i] - x[:, i, j]),
            2 * (x[:, k, i] * y[:, i, k] - x[:, i, j] * y[:, j, i]),
        ]
        rows[:, 3 * i + 2] = _STRETCH / 6 * np.stack(turn, axis=1)
    return rows / 2


def _higher(x: Array, y: Array, area: Array, stiffness: Array) -> tuple[Array, Array]:
    """Return the higher stiffness (e, 3, 3) by the corners' own turns, and these by all unknowns (e, 3, 9)."""
    squares = np.stack([x[:, i, j] ** 2 + y[:, i, j] ** 2 for i, j in ((1, 0), (2, 1), (0, 2))], axis=1)
    natural = np.zeros((len(x), 3, 3))
    for side, (i, j, k) in enumerate(((1, 2, 0), (2, 0, 1), (0, 1, 2))):
        # Felippa's T_e: column of the side (21, 32, 13), by the other two.
        natural[:, 0, side] = y[:, i, j] * y[:, k, j] * squares[:, side]
        natural[:, 1, side] = x[:, i, j] * x[:, k, j] * squares[:, side]
        natural[:, 2, side] = (y[:, i, j] * x[:, j, k] + x[:, j, i] * y[:, k, j]) * squares[:, side]
    natural /= (4 * area**2)[:, None, None]
    energy = np.einsum("eia,ij,ejb->eab", natural, stiffness, natural, optimize=True)
    weight = (2 * area / 3)[:, None, None] / squares[:, :, None]
    at = [np.array(each, float).reshape(3, 3) * weight for each in _DRILL]
    total = np.zeros((len(x), 3, 3))
    for i, j in ((0, 1), (1, 2), (2, 0)):
        middle = (at[i] + at[j]) / 2
        total += np.einsum("eab,eac,ecd->ebd", middle, energy, middle, optimize=True)
    own = np.zeros((len(x), 3, 9))
    for corner, (i, j) in enumerate(((2, 1), (0, 2), (1, 0))):
        own[:, :, 3 * corner] = (x[:, i, j] / (4 * area))[:, None]
        own[:, :, 3 * corner + 1] = (y[:, i, j] / (4 * area))[:, None]
    for corner in range(3):
        own[:, corner, 3 * corner + 2] += 1
    return total * area[:, None, None], own
