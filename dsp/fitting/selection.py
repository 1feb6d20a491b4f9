"""Selection of modes among candidates: orthogonal matching pursuit in the Gram matrix.

One by one the candidate is taken that lowers the squared error most, given those taken before (Y. C. Pati,
R. Rezaiifar, P. S. Krishnaprasad, 1993). All of it happens between inner products (sums.py).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..numerics.checks import Array
from .sums import Complex, as_weights, products, project, real_gram

_RIDGE = 1e-9  # of the diagonal: candidates may be nearly alike
_ALIKE = 1e-12  # of a determinant


def select(takes: Sequence[Array], s: Complex, count: int) -> Complex:
    """Select the `count` of the candidates `s` that together explain most of the takes' energy, best first."""
    grams, sides = [], []
    for take in takes:
        gram = real_gram(*products(s, len(take)))
        grams.append(gram + _RIDGE * np.diag(np.diag(gram)))
        sides.append(as_weights(project(take, s)))
    size = len(s)
    chosen: list[int] = []
    left = sides
    for _ in range(min(count, size)):
        gain = np.sum([_gain(gram, residual) for gram, residual in zip(grams, left, strict=True)], axis=0)
        gain[chosen] = -1.0
        chosen.append(int(np.argmax(gain)))
        pair = np.concatenate([np.array(chosen), np.array(chosen) + size])
        left = []
        for gram, side in zip(grams, sides, strict=True):
            weights = np.linalg.solve(gram[np.ix_(pair, pair)], side[pair])
            left.append(side - gram[:, pair] @ weights)
    return s[chosen]


def _gain(gram: Array, residual: Array) -> Array:
    """Return by how much each candidate, alone, would lower the squared error."""
    size = len(gram) // 2
    cosine, sine = np.diag(gram)[:size], np.diag(gram)[size:]
    between = np.diagonal(gram, size)
    a, b = residual[:size], residual[size:]
    area = np.maximum(cosine * sine - between**2, _ALIKE * cosine * sine)
    gain: Array = (a * a * sine - 2 * a * b * between + b * b * cosine) / area
    return gain
