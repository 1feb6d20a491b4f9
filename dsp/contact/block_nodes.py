"""Quadrature over a sample whose force is a line by its values at two Gauss nodes, over all, half or a third of it.

Tables by the number of parts, for contacts that are solved in blocks (block.py): where the nodes lie, what a force at
each does to the displacement and its rate there and at the sample's end, and its Legendre moments.
"""

import math
from functools import cache

import numpy as np
from numpy.polynomial import legendre

from ..numerics.checks import Array
from ..numerics.legendre import FINE
from ..numerics.settled import same_everywhere
from .block_sizes import MOMENTS_AHEAD, MOST_PARTS, NODES_PER_PART

TILT = math.sqrt(3.0)
"""A line over [-1, 1] is its mean at a part's nodes, and its mean with x times TILT more at the second, less at the
first."""

_WITHIN = same_everywhere("WITHIN", (legendre.leggauss(NODES_PER_PART)[0] + 1.0) / 2.0)
_CARDINAL = np.linalg.inv(np.vander(_WITHIN, increasing=True))


_gauss = cache(legendre.leggauss)


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
    x, w = _gauss(FINE)
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


def _rates(parts: int) -> Array:
    """Return their derivatives over the time at each node, by the line of least squares over the node's part: (nodes,
    FINE, nodes)."""
    x, w = _gauss(FINE // 2 + 1)
    found = np.zeros((parts * NODES_PER_PART, FINE, parts * NODES_PER_PART))
    for i, c in enumerate(nodes_of(parts)):
        part = i // NODES_PER_PART
        shares = 0.5 * w * (1.0 + 3.0 * (2.0 * (parts * c - part) - 1.0) * x)
        for time, share in zip((part + 0.5 * (x + 1.0)) / parts, shares, strict=True):
            found[i, 1:] += share * np.arange(1, FINE)[:, None] * _answers(parts, float(time), FINE - 1)
    return found


def _moments(parts: int) -> Array:
    """Return the Legendre moments of the force of each node over a sample of unit length: (MOMENTS_AHEAD, nodes)."""
    x, w = _gauss(8)
    found = np.zeros((MOMENTS_AHEAD, parts * NODES_PER_PART))
    for part in range(parts):
        u = 0.5 * (x + 1.0)
        lines = np.vander(u, NODES_PER_PART, increasing=True) @ _CARDINAL
        values = legendre.legvander(2.0 * (part + u) / parts - 1.0, MOMENTS_AHEAD - 1)
        found[:, part * NODES_PER_PART : (part + 1) * NODES_PER_PART] = (0.5 / parts * w[:, None] * values).T @ lines
    return found


def _travels(parts: int) -> Array:
    """Return int_0^1 P_l(2 t - 1) r'(t) dt for each moment that later samples feel, with r the answers to that of a
    force of which they feel no others: (MOMENTS_AHEAD, FINE, nodes)."""
    x, w = _gauss(FINE)
    t, n, kept = 0.5 * (x + 1.0), np.arange(1, FINE), parts + 1
    values = legendre.legvander(x, kept - 1)  # of P_l
    lag = np.zeros((FINE, FINE, kept))  # [t, n]: the derivative of int_0^t (t - s)^n P_l(2 s - 1) ds
    lag[:, 0] = values
    s = t[:, None] * t
    kernels = 0.5 * w * t[:, None] * n[:, None, None] * (t[:, None] - s) ** (n[:, None, None] - 1)
    lag[:, 1:] = np.einsum("nts,tsl->tnl", kernels, legendre.legvander(2.0 * s - 1.0, kept - 1))
    felt = (2.0 * np.arange(kept) + 1.0)[:, None] * _moments(parts)[:kept]  # of each force, by P_l
    found = np.zeros((MOMENTS_AHEAD, FINE, parts * NODES_PER_PART))
    found[:kept] = np.einsum("tl,t,tnm,mj->lnj", values, 0.5 * w, lag, felt)
    return found


_PARTS = range(1, MOST_PARTS + 1)
AT = _padded([nodes_of(parts) for parts in _PARTS])
"""The nodes, in [0, 1] of a sample, by parts."""
TIMES_OF_ONE = tuple(float(time) for time in nodes_of(1))
TIMES_OF_TWO = tuple(float(time) for time in nodes_of(2))
TIMES_OF_THREE = tuple(float(time) for time in nodes_of(3))
TO_NODES = same_everywhere(  # [parts, i, n, j]
    "TO_NODES", _padded([np.array([_answers(p, float(c), FINE) for c in nodes_of(p)]) for p in _PARTS])
)
RATES = same_everywhere("RATES", _padded([_rates(parts) for parts in _PARTS]))
TRAVELS = same_everywhere("TRAVELS", _padded([_travels(parts) for parts in _PARTS]))  # [parts, l, n, j]
FORCE_MOMENTS = same_everywhere("FORCE_MOMENTS", _padded([_moments(parts) for parts in _PARTS]))
SHARES = same_everywhere(
    "SHARES",
    _padded([np.tile(_CARDINAL.T @ (1.0 / np.arange(1, NODES_PER_PART + 1)) / parts, parts) for parts in _PARTS]),
)
