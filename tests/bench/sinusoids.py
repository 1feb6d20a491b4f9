"""Least rest of a sound that any sum of so many damped sinusoids leaves: a bound that no fit can pass.

The Hankel matrix x_(i+j) of one damped sinusoid has rank 2, that of k of them at most 2 k. Here A is the sound's, each
x_(i+j) times sqrt(a_i a_j), where the a_i are the coefficients of (1 - z)^(-1/2). The sum of a_i a_j over i + j = t is
1: in A's squared norm each sample up to the middle of the sound counts once, later ones less. Let X be such a matrix
of k damped sinusoids, and Z any matrix orthogonal to all Hankel matrices weighted so. Then

    |A - X|^2 = |A|^2 - 2 <A + Z, X> + |X|^2 >= |A|^2 - sum_(i <= 2 k) sigma_i(A + Z)^2.

For Z = 0 that is what Eckart and Young found (1936). It is concave in Z, and steps along its slope tighten it
(V. Larsson, C. Olsson, "Convex low rank approximation", Int. J. Computer Vision 120, 2016). The slope is 2 (P Y - Y):
Y is the matrix of rank 2 k nearest to A + Z, and P Y the weighted Hankel matrix nearest to Y.
"""

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.sparse.linalg import LinearOperator, eigsh

from carom.dsp.numerics.blas import on_one_thread

_TOLERANCE = 1e-6  # of an eigenvector; an eigenvalue is off by its square


def least_left(samples: np.ndarray, count: int, steps: int = 8) -> float:
    """Return the energy that `count` damped sinusoids leave of a sound (n,) at least; n > 4 count + 2. More steps tell
    more.

    The sinusoids begin with the sound, at any phase, and may grow.
    """
    sound = np.array(samples[: (len(samples) - 1) // 2 * 2 + 1], np.float64)
    size = len(sound) // 2 + 1
    length = next_fast_len(len(sound) + size, real=True)
    order = np.arange(1, size)
    weight = np.sqrt(np.cumprod(np.r_[1, (2 * order - 1) / (2 * order)]))
    counts = irfft(rfft(weight**2, length) ** 2, length)[: len(sound)]
    energy, best = counts @ sound**2, 0.0
    values, vectors = np.zeros(0), np.zeros((size, 0))  # of what is no Hankel matrix in A + Z
    for step in 2 / (2 + np.arange(steps + 1)):
        spectrum = rfft(sound, length)

        def times(v: np.ndarray, spectrum: np.ndarray = spectrum, parts: tuple = (values, vectors)) -> np.ndarray:
            smooth = irfft(spectrum * rfft(weight * v.ravel(), length).conj(), length)[:size]
            return weight * smooth + parts[1] @ (parts[0] * (v.ravel() @ parts[1]))

        matrix = LinearOperator((size, size), times, dtype=np.float64)
        with on_one_thread():
            value, vector = eigsh(matrix, 2 * count, tol=_TOLERANCE, v0=weight)
        best = max(best, float(energy - value @ value))
        squares = value @ rfft((weight[:, None] * vector).T, length) ** 2
        sound += step * irfft(squares, length)[: len(sound)] / counts
        values, vectors = np.r_[values, -step * value], np.hstack([vectors, vector])
    return best
