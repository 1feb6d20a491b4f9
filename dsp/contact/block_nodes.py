"""Quadrature over a sample whose force is a line by its values at two Gauss nodes, over all, half or a third of it.

Tables by the number of parts, for contacts that are solved in blocks (block.py): where the nodes lie, what a force at
each does to the displacement and its rate there and at the sample's end, and its Legendre moments.
"""

import numpy as np
from numpy.polynomial import legendre

from ..numerics.checks import Array
from ..numerics.legendre import FINE

MOST_PARTS = 3
"""Parts of a sample, at most."""

NODES_PER_PART = 2  # in a part
FORCES = MOST_PARTS * NODES_PER_PART
"""Unknown forces in a sample, at most."""

MOTIONS = 2 * FORCES  # compression and rate at all nodes

MOMENTS_AHEAD = MOST_PARTS + 1
"""Legendre moments of the force over a sample that later ones feel, at most: one more than it has parts."""

_WITHIN = (legendre.leggauss(NODES_PER_PART)[0] + 1.0) / 2.0
_CARDINAL = np.linalg.inv(np.vander(_WITHIN, increasing=True))


def nodes_of(parts: int) -> Array:
    """Return the nodes of a sample of so many parts, in [0, 1] of it."""
    return np.concatenate([(part + _WITHIN) / parts for part in range(parts)])


def _padded(tables: list[Array]) -> Array:
    """Return tables in one array, by parts, with zeros for nodes that there are not: first of none."""
    found = np.zeros((len(tables) + 1, *tables[-1].shape))
    for each, table in zip(found[1:], tables, strict=True):
        each[tuple(slice(n) for n in table.shape)] = table
    return found


def _answers(parts: int, time: float, powers: int) -> Array:
    """Return int_0^time (time - s)^n l_j(s) ds for n < powers, with l_j the force of a node that is 1: a column for
    each node."""
    x, w = legendre.leggauss(FINE)
    found = np.zeros((powers, parts * NODES_PER_PART))
    for part in range(parts):
        begin, end = part / parts, min((part + 1) / parts, time)
        if end > begin:
            s = begin + (end - begin) * 0.5 * (x + 1.0)
            lines = np.vander(parts * (s - begin), NODES_PER_PART, increasing=True) @ _CARDINAL
            weighted = 0.5 * (end - begin) * w[:, None] * lines
            powers_of = (time - s) ** np.arange(powers)[:, None]
            found[:, part * NODES_PER_PART : (part + 1) * NODES_PER_PART] = powers_of @ weighted
    return found


def _to_nodes(parts: int) -> Array:
    """Return those of the displacement at each node: (nodes, FINE, nodes)."""
    return np.array([_answers(parts, float(c), FINE) for c in nodes_of(parts)])


def _rates(parts: int) -> Array:
    """Return their derivatives over the time."""
    powers = np.arange(1, FINE)[:, None]
    return np.array([np.concatenate([0.0 * each[:1], powers * each[:-1]]) for each in _to_nodes(parts)])


def _moments(parts: int) -> Array:
    """Return the Legendre moments of the force of each node over a sample of unit length: (MOMENTS_AHEAD, nodes)."""
    x, w = legendre.leggauss(8)
    found = np.zeros((MOMENTS_AHEAD, parts * NODES_PER_PART))
    for part in range(parts):
        u = 0.5 * (x + 1.0)
        lines = np.vander(u, NODES_PER_PART, increasing=True) @ _CARDINAL
        values = legendre.legvander(2.0 * (part + u) / parts - 1.0, MOMENTS_AHEAD - 1)
        found[:, part * NODES_PER_PART : (part + 1) * NODES_PER_PART] = (0.5 / parts * w[:, None] * values).T @ lines
    return found


_PARTS = range(1, MOST_PARTS + 1)
AT = _padded([nodes_of(parts) for parts in _PARTS])
"""The nodes, in [0, 1] of a sample, by parts."""
TIMES_OF_ONE = tuple(float(time) for time in nodes_of(1))
TIMES_OF_TWO = tuple(float(time) for time in nodes_of(2))
TIMES_OF_THREE = tuple(float(time) for time in nodes_of(3))
TO_NODES = _padded([_to_nodes(parts) for parts in _PARTS])  # [parts, i, n, j]
RATES = _padded([_rates(parts) for parts in _PARTS])
TO_END = _padded([_answers(parts, 1.0, FINE) for parts in _PARTS])
FORCE_MOMENTS = _padded([_moments(parts) for parts in _PARTS])
SHARES = _padded([np.tile(_CARDINAL.T @ (1.0 / np.arange(1, NODES_PER_PART + 1)) / parts, parts) for parts in _PARTS])
