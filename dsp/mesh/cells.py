"""Finite cells: the modes of a solid, or of a thick sheet, on a grid of cubes that needs no mesh of its own.

The displacement is a polynomial in each cube; the body is met by the quadrature alone (J. Parvizian, A. Duester,
E. Rank, Comput. Mech. 41, 2007). Outside, a stiffness of at most 1e-6 of the body's and no mass keep the system
definite. The body is turned against the grid, so that its flat faces don't lie along the rays.
"""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array, Material
from .fronts import Elements, Factor
from .lanczos import lowest
from .polynomials import gauss, integrals, moments, products
from .rays import Grid, Quadrature, grid_about, quadrature
from .sheets import of_sheet
from .surface import Indices, MeshError, Surface, faces_of, rotation, volume_of

TILT = rotation((0.11, 0.13, 0.17))
"""The turn of the body against the grid: of angles that no body has."""

_VOID = 1e-6  # of the stiffness: outside of the body
_SLIVER = 1e-2  # of the stiffness, times the cube of the filling: of cells that hold little
_LEAST_FILLED = 1e-3  # of a cell
_THIN = 0.3  # of a cell's side: sheets are thinner
_BENT = 0.06  # of the normals' squares: across the first direction, where sheets meet
_LEFT = 0.4  # share of the stiffness along a sheet's normal that stays, over (thickness/side of a cell)^2
_AGREED = 0.02  # of the volume, by triangles and by rays: within that the triangles' counts
_SHIFT = 0.02  # of a wave's frequency along the body
_SIZES = 24  # halvings
_SAMPLES = 30_000
_RAYS = (24, 40)  # of a cell: the fewest, the most
_THROUGH = 4  # rays through a wall


class Mesh(NamedTuple):
    """The cells in use: their numbers, indices (e, 3), nodes (e, m) and how many nodes there are."""

    grid: Grid
    degree: int
    cells: Indices
    at: Indices
    nodes: Indices
    size: int


class Solution(NamedTuple):
    """Modes on cells: frequencies (n,) in Hz and displacements (nodes, 3, n) of unit modal mass, the cells, the body's
    mass (kg), and the share of rays that met a gap."""

    frequency: Array
    displacement: Array
    mesh: Mesh
    mass: float
    leaks: float

    def at(self, points: Array) -> Array:
        """Return the shapes (points, 3, n) in kg^-1/2 at points of the body (points, 3)."""
        from scipy.sparse import csr_array
        from scipy.spatial import cKDTree

        mesh, grid = self.mesh, self.mesh.grid
        places = points @ TILT.T
        numbers = grid.number(places)
        element = np.clip(np.searchsorted(mesh.cells, numbers), 0, len(mesh.cells) - 1)
        outside = mesh.cells[element] != numbers
        if outside.any():
            middles = grid.corner + grid.side * (mesh.at + 0.5)
            element[outside] = cKDTree(middles).query(places[outside])[1]
        values = products((places - grid.corner) / grid.side - mesh.at[element], mesh.degree)[0]
        rows = np.arange(0, values.size + 1, values.shape[1])
        weights = csr_array((values.ravel(), mesh.nodes[element].ravel(), rows), shape=(len(points), mesh.size))
        found: Array = (weights @ self.displacement.reshape(mesh.size, -1)).reshape(len(points), 3, -1)
        return found


class Sizes(NamedTuple):
    """The side of cells (m), rays through each, and the body's thickness (m): twice its volume over its area."""

    side: float
    rays: int
    thickness: float


def sizes(surface: Surface, cells: int, wall: float | None = None) -> Sizes:
    """Return sizes for about so many cells."""
    turned = Surface(surface.points @ TILT.T, surface.faces)
    areas = faces_of(turned).areas
    total = float(areas.sum())
    volume = volume_of(turned) if wall is None else wall * total
    rng = np.random.default_rng(0)
    face = rng.choice(len(areas), _SAMPLES, p=areas / total)
    places = np.einsum("ij,ijk->ik", rng.dirichlet((1, 1, 1), _SAMPLES), turned.points[turned.faces[face]])
    low, high = 1e-3 * float(np.ptp(turned.points)), float(np.ptp(turned.points))
    for _ in range(_SIZES):
        side = np.sqrt(low * high)
        grid = grid_about(turned, side, 1)
        crossed = len(np.unique(grid.number(places)))
        if crossed + (max(0.0, volume / side**3 - crossed / 2) if wall is None else 0) > cells:
            low = side
        else:
            high = side
    thickness = 2 * volume / total
    return Sizes(high, int(np.clip(np.ceil(high * _THROUGH / thickness), *_RAYS)), thickness)


def solve(surface: Surface, material: Material, size: Sizes, degree: int, count: int) -> Solution:
    """Return a solid's `count` lowest modes, rigid motions among them."""
    turned = Surface(surface.points @ TILT.T, surface.faces)
    grid = grid_about(turned, size.side, size.rays)
    inside = quadrature(turned, grid, degree)
    if not len(inside.weights) and not len(inside.full):
        raise MeshError("no ray meets the inside: expected a closed surface with a thickness")
    true = volume_of(turned)
    got = float(inside.weights.sum()) + len(inside.full) * grid.side**3
    if abs(got / true - 1) < _AGREED:
        inside = inside._replace(weights=inside.weights * (1 + (true - got) / max(float(inside.weights.sum()), 1e-300)))
    return of_points(inside, grid, material, degree, count)


def solve_sheet(surface: Surface, wall: float, material: Material, size: Sizes, degree: int, count: int) -> Solution:
    """Return the lowest modes of a sheet of a wall (m) about a surface."""
    turned = Surface(surface.points @ TILT.T, surface.faces)
    grid = grid_about(turned, size.side, size.rays, wall)
    return of_points(of_sheet(turned, wall, grid, degree), grid, material, degree, count)


def of_points(inside: Quadrature, grid: Grid, material: Material, degree: int, count: int) -> Solution:
    """Return the modes of a body that a quadrature stands for."""
    order = np.argsort(inside.cells, kind="stable")
    cells, begin = np.unique(inside.cells[order], return_index=True)
    end = np.r_[begin[1:], len(order)]
    volumes = np.add.reduceat(inside.weights[order], begin) if len(order) else np.zeros(0)
    keep = volumes > _LEAST_FILLED * grid.side**3
    none = np.zeros(len(inside.full), np.int64)
    numbers = np.r_[cells[keep], inside.full]
    sort = np.argsort(numbers)
    spans = np.stack([np.r_[begin[keep], none], np.r_[end[keep], none]], axis=1)[sort]
    mesh = _mesh(grid, degree, numbers[sort])
    stiffness, mass = _matrices(mesh, inside, order, spans, material)
    elements = Elements(mesh.nodes, grid.corner + grid.side * (mesh.at + 0.5), 3, mesh.size)
    length = float((mesh.at.max(axis=0) - mesh.at.min(axis=0) + 1).max()) * grid.side
    shift = (2 * np.pi * _SHIFT * np.sqrt(material.youngs_modulus / material.density) / length) ** 2
    values, vectors = _modes(elements, stiffness, mass, shift, count)
    displacement = np.einsum("ij,aim->ajm", TILT, vectors.reshape(mesh.size, 3, -1))
    total = material.density * (float(volumes[keep].sum()) + len(inside.full) * grid.side**3)
    return Solution(np.sqrt(np.maximum(values, 0)) / (2 * np.pi), displacement, mesh, total, inside.leaks)


def _mesh(grid: Grid, degree: int, numbers: Indices) -> Mesh:
    """Return the cells with their nodes numbered."""
    at = grid.cell(numbers)
    steps = np.arange(degree + 1)
    local = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    nodes = at[:, None] * degree + local
    most = grid.counts * degree + 1
    keys = (nodes[..., 0] * most[1] + nodes[..., 1]) * most[2] + nodes[..., 2]
    names, numbered = np.unique(keys, return_inverse=True)
    return Mesh(grid, degree, numbers, at, numbered.reshape(keys.shape).astype(np.int64), len(names))


def _matrices(
    mesh: Mesh, inside: Quadrature, order: Indices, spans: Indices, material: Material
) -> tuple[Array, Array]:
    """Return the stiffness (e, 3 m, 3 m) and the mass (e, m, m) of each cell; spans: its points, in their order."""
    grid, degree = mesh.grid, mesh.degree
    nodes, weights = gauss(degree + 1)
    at = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 3)
    whole = (weights[:, None, None] * weights[:, None] * weights).ravel() * grid.side**3
    full = _of_cell(at, whole, mesh, material)
    stiffness = np.empty((len(mesh.cells), *full[0].shape))
    mass = np.empty((len(mesh.cells), *full[1].shape))
    for number, (begin, end) in enumerate(spans):
        if begin == end:
            stiffness[number], mass[number] = full
            continue
        points = order[begin:end]
        weight = inside.weights[points]
        places = (inside.places[points] - grid.corner) / grid.side - mesh.at[number]
        own = _of_cell(places, weight, mesh, material)
        normals = inside.normals[points]
        thickness = float(np.median(inside.through[points])) / grid.side
        if thickness < _THIN and _is_bent(weight, normals):
            share = 1 - _LEFT * thickness**2
            own[0][:] -= share * _held_across(places, weight, normals, mesh, material)
        filled = float(weight.sum()) / grid.side**3
        stiffness[number] = own[0] + min(_VOID, _SLIVER * filled**3) * full[0]
        mass[number] = own[1]
    return stiffness, mass


def _of_cell(places: Array, weights: Array, mesh: Mesh, material: Material) -> tuple[Array, Array]:
    """Return the stiffness and the mass of a cell that is met at places (n, 3) of it, 0 to 1, with weights in m^3."""
    degree = mesh.degree
    of, count = moments(places, weights, degree), (degree + 1) ** 3
    nu = material.poisson_ratio
    mu = material.youngs_modulus / (2 * (1 + nu)) / mesh.grid.side**2
    lame = 2 * mu * nu / (1 - 2 * nu)
    stiffness, trace = np.empty((count, 3, count, 3)), np.zeros((count, count))
    for i in range(3):
        for j in range(i, 3):
            pair = integrals(of, degree, (i, j))
            stiffness[:, i, :, j] = lame * pair + mu * pair.T
            if i != j:
                stiffness[:, j, :, i] = stiffness[:, i, :, j].T
            else:
                trace += pair
    for axis in range(3):
        stiffness[:, axis, :, axis] += mu * trace
    return stiffness.reshape(3 * count, 3 * count), material.density * integrals(of, degree)


def _is_bent(weights: Array, normals: Array) -> bool:
    """Return whether sheets meet at an angle in a cell, by the normals (n, 3) at its points."""
    tensor = np.einsum("p,pi,pj->ij", weights, normals, normals) / weights.sum()
    return bool(np.linalg.eigvalsh(tensor)[1] > _BENT)


def _held_across(places: Array, weights: Array, normals: Array, mesh: Mesh, material: Material) -> Array:
    """Return the stiffness (3 m, 3 m) by which a cell's polynomials resist where sheets may yield: that of the stress
    along their normals (n, 3), which is none in a thin sheet.

    Where it is left, sheets that meet don't bend near their edge: the curvature of each would stretch the other across.
    """
    nu = material.poisson_ratio
    mu = material.youngs_modulus / (2 * (1 + nu))
    lame = 2 * mu * nu / (1 - 2 * nu)
    slopes = products(places, mesh.degree)[1] / mesh.grid.side
    along = np.einsum("inm,ni->nm", slopes, normals)
    stress = lame * slopes.transpose(1, 2, 0) + 2 * mu * along[:, :, None] * normals[:, None, :]
    share = np.sqrt(weights / (lame + 2 * mu))
    scaled = share[:, None] * stress.reshape(len(normals), -1)
    held: Array = scaled.T @ scaled
    return held


def _modes(elements: Elements, stiffness: Array, mass: Array, shift: float, count: int) -> tuple[Array, Array]:
    """Return eigenvalues and vectors of elements whose mass is the same for all three directions."""
    from scipy.sparse import csr_array

    nodes, size = elements.nodes, elements.size
    gather = csr_array((np.ones(nodes.size), (nodes.ravel(), np.arange(nodes.size))), shape=(size, nodes.size))
    cells, m = nodes.shape
    blocks = stiffness.reshape(cells, m, 3, m, 3)
    for axis in range(3):
        blocks[:, :, axis, :, axis] += shift * mass
    factor = Factor(elements, stiffness, max(1, 64 // m * 4))

    def weigh(x: Array) -> Array:
        each = np.matmul(mass, x.reshape(size, -1)[nodes])
        weighed: Array = (gather @ each.reshape(nodes.size, -1)).reshape(3 * size, -1)
        return weighed

    return lowest(factor.solve, weigh, 3 * size, shift, count)
