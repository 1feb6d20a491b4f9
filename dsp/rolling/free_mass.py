"""The forces at a collocation step's nodes between a path and one free mass on a dashpot.

With the matrix P of integrals up to the nodes (INTEGRAL), a step of h s and the mass m, forces f take q = (h/m) P f +
f/Z off the rates of compression, and h P q off the compressions, with 1/Z the dashpot's mobility. Newton's method with
the mean of the nodes' stiffness and damping for all of them has a matrix that is a polynomial of P. In P's
eigenvectors, which are known beforehand, it is solved by one real division and a complex one. The difference between
the nodes counts by the square of the swing in a step: each iteration gains two to four digits.
"""

import numpy as np
from numpy.typing import NDArray

from ..contact.collocation import INTEGRAL, WEIGHTS, raised, solve
from ..contact.step_record import Step
from ..native.jit import kernel, noinline_kernel

_ITERATIONS = 10
_SOLVED = 1e-11  # share of the forces by which they may err
_SLOW = 0.3  # of the change before: where a change is more, Newton's method with each node's own slopes takes over


def _eigenvectors() -> tuple[float, complex, NDArray[np.float64], NDArray[np.float64]]:
    """Return P's real eigenvalue and a complex one; the first's vector and both parts of the other's, and their
    inverse."""
    values, vectors = np.linalg.eig(INTEGRAL)
    real = int(np.argmin(abs(values.imag)))
    other = int(np.argmax(values.imag))
    basis = np.column_stack([vectors[:, real].real, vectors[:, other].real, vectors[:, other].imag])
    return float(values[real].real), complex(values[other]), basis, np.linalg.inv(basis)


_REAL, _OTHER, _basis, _inverse = _eigenvectors()
_OTHER_RE, _OTHER_IM = _OTHER.real, _OTHER.imag
_SQUARE_RE, _SQUARE_IM = (_OTHER * _OTHER).real, (_OTHER * _OTHER).imag
_TWICE = INTEGRAL @ INTEGRAL
_P = tuple(tuple(float(x) for x in row) for row in INTEGRAL)
_PP = tuple(tuple(float(x) for x in row) for row in _TWICE)
_B = tuple(tuple(float(x) for x in row) for row in _basis)
_C = tuple(tuple(float(x) for x in row) for row in _inverse)
_W = tuple(float(x) for x in WEIGHTS)


@kernel
def _times(
    matrix: tuple[tuple[float, ...], ...],
    f0: float,
    f1: float,
    f2: float,
) -> tuple[float, float, float]:
    """Multiply a matrix of 3 x 3 numbers by a vector."""
    return (
        matrix[0][0] * f0 + matrix[0][1] * f1 + matrix[0][2] * f2,
        matrix[1][0] * f0 + matrix[1][1] * f1 + matrix[1][2] * f2,
        matrix[2][0] * f0 + matrix[2][1] * f1 + matrix[2][2] * f2,
    )


@kernel
def _law(x: float, v: float, k: float, mu: float, a: float) -> tuple[float, float, float]:
    """Return the contact force (N) and its slopes over x and v."""
    slack = 1.0 + mu * v
    if x <= 0.0 or slack <= 0.0:
        return 0.0, 0.0, 0.0
    rate = k * raised(x, a - 1.0)
    return rate * x * slack, a * rate * slack, mu * rate * x


@kernel
def _compressions(
    step: Step, f: tuple[float, float, float], h: float, lightness: float, mobility: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return the compressions and their rates under forces at the nodes."""
    p = _times(_P, f[0], f[1], f[2])
    pp = _times(_PP, f[0], f[1], f[2])
    heavy, light = h * lightness, h * mobility
    x = (
        step.free_x[0] - (heavy * pp[0] + light * p[0]),
        step.free_x[1] - (heavy * pp[1] + light * p[1]),
        step.free_x[2] - (heavy * pp[2] + light * p[2]),
    )
    v = (
        step.free_v[0] - (lightness * p[0] + mobility * f[0]),
        step.free_v[1] - (lightness * p[1] + mobility * f[1]),
        step.free_v[2] - (lightness * p[2] + mobility * f[2]),
    )
    return x, v


@kernel
def _slopes(
    stiffness: float, damping: float, h: float, lightness: float, mobility: float
) -> tuple[float, float, float]:
    """Return the reciprocals of Newton's matrix in P's eigenvectors: a real number, and a complex one by its parts."""
    c0, c1, c2 = 1.0 + damping * mobility, damping * lightness + stiffness * h * mobility, stiffness * h * lightness
    real = 1.0 / (c0 + _REAL * (c1 + _REAL * c2))
    re = c0 + _OTHER_RE * c1 + _SQUARE_RE * c2
    im = _OTHER_IM * c1 + _SQUARE_IM * c2
    size = 1.0 / (re * re + im * im)
    return real, re * size, -im * size


@noinline_kernel
def solve_free_mass(
    step: Step, h: float, lightness: float, mobility: float, law: tuple[float, float, float], negligible: float
) -> bool:
    """Solve for the forces at the nodes, from `step.f` on, within `negligible` (N); return False if the step is too
    long to find them.

    lightness: h over the mass, s/kg; law: k, mu, a. step.free_x, step.free_v: compressions and rates without the force.
    """
    k, mu, a = law
    f = step.f[0], step.f[1], step.f[2]
    inverse = 1.0, 1.0, 0.0
    before = 0.0
    for n in range(_ITERATIONS):
        x, v = _compressions(step, f, h, lightness, mobility)
        r0, s0, d0 = _law(x[0], v[0], k, mu, a)
        r1, s1, d1 = _law(x[1], v[1], k, mu, a)
        r2, s2, d2 = _law(x[2], v[2], k, mu, a)
        if n == 0:
            stiffness, damping = _W[0] * s0 + _W[1] * s1 + _W[2] * s2, _W[0] * d0 + _W[1] * d1 + _W[2] * d2
            inverse = _slopes(stiffness, damping, h, lightness, mobility)
        real, re, im = inverse
        c0, c1, c2 = _times(_C, r0 - f[0], r1 - f[1], r2 - f[2])
        # c1 - i c2 is the coordinate that P multiplies by its complex eigenvalue.
        d = _times(_B, real * c0, re * c1 + im * c2, re * c2 - im * c1)
        f = f[0] + d[0], f[1] + d[1], f[2] + d[2]
        change = max(abs(d[0]), abs(d[1]), abs(d[2]))
        enough = _SOLVED * max(abs(f[0]), abs(f[1]), abs(f[2])) + negligible
        if change <= enough or (n > 0 and change * change <= enough * before):
            step.f[0], step.f[1], step.f[2] = f
            return True
        if n > 0 and not change <= _SLOW * before:
            break
        before = change
    return _solve_each(step, h, lightness, mobility, law, negligible)


@noinline_kernel
def _solve_each(
    step: Step, h: float, lightness: float, mobility: float, law: tuple[float, float, float], negligible: float
) -> bool:
    """Solve for the same by Newton's method with each node's own slopes."""
    k, mu, a = law
    for i in range(3):
        for j in range(3):
            step.give_v[i, j] = lightness * INTEGRAL[i, j]
            step.give_x[i, j] = h * (lightness * _TWICE[i, j] + mobility * INTEGRAL[i, j])
        step.give_v[i, i] += mobility
    return solve(step, k, mu, a, negligible)
