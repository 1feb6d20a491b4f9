"""Thin cylindrical shells whose ends hold their round: how fast their walls swing.

Displacements u = U cos(l x/R) cos(n theta) along the axis, v = V sin(l x/R) sin(n theta) around it and
w = W sin(l x/R) cos(n theta) outwards, l = m pi R/H, fit ends that keep round and turn freely, at x = 0 and H. The
strains of the middle surface and its curvatures then follow from (U, V, W) alone (A. Love 1888; A. Leissa, Vibration of
Shells, NASA SP-288, 1973, ch. 1), and the energy of both makes a symmetric matrix for each m and n. Its lowest
eigenvalue belongs to the mode that moves the wall outwards most.
"""

import math

import numpy as np

from .material import Array, Material


def wall_modes(
    material: Material, radius: float, thickness: float, height: float, order: Array, row: int
) -> tuple[Array, Array]:  # fmt: skip
    """Return the frequencies (Hz) of a cylinder's modes of orders n (k,) around it and `row` half waves along it, and
    how much heavier each is than by its motion outwards alone, (U^2 + V^2 + W^2)/W^2.

    radius (of the middle line), thickness and height in m. Shear and rotation are left out.
    """
    nu = material.poisson_ratio
    waves, one, none = np.full_like(order, row * math.pi * radius / height), np.ones_like(order), np.zeros_like(order)
    stretched = np.array(
        [[-waves, none, none], [none, order, one], [-order, waves, none]]  # along, around, sheared
    )
    bent = np.array([[none, none, waves**2], [none, order, order**2], [none, 2 * waves, 2 * waves * order]])
    law = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    thin = thickness**2 / (12 * radius**2)
    stiffness = sum(
        factor * np.einsum("aik,ab,bjk->kij", strain, law, strain)
        for factor, strain in ((1.0, stretched), (thin, bent))
    )
    values, motions = np.linalg.eigh(stiffness)
    fast = math.sqrt(material.youngs_modulus / (material.density * (1 - nu**2)))
    return np.sqrt(np.maximum(values[:, 0], 0.0)) * fast / (2 * math.pi * radius), motions[:, 2, 0] ** -2.0
