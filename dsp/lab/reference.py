"""References for experiments: the rigid wall's release velocity and force spectrum, by slower and independent means."""

from decimal import Decimal, localcontext

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray

from ..contact.law import potential, restitution_of, time_scale
from ..numerics.checks import Array
from ..numerics.elementwise import elementwise

_DIGITS = 50
_CLOSE = Decimal("1e-20")  # and so the next step below its square

# Panels between 0 and 1: even ones for the waves in a pulse, finer and finer ones towards both ends for the layers that
# strong dissipation has there.
_EDGES = np.union1d(np.linspace(0.0, 1.0, 257)[1:-1], 1.0 / (1.0 + np.exp(-np.linspace(-36.0, 36.0, 145))))
_NODES, _WEIGHTS = legendre.leggauss(20)


def restitution(w: float | Decimal) -> Decimal:
    """Return the coefficient of restitution E of w = mu v_in, to 25 digits for w > 1e-12.

    The root of equation (6) of Papetti, Avanzini, Rocchesso 2011 (see contact/law.py), by Newton's method in decimal
    arithmetic.
    """
    if w == 0:
        return Decimal(1)
    with localcontext() as context:
        context.prec = _DIGITS
        w = Decimal(w)
        if w < Decimal("1e-13"):
            return 1 - 2 * w / 3 + 4 * w * w / 9
        h = w - (1 + w).ln()
        # q = 1 + mu v_out obeys q - ln q = 1 + h. Both starts lie below it, from where Newton's method can't fail.
        q = max((-1 - h).exp(), 1 - (2 * h).sqrt())
        step = Decimal(1)
        while abs(step) > _CLOSE * (1 - q):
            step = (q - q.ln() - 1 - h) * q / (1 - q)
            q += step
        return (1 - q) / w


def release_velocity(v_in: float, mu: float) -> Decimal:
    """Return the velocity at release (m/s, negative), as exact as `restitution`."""
    with localcontext() as context:
        context.prec = _DIGITS
        v = Decimal(v_in)
        return -v * restitution(Decimal(mu) * v)


def release_error(v_out: float, v_in: float, mu: float) -> float:
    """Return the relative error of a release velocity v_out (m/s)."""
    exact = release_velocity(v_in, mu)
    return float((Decimal(v_out) - exact) / exact)


@elementwise
def _potential(distance: float, log1p_wd: float, u: float, w: float) -> float:
    return potential(distance, log1p_wd, u, w)


def _inner_integrals() -> Array:
    """Return the matrix from a function's values at _NODES to its integrals from -1 to each of them."""
    degrees = np.arange(len(_NODES))
    cardinal = (degrees + 0.5)[:, None] * legendre.legvander(_NODES, len(_NODES) - 1).T * _WEIGHTS
    return np.asarray(legendre.legval(_NODES, legendre.legint(cardinal, lbnd=-1)).T, np.float64)


_INNER = _inner_integrals()


def force_spectrum(
    v_in: float, m: float, k: float, mu: float, a: float, frequency: ArrayLike
) -> NDArray[np.complex128]:
    """Return the fourier transform (N s) of the force pulse at frequencies (Hz) of up to 1000 waves in a contact, of
    their shape.

    By 20 Gauss nodes in each of two times 398 panels; within 1e-13 of the momentum.
    """
    w = mu * v_in
    unit = time_scale(v_in, m, k, a)
    compressing = float(np.log1p(w)) / w if w else 1.0
    half = np.diff(_EDGES)[:, None] / 2
    zeta = _EDGES[:-1, None] + half * (1 + _NODES)
    Z = zeta ** (a + 1)
    times, impulses, ends = [], [], []
    # Compression and release, each in the logarithmic velocity from its own end on: see closed_form.py.
    for span, z in ((compressing, w), (1 + restitution_of(w) - compressing, -w)):
        u, distance = (np.expm1(z * span * part) / z if z else span * part for part in (1 - Z, Z))
        slowness = unit * span * (a + 1) * (Z / ((a + 1) * _potential(distance, z * span * Z, u, z))) ** (a / (a + 1))
        panels = (half * slowness) @ _WEIGHTS
        before = np.concatenate([[0.0], np.cumsum(panels)])
        times.append(before[:-1, None] + half * (slowness @ _INNER.T))
        ends.append(before[-1])
        impulses.append(half * _WEIGHTS * m * v_in * (a + 1) * span * np.exp(z * span * (1 - Z)) * Z / zeta)
    times[1] = ends[0] + ends[1] - times[1]
    t, impulse = np.concatenate(times).ravel(), np.concatenate(impulses).ravel()
    return np.asarray(impulse @ np.exp(-2j * np.pi * np.outer(t, np.asarray(frequency))), np.complex128)
