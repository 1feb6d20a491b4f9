"""All poles and amplitudes at once: Levenberg and Marquardt's method in closed form.

The amplitudes are linear, and each set of poles has its best ones: what is left is a problem in the poles alone
(variable projection: G. H. Golub, V. Pereyra 1973, in L. Kaufman's form). Gram matrices of atoms and slopes (sums.py)
hold all that it needs. In white noise the result is the most likely one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..numerics.checks import Array
from .sums import Complex, Head, as_weights, products, project, real_gram

Heads = Callable[[Complex], Sequence[Head | None]]
"""Function from log poles to the head of the atoms of each take."""

_SMALLEST = 1e-20  # of the highest of a diagonal
_RIDGE = 1e-10  # of a normalised Gram matrix
_FIRST, _CALMER, _BOLDER, _LEAST = 1e-3, 6.0, 0.2, 1e-8  # the damping: to begin with, and how it goes up and down
_TRIES = 5
_MOST_DECAY = 5000.0  # 1/s
_LEAST_FALL = 0.5  # dB by which a mode falls over the longest take
_MOST_DAMPED = 0.5  # of a mode's angular frequency, its decay rate: more is a click, and no mode


def slowest(takes: Sequence[Array]) -> float:
    """Return the least decay per sample that is looked for."""
    return float(np.log(10) / 20 * _LEAST_FALL / max(map(len, takes)))


def plain(takes: Sequence[Array]) -> Heads:
    """Return atoms that begin at once."""
    return lambda _: [None] * len(takes)


def amplitudes(takes: Sequence[Array], s: Complex, heads: Sequence[Head | None]) -> tuple[list[Complex], float]:
    """Return the best amplitudes (k,) for each take, and the squared error that is left of all."""
    found, error = [], 0.0
    for take, head in zip(takes, heads, strict=True):
        weights, less = solved(real_gram(*products(s, len(take), head)), as_weights(project(take, s, head)))
        found.append(weights[: len(s)] + 1j * weights[len(s) :])
        error += float(take @ take) - less
    return found, error


def solved(gram: Array, side: Array) -> tuple[Array, float]:
    """Return the best weights of atoms with this Gram matrix and these products with a take, and the energy they
    explain."""
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    weights = np.linalg.solve(gram / np.outer(scale, scale) + _RIDGE * np.eye(len(gram)), side / scale) / scale
    return weights, float(2 * weights @ side - weights @ gram @ weights)


def refine(
    takes: Sequence[Array], s: Complex, rate: float, heads: Heads, steps: int = 20, enough: float = 1e-4
) -> Complex:
    """Refine the poles from a first guess, so that they leave the least of the takes.

    s (k,): log poles per sample. rate: Hz. It ends after some steps, or where one gains less than a share of the error.
    """
    least = slowest(takes)
    s = _bounded(s, rate, least)
    if not len(s):
        return s
    amplitude, error = amplitudes(takes, s, heads(s))
    damping = _FIRST
    for _ in range(steps):
        normal, slope = _normal(takes, s, amplitude, heads(s))
        scale = np.sqrt(np.maximum(np.diag(normal), _SMALLEST * np.diag(normal).max()))
        scaled = normal / np.outer(scale, scale)
        for _try in range(_TRIES):
            step = np.linalg.solve(scaled + damping * np.eye(len(scaled)), slope / scale) / scale
            tried = _bounded(s + step[: len(s)] + 1j * step[len(s) :], rate, least)
            there, left = amplitudes(takes, tried, heads(tried))
            if left < error:
                break
            damping *= _CALMER
        else:
            return s
        gain = (error - left) / error
        s, amplitude, error, damping = tried, there, left, max(damping * _BOLDER, _LEAST)
        if gain < enough:
            break
    return s


def variances(takes: Sequence[Array], s: Complex, amplitude: list[Complex], heads: Sequence[Head | None]) -> Array:
    """Return the variances of the decays (k,), per sample squared, in white noise of the power 1: the Cramer-Rao
    bound."""
    normal, _ = _normal(takes, s, amplitude, heads)
    scale = np.sqrt(np.maximum(np.diag(normal), _SMALLEST * np.diag(normal).max()))
    inverse = np.linalg.inv(normal / np.outer(scale, scale) + _RIDGE * np.eye(len(normal)))
    found: Array = (np.diag(inverse) / scale**2)[: len(s)]
    return found


def _normal(
    takes: Sequence[Array], s: Complex, amplitude: list[Complex], heads: Sequence[Head | None]
) -> tuple[Array, Array]:
    """Return the matrix and the right side of a Gauss-Newton step in Re s and Im s; the amplitudes follow by
    themselves."""
    count = len(s)
    normal, slope = np.zeros((2 * count, 2 * count)), np.zeros(2 * count)
    own = np.r_[0:count, 2 * count : 3 * count]
    moved = np.r_[count : 2 * count, 3 * count : 4 * count]
    for take, c, head in zip(takes, amplitude, heads, strict=True):
        weight = np.concatenate([np.ones(count), c])
        alike, crossed = products(s, len(take), head, slopes=True)
        gram = real_gram(alike * np.outer(weight, weight), crossed * np.outer(weight.conj(), weight))
        side = as_weights(project(take, s, head, slopes=True) * weight)
        left = side - gram[:, own] @ np.concatenate([c.real, c.imag])
        atoms = gram[np.ix_(own, own)]
        scale = np.sqrt(np.maximum(np.diag(atoms), 1e-300))
        across = gram[np.ix_(own, moved)] / scale[:, None]
        ridge = _RIDGE * np.eye(len(atoms))
        normal += gram[np.ix_(moved, moved)] - across.T @ np.linalg.solve(
            atoms / np.outer(scale, scale) + ridge, across
        )
        slope += left[moved]
    return normal, slope


def _bounded(s: Complex, rate: float, least: float) -> Complex:
    omega = np.clip(s.imag, 2 * np.pi * 10 / rate, np.pi * 0.99)
    most = np.minimum(_MOST_DECAY / rate, _MOST_DAMPED * omega)
    bounded: Complex = -np.clip(-s.real, np.minimum(least, most), most) + 1j * omega
    return bounded
