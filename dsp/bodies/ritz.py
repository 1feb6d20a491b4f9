"""The common part of all Ritz series along a bar: Legendre polynomials on -1..1, their quadrature, and how many there
are."""

import math
from collections.abc import Callable, Hashable
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from ..kept import Kept
from .material import Array
from .modes import read_only

MOST_TERMS = 160  # of a series
_TERMS_PER_RADIAN, _MORE_TERMS = 1.25, 12  # of the half bar's waves: a Ritz series needs pi terms per wave at least
_CONVERGED = 0.6  # share of the modes of a Ritz series that mean something


def terms_for(waves: float) -> int:
    """Return the terms of a series for shapes of up to `waves` (rad) along half the bar."""
    return min(MOST_TERMS, math.ceil(_TERMS_PER_RADIAN * waves) + _MORE_TERMS)


def converged(terms: int, rigid: int) -> slice:
    """Return which of a series' modes, by ascending frequency, are exact enough; the first `rigid` are no vibration."""
    return slice(rigid, rigid + math.ceil(_CONVERGED * terms))


@lru_cache(maxsize=2 * MOST_TERMS)  # nearly all there can be, 2 MB; to find them takes as long as the modes
def quadrature(points: int, kinks: tuple[float, ...] = ()) -> tuple[Array, Array]:
    """Return nodes and weights of Gauss and Legendre in -1..1, read-only; so many in each of the pieces between
    kinks."""
    nodes, weights = legendre.leggauss(points)
    if kinks:
        edges = np.array([-1.0, *kinks, 1.0])[:, None]
        middle, half = (edges[1:] + edges[:-1]) / 2, (edges[1:] - edges[:-1]) / 2
        nodes, weights = (middle + half * nodes).ravel(), (half * weights).ravel()
    read_only(nodes, weights)
    return nodes, weights


def basis(x: Array, terms: int, clamped: bool, derivatives: int = 1) -> list[Array]:
    """Return values and derivatives (len(x), terms) of normalised Legendre polynomials, zero at -1 where clamped;
    read-only."""
    return _made(("basis", terms, clamped, derivatives), x, lambda: _basis(x, terms, clamped, derivatives))


def legendre_at(x: Array, terms: int) -> Array:
    """Return Legendre polynomials (len(x), terms), read-only."""
    return _made(("legendre", terms), x, lambda: [np.asarray(legendre.legvander(x, terms - 1), np.float64)])[0]


def _made(key: tuple[Hashable, ...], x: Array, make: Callable[[], list[Array]]) -> list[Array]:
    """Return tables at x (p,): those that are kept, as bodies of other sizes ask for the same places, or new ones."""
    found = _kept.get((*key, x.tobytes()))
    if found is None:
        found = make()
        read_only(*found)
        _kept.put((*key, x.tobytes()), found)
    return found


_kept: Kept[Hashable, list[Array]] = Kept(16_000_000, lambda tables: sum(each.nbytes for each in tables))


def _basis(x: Array, terms: int, clamped: bool, derivatives: int) -> list[Array]:
    degree = np.arange(terms + 1)
    scale = np.diag(np.sqrt(degree + 0.5))
    if clamped:
        scale = (np.eye(terms + 1) + np.eye(terms + 1, k=-1))[:, :terms]  # P_k + P_(k+1) vanishes at -1
        scale = scale * np.sqrt(degree[:terms] + 0.5)
    found = [legendre.legvander(x, terms) @ scale]
    for order in range(1, derivatives + 1):
        found.append(legendre.legvander(x, terms - order) @ legendre.legder(scale, order))
    return [np.asarray(value[:, :terms], np.float64) for value in found]
