"""The Hunt-Crossley contact law and the rigid wall's closed forms.

A point mass m (kg) meets a wall at v_in (m/s). Its compression x (m) and compression velocity v = dx/dt obey
m dv/dt = -f(x, v), f = k x^a (1 + mu v) for x > 0, with stiffness k (N/m^a), exponent a and dissipation
mu = lambda/k (s/m); equations (1), (2) of Papetti, Avanzini, Rocchesso, "Numerical Methods for a Non-Linear
Impact Model", IEEE Trans. ASLP 2011, to which every number in brackets refers.

All forms are exact and well conditioned for mu = 0, any a >= 1 and any positive m, k and v_in. They work in
w = mu v_in, u = v/v_in and the length L = (m v_in^2/k)^(1/(a+1)).
"""

import math

import numpy as np
from numba import vectorize
from numpy.typing import ArrayLike, NDArray

from ..native.jit import kernel
from ..numerics.checks import checked

# Below this |z| the series of psi is exact to double precision; above it the plain form loses under 2 bits.
_SERIES_BELOW = 1.0
_SERIES_TERMS = 17

# Below this, squares of w underflow, and nothing tells it from 0.
_NO_DISSIPATION = 1e-100

# From here on exp(-(1 + w)) is below half an ulp of 1, so the release velocity is v_lim = -1/mu itself.
_STRONG_DISSIPATION = 40.0


@kernel
def psi(z, log1p_z):
    """(z - ln(1 + z))/z^2 for z > -1, given ln(1 + z); 1/2 at z = 0."""
    if abs(z) > _SERIES_BELOW or z < -0.5:
        return (z - log1p_z) / (z * z)
    # ln(1 + z) = 2 artanh(r): the leading terms cancel by hand, not in floating point.
    r = z / (2.0 + z)
    square = r * r
    fourth = square * square
    # Terms of odd and even n apart: two chains that the processor follows side by side.
    odd = even = 0.0
    for n in range(_SERIES_TERMS, 0, -2):
        odd = odd * fourth + 1.0 / (2 * n + 1)
    for n in range(_SERIES_TERMS - 1, 0, -2):
        even = even * fourth + 1.0 / (2 * n + 1)
    tail = odd + square * even
    return 0.5 * (1.0 - r) - 0.5 * r * (1.0 - r) * (1.0 - r) * tail


@kernel
def restitution_of(w):
    """Restitution E = |v_out/v_in| of w = mu v_in: the root of (6), by Halley's method on a form without
    cancellation."""
    if w < _NO_DISSIPATION:
        return 1.0
    if w >= _STRONG_DISSIPATION:
        return 1.0 / w
    h = w * w * psi(w, math.log1p(w))
    if h > 1.0:
        # q = 1 - mu |v_out| obeys q exp(-q) = exp(-(1 + h)).
        q = math.exp(-(1.0 + h))
        for _ in range(4):
            residual = math.log(q) - q + 1.0 + h
            slope = 1.0 / q - 1.0
            q -= residual * slope / (slope * slope + 0.5 * residual / (q * q))
        return (1.0 - q) / w
    s = math.sqrt(2.0 * h)
    d = s * (1.0 + s * (-1.0 / 3.0 + s * (1.0 / 36.0 + s / 270.0)))
    for _ in range(2):
        residual = d * d * psi(-d, math.log1p(-d)) - h
        slope = d / (1.0 - d)
        curvature = 1.0 / ((1.0 - d) * (1.0 - d))
        d -= residual * slope / (slope * slope - 0.5 * residual * curvature)
    return d / w


@kernel
def potential(distance, log1p_wd, u, w):
    """x^(a+1)/((a+1) L^(a+1)) on the trajectory (3), from the distance d to the contact's nearer end.

    Seen from the beginning d = (1 - u)/(1 + w u). Seen from the release d = (u + E)/(1 + w u), and u and w are given
    with their signs changed. `log1p_wd` is ln(1 + w d).
    """
    return distance * (u + distance * psi(w * distance, log1p_wd))


@kernel
def potential_at(u, w):
    """x^(a+1)/((a+1) L^(a+1)) at the velocity u = v/v_in: equation (3) without its cancellation."""
    p = 1.0 + w * u
    if u < 0.0:
        d = max((u + restitution_of(w)) / p, 0.0)
        # Further away, strong dissipation makes the distance to the release ill-conditioned.
        if w * d <= 0.5:
            return potential(d, math.log1p(-w * d), -u, -w)
    return potential_from_entry(u, w)


@kernel
def potential_from_entry(u, w):
    """The same, negative beyond the release: it is defined for all u > -1/w, but cancels as u nears the release."""
    d = (1.0 - u) / (1.0 + w * u)
    return potential(d, math.log1p(w * d), u, w)


@kernel
def length_scale(v_in, m, k, a):
    """L = (m v_in^2/k)^(1/(a+1)) in m."""
    return (m * v_in * v_in / k) ** (1.0 / (a + 1.0))


@kernel
def paper_release_of(v_in, mu):
    """The paper's approximation of v_out: (7), (8)."""
    if mu == 0.0:
        return -v_in
    w = mu * v_in
    b = 1.0 + w * (1.0 + w * (2.0 / 3.0 + w * (2.0 / 9.0 + w * 14.0 / 135.0)))
    return -(1.0 - b * math.exp(-2.0 * w)) / mu


@kernel
def trajectory(v, v_in, m, k, mu, a):
    """Compression x(v) in m: (3)."""
    g = potential_at(v / v_in, mu * v_in)
    return length_scale(v_in, m, k, a) * ((a + 1.0) * g) ** (1.0 / (a + 1.0))


@vectorize
def _restitution(w):
    return restitution_of(w)


@vectorize
def _paper_release(v_in, mu):
    return paper_release_of(v_in, mu)


@vectorize
def _compression(v, v_in, m, k, mu, a):
    return trajectory(v, v_in, m, k, mu, a)


@vectorize
def _energy(v, v_in, m, mu):
    u = v / v_in
    return m * v_in * v_in * (0.5 * u * u + potential_at(u, mu * v_in))


@vectorize
def _force(x, v, k, mu, a):
    if x <= 0.0:
        return 0.0
    return k * x**a * (1.0 + mu * v)


def restitution(v_in: ArrayLike, mu: ArrayLike) -> NDArray:
    """Coefficient of restitution E = |v_out/v_in|, in [0, 1]: (5) and the exact root of (6).

    v_in (m/s) > 0 and mu (s/m) >= 0 broadcast; relative error under 1e-14. ValueError names what is out of range.
    """
    return _restitution(checked("v_in", v_in, 0.0) * checked("mu", mu, 0.0, strict=False))


def release_velocity(v_in: ArrayLike, mu: ArrayLike) -> NDArray:
    """Velocity at release v_out (m/s, negative): the exact root of (6), through Lambert's W.

    Arguments as in `restitution`.
    """
    return -np.asarray(v_in, np.float64) * restitution(v_in, mu)


def paper_release_velocity(v_in: ArrayLike, mu: ArrayLike) -> NDArray:
    """The paper's approximation of v_out (7), (8), for comparison: off by up to 2.05 % (at mu v_in = 3)."""
    return _paper_release(checked("v_in", v_in, 0.0), checked("mu", mu, 0.0, strict=False))


def force(x: ArrayLike, v: ArrayLike, k: ArrayLike, mu: ArrayLike, a: ArrayLike) -> NDArray:
    """Contact force f(x, v) = k x^a (1 + mu v) in N, 0 where x <= 0: (1).

    x (m), v (m/s), k (N/m^a) > 0, mu (s/m) >= 0, a >= 1 broadcast. ValueError names what is out of range.
    """
    return _force(x, v, *_law(k, mu, a))


def compression(v: ArrayLike, v_in: ArrayLike, m: ArrayLike, k: ArrayLike, mu: ArrayLike, a: ArrayLike) -> NDArray:
    """Compression x(v) in m on the trajectory from v_in: (3), well conditioned also as mu -> 0.

    v (m/s) lies in [v_out, v_in]; m (kg) > 0; the others as in `force`. Near both ends x ~ (v_in - v)^(1/(a+1))
    amplifies an error in v. ValueError names what is out of range.
    """
    v_in = checked("v_in", v_in, 0.0)
    k, mu, a = _law(k, mu, a)
    slowest = release_velocity(v_in, mu)
    v = np.asarray(v, np.float64)
    if not ((v <= v_in) & (v >= slowest * (1 + 1e-12))).all():
        raise ValueError(f"v = {v}: expected velocities between v_out = {slowest} and v_in = {v_in}")
    return _compression(v, v_in, checked("m", m, 0.0), k, mu, a)


def max_compression(v_in: ArrayLike, m: ArrayLike, k: ArrayLike, mu: ArrayLike, a: ArrayLike) -> NDArray:
    """Greatest compression x_max = x(0) in m: (4). Arguments as in `compression`."""
    return compression(0.0, v_in, m, k, mu, a)


def potential_energy(x: ArrayLike, k: ArrayLike, a: ArrayLike) -> NDArray:
    """Elastic energy V = k x^(a+1)/(a+1) in J, 0 where x <= 0: (13)."""
    k, _, a = _law(k, 0.0, a)
    return k * np.maximum(x, 0.0) ** (a + 1.0) / (a + 1.0)


def energy(v: ArrayLike, v_in: ArrayLike, m: ArrayLike, mu: ArrayLike) -> NDArray:
    """Energy H(v) in J, kinetic and elastic, on the trajectory from v_in: (20).

    H falls from m v_in^2/2 to m v_out^2/2 and does not depend on k or a. Arguments as in `compression`.
    """
    return _energy(v, checked("v_in", v_in, 0.0), checked("m", m, 0.0), checked("mu", mu, 0.0, strict=False))


def _law(k: ArrayLike, mu: ArrayLike, a: ArrayLike) -> tuple[NDArray, NDArray, NDArray]:
    return checked("k", k, 0.0), checked("mu", mu, 0.0, strict=False), checked("a", a, 1.0, strict=False)
