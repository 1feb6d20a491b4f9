"""Stiffness and mass of finite cells, from the points of the body in each, and the share of each material in them."""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array, Material
from .corners import Law, held_across, is_bent
from .numbering import Mesh
from .polynomials import cube_of, gauss, integrals, moments
from .rays import Points
from .surface import Indices

_VOID = 1e-6  # of the stiffness: outside of the body
_SLIVER = 1e-2  # of the stiffness, times the cube of the filling: of cells that hold little
_FAR = 1e-10  # of the stiffness: of nodes that hardly move a cell's part of the body


class Share(NamedTuple):
    """The share of one material in a cell: the cell's place among those in use, the material's number, stiffness."""

    number: int
    of: int
    stiffness: Array


def matrices(
    mesh: Mesh, points: Points, full: list[Indices], materials: tuple[Material, ...], laws: list[Law | None]
) -> tuple[Array, Array, list[Share]]:
    """Return the stiffness (e, 3 m, 3 m) and the mass (e, m, m) of each cell, and the pieces of cells that hold several
    materials. full: numbers of the cells that are full of each material; laws: by which walls yield in each cell."""
    degree = mesh.degree
    nodes, weights = gauss(degree + 1)
    at = cube_of(nodes)
    cube = (weights[:, None, None] * weights[:, None] * weights).ravel()
    whole = [_of_cell(at, cube, 1.0, degree, material) for material in materials]
    wide = mesh.nodes.shape[1]
    stiffness, mass = np.zeros((len(mesh.cells), 3 * wide, 3 * wide)), np.zeros((len(mesh.cells), wide, wide))
    filled, last = np.zeros(len(mesh.cells)), np.zeros(len(mesh.cells), np.int64)
    pieces = []

    def add(number: int, of: int, stiff: Array, heavy: Array) -> None:
        stiff, heavy = _by_nodes(mesh, number, stiff), _by_nodes(mesh, number, heavy)
        stiffness[number] += stiff
        mass[number] += heavy
        if len(materials) > 1:
            pieces.append(Share(number, of, stiff))

    for begin, end in _spans(mesh, points):
        own = points.part(begin, end)
        number, of = int(np.searchsorted(mesh.cells, own.cells[0])), int(own.of[0])
        add(number, of, *_of_piece(own, mesh, number, materials[of], laws[number]))
        filled[number] += float(own.weights.sum()) / mesh.sides[number] ** 3
        last[number] = of
    for of, cells in enumerate(full):
        for number in np.searchsorted(mesh.cells, cells):
            side = mesh.sides[number]
            add(int(number), of, side * whole[of][0], side**3 * whole[of][1])
            filled[number] = 1.0
    for number, share in enumerate(filled):
        if share < 1:
            soft = min(_VOID, _SLIVER * share**3) * mesh.sides[number]
            stiffness[number] += _by_nodes(mesh, number, soft * whole[last[number]][0])
    # Of a large cube a small one beside it, across a gap, may have nodes alone: from its own part they are far.
    alone = np.bincount(mesh.nodes.ravel(), minlength=mesh.size) == 1
    for number in mesh.ties:
        rows = np.flatnonzero(np.repeat(alone[mesh.nodes[number]], 3))
        stiffness[number, rows, rows] += _FAR * mesh.sides[number] * whole[last[number]][0].max()
    return stiffness, mass, pieces


def _by_nodes(mesh: Mesh, number: int, matrix: Array) -> Array:
    """Return a matrix of a cell's polynomials (d m, d m), whose last axis runs fastest, by the cell's nodes."""
    tie = mesh.ties.get(number)
    if tie is None:
        return matrix
    d = len(matrix) // len(tie)
    half = np.einsum("man,mb->ban", matrix.reshape(len(tie), d, -1), tie, optimize=True).reshape(-1, len(tie), d)
    found: Array = np.einsum("rma,mb->rba", half, tie, optimize=True).reshape(len(half), -1)
    return found


def _spans(mesh: Mesh, points: Points) -> list[tuple[int, int]]:
    """Return where the points of each cell that is in use and of each of its materials begin and end."""
    change = (np.diff(points.cells) != 0) | (np.diff(points.of) != 0)
    begin = np.r_[0, np.flatnonzero(change) + 1][: len(points.cells)]
    end = np.r_[begin[1:], len(points.cells)][: len(begin)]
    used = np.isin(points.cells[begin], mesh.cells)
    return list(zip(begin[used].tolist(), end[used].tolist(), strict=True))


def _of_piece(own: Points, mesh: Mesh, number: int, material: Material, law: Law | None) -> tuple[Array, Array]:
    """Return the stiffness and the mass of a cell's points of one material."""
    side = float(mesh.sides[number])
    places = (own.places - mesh.corners[number]) / side
    stiffness, mass = _of_cell(places, own.weights, side, mesh.degree, material)
    thickness = float(np.median(own.through)) / side
    if law and thickness < law.most and is_bent(own.weights, own.normals):
        share = 1 - law.factor * thickness**law.power
        stiffness -= share * held_across(own._replace(places=places), side, mesh.degree, material)
    return stiffness, mass


def energies(mesh: Mesh, pieces: list[Share], vectors: Array, count: int) -> Array:
    """Return the share (count, n) of each material in the energy that bends the body, of each mode."""
    shapes = vectors.reshape(mesh.size, 3, -1)
    found = np.zeros((count, shapes.shape[2]))
    for piece in pieces:
        moved = shapes[mesh.nodes[piece.number]].reshape(-1, shapes.shape[2])
        found[piece.of] += np.einsum("an,an->n", moved, piece.stiffness @ moved)
    return np.asarray(found / np.maximum(found.sum(axis=0), 1e-300))


def _of_cell(places: Array, weights: Array, side: float, degree: int, material: Material) -> tuple[Array, Array]:
    """Return the stiffness and the mass of a cell that is met at places (n, 3) of it, 0 to 1, with weights in m^3."""
    of, count = moments(places, weights, degree), (degree + 1) ** 3
    nu = material.poisson_ratio
    mu = material.youngs_modulus / (2 * (1 + nu)) / side**2
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
