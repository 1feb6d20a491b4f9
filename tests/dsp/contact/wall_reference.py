"""The contact with a rigid wall by means that share nothing with ours: DOP853, and mpmath at many digits."""

from collections.abc import Callable
from itertools import pairwise

import mpmath as mp
import numpy as np
from scipy.integrate import solve_ivp

LAWS = [(a, w) for a in (1.0, 1.3, 1.5, 2.5, 4.0, 6.0) for w in (0.0, 1e-9, 0.1, 1.0, 5.0, 40.0)]
"""Exponents, and mu v_in."""

_ORDER = 24
_DIGITS = 80  # twice what is wanted and more: the printed form of (3) cancels


def solution(
    v_in: float, m: float, k: float, mu: float, a: float, push: float = 0.0, seconds: float = np.inf
) -> tuple[Callable[[np.ndarray], np.ndarray], float]:
    """Return the dense solution (x, v) of the contact by DOP853 in its natural units, and its duration; of one that a
    push (N) brings back, over some seconds."""
    length = (m * v_in**2 / k) ** (1 / (a + 1))
    unit = length / v_in
    w, p = mu * v_in, push * unit / (m * v_in)

    def motion(t, y):
        return [y[1], p - max(y[0], 0.0) ** a * max(0.0, 1 + w * y[1])]

    def released(t, y):
        return y[0] if t > 1e-3 else 1.0

    released.terminal, released.direction = push == 0.0, -1
    span = 0, min(seconds / unit, 1e4)
    run = solve_ivp(
        motion, span, (0, 1), "DOP853", events=released, rtol=1e-13, atol=1e-15, dense_output=True, first_step=1e-4
    )
    end = run.t[-1]
    return (lambda t: run.sol(np.minimum(t / unit, end)) * np.array([length, v_in])[:, None]), end * unit


def restitution(w: float) -> mp.mpf:
    """Return E of w = mu v_in by Lambert's W."""
    w = mp.mpf(w)
    return mp.mpf(1) if w == 0 else (1 + mp.lambertw(-(1 + w) * mp.exp(-(1 + w))).real) / w


def duration(v_in: float, m: float, k: float, mu: float, a: float) -> mp.mpf:
    """Return the contact time in s: the integral of dv/(f/m) over v, by panels that get finer towards both ends of each
    phase.

    Each phase runs in z, with U = ln(1 + w u)/w = U_end (1 - z^(a+1)) in it, so that the integrand is smooth.
    """
    with mp.workdps(_DIGITS):
        v_in, m, k, mu, a = map(mp.mpf, (v_in, m, k, mu, a))
        w = mu * v_in
        e = restitution(w)
        first = mp.log1p(w) / w if w else mp.mpf(1)
        total = sum(
            _integral(lambda z, end=end: _slowness(z, end, first, w, a), _edges(w)) for end in (first, first - 1 - e)
        )
        return (m * v_in**2 / k) ** (1 / (a + 1)) / v_in * total


def _slowness(z: mp.mpf, end: mp.mpf, first: mp.mpf, w: mp.mpf, a: mp.mpf) -> mp.mpf:
    """Return |dt/dz| in L/v_in: dt = -dU/y^a, with y from equation (3) as printed."""
    here = end * (1 - z ** (a + 1))
    u = mp.expm1(w * here) / w if w else here
    g = (w * (1 - u) + w * (here - first)) / w**2 if w else (1 - u**2) / 2
    return abs(end) * (a + 1) * z**a / ((a + 1) * g) ** (a / (a + 1))


def _edges(w: mp.mpf) -> list[mp.mpf]:
    finest = 14 + int(mp.log(1 + w, 2))
    half = mp.mpf(1) / 2
    return [mp.mpf(0), *(half**n for n in range(20, 1, -1)), *(1 - half**n for n in range(1, finest)), mp.mpf(1)]


def _integral(f: Callable[[mp.mpf], mp.mpf], edges: list[mp.mpf]) -> mp.mpf:
    x, weights = np.polynomial.legendre.leggauss(_ORDER)
    total = mp.mpf(0)
    for low, high in pairwise(edges):
        middle, half = (low + high) / 2, (high - low) / 2
        total += half * mp.fsum(mp.mpf(c) * f(middle + half * mp.mpf(t)) for t, c in zip(x, weights, strict=True))
    return total
