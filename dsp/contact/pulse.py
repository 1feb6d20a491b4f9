"""The force pulse of a contact over time, to double precision: its duration, its values, its quadrature nodes.

The integrals are those of closed_form.py, by the double exponential rule (Takahasi, Mori 1974), whose nodes see the
layers of any width that strong dissipation makes at either end of a phase. Running integrals are sinc quadratures at
the same nodes (Haber 1993).
"""

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from ..native.jit import kernel
from ..numerics.checks import Array, checked, checked_scalar
from ..numerics.elementwise import elementwise
from .closed_form import slowness_at, spans_of, velocity_of
from .law import checked_law, force_scale, potential, restitution, restitution_of, time_scale

_WIDEST = 3.4  # of the variable of the double exponential rule: nodes end 4e-21 from 0 and 1
_COUNT = 141
_PER_HALF_TURN = 16  # nodes of an integral of sin(x)/x: to rounding
_LEAST_Z = 1e-290  # of zeta^(a+1): below, it might underflow
_NEWTON_STEPS = 60
_CLOSE = 1e-14  # relative change of zeta that ends Newton's method
_LEAST_SHARE = 1e-13  # of the momentum: nodes that carry less are left out, whose times rounding may mix up


def _double_exponential() -> tuple[Array, Array]:
    """Return nodes and weights on (0, 1)."""
    t = np.linspace(-_WIDEST, _WIDEST, _COUNT)
    s = np.pi * np.sinh(t)
    nodes = 1.0 / (1.0 + np.exp(-s))
    return nodes, (t[1] - t[0]) * np.pi * np.cosh(t) * nodes / (1.0 + np.exp(s))


_NODES, _WEIGHTS = _double_exponential()


@cache
def _running() -> Array:
    """Return the matrix from integrand times weight to the integral from 0 to each node."""
    nodes, weights = np.polynomial.legendre.leggauss(_PER_HALF_TURN)
    x = np.pi * (np.arange(_COUNT - 1)[:, None] + (nodes + 1.0) / 2.0)
    turns = np.append(0.0, np.cumsum((np.sin(x) / x) @ weights / 2.0))  # Si(k pi)/pi
    steps = np.arange(_COUNT)
    apart = steps[:, None] - steps
    whole: Array = 0.5 + np.sign(apart) * turns[np.abs(apart)]
    return whole


@kernel
def _slowness(zeta: float, span: float, w: float, a: float) -> float:
    return slowness_at(max(zeta ** (a + 1.0), _LEAST_Z), span, w, a)


@kernel
def _time(zeta: float, span: float, w: float, a: float) -> float:
    """Return the time from a phase's contact end to zeta, in L/v_in."""
    total = 0.0
    for j in range(_COUNT):
        total += _WEIGHTS[j] * _slowness(zeta * _NODES[j], span, w, a)
    return zeta * total


@kernel
def _zeta(t: float, whole: float, span: float, w: float, a: float) -> float:
    """Invert `_time` by Newton's method within a bracket; `whole` is the phase's duration."""
    low, high = 0.0, 1.0
    zeta = t / whole
    for _ in range(_NEWTON_STEPS):
        residual = _time(zeta, span, w, a) - t
        if residual > 0.0:
            high = zeta
        else:
            low = zeta
        step = residual / _slowness(zeta, span, w, a)
        if not (low < zeta - step and zeta - step < high):
            step = zeta - 0.5 * (low + high)
        zeta -= step
        if abs(step) <= _CLOSE * zeta:
            break
    return zeta


_node_slowness = elementwise(_slowness)


@elementwise
def _contact_time(v_in: float, m: float, k: float, mu: float, a: float) -> float:
    w = mu * v_in
    compressing, releasing = spans_of(w, restitution_of(w))
    return time_scale(v_in, m, k, a) * (_time(1.0, compressing, w, a) + _time(1.0, releasing, -w, a))


@elementwise
def _force_at(t: float, v_in: float, m: float, k: float, mu: float, a: float) -> float:
    if t <= 0.0:
        return 0.0
    w = mu * v_in
    span, other = spans_of(w, restitution_of(w))
    whole = _time(1.0, span, w, a)
    since = t / time_scale(v_in, m, k, a)
    if since > whole:
        # From here on seen from the release.
        span, w = other, -w
        releasing = _time(1.0, span, w, a)
        since = whole + releasing - since
        whole = releasing
        if since <= 0.0:
            return 0.0
    Z = max(_zeta(since, whole, span, w, a) ** (a + 1.0), _LEAST_Z)
    u = velocity_of(w, span * (1.0 - Z))
    y = ((a + 1.0) * potential(velocity_of(w, span * Z), w * span * Z, u, w)) ** (1.0 / (a + 1.0))
    force: float = force_scale(v_in, m, k, a) * y**a * (1.0 + w * u)
    return force


@elementwise
def _compressing(w: float) -> float:
    return spans_of(w, restitution_of(w))[0]


@elementwise
def _unit(v_in: float, m: float, k: float, a: float) -> float:
    return time_scale(v_in, m, k, a)


def contact_time(v_in: ArrayLike, m: ArrayLike, k: ArrayLike, mu: ArrayLike, a: ArrayLike) -> Array:
    """Return the duration of a contact.

    Parameters
    ----------
    v_in : float or array, m/s
        Speed at which striker and wall meet, above 0.
    m : float or array, kg
        Mass of the striker, above 0.
    k : float or array, N/m^a
        Stiffness, above 0.
    mu : float or array, s/m
        Dissipation, at least 0.
    a : float or array
        Exponent, at least 1.

    Returns
    -------
    array
        float64, s, of the shape to which the arguments broadcast.

    Raises
    ------
    ValueError
        An argument is out of range or not finite; the text names it.

    Notes
    -----
    Equation (9) of Papetti, Avanzini, Rocchesso 2011, in the variable of closed_form.py, within a relative error of
    1e-13 (1e-12 where L/v_in needs logarithms).

    Examples
    --------
    >>> from carom.dsp import contact_time
    >>> f"{contact_time(1.0, 0.01, 1e4, 0.0, 1.0):.4g}"  # pi sqrt(m/k)
    '0.003142'
    """
    return _contact_time(*checked_law(v_in, m, k, mu, a))


def force_pulse(t: ArrayLike, v_in: ArrayLike, m: ArrayLike, k: ArrayLike, mu: ArrayLike, a: ArrayLike) -> Array:
    """Return the force f(t) of a contact, 0 outside of it.

    Parameters
    ----------
    t : float or array, s
        Times since the contact began.
    v_in : float or array, m/s
        Speed at which striker and wall meet, above 0.
    m : float or array, kg
        Mass of the striker, above 0.
    k : float or array, N/m^a
        Stiffness, above 0.
    mu : float or array, s/m
        Dissipation, at least 0.
    a : float or array
        Exponent, at least 1.

    Returns
    -------
    array
        float64, N, of the shape to which the arguments broadcast.

    Raises
    ------
    ValueError
        An argument is out of range or not finite; the text names it.

    Notes
    -----
    Equations (1) and (9) of Papetti, Avanzini, Rocchesso 2011, within 1e-10 of the peak.
    """
    return _force_at(checked("t", t), *checked_law(v_in, m, k, mu, a))


def force_nodes(v_in: float, m: float, k: float, mu: float, a: float) -> tuple[Array, Array]:
    """Return the quadrature nodes of a force pulse.

    Parameters
    ----------
    v_in : float, m/s
        Speed at which striker and wall meet, above 0.
    m : float, kg
        Mass of the striker, above 0.
    k : float, N/m^a
        Stiffness, above 0.
    mu : float, s/m
        Dissipation, at least 0.
    a : float
        Exponent, at least 1.

    Returns
    -------
    times : array (n,)
        float64, s since contact, ascending; some 100 to 250.
    impulses : array (n,)
        float64, N s.

    Raises
    ------
    ValueError
        An argument is out of range or not finite; the text names it.

    Notes
    -----
    The sum of impulses times exp(-s t) is the pulse's Laplace transform, within 3e-10 of m (v_in - v_out) for
    |s| tau <= 40.
    """
    names = ("v_in", "m", "k", "mu", "a")
    law = (checked_scalar(name, value) for name, value in zip(names, (v_in, m, k, mu, a), strict=True))
    v_in, m, k, mu, a = map(float, checked_law(*law))
    w = mu * v_in
    compressing = float(_compressing(w))
    releasing = 1.0 + float(restitution(v_in, mu)) - compressing
    Z = _NODES ** (a + 1.0)
    times, impulses, duration = [], [], 0.0
    for span, sign in ((compressing, 1.0), (releasing, -1.0)):
        durations = _WEIGHTS * _node_slowness(_NODES, span, sign * w, a)
        times.append(_running() @ durations)
        loss = np.exp(sign * w * span * (1.0 - Z))  # 1 + w u
        impulses.append(_WEIGHTS * (a + 1.0) * span * loss * Z / _NODES)
        duration += durations.sum()
    t = np.concatenate([times[0], duration - times[1][::-1]])
    impulse = np.concatenate([impulses[0], impulses[1][::-1]])
    kept = impulse > _LEAST_SHARE * impulse.sum()
    return t[kept] * float(_unit(v_in, m, k, a)), impulse[kept] * m * v_in
