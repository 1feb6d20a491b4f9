"""The sampled methods that the paper compares, on the rigid wall, and its two corrections.

A method is one function of a contact and a step of h seconds that returns x, v and the acceleration after it; a new one
takes a place in METHODS and in `step`. Equations are those of Papetti, Avanzini, Rocchesso 2011 (see contact/law.py).
Verlet and Heun keep the acceleration of their predicted state for the next step, as printed there. Verlet's is taken
with the velocity of the half step: it converges with order 1, and with its order of 2 only without dissipation.

The hybrid correction takes only v from the method and puts x = x(v) by equation (3). The release correction replaces
the velocity at release by the exact root of equation (6), or by the approximation (7) where that errs by less than 0.1
%.
"""

import math

from ..contact.law import paper_release_of, restitution_of, trajectory
from ..native.jit import kernel
from ..native.typed import Record, dtype_of

METHODS = ("am1", "verlet", "heun", "rk4")
"""Names of the methods; their places are their numbers."""

_FROM_STATE = (METHODS.index("am1"), METHODS.index("rk4"))
"""Methods whose acceleration is that of their state; the others keep a predicted one."""

_HYBRID, _RELEASE, _PAPER = 1, 2, 4

CORRECTIONS = {
    "none": 0,
    "hybrid": _HYBRID,
    "release": _RELEASE,
    "both": _HYBRID | _RELEASE,
    "paper-release": _RELEASE | _PAPER,
    "paper-both": _HYBRID | _RELEASE | _PAPER,
}
"""Names of the corrections and their numbers."""

_PAPER_BOUND = (0.798, 8.05)  # mu v_in between which the paper's release velocity errs by more than 0.1 %
_NEWTON_STEPS = 100
_SOLVED = 1e-14  # relative change of the acceleration that ends Newton's method


State = tuple[float, float, float]
"""Compression (m), its velocity (m/s), and the acceleration (m/s^2) as the method keeps it."""


class Sampled(Record):
    """A contact that is being stepped through."""

    method: int
    correction: int
    x: float  # m
    v: float  # m/s
    acceleration: float  # m/s^2, as the method keeps it
    v_in: float
    v_out: float  # what a release correction puts; NaN: nothing
    v_least: float  # the exact release velocity, below which x(v) ends
    m: float
    k: float
    mu: float
    a: float


SAMPLED = dtype_of(Sampled)


@kernel
def acceleration_of(contact: Sampled, x: float, v: float) -> float:
    """Return -f(x, v)/m in m/s^2: equations (1) and (2)."""
    return -contact.k / contact.m * x**contact.a * (1.0 + contact.mu * v) if x > 0.0 else 0.0


@kernel
def am1(contact: Sampled, h: float) -> State:
    """Step by one-step Adams-Moulton (trapezoid rule), equation (23): safeguarded Newton's method on the new
    acceleration."""
    p = contact.x + h * contact.v + 0.25 * h * h * contact.acceleration
    q = contact.v + 0.5 * h * contact.acceleration
    if p <= 0.0:
        return p, q, 0.0
    # Contact ends the bracket on the left; on the right any acceleration does that the law can't hold against.
    low = -4.0 * p / (h * h)
    high = max(0.0, acceleration_of(contact, p, q))
    for _ in range(_NEWTON_STEPS):
        if _am1_residual(contact, high, p, q, h) >= 0.0:
            break
        high *= 2.0
    new = min(max(contact.acceleration, low), high)
    k, mu, a = contact.k, contact.mu, contact.a
    for _ in range(_NEWTON_STEPS):
        residual = _am1_residual(contact, new, p, q, h)
        if residual > 0.0:
            high = new
        else:
            low = new
        x1 = p + 0.25 * h * h * new
        slope = 1.0
        if x1 > 0.0:
            v1 = q + 0.5 * h * new
            slope += k / contact.m * x1 ** (a - 1.0) * (a * (1.0 + mu * v1) * 0.25 * h * h + x1 * mu * 0.5 * h)
        step = residual / slope
        # Half the bracket where Newton's step leaves it, or has no slope to follow.
        if not low < new - step < high:
            step = new - 0.5 * (low + high)
        new -= step
        if abs(step) <= _SOLVED * abs(new):
            break
    return p + 0.25 * h * h * new, q + 0.5 * h * new, new


@kernel
def _am1_residual(contact: Sampled, new: float, p: float, q: float, h: float) -> float:
    return new - acceleration_of(contact, p + 0.25 * h * h * new, q + 0.5 * h * new)


@kernel
def verlet(contact: Sampled, h: float) -> State:
    """Step by velocity Verlet: equation (24)."""
    x1 = contact.x + h * contact.v + 0.5 * h * h * contact.acceleration
    half = contact.v + 0.5 * h * contact.acceleration
    new = acceleration_of(contact, x1, half)
    return x1, half + 0.5 * h * new, new


@kernel
def heun(contact: Sampled, h: float) -> State:
    """Step by Heun's method: equation (25)."""
    predicted = contact.v + h * contact.acceleration
    x1 = contact.x + 0.5 * h * (contact.v + predicted)
    new = acceleration_of(contact, x1, predicted)
    return x1, contact.v + 0.5 * h * (contact.acceleration + new), new


@kernel
def rk4(contact: Sampled, h: float) -> State:
    """Step by the classic Runge-Kutta method of order 4: equation (26)."""
    x, v, a1 = contact.x, contact.v, contact.acceleration
    v2 = v + 0.5 * h * a1
    a2 = acceleration_of(contact, x + 0.5 * h * v, v2)
    v3 = v + 0.5 * h * a2
    a3 = acceleration_of(contact, x + 0.5 * h * v2, v3)
    v4 = v + h * a3
    a4 = acceleration_of(contact, x + h * v3, v4)
    x1 = x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
    v1 = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return x1, v1, acceleration_of(contact, x1, v1)


@kernel
def step(contact: Sampled, h: float) -> State:
    """Take a step of the contact's method."""
    if contact.method == 0:
        return am1(contact, h)
    if contact.method == 1:
        return verlet(contact, h)
    if contact.method == 2:
        return heun(contact, h)
    return rk4(contact, h)


@kernel
def begin_sampled(
    contact: Sampled, method: int, correction: int, v_in: float, m: float, k: float, mu: float, a: float
) -> None:
    """Begin a contact: x = 0, v = v_in."""
    contact.method = method
    contact.correction = correction
    contact.x = 0.0
    contact.v = v_in
    contact.acceleration = 0.0
    contact.v_in = v_in
    contact.m = m
    contact.k = k
    contact.mu = mu
    contact.a = a
    w = mu * v_in
    contact.v_least = -v_in * restitution_of(w)
    contact.v_out = math.nan
    if correction & _PAPER:
        if w < _PAPER_BOUND[0] or w > _PAPER_BOUND[1]:
            contact.v_out = paper_release_of(v_in, mu)
    elif correction & _RELEASE:
        contact.v_out = contact.v_least


@kernel
def step_sampled(contact: Sampled, h: float) -> bool:
    """Take one step of h seconds, corrections included. True as long as the contact lasts.

    It ends at the first sample with x <= 0, or where the state is not finite; a hybrid one also where v has passed the
    release velocity, as there is no x(v) beyond.
    """
    x, v, acceleration = step(contact, h)
    lasts = x > 0.0 and math.isfinite(v)
    if lasts and contact.correction & _HYBRID and v < contact.v_in:
        lasts = v > contact.v_least
        if lasts:
            x = trajectory(v, contact.v_in, contact.m, contact.k, contact.mu, contact.a)
            if contact.method in _FROM_STATE:
                acceleration = acceleration_of(contact, x, v)
    if not lasts and math.isfinite(v) and not math.isnan(contact.v_out):
        x = 0.0
        v = contact.v_out
    contact.x = x
    contact.v = v
    contact.acceleration = acceleration
    return lasts
