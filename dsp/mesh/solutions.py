"""Modes on finite cells: their shapes anywhere in the body, and the products of those of two grids."""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from .grids import TILT
from .numbering import Mesh
from .polynomials import cube_of, lobatto, products


class Solution(NamedTuple):
    """Modes on cells: frequencies (n,) in Hz and displacements (nodes, 3, n) of unit modal mass, the cells, the body's
    mass (kg) and volume (m^3), the share of rays that met a gap, the share (materials, n) of each material in the
    energy that bends the body, and the cells' masses (e, m, m). inside (e, 3): a place of the body in each. coarse
    (k,): the lowest frequencies by polynomials of one degree less, if they are known; weakest (3,): the place of the
    body that the lowest mode bends most."""

    frequency: Array
    displacement: Array
    mesh: Mesh
    mass: float
    volume: float
    leaks: float
    energy: Array
    masses: Array
    inside: Array
    coarse: Array = np.zeros(0)
    weakest: Array | None = None

    def at(self, points: Array) -> Array:
        """Return the shapes (points, 3, n) in kg^-1/2 at points of the body (points, 3)."""
        from scipy.sparse import csr_array
        from scipy.spatial import cKDTree

        mesh = self.mesh
        places = points @ TILT.T
        element = mesh.elements(places)
        outside = element < 0
        if outside.any():
            middles = mesh.corners + mesh.sides[:, None] / 2
            element[outside] = cKDTree(middles).query(places[outside])[1]
        values = products((places - mesh.corners[element]) / mesh.sides[element, None], mesh.degree)
        by_nodes = np.zeros((len(points), mesh.nodes.shape[1])) if mesh.ties else values
        for number, tie in mesh.ties.items():
            by_nodes[element == number] = values[element == number] @ tie
        values = by_nodes
        rows = np.arange(0, values.size + 1, values.shape[1])
        weights = csr_array((values.ravel(), mesh.nodes[element].ravel(), rows), shape=(len(points), mesh.size))
        found: Array = (weights @ self.displacement.reshape(mesh.size, -1)).reshape(len(points), 3, -1)
        return found


def shared(one: Solution, other: Solution) -> Array:
    """Return the integrals (n, m) of the products of two solutions' modes, times the density. The other one's cells are
    those of the first, or parts of them."""
    mesh, moved = other.mesh, _moved(one, other)
    found = np.zeros((moved.shape[2], other.displacement.shape[2]))
    for nodes, mass in zip(mesh.nodes, other.masses, strict=True):
        heavy = (mass @ other.displacement[nodes].reshape(len(nodes), -1)).reshape(3 * len(nodes), -1)
        found += moved[nodes].reshape(3 * len(nodes), -1).T @ heavy
    return found


def _moved(one: Solution, other: Solution) -> Array:
    """Return the shapes (nodes, 3, n) of a solution at the nodes of another one, whose cells are its own, or parts."""
    mesh, coarse = other.mesh, one.mesh
    local = cube_of(lobatto(mesh.degree))
    found = np.zeros((mesh.size, 3, one.displacement.shape[2]))
    for row, (nodes, of) in enumerate(zip(mesh.nodes, coarse.elements(other.inside).tolist(), strict=True)):
        if of < 0:
            continue
        places = (mesh.corners[row] + mesh.sides[row] * local - coarse.corners[of]) / coarse.sides[of]
        values = products(places, mesh.degree)
        shapes = np.tensordot(values @ coarse.ties.get(of, np.eye(len(local))), one.displacement[coarse.nodes[of]], 1)
        tie = mesh.ties.get(row, np.eye(len(local)))
        own, node = np.nonzero((tie == 1) & (np.count_nonzero(tie, axis=1) == 1)[:, None])
        found[nodes[node]] = shapes[own]
    return found
