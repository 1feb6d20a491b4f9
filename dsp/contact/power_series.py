"""Power series of a motion over one sample: tables of their integrals, and their values.

Time is in samples. Force over a step is a quadratic through its values at collocation.GAUSS of the step.
"""

import math

import numpy as np
from numpy.polynomial import Chebyshev, Legendre, Polynomial, legendre

from ..native.jit import kernel
from ..native.typed import View
from ..numerics.checks import Array
from ..numerics.legendre import FINE
from .collocation import CARDINAL, GAUSS, INTEGRAL
from .step_record import NODES

_nodes, _weights = legendre.leggauss(FINE // 2 + 1)
QUADRATURE, QUADRATURE_WEIGHTS = 0.5 * (_nodes + 1.0), 0.5 * _weights
"""Nodes and weights over a step, for a force times FINE powers."""

FORCE_AT = np.vander(QUADRATURE, NODES, increasing=True) @ CARDINAL
"""Values of a quadratic at QUADRATURE."""

BINOMIAL = np.array([[math.comb(n, k) for k in range(FINE)] for n in range(FINE)], np.float64)

CENTRED = np.array([np.pad(legendre.leg2poly([0] * k + [1]), (0, FINE - 1 - k)) for k in range(FINE)])
"""Power series of the sample's Legendre polynomials in x = 2 t - 1: a row each."""

POWERS = np.zeros((FINE, FINE))
"""Power series of the sample's Legendre polynomials: a column each."""

for _k in range(FINE):
    POWERS[: _k + 1, _k] = Legendre.basis(_k, domain=[0, 1]).convert(domain=[-1, 1], kind=Polynomial).coef


def _beyond() -> Array:
    """Return t^FINE on [0, 1] by the powers from t^2 on: t^2 times Chebyshev's best for t^(FINE - 2)."""
    n = FINE - 2
    top = Chebyshev.basis(n, domain=[0, 1]).convert(domain=[-1, 1], kind=Polynomial).coef
    return np.concatenate([np.zeros(2), -top[:n] / top[n]])


BEYOND = _beyond()
"""Coefficients of t^FINE on [0, 1] by the powers below it, which err by 1.2e-7 at most."""


def _moment_tables() -> tuple[Array, Array, Array]:
    """Return the integrals over a unit step with l_j, the quadratics that are 1 at one node and 0 at the others."""

    def running(t: float) -> Array:
        # int_0^t (t - s)^n s^p ds = n! p!/(n + p + 1)! t^(n + p + 1)
        beta = [
            [math.factorial(n) * math.factorial(p) / math.factorial(n + p + 1) * t ** (n + p + 1) for p in range(NODES)]
            for n in range(FINE)
        ]
        integrals: Array = np.array(beta) @ CARDINAL
        return integrals

    nodes, weights = legendre.leggauss(FINE)
    double = sum(
        0.5 * w * (t ** np.arange(NODES) @ CARDINAL)[None, :, None] * running(t)[:, None, :]
        for t, w in zip((nodes + 1.0) / 2.0, weights, strict=True)
    )
    return np.stack([running(c) for c in GAUSS], axis=1), running(1.0), np.asarray(double)


_TO_NODE, TO_END, _DOUBLE = _moment_tables()
"""[n, i, j]: int_0^c_i (c_i - s)^n l_j ds; [n, j]: the same up to 1; [n, i, j]: int_0^1 l_i(t) int_0^t (t - s)^n l_j(s)
ds dt."""

MISSED = np.vander(GAUSS, FINE, increasing=True).T @ INTEGRAL.T - np.array(
    [GAUSS ** (n + 1) / (n + 1) for n in range(FINE)]
)
"""[n, i]: by how much the Gauss method's own integral of t^n up to c_i is above the exact one; 0 up to t^2."""

AT_NODES = np.zeros((FINE, 2 * NODES))
"""[n]: t^n at the nodes of a unit step, then its derivative there."""

ANSWER_AT = np.zeros((FINE, NODES * NODES))
"""[n]: the derivative of int_0^t (t - s)^n l_j(s) ds at GAUSS[i], as 3 i + j."""

ANSWER_TO_END = np.zeros((FINE, 2 * NODES))
"""[n]: that integral up to 1, then its derivative there, for each l_j."""

WORK = np.zeros((FINE, 3))
"""[n, j]: int_0^1 l_j(t) n t^(n-1) dt, the work of a force along t^n."""

TAKEN = np.zeros((FINE, NODES * NODES))
"""[n]: n int_0^1 l_i(t) int_0^t (t - s)^(n-1) l_j(s) ds dt, as 3 i + j."""

for _n in range(FINE):
    AT_NODES[_n] = np.concatenate([GAUSS**_n, _n * GAUSS ** max(_n - 1, 0)])
    ANSWER_TO_END[_n, :NODES] = TO_END[_n]
    if _n > 0:
        ANSWER_AT[_n] = _n * _TO_NODE[_n - 1].ravel()
        ANSWER_TO_END[_n, NODES:] = _n * TO_END[_n - 1]
        WORK[_n] = CARDINAL.T @ (_n / (_n + np.arange(NODES)))
        TAKEN[_n] = _n * _DOUBLE[_n - 1].ravel()


@kernel
def value_at(series: View[float], t: float) -> tuple[float, float]:
    """Return a power series and its derivative."""
    value = series[FINE - 1]
    slope = 0.0
    for n in range(FINE - 2, -1, -1):
        slope = slope * t + value
        value = value * t + series[n]
    return value, slope


@kernel
def legendre_moments(moments: View[float]) -> None:
    """Make Legendre moments of a force over a sample, in the place of its moments of the powers of x = 2 t - 1."""
    for k in range(FINE - 1, 1, -1):
        total = 0.0
        for n in range(k % 2, k + 1, 2):
            total += CENTRED[k, n] * moments[n]
        moments[k] = total
