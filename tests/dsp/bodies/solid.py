"""The modes of a free rectangular bar as a solid: Ritz's method in three dimensions, with no theory of bars in it."""

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import block_diag, eigh

MODES = 24


class Solid:
    """A bar of sides `sides` (length, width, thickness; m) whose thickness is carved in a parabola over all its length.

    Displacements are products of Legendre polynomials up to `degrees`, in coordinates that map the carved bar to a
    cube; all modes are of one parity across the width: sideways bending and torsion (odd), or upright bending.
    """

    def __init__(self, material, sides, undercut, odd, degrees=(18, 5, 4)):
        self.degrees, self.odd = degrees, odd
        self.scale = np.array(sides) / 2
        nodes, weights = zip(*(legendre.leggauss(degree + 3) for degree in (2 * degrees[0], *degrees[1:])), strict=True)
        depth = 1 - undercut * (1 - nodes[0] ** 2)  # of the thickness
        stretch = (2 * undercut * nodes[0] / depth)[:, None, None]
        (px, dx), (py, dy), (pz, dz) = (values(x, n) for x, n in zip(nodes, degrees, strict=True))
        volume = np.einsum("x,y,z->xyz", weights[0] * depth, weights[1], weights[2]).ravel() * self.scale.prod()
        # z = thickness (1 - depth (1 - zeta)) / 2 from the face that is not carved
        moved = (stretch * (1 - nodes[2])).repeat(len(nodes[1]), axis=1).reshape(-1, 1)
        across = product(px, py, dz)
        slopes = (
            (product(dx, py, pz) + moved * across) / self.scale[0],
            product(px, dy, pz) / self.scale[1],
            across / (self.scale[2] * depth).repeat(len(nodes[1]) * len(nodes[2]))[:, None],
        )
        self._solve(material, product(px, py, pz), slopes, volume)

    def _solve(self, material, value, slopes, volume):
        own = [self.of(value, axis) for axis in range(3)]
        slope = [[self.of(each, axis) for axis in range(3)] for each in slopes]  # along an axis, of a displacement
        weighed = [[each.T * volume for each in row] for row in slope]
        g = material.shear_modulus
        bulk = 2 * g * material.poisson_ratio / (1 - 2 * material.poisson_ratio)  # Lamé's lambda
        stiffness = [
            [bulk * weighed[i][i] @ slope[j][j] + g * weighed[j][i] @ slope[i][j] for j in range(3)] for i in range(3)
        ]
        for i in range(3):
            stiffness[i][i] += sum(g * weighed[k][i] @ slope[k][i] for k in range(3))
        inertia = block_diag(*(material.density * (each.T * volume) @ each for each in own))
        square, vector = eigh(np.block(stiffness), inertia, subset_by_index=[0, MODES - 1])
        kept = square > 1e-6 * square[-1]  # no rigid motion
        self.frequency = np.sqrt(square[kept]) / (2 * np.pi)
        self.vectors = np.split(vector[:, kept], np.cumsum([each.shape[1] for each in own])[:2])

    def of(self, columns, axis):
        """Return the columns of those products that the displacement along an axis is made of."""
        j = np.unravel_index(np.arange(columns.shape[1]), [degree + 1 for degree in self.degrees])[1]
        return columns[:, (j % 2 == 1) == (self.odd == (axis != 1))]

    def displacement(self, x, y, z):
        """Return the mass-normalised displacements (axes, len(x), modes) at points of -1..1 along each axis."""
        value = product(*(values(np.atleast_1d(at), n)[0] for at, n in zip((x, y, z), self.degrees, strict=True)))
        return np.array([self.of(value, axis) @ self.vectors[axis] for axis in range(3)])


def values(x, degree):
    """Return Legendre polynomials (len(x), degree + 1) and their derivatives."""
    slope = np.stack([legendre.legval(x, legendre.legder(row)) for row in np.eye(degree + 1)], axis=1)
    return legendre.legvander(x, degree), slope


def product(x, y, z):
    return np.einsum("ai,bj,ck->abcijk", x, y, z).reshape(len(x) * len(y) * len(z), -1)
