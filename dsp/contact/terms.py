"""The arithmetic of the four Legendre terms of a force and of a rate over a sample (block.py)."""

from typing import TypeAlias

import numpy as np
from numpy.polynomial import legendre

from ..native.jit import kernel, simd_kernel
from ..native.typed import View, View2D
from ..numerics.checks import Array
from ..numerics.settled import same_everywhere
from ..numerics.sums import put_few
from .block_records import POINTS, TERMS, Newton
from .law import law_by_power, raise_all, slack_of

Terms: TypeAlias = tuple[float, float, float, float]
NONE: Terms = (0.0, 0.0, 0.0, 0.0)

NEAR = 2e-3
"""Share of a compression by which it may change between two steps of Newton's method, for the second to be the last."""

_LEAST = 1e-300  # keeps a quotient finite


def _tables() -> tuple[Array, Array, Array]:
    """Return tables for `put_few`, by Gauss's quadrature at POINTS.

    From v_l to the way up to each point and to the rate there; from the law's slopes over compression and over rate at
    each point to K; and from its force there to its terms.
    """
    u, w = legendre.leggauss(POINTS)
    values, order = legendre.legvander(u, TERMS), 2 * np.arange(TERMS) + 1
    ways = np.column_stack([0.5 * (u + 1), 0.5 * (values[:, 2:] - values[:, :-2]) / order[1:]])
    values = values[:, :TERMS]
    shares = order * 0.5 * w[:, None] * values
    slopes = np.array([shares[:, :, None] * each[:, None, :] for each in (ways, values)])
    lines = slopes.reshape(2 * POINTS, 2, POINTS).transpose(1, 0, 2)
    return np.array([ways.T, values.T]), lines, np.pad(shares, ((0, 0), (0, POINTS - TERMS)))


_TO_POINTS, _SLOPES, _SHARES = (
    same_everywhere(name, each.ravel()) for name, each in zip(("TO_POINTS", "SLOPES", "SHARES"), _tables(), strict=True)
)


@simd_kernel
def take(row: View[float]) -> Terms:
    """Return the first four values of an array."""
    return row[0], row[1], row[2], row[3]


@kernel
def put(row: View[float], terms: Terms) -> None:
    """Write terms into an array."""
    row[0], row[1], row[2], row[3] = terms


@simd_kernel
def plus(a: Terms, factor: float, b: Terms) -> Terms:
    """Return a + factor b."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2], a[3] + factor * b[3]


@simd_kernel
def dot(a: Terms, b: Terms) -> float:
    """Return sum a_l b_l."""
    return a[0] * b[0] + a[1] * b[1] + (a[2] * b[2] + a[3] * b[3])


@simd_kernel
def times(m: View2D[float], b: Terms) -> Terms:
    """Return the product of a matrix with terms."""
    return dot(take(m[0]), b), dot(take(m[1]), b), dot(take(m[2]), b), dot(take(m[3]), b)


@simd_kernel
def work_of(force: Terms, rate: Terms) -> float:
    """Return sum f_l v_l/(2 l + 1): the integral of the product."""
    f, v = force, rate
    return f[0] * v[0] + (1.0 / 3.0) * (f[1] * v[1]) + (0.2 * (f[2] * v[2]) + (1.0 / 7.0) * (f[3] * v[3]))


@simd_kernel
def change_of(x: float, rate: Terms, before: Terms, bend: float) -> float:
    """Return how much rates differ from those before, against the compression at both ends of the sample, at the first
    x (m). Up to NEAR, what the law changes by between is a line, but for a share of about NEAR. bend: mu in
    samples/m."""
    moved = abs(rate[0] - before[0]) + abs(rate[1] - before[1]) + (abs(rate[2] - before[2]) + abs(rate[3] - before[3]))
    end = x + rate[0]
    deep = max(min(x, end), NEAR * max(abs(x), abs(end)))
    return moved * (1.0 + bend * deep) / max(deep, _LEAST)


@simd_kernel
def project_law(newton: Newton, x: float, rate: Terms, law: tuple[float, float, float], period: float) -> None:
    """Find the terms (N) of the law's force over a sample, with k, mu and a, from a compression x (m) on at rates v_l
    (m per sample): `found`; and the slopes K of each over all v_l."""
    k, mu, a = law
    mu /= period
    put_few(newton.seen, _TO_POINTS, rate, 2 * POINTS)
    seen = newton.seen
    raise_all(x, seen, a - 1.0, newton.force)
    for q in range(POINTS):
        slack = slack_of(seen[POINTS + q], mu)
        force, stiffness, damping = law_by_power(newton.force[q], max(x + seen[q], 0.0), slack, (k, mu, a))
        newton.stiffness[q] = stiffness
        newton.damping[q] = damping if slack > 0.0 else 0.0
        newton.force[q] = force
    f, s, d = newton.force, newton.stiffness, newton.damping
    put_few(newton.found, _SHARES, (f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7]), POINTS)
    each = s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]
    put_few(newton.slopes, _SLOPES, each, TERMS * TERMS)


@simd_kernel
def solve_terms(newton: Newton, away: Terms, within: View2D[float]) -> Terms:
    """Return the terms (N) of the force where the law is a line about the rates at which it was found: the solution of
    (1 + K W) f = found + K away, with `away` from these to the rates without a force."""
    k, m = newton.slopes, newton.matrix
    k0, k1, k2, k3 = take(k), take(k[4:]), take(k[8:]), take(k[12:])
    put_few(m[0], within, k0, TERMS)
    put_few(m[1], within, k1, TERMS)
    put_few(m[2], within, k2, TERMS)
    put_few(m[3], within, k3, TERMS)
    a, b, c, d = take(m[0]), take(m[1]), take(m[2]), take(m[3])
    a, b = plus(a, 1.0, (1.0, 0.0, 0.0, 0.0)), plus(b, 1.0, (0.0, 1.0, 0.0, 0.0))
    c, d = plus(c, 1.0, (0.0, 0.0, 1.0, 0.0)), plus(d, 1.0, (0.0, 0.0, 0.0, 1.0))
    r0, r1, r2, r3 = plus(take(newton.found), 1.0, (dot(k0, away), dot(k1, away), dot(k2, away), dot(k3, away)))
    # Two by two: [a b] and [c d] are rows of blocks of two columns.
    share = 1.0 / (a[0] * b[1] - a[1] * b[0])
    t0, t1 = share * (c[0] * b[1] - c[1] * b[0]), share * (c[1] * a[0] - c[0] * a[1])
    u0, u1 = share * (d[0] * b[1] - d[1] * b[0]), share * (d[1] * a[0] - d[0] * a[1])
    c, d = plus(plus(c, -t0, a), -t1, b), plus(plus(d, -u0, a), -u1, b)
    r2, r3 = r2 - t0 * r0 - t1 * r1, r3 - u0 * r0 - u1 * r1
    last = 1.0 / (c[2] * d[3] - c[3] * d[2])
    f2, f3 = last * (r2 * d[3] - r3 * c[3]), last * (r3 * c[2] - r2 * d[2])
    r0, r1 = r0 - a[2] * f2 - a[3] * f3, r1 - b[2] * f2 - b[3] * f3
    return share * (r0 * b[1] - r1 * a[1]), share * (r1 * a[0] - r0 * b[0]), f2, f3
