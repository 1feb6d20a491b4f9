"""The lowest modes of K x = lambda M x: block Lanczos on (K + sigma M)^-1 M, which finds pairs as pairs.

R. Grimes, J. Lewis, H. Simon, SIAM J. Matrix Anal. Appl. 15, 1994; here with full orthogonalization.
"""

from collections.abc import Callable

import numpy as np

from ..bodies.material import Array
from .surface import MeshError

Apply = Callable[[Array], Array]

RESIDUAL = 1e-4
"""The residual of a vector at most, beside its eigenvalue times it."""

_BLOCK = 16
_MOST_STEPS = 60
_UNSETTLED = f"modes did not converge in {_MOST_STEPS} steps: expected a body without slivers"
_CHANGE = 2e-3  # of an eigenvalue by a step from vectors that are near: then they are near enough
_ROOM = 10  # blocks of vectors beyond those wanted, at first


def lowest(
    solve: Apply, mass: Apply, size: int, shift: float, count: int, residual: float = RESIDUAL
) -> tuple[Array, Array]:
    """Return the lowest eigenvalues (count,) and vectors (size, count) of unit modal mass, ascending.

    solve: applies (K + shift M)^-1, mass: M, each to (size, k). residual: of a vector at most. MeshError if they don't
    settle.
    """
    count = min(count, size - _BLOCK)
    ahead = solve(mass(np.random.default_rng(0).standard_normal((size, _BLOCK))))
    room = np.empty((2, count + _ROOM * _BLOCK, size))  # of vectors, and the mass times these
    projected = np.zeros((0, 0))
    for _ in range(_MOST_STEPS):
        before = len(projected)
        vectors, weighed = (each[:before].T for each in room)
        for begin in (max(0, before - 2 * _BLOCK), 0):  # in the last two blocks lies all but what rounding left
            ahead = ahead - vectors[:, begin:] @ (weighed[:, begin:].T @ ahead)
        new, heavy = _orthonormal(ahead, mass)
        block = new.shape[1]
        if before + block > room.shape[1]:
            room = np.concatenate([room, np.empty_like(room)], axis=1)
        room[0, before : before + block], room[1, before : before + block] = new.T, heavy.T
        vectors, weighed = (each[: before + block].T for each in room)
        ahead = solve(heavy)
        column = weighed.T @ ahead
        grown = np.zeros((before + block,) * 2)
        grown[:before, :before] = projected
        grown[:, before:] = column
        grown[before:, :before] = column[:before].T
        grown[before:, before:] = (column[before:] + column[before:].T) / 2
        projected = grown
        if len(projected) < count + _BLOCK:
            continue
        inverse, inner = np.linalg.eigh(projected)
        inverse, inner = inverse[::-1][:count], inner[:, ::-1][:, :count]
        rest = ahead - vectors @ column
        last = inner[-block:]
        error = np.sqrt(np.maximum(np.einsum("ij,ik,kj->j", last, rest.T @ mass(rest), last), 0)) / inverse
        if error.max() < residual:
            return 1 / inverse - shift, vectors @ inner
    raise MeshError(_UNSETTLED)


def followed(solve: Apply, mass: Apply, shift: float, start: Array, count: int) -> tuple[Array, Array]:
    """Return the lowest eigenvalues (count,) and vectors (size, count) as `lowest` does, by vectors (size, m) that are
    near them, some more than are wanted: steps of subspace iteration (K.-J. Bathe, E. Wilson, Int. J. Numer. Methods
    Eng. 6, 1973) until one changes little. What is left is less than a step changes."""
    vectors = start
    for _ in range(_MOST_STEPS):
        heavy = mass(vectors)
        ahead = solve(heavy)
        stiff = ahead.T @ heavy
        before, _ = _pencil(stiff, vectors.T @ heavy)
        found, turn = _pencil(ahead.T @ mass(ahead), stiff)
        vectors = ahead @ turn
        if np.abs(before / found - 1)[:count].max() < _CHANGE:
            return 1 / found[:count] - shift, vectors[:, :count]
    raise MeshError(_UNSETTLED)


def _orthonormal(block: Array, mass: Apply) -> tuple[Array, Array]:
    """Return a block's vectors made orthonormal by the mass, and the mass times these; what depends is left out."""
    heavy = mass(block)
    gram = block.T @ heavy
    weight, turn = np.linalg.eigh((gram + gram.T) / 2)
    keep = weight > 1e-13 * max(float(weight.max()), 1e-300)
    block = block @ (turn[:, keep] / np.sqrt(weight[keep]))
    heavy = mass(block)
    gram = block.T @ heavy
    factor = np.linalg.cholesky((gram + gram.T) / 2)
    return np.linalg.solve(factor, block.T).T, np.linalg.solve(factor, heavy.T).T


def _pencil(gram: Array, stiff: Array) -> tuple[Array, Array]:
    """Return the eigenvalues (n,) of `gram` against `stiff`, the greatest first, and vectors (n, n) of unit gram."""
    factor = np.linalg.cholesky((stiff + stiff.T) / 2)
    half = np.linalg.solve(factor, (gram + gram.T) / 2)
    found, turn = np.linalg.eigh(np.linalg.solve(factor, half.T))
    found, turn = found[::-1], turn[:, ::-1]
    return found, np.linalg.solve(factor.T, turn) / np.sqrt(found)
