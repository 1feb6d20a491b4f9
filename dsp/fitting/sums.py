"""Damped sinusoids in closed form: their inner products, their projections on a signal, and their sum.

The atoms are e_i(t) = exp(s_i t), t = 0, 1, ... n - 1 in samples, and t e_i(t), their derivatives by s_i. Sums of
powers w^t, t w^t and t^2 w^t are geometric series, so no inner product of two atoms costs work that grows with n.
While a blow lasts, atoms are not exponentials yet (blow.py): a head of few samples takes the place of their beginnings.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..numerics.checks import Array

Complex = npt.NDArray[np.complex128]

_BLOCK = 512  # samples that share one table of exponentials


@dataclass(frozen=True)
class Head:
    """The first m samples of all atoms (m, k) and of their derivatives by s (m, k), as a blow makes them.

    From sample m on, atoms are exp(s (t - origin)); origin: in samples.
    """

    atoms: Complex
    slopes: Complex
    origin: int

    @property
    def length(self) -> int:
        return len(self.atoms)


def geometric(left: Complex, right: Complex, n: int) -> tuple[Complex, Complex, Complex]:
    """Return sums of w^t, t w^t and t^2 w^t over t = 0 ... n - 1, for w = exp(left_i + right_j), |w| < 1, (k, k) each.

    They are written so that none cancels. Exponentials are taken of the k numbers, not of the k^2 sums.
    """
    first_part, second_part = np.expm1(left)[:, None], np.expm1(right)[None]
    rest: Complex = np.negative(first_part + second_part + first_part * second_part, dtype=np.complex128)
    w = 1 - rest
    last = np.outer(np.exp(n * left), np.exp(n * right))
    gone: Complex = np.subtract(1, last, dtype=np.complex128)
    shared = n * rest
    zeroth = gone / rest
    first = (w * zeroth - n * last) / rest
    second = (w * (1 + w) * zeroth - last * n * (shared + 2 * w)) / rest**2
    return zeroth, first, second


def products(s: Complex, n: int, head: Head | None = None, slopes: bool = False) -> tuple[Complex, Complex]:
    """Return sums over time of a_i a_j and of conj(a_i) a_j for all atoms a, (k, k), or with their slopes (2 k, 2 k).

    s (k,): log poles per sample, with negative real parts. n: samples.
    """
    if head is None:
        return ringing_products(s, n, 0, slopes)
    plain, crossed = ringing_products(s, n - head.length, head.length - head.origin, slopes)
    atoms = np.hstack([head.atoms, head.slopes]) if slopes else head.atoms
    return plain + atoms.T @ atoms, crossed + atoms.conj().T @ atoms


def ringing_products(s: Complex, n: int, later: int, slopes: bool = False) -> tuple[Complex, Complex]:
    """Return the same of exponentials alone, of n samples from `later` on."""
    begin = np.exp(s * later)
    both = []
    for left, begins in ((s, begin), (s.conj(), begin.conj())):
        zeroth, first, second = geometric(left, s, n)
        if slopes:
            second = second + 2 * later * first + later**2 * zeroth
            first = first + later * zeroth
            zeroth = np.block([[zeroth, first], [first, second]])
            both.append(zeroth * np.outer(np.tile(begins, 2), np.tile(begin, 2)))
        else:
            both.append(zeroth * np.outer(begins, begin))
    return both[0], both[1]


def real_gram(plain: Complex, conjugate: Complex) -> Array:
    """Return the Gram matrix (2 k, 2 k) of Re a_i and -Im a_i, of which Re(c a) is the sum with the weights Re c and Im
    c."""
    between = 0.5 * (plain + conjugate).imag
    gram: Array = np.block([
        [0.5 * (plain + conjugate).real, -between],
        [-between.T, 0.5 * (conjugate - plain).real],
    ])  # fmt: skip
    return gram


def project(x: Array, s: Complex, head: Head | None = None, slopes: bool = False) -> Complex:
    """Return sums over time of x a_i for all atoms (k,), or with their slopes (2 k,)."""
    if head is None:
        return ringing_project(x, s, 0, slopes)
    found = ringing_project(x[head.length :], s, head.length - head.origin, slopes)
    return found + x[: head.length] @ (np.hstack([head.atoms, head.slopes]) if slopes else head.atoms)


def ringing_project(x: Array, s: Complex, later: int, slopes: bool = False) -> Complex:
    """Return the same of exponentials alone, from `later` on."""
    count = -(-len(x) // _BLOCK)
    blocks = np.pad(x, (0, count * _BLOCK - len(x))).reshape(count, _BLOCK).T
    inside = np.exp(np.outer(s, np.arange(_BLOCK)))
    starts = later + _BLOCK * np.arange(count)
    between = np.exp(np.outer(s, starts))
    zeroth = _times_real(inside, blocks)
    sums: Complex = np.sum(zeroth * between, axis=1)
    if not slopes:
        return sums
    first = _times_real(inside * np.arange(_BLOCK), blocks)
    return np.concatenate([sums, np.sum((first + zeroth * starts) * between, axis=1)])


def _times_real(left: Complex, right: Array) -> Complex:
    """Multiply as matrices; numpy would make the right one complex, too."""
    product: Complex = left.real @ right + 1j * (left.imag @ right)
    return product


def as_weights(products_with_x: Complex) -> Array:
    """Return the inner products (2 k,) of a signal with Re a_i and -Im a_i, from those with a_i (k,)."""
    return np.concatenate([products_with_x.real, -products_with_x.imag])


def ring(amplitude: Complex, s: Complex, n: int, head: Head | None = None) -> Array:
    """Return the sum of Re(c_i a_i), (n,)."""
    if head is not None:
        later = head.length - head.origin
        rest = ring(amplitude * np.exp(s * later), s, n - head.length)
        return np.concatenate([(head.atoms @ amplitude).real, rest])
    count = -(-n // _BLOCK)
    inside = np.exp(np.outer(s, np.arange(_BLOCK)))
    between = np.exp(np.outer(_BLOCK * np.arange(count), s)) * amplitude
    sound: Array = (between @ inside).real.reshape(-1)[:n]
    return sound
