"""Removal of modes that can be spared: backward elimination in the inverse of the Gram matrix.

One by one the mode goes whose loss raises the squared error least, while the others take over what they can. Modes that
were chosen too many and refined together, and then pruned, fit better than as many chosen one by one (selection.py).
Then those go that explain less than noise would, and those that others stand for: two modes of nearly one pole, large
and of opposite signs, fit the end of an attack better than one, but no body has them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..numerics.checks import Array
from .sums import Complex, as_weights, products, project, real_gram

_RIDGE = 1e-9  # of a normalised Gram matrix
_ALIKE = 1e-12  # of a determinant
_STOOD_FOR = 0.01  # of a mode's own energy: if the others explain all but so little of it, it is none


def prune(takes: Sequence[Array], s: Complex, count: int, needed: Array | None = None) -> Complex:
    """Keep those of the modes `s` (k,) that can be spared least: at most `count`.

    needed (k,): the energy that each has to explain, which nothing else does; 0 unless it is given.
    """
    size = len(s)
    needed = np.zeros(size) if needed is None else needed
    inverses, weights = [], []
    for take in takes:
        gram = real_gram(*products(s, len(take)))
        scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
        inverse = np.linalg.inv(gram / np.outer(scale, scale) + _RIDGE * np.eye(2 * size))
        inverses.append(inverse)
        weights.append(inverse @ (as_weights(project(take, s)) / scale))
    kept = np.ones(size, bool)
    while kept.any():
        loss = np.sum([_loss(inverse, weight) for inverse, weight in zip(inverses, weights, strict=True)], axis=0)
        own = np.sum([weight[:size] ** 2 + weight[size:] ** 2 for weight in weights], axis=0)
        weak = loss < np.maximum(needed, _STOOD_FOR * own)
        if kept.sum() <= count and not np.any(kept & weak):
            break
        spared = int(np.argmin(np.where(kept & (weak | (kept.sum() > count)), loss, np.inf)))
        kept[spared] = False
        pair = [spared, spared + size]
        for each, (inverse, weight) in enumerate(zip(inverses, weights, strict=True)):
            taken = inverse[:, pair] @ np.linalg.inv(inverse[np.ix_(pair, pair)])
            weights[each] = weight - taken @ weight[pair]
            inverses[each] = inverse - taken @ inverse[pair]
    return s[kept]


def _loss(inverse: Array, weight: Array) -> Array:
    """Return by how much the squared error grows without each mode."""
    size = len(weight) // 2
    cosine, sine = np.diag(inverse)[:size], np.diag(inverse)[size:]
    between = np.diagonal(inverse, size)
    a, b = weight[:size], weight[size:]
    area = np.maximum(cosine * sine - between**2, _ALIKE * np.abs(cosine * sine) + 1e-300)
    loss: Array = (a * a * sine - 2 * a * b * between + b * b * cosine) / area
    return loss
