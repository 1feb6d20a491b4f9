"""The step of contacts that have no closed form: one scalar equation.

Over a step of h seconds the contact force is the quadratic through its values at three Gauss nodes, and the law
f = k x^a (1 + mu v), x > 0 (law.py), holds at the nodes. Whatever moves linearly enters by a few numbers: the
compression that there would be without the force, and by how much the nodes' forces take it back. Along the exact flow
this is Gauss collocation of order 6; for a free mass it is the Runge-Kutta method of that name, A-stable. A contact
that sticks never pulls: where 1 + mu v < 0 the law gives 0.

Where the steps would have to become too fine, `discrete_gradient` holds the force for the step at
[V(x1) - V(x0)]/(x1 - x0) max(0, 1 + mu (x1 - x0)/h), with V = k x^(a+1)/(a+1): the work is at least the change of V, so
energy can't grow, whatever the step, and the root is unique.
"""

import numpy as np
from numpy.polynomial import legendre

from ..native.jit import kernel
from ..native.typed import View, View2D
from ..numerics.settled import same_everywhere
from .law import compression_at, elastic, law_with_slopes, slack_of, spring_of
from .step_record import NODES, Step

GAUSS = same_everywhere("GAUSS", (legendre.leggauss(NODES)[0] + 1.0) / 2.0)
"""The nodes, in [0, 1] of a step."""

CARDINAL = same_everywhere("CARDINAL", np.linalg.inv(np.vander(GAUSS, increasing=True)))
# power series of the polynomials 1 at one node, 0 at others

WEIGHTS = same_everywhere("WEIGHTS", [CARDINAL[:, j] @ (1.0 / np.arange(1, NODES + 1)) for j in range(NODES)])
"""Integrals over the step."""

INTEGRAL = same_everywhere(
    "INTEGRAL", [[c ** np.arange(1, 4) / np.arange(1, 4) @ CARDINAL[:, j] for j in range(NODES)] for c in GAUSS]
)
"""Integrals from the step's beginning up to a node (row): the Gauss method's matrix."""

LAST: View[float] = same_everywhere("LAST", CARDINAL.sum(axis=0))
"""The quadratic's value at the step's end."""

_C = tuple(tuple(float(x) for x in row) for row in CARDINAL)

WITHIN = 0.8
"""Share of the longest step within a tolerance that `better_step` tries."""

LEAST_REST = 1e-300
"""Lower bound of the remainder at a step's end, which keeps a quotient finite."""

SOLVED = 1e-8  # relative change of the forces that ends Newton's method, whose error is then about its square
NEWTON_STEPS = 16
_SMALL = 2 * NODES  # unknowns: no zero is worth a look
_CLOSED = 1e-10  # of a step's greatest compression, that is left at the release
_OPEN = 0.1  # of the tolerance: share of it that the gap may be by then, which costs no energy
_GRADIENT_STEPS = 200
_ROUNDED = 2e-14  # share of its parts that is left of a residual by rounding
_NEARLY_EQUAL = 3e-2  # share of x below which a change makes energies too equal to subtract
_SHORTEN, LENGTHEN = 0.2, 2.0  # a step by at most, at once
FAR = (LENGTHEN / WITHIN) ** 4  # times the rest that is left, from which on that much is allowed


@kernel
def captured(x: float, v: float, m: float, k: float, a: float, push: float) -> bool:
    """True if the mass can never leave while it is pushed like this.

    E = m v^2/2 + k x^(a+1)/(a+1) - push x does not grow in contact, and isn't negative at x = 0.
    """
    return x > 0.0 and 0.5 * m * v * v + elastic(x, k, a) < push * x


@kernel
def eliminate_three(m: View2D[float]) -> None:
    """Do what `eliminate` does for three equations, by determinants: one quotient, and few products wait for others."""
    r0, r1, r2 = m[0, 3], m[1, 3], m[2, 3]
    share = 1.0 / (m[0, 0] * _cofactor(m, 0, 0) + m[0, 1] * _cofactor(m, 0, 1) + m[0, 2] * _cofactor(m, 0, 2))
    x0 = _cofactor(m, 0, 0) * r0 + _cofactor(m, 1, 0) * r1 + _cofactor(m, 2, 0) * r2
    x1 = _cofactor(m, 0, 1) * r0 + _cofactor(m, 1, 1) * r1 + _cofactor(m, 2, 1) * r2
    x2 = _cofactor(m, 0, 2) * r0 + _cofactor(m, 1, 2) * r1 + _cofactor(m, 2, 2) * r2
    m[0, 3], m[1, 3], m[2, 3] = share * x0, share * x1, share * x2


@kernel
def _cofactor(m: View2D[float], i: int, j: int) -> float:
    """Return a cofactor of the first three columns of three equations."""
    a, b, c, d = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
    return m[a, c] * m[b, d] - m[a, d] * m[b, c]


@kernel
def eliminate(linear: View2D[float], size: int) -> None:
    """Solve the linear equations; the solution takes the right side's place. Their diagonal is safely positive."""
    for i in range(size):
        reciprocal = 1.0 / linear[i, i]
        for j in range(i + 1, size + 1):
            linear[i, j] *= reciprocal
        for row in range(i + 1, size):
            if size > _SMALL and linear[row, i] == 0.0:  # of many contacts few share an object
                continue
            for j in range(i + 1, size + 1):
                linear[row, j] -= linear[row, i] * linear[i, j]
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, size):
            linear[i, size] -= linear[i, j] * linear[j, size]


@kernel
def factor(linear: View2D[float], size: int) -> None:
    """Factor the matrix of linear equations, for `substitute`. Its diagonal is safely positive."""
    for i in range(size):
        linear[i, i] = 1.0 / linear[i, i]
        for row in range(i + 1, size):
            linear[row, i] *= linear[i, i]
            for j in range(i + 1, size):
                linear[row, j] -= linear[row, i] * linear[i, j]


@kernel
def substitute(linear: View2D[float], size: int) -> None:
    """Solve linear equations whose matrix is factored; the solution takes the right side's place."""
    for i in range(size):
        for j in range(i):
            linear[i, size] -= linear[i, j] * linear[j, size]
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, size):
            linear[i, size] -= linear[i, j] * linear[j, size]
        linear[i, size] *= linear[i, i]


@kernel
def force_at(f0: float, f1: float, f2: float, theta: float) -> float:
    """Return the quadratic through a step's forces at `theta`, in times of the step; never negative."""
    c0, c1, c2 = power_series_of(f0, f1, f2)
    return max(c0 + theta * (c1 + theta * c2), 0.0)


@kernel
def power_series_of(f0: float, f1: float, f2: float) -> tuple[float, float, float]:
    """Return the power series of the quadratic through a step's forces, in times of the step."""
    return (
        _C[0][0] * f0 + _C[0][1] * f1 + _C[0][2] * f2,
        _C[1][0] * f0 + _C[1][1] * f1 + _C[1][2] * f2,
        _C[2][0] * f0 + _C[2][1] * f1 + _C[2][2] * f2,
    )


@kernel
def end_of(f: View[float]) -> float:
    """Evaluate the quadratic through the nodes' values at the step's end."""
    return LAST[0] * f[0] + LAST[1] * f[1] + LAST[2] * f[2]


@kernel
def discrete_gradient(
    x: float, free: float, give: float, h: float, k: float, mu: float, a: float
) -> tuple[float, float]:
    """Return the change of x over a step of h seconds, and the force that is held for it.

    Without the force x would change by `free` (m); a held one takes off `give` (m/N) > 0. The change that the law
    allows is the root of an increasing convex function: Newton's method comes down to it from above.
    """
    stored, change = elastic(x, k, a), free
    if x >= 0.0 and free > 0.0:
        # f is at least k x1^a/(a+1) where x1 > x, and takes off no more than `free`.
        change = min(change, max(compression_at((a + 1.0) * free / give, k, a) - x, 0.0))
    for _ in range(_GRADIENT_STEPS):
        # [V(x + change) - V(x)]/change max(0, 1 + mu change/h), and its slope over the change; V(x) is `stored`.
        slack = slack_of(change / h, mu)
        end = x + change
        if slack <= 0.0 or (x <= 0.0 and end <= 0.0):
            f, slope = 0.0, 0.0
        else:
            if min(x, end) > 0.0 and abs(change) < _NEARLY_EQUAL * x:
                # Nearly equal energies would cancel; their difference is the mean of the force.
                mean = slope = 0.0
                for j in range(NODES):
                    force, stiffness, _ = law_with_slopes(x + GAUSS[j] * change, 0.0, (k, 0.0, a))
                    mean += WEIGHTS[j] * force
                    slope += WEIGHTS[j] * GAUSS[j] * stiffness
            else:
                mean = (elastic(end, k, a) - stored) / change
                slope = (spring_of(end, k, a) - mean) / change
            f, slope = mean * slack, slope * slack + mean * mu / h
        residual = change - free + give * f
        step = residual / (1.0 + give * slope)
        if abs(step) <= _ROUNDED * (abs(change) + (abs(free) + give * f) / (1.0 + give * slope)):
            break  # at what rounding makes of it
        change -= step
    return change, max(free - change, 0.0) / give


@kernel
def until_release(
    step: Step, x: float, v: float, h: float, longest: float, closing: bool, tolerance: float
) -> tuple[float, bool]:
    """Return the length of the step, at most `longest`, that ends where x comes to 0; and whether that is being sought.

    x and v (per unit of h) are those at the end of the step as tried. Newton's method from either side.
    """
    if step.x[0] < 0.0:
        return h * GAUSS[0], False
    for i in range(1, NODES):
        if step.x[i] < 0.0:
            share = step.x[i - 1] / (step.x[i - 1] - step.x[i])
            return h * (GAUSS[i - 1] + share * (GAUSS[i] - GAUSS[i - 1])), True
    most = max(step.x[0], step.x[1], step.x[2])
    near = _CLOSED * most
    if x < -max(near, _OPEN * tolerance * most):
        return (h - x / v, True) if v < 0.0 else (h * GAUSS[NODES - 1], False)
    if closing and x > near:
        return (h - x / v, True) if v < 0.0 and h - x / v <= longest else (h, False)
    return h, closing or (x <= 0.0 and v <= 0.0)


@kernel
def better_step(share: float) -> float:
    """Return the factor from a step to the next one to try; share: the longest within the tolerance over this step."""
    return min(max(WITHIN * share, _SHORTEN), LENGTHEN)
