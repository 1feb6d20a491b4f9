"""Exact modes of free elastic bodies, for models of meshes to be judged by: boxes, and bodies of revolution.

Ritz's method with polynomials of high degree: a box by Legendre's in its three directions, whose four symmetries part
the problem in eight; a body of revolution by waves round its axis times polynomials in its section. Both converge
faster than any power of the degree where nothing is sharp.
"""

from collections.abc import Callable
from itertools import product

import numpy as np
from scipy.linalg import eigh

from carom.dsp.bodies.material import Material
from carom.dsp.mesh.polynomials import gauss, lagrange

_STEP = 1e-6  # by which a section is differentiated
_RIGID = 6

Section = Callable[[np.ndarray], np.ndarray]
"""Places (2, n), 0 to 1 -> radius and height (2, n) in m of a body's section."""


def box(material: Material, sides: tuple[float, ...], degrees: tuple[int, ...], count: int) -> np.ndarray:
    """Return the `count` lowest frequencies (Hz) of a box, by polynomials of a degree along each of its sides (m)."""
    lame, shear = moduli(material)
    each = [_legendre(side, degree) for side, degree in zip(sides, degrees, strict=True)]
    found = []
    for parity in product((0, 1), repeat=3):
        orders = [
            [np.arange((parity[axis] + (axis == of)) % 2, degrees[axis] + 1, 2) for axis in range(3)] for of in range(3)
        ]

        def pair(one: int, other: int, first: int, second: int, orders: list = orders) -> np.ndarray:
            """Return the integrals of slopes of two directions' terms, along the axes `first` and `second`."""
            whole = np.ones((1, 1))
            for axis in range(3):
                part = each[axis][int(axis == first), int(axis == second)]
                whole = np.kron(whole, part[np.ix_(orders[one][axis], orders[other][axis])])
            return whole

        rows = [[lame * pair(i, j, i, j) + shear * pair(i, j, j, i) for j in range(3)] for i in range(3)]
        for axis in range(3):
            rows[axis][axis] = rows[axis][axis] + shear * sum(pair(axis, axis, c, c) for c in range(3))
        found.append(eigh(np.block(rows), eigvals_only=True, subset_by_index=(0, count + _RIGID - 1)))
    return _frequencies(np.concatenate(found) / material.density, count)


def revolved(
    material: Material, section: Section, degrees: tuple[int, int], pieces: int, waves: int, count: int
) -> np.ndarray:
    """Return the `count` lowest frequencies (Hz) of what a section makes as it turns about z.

    degrees: of the polynomials along the section's two coordinates; the second one is cut into so many pieces, between
    which the section may have corners. waves: round the axis, at most.
    """
    lame, shear = moduli(material)
    value, along_r, along_z, radius, weight = _fields(section, degrees, pieces)
    weight = weight * radius * 2 * np.pi
    none = np.zeros_like(value)
    around = value / radius[:, None]
    mass = np.kron(np.eye(3), material.density * (value.T * weight) @ value)
    found = []
    for wave in range(waves + 1):
        strains = [
            (2, np.hstack([along_r, none, none])),
            (2, np.hstack([around, wave * around, none])),
            (2, np.hstack([none, none, along_z])),
            (1, np.hstack([along_z, none, along_r])),
            (1, np.hstack([-wave * around, along_r - around, none])),
            (1, np.hstack([none, along_z, -wave * around])),
        ]
        stiffness = sum(share * shear * (strain.T * weight) @ strain for share, strain in strains)
        trace = sum(strain for share, strain in strains if share == 2)
        stiffness = stiffness + lame * (trace.T * weight) @ trace
        values = eigh(stiffness, mass, eigvals_only=True, subset_by_index=(0, min(count + _RIGID, len(mass)) - 1))
        found += [values] if wave == 0 else [values, values]
    return _frequencies(np.concatenate(found), count)


def moduli(material: Material) -> tuple[float, float]:
    """Return Lamé's two moduli (Pa)."""
    nu = material.poisson_ratio
    shear = material.youngs_modulus / (2 * (1 + nu))
    return 2 * shear * nu / (1 - 2 * nu), shear


def _frequencies(squares: np.ndarray, count: int) -> np.ndarray:
    """Return the frequencies (Hz) of the lowest eigenvalues (1/s^2) but the rigid motions'."""
    lowest = np.sort(squares)[_RIGID : count + _RIGID]
    return np.sqrt(lowest) / (2 * np.pi)


def _legendre(side: float, degree: int) -> np.ndarray:
    """Return the integrals (2, 2, k, k) over a side of products of two of Legendre's polynomials, of unit squares: of
    each the value, or the slope."""
    nodes, weights = np.polynomial.legendre.leggauss(degree + 1)
    norm = np.sqrt((2 * np.arange(degree + 1) + 1) / side)
    values = np.polynomial.legendre.legvander(nodes, degree) * norm
    eye = np.eye(degree + 1)
    slopes = np.stack(
        [np.polynomial.legendre.legval(nodes, np.polynomial.legendre.legder(row)) for row in eye], axis=1
    ) * (norm * 2 / side)
    both = np.stack([values, slopes])
    return np.einsum("n,ina,jnb->ijab", weights * side / 2, both, both)


def _fields(
    section: Section, degrees: tuple[int, int], pieces: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return at points of a section the polynomials (n, m), their slopes along r and z, the radius (n,) and the area
    (n,) that each stands for."""
    across, along = (gauss(degree + 4) for degree in degrees)
    one, one_slope = lagrange(across[0], degrees[0])
    piece, piece_slope = lagrange(along[0], degrees[1])
    count = pieces * degrees[1] + 1
    other, other_slope = np.zeros((2, pieces, len(along[0]), count))
    for number in range(pieces):
        own = slice(number * degrees[1], (number + 1) * degrees[1] + 1)
        other[number, :, own], other_slope[number, :, own] = piece, piece_slope * pieces
    places = ((np.arange(pieces)[:, None] + along[0]) / pieces).ravel()
    lengths = np.tile(along[1] / pieces, pieces)
    at = np.stack(np.meshgrid(across[0], places, indexing="ij")).reshape(2, -1)

    def terms(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.einsum("ia,jb->ijab", x, y.reshape(-1, count)).reshape(at.shape[1], -1)

    slopes = [terms(one_slope, other), terms(one, other_slope)]
    step = _STEP * np.eye(2)[:, :, None]
    jacobian = np.stack([section(at + each) - section(at - each) for each in step]) / (2 * _STEP)  # by s and t, of r, z
    area = jacobian[0, 0] * jacobian[1, 1] - jacobian[0, 1] * jacobian[1, 0]
    along_r = (slopes[0] * jacobian[1, 1][:, None] - slopes[1] * jacobian[0, 1][:, None]) / area[:, None]
    along_z = (slopes[1] * jacobian[0, 0][:, None] - slopes[0] * jacobian[1, 0][:, None]) / area[:, None]
    weight = np.abs(area) * np.outer(across[1], lengths).ravel()
    return terms(one, other), along_r, along_z, section(at)[0], weight
