"""Domed discs: shallow caps with a free edge, whose modes stretch the middle surface as well as they bend it.

Marguerre's equations of shallow shells, with Airy's stress function F. At a free edge F = F_r = 0, as of the deflection
of a clamped disc, whose modes span F: the stretching energy is a sum of squares, one for each of them. Modes of one
angular order mix. (Thomas, Touze, Chaigne, Int. J. Solids Struct. 42, 2005.)
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..numerics.bessel import ine, jn
from .material import Array, Indices

SHALLOW = 0.25
"""Times its radius: the rise up to which a cap counts as shallow."""


class Waves(NamedTuple):
    """Radial waves scale (J_m(root r) + growing I_m(root r)/I_m(root)) of a disc of radius 1, (k,): orders m, roots.

    For stress functions scale makes the integral of the square over the disc 1.
    """

    order: Array
    root: Array
    growing: Array
    scale: Array


class Mixed(NamedTuple):
    """The modes of a cap: frequencies without air (Hz, (k,)), and for each angular order the indices of its modes and
    its mixture (n, n): column j holds mode j of the cap by the modes of the flat disc."""

    frequency: Array
    parts: list[tuple[Indices, Array]]

    def mix(self, flat: Array, mode: Indices) -> Array:
        """Return the radial shapes (p, n) of some of the cap's modes (n,) from those of all the flat disc's (p, k)."""
        whole = np.empty_like(flat)
        for row, mixture in self.parts:
            whole[:, row] = flat[:, row] @ mixture
        mixed: Array = whole[:, mode]
        return mixed


def domed(flat: Waves, frequency: Array, stress: Waves, stiffness: float) -> Mixed:
    """Return the modes of a cap from those of the flat disc: its mass-normalised waves, and its frequencies (Hz).

    stress: stress functions, of the orders of `flat` at least. stiffness (N/m): 4 E h d^2/R^2 for the rise d.
    """
    mixed, parts = frequency.copy(), []
    strains = strains_of(stress, flat)
    for m in np.unique(flat.order):
        row, column = np.flatnonzero(stress.order == m), np.flatnonzero(flat.order == m)
        column = column[np.argsort(frequency[column], kind="stable")]
        strain = math.sqrt(stiffness) * strains(row, column)
        omega = 2 * math.pi * frequency[column]
        square, mixture = np.linalg.eigh(np.diag(omega**2) + strain.T @ strain)
        mixture *= np.sign(np.take_along_axis(mixture, np.abs(mixture).argmax(axis=0)[None], axis=0))
        mixed[column] = np.sqrt(square) / (2 * math.pi)
        parts.append((column, mixture))
    return Mixed(mixed, parts)


def strains_of(stress: Waves, flat: Waves) -> Callable[[Indices, Indices], Array]:
    """Return the function of the numbers of stress functions (s,) and of waves (k,), all of one order, that returns the
    integrals over the disc of these functions over z^2 times the Laplacians of these waves, (s, k).

    Both are eigenfunctions of the biharmonic operator, by z^4 and k^4. So Green's formula gives (z^4 - k^4) times the
    integral by what they are at the edge, where the stress function and its slope are 0.
    """
    curved, curved_slope = _laplacian_at_edge(stress)
    bent, bent_slope = _laplacian_at_edge(flat)

    def strains(s: Indices, k: Indices) -> Array:
        around = math.pi * (2.0 if flat.order[k[0]] == 0 else 1.0)
        edge = np.outer(curved_slope[s], bent[k]) - np.outer(curved[s], bent_slope[k])
        height = np.outer(stress.scale[s] / stress.root[s] ** 2, flat.scale[k])
        overlap: Array = around * height * edge / (stress.root[s, None] ** 4 - flat.root[k] ** 4)
        return overlap

    return strains


def _laplacian_at_edge(waves: Waves) -> tuple[Array, Array]:
    """Return the Laplacians of waves that are not scaled, and their slopes, at the edge (k,)."""
    k, growing = waves.root, waves.growing
    value, slope, growing_slope = at_edge(waves.order, k)
    return k**2 * (growing - value), k**3 * (growing * growing_slope - slope)


def at_edge(order: Array, root: Array) -> tuple[Array, Array, Array]:
    """Return J_n and J_n' at roots, and I_n'/I_n; arrays that broadcast."""
    order = np.broadcast_to(order, np.broadcast_shapes(order.shape, root.shape))
    both = np.stack([order, order + 1])
    (j, j_up), (i, i_up) = jn(both, root), ine(both, root)
    return j, order / root * j - j_up, order / root + i_up / i
