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
from ..numerics.settled import same_everywhere
from ..numerics.sums import AT_ONCE, put_few
from .collocation import CARDINAL, GAUSS, INTEGRAL, WEIGHTS
from .step_record import FREE_COUNT, GIVE_COUNT, NODES, PUSH_COUNT, SERIES_COUNT

_nodes, _weights = legendre.leggauss(FINE // 2 + 1)
QUADRATURE, QUADRATURE_WEIGHTS = 0.5 * (_nodes + 1.0), 0.5 * _weights
"""Nodes and weights over a step, for a force times FINE powers."""

_AT_THEM = np.vander(QUADRATURE, NODES, increasing=True) @ CARDINAL
FORCES_THERE = same_everywhere(
    "FORCES_THERE", np.concatenate([*(QUADRATURE_WEIGHTS[:, None] * _AT_THEM).T, QUADRATURE])
)
"""The weights times the quadratic that is 1 at a node of the step and 0 at the others, for each; then QUADRATURE."""

WHOLE_SAMPLE = same_everywhere("WHOLE_SAMPLE", legendre.legvander(2.0 * GAUSS - 1.0, NODES - 1).T * WEIGHTS)
"""[k, j]: Legendre moments over the sample of a quadratic over all of it, by its values at GAUSS; others are 0."""

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


LAST_POWER = same_everywhere("LAST_POWER", _beyond())
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


_TO_NODE, TO_END, _DOUBLE = map(same_everywhere, ("TO_NODE", "TO_END", "DOUBLE"), _moment_tables())
"""[n, i, j]: int_0^c_i (c_i - s)^n l_j ds; [n, j]: the same up to 1; [n, i, j]: int_0^1 l_i(t) int_0^t (t - s)^n l_j(s)
ds dt."""

_MISSED = same_everywhere(
    "MISSED",
    np.vander(GAUSS, FINE, increasing=True).T @ INTEGRAL.T
    - np.array([GAUSS ** (n + 1) / (n + 1) for n in range(FINE)]),
)
"""[n, i]: by how much the Gauss method's own integral of t^n up to c_i is above the exact one; 0 up to t^2."""

_N = np.arange(FINE)
_LESS = np.maximum(_N - 1, 0)  # the power of a derivative, which has _N as its factor


def _derived(table: Array) -> Array:
    """Return n table[n - 1], a row for each n, flat."""
    return (_N * table[_LESS].reshape(FINE, -1).T).T


def _by_lines(count: int, *tables: Array) -> Array:
    """Return tables, a row for each n, as `put_few` reads them: `count` columns, of which the last ones are 0."""
    columns = np.concatenate(tables, axis=1)
    lines = np.pad(columns, ((0, 0), (0, count - columns.shape[1]))).reshape(FINE, count // AT_ONCE, AT_ONCE)
    return np.ascontiguousarray(lines.transpose(1, 0, 2)).ravel()


_WORK = same_everywhere("WORK", [CARDINAL.T @ (n / np.maximum(n + np.arange(NODES), 1)) for n in range(FINE)])
_AT_GAUSS = same_everywhere("AT_GAUSS", GAUSS ** _N[:, None])  # powers
FREE = _by_lines(FREE_COUNT, _AT_GAUSS, _derived(_AT_GAUSS), np.stack([_N**0, _N], 1), _WORK)
NODE_RATES, END, WORK = NODES, 2 * NODES, 2 * NODES + 2
"""Tables of the products of a motion (FREE_COUNT), by t^n, and their places: behind its values at the nodes of a unit
step their rates, value and rate at its end, and the work int_0^1 l_j(t) n t^(n-1) dt of a force along it."""

ON = _by_lines(SERIES_COUNT, BINOMIAL)
"""Tables of the power series of a motion from the end of a unit step on, by that from its beginning on."""

CLOSING = _by_lines(SERIES_COUNT, -POWERS.T)
"""Tables of the power series by which a compression grows while the point moves as the sample's Legendre polynomials
with such coefficients say: the negative of theirs."""

GIVE = _by_lines(GIVE_COUNT, _derived(_TO_NODE), TO_END, _derived(TO_END), _derived(_DOUBLE), _MISSED)
TO_ENDS, TAKEN, MISSED = NODES * NODES, NODES * NODES + 2 * NODES, 2 * NODES * NODES + 2 * NODES
"""Tables of the products of an answer (GIVE_COUNT), by t^n, and their places. At 3 i + j the derivative of
int_0^t (t - s)^n l_j(s) ds at GAUSS[i]; that integral up to 1, then its derivative there, for each l_j; at 3 i + j n
int_0^1 l_i(t) int_0^t (t - s)^(n-1) l_j(s) ds dt; and, for each node, what is missed of a force that lasts."""

PUSH = _by_lines(
    PUSH_COUNT,
    *(
        np.array([[BINOMIAL[n, k] * TO_END[n - k, j] if k <= n else 0.0 for k in range(FINE)] for n in range(FINE)])
        for j in range(NODES)
    ),
)
"""Tables of FINE columns for each node (PUSH_COUNT): the power series, from the step's end on, of what its force takes
off."""


@kernel
def put(series: View[float], tables: View[float], products: View[float]) -> None:
    """Set the sums of tables times a power series, or times other coefficients."""
    factors = (
        series[0], series[1], series[2], series[3], series[4], series[5], series[6],
        series[7], series[8], series[9], series[10], series[11], series[12], series[13],
    )  # fmt: skip
    put_few(products, tables, factors, len(products))


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
