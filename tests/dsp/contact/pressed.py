"""A mass in contact under a constant force: weight, a hand, or none.

Gauss collocation in steps of its own, which know nothing of samples: one call, one step. So collocation is tested by
itself, and coupled contacts are against walls.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from carom.dsp.contact.collocation import (
    GAUSS,
    INTEGRAL,
    WEIGHTS,
    WITHIN,
    allowance,
    discrete_gradient,
    elastic,
    end_of,
    extrapolate,
    law,
    solve,
    step_within,
    until_release,
)
from carom.dsp.contact.step_record import NODES, STEP
from carom.dsp.native.jit import kernel
from carom.dsp.numerics.checks import checked

_TWICE = INTEGRAL @ INTEGRAL

PRESSED = np.dtype(
    [
        ("step", STEP),
        ("force", np.float64, NODES),  # N, at GAUSS of the last step
        ("x", np.float64),  # compression, m
        ("v", np.float64),  # its rate, m/s
        ("m", np.float64),  # kg
        ("k", np.float64),
        ("mu", np.float64),
        ("a", np.float64),
        ("push", np.float64),  # constant force into the contact, N
        ("tolerance", np.float64),
        ("energy", np.float64),  # J: the least so far, which is not exceeded
        ("next", np.float64),  # s: the step to try
        ("steps", np.int64),
        ("gradients", np.int64),  # steps that had to be held ones
    ],
    align=True,
)
"""A mass in contact under a constant force: m dv/dt = push - f(x, v)."""

EXACT = 1e-5
"""Tolerance of `press` for release velocities and times within 3e-7 of their exact values."""

_TRIALS = 60
_FINEST = 2.0**-20  # of the step tried first: where it comes to this, the force is held
_ROUNDING = 1e-14  # share of the momentum at hand that no force is asked for


@kernel
def begin_pressed(contact, x, v, m, k, mu, a, push, tolerance):
    """Begin with a mass m (kg) under a force of `push` (N), at compression x >= 0 (m) and its rate v (m/s)."""
    contact.m = m
    contact.k = k
    contact.mu = mu
    contact.a = a
    contact.tolerance = tolerance
    contact.steps = 0
    contact.gradients = 0
    place(contact, x, v, push)


@kernel
def place(contact, x, v, push):
    """Put the mass elsewhere, give it another velocity, or push it otherwise."""
    m, k, mu, a = contact.m, contact.k, contact.mu, contact.a
    contact.x = x
    contact.v = v
    contact.push = push
    contact.energy = _energy(contact, x, v)
    for i in range(NODES):
        contact.step.f[i] = law(x, v, k, mu, a)
    # A twentieth of the contact's natural time, or of the time in which strong dissipation slows it.
    speed = _speed(contact, x, v)
    if speed > 0.0:
        time = (m / k / speed ** (a - 1.0)) ** (1.0 / (a + 1.0))
        contact.next = 0.05 * time / max(1.0, mu * speed) ** (1.0 / (a + 1.0))
    else:
        contact.next = 0.05 * (m / k * (m / max(abs(push), 1e-300)) ** (a - 1.0)) ** (0.5 / a)


@kernel
def _speed(contact, x, v):
    """Return the speed that kinetic and elastic energy amount to."""
    return math.sqrt(v * v + 2.0 * elastic(x, contact.k, contact.a) / contact.m)


@kernel
def _energy(contact, x, v):
    return 0.5 * contact.m * v * v + elastic(x, contact.k, contact.a) - contact.push * x


@kernel
def press(contact, longest):
    """Take one step of a pressed contact; return its length in s, at most `longest` > 0.

    The force over it is the quadratic through contact.force. When x comes to 0 the step ends there: x is 0 exactly,
    v <= 0, and the mass is free. A step is accepted where |f_end - f(x, v)| h, with f_end the quadratic's value at the
    end, is below tolerance times the momentum at hand, and the energy below the least so far, but for _GROWTH.
    """
    if contact.x <= 0.0 and (contact.v < 0.0 or (contact.v == 0.0 and contact.push <= 0.0)):
        contact.x = 0.0
        return 0.0
    contact.steps += 1
    h = min(contact.next, longest)
    finest = _FINEST * h
    closing = False
    for _ in range(_TRIALS):
        if h < finest:
            break
        solved, x, v = _collocate(contact, h)
        if not solved:
            h *= 0.25
            closing = False
            continue
        whole, closing = until_release(contact.step, x, v, h, longest, closing, contact.tolerance)
        ratio = _ratio(contact, h, x, v)
        if whole != h or ratio < WITHIN:
            # No need to seek a release that is too far away for one step.
            closing = closing and ratio >= WITHIN
            h = whole if ratio >= WITHIN else min(whole, ratio * h)
            continue
        if _sound(contact, x, v):
            if not closing:
                contact.next = max(ratio * h, contact.next if h == longest else 0.0)
            for i in range(NODES):
                contact.force[i] = contact.step.f[i]
            extrapolate(contact.step, contact.next / h)
            _move(contact, 0.0 if closing else x, v)
            return h
        h *= 0.5
        closing = False
    return _hold(contact, max(h, finest))


@kernel
def _collocate(contact, h):
    """Try a step: whether it is solved, and x and v at its end."""
    step = contact.step
    push, lightness = contact.push / contact.m, h / contact.m
    for i in range(NODES):
        t = h * GAUSS[i]
        step.free_x[i] = contact.x + t * (contact.v + 0.5 * t * push)
        step.free_v[i] = contact.v + t * push
        for j in range(NODES):
            step.give_v[i, j] = lightness * INTEGRAL[i, j]
            step.give_x[i, j] = h * lightness * _TWICE[i, j]
    negligible = _ROUNDING * contact.m * _speed(contact, contact.x, contact.v) / h
    solved = solve(step, contact.k, contact.mu, contact.a, negligible)
    v = contact.v + h * push
    x = contact.x + h * (contact.v + 0.5 * h * push)
    for j in range(NODES):
        v -= lightness * WEIGHTS[j] * step.f[j]
        x -= h * lightness * WEIGHTS[j] * (1.0 - GAUSS[j]) * step.f[j]
    return solved, x, v


@kernel
def _ratio(contact, h, x, v):
    """Return the factor by which to change the step to meet the tolerance."""
    speed = max(_speed(contact, x, v), _speed(contact, contact.x, contact.v))
    rest = abs(end_of(contact.step.f) - law(x, v, contact.k, contact.mu, contact.a)) * h
    return step_within(rest, contact.tolerance * contact.m * speed)


@kernel
def _sound(contact, x, v):
    """True if the energy keeps below the least so far, but for what is allowed."""
    before = _energy(contact, contact.x, contact.v)
    after = _energy(contact, x, v)
    push = abs(contact.push)
    scale = max(before + push * contact.x, after + push * x)
    return after - before <= allowance(before - contact.energy, scale)


@kernel
def _hold(contact, h):
    """Take a step with its force held, which can't gain energy; return its length."""
    push = contact.push / contact.m
    free = h * (contact.v + 0.5 * h * push)
    change, force = discrete_gradient(contact.x, free, 0.5 * h * h / contact.m, h, contact.k, contact.mu, contact.a)
    contact.gradients += 1
    contact.next = 2.0 * h
    for i in range(NODES):
        contact.force[i] = contact.step.f[i] = force
    v = contact.v + h * (push - force / contact.m)
    _move(contact, max(contact.x + change, 0.0), v)
    return h


@kernel
def _move(contact, x, v):
    contact.x = x
    contact.v = v
    contact.energy = min(contact.energy, _energy(contact, x, v))


@njit(error_model="numpy")
def _pressed(contact, seconds, path):
    t = 0.0
    path[0, 0], path[0, 1], path[0, 2] = t, contact.x, contact.v
    for n in range(1, len(path)):
        t += press(contact, seconds - t)
        path[n, 0], path[n, 1], path[n, 2] = t, contact.x, contact.v
        if contact.x <= 0.0 or t >= seconds:
            return n + 1
    return len(path)


def pressed(
    v_in: float, m: float, k: float, mu: float, a: float, push: float, seconds: float, tolerance: float = EXACT
) -> NDArray:
    """Return the motion of a mass that meets a wall at v_in under a constant force, until it leaves or for some
    seconds.

    v_in (m/s) >= 0, m (kg), k (N/m^a) > 0, mu (s/m) >= 0, a >= 1, push (N) into the wall. Rows of time (s),
    compression (m) and its rate (m/s), (steps + 1, 3) float64. ValueError names what is out of range.
    """
    law = [
        float(checked(name, value, low, strict=strict))
        for name, value, low, strict in (
            ("v_in", v_in, 0.0, False), ("m", m, 0.0, True), ("k", k, 0.0, True), ("mu", mu, 0.0, False),
            ("a", a, 1.0, False), ("push", push, -np.inf, True),
        )
    ]  # fmt: skip
    seconds, tolerance = float(checked("seconds", seconds, 0.0)), float(checked("tolerance", tolerance, 0.0, 1.0))
    contact = np.zeros(1, PRESSED)[0]
    _begin_pressed(contact, 0.0, *law, tolerance)
    path = np.empty((_MOST_STEPS + 1, 3))
    return path[: _pressed(contact, seconds, path)].copy()


_MOST_STEPS = 1_000_000


@njit(error_model="numpy")
def _begin_pressed(contact, x, v, m, k, mu, a, push, tolerance):
    begin_pressed(contact, x, v, m, k, mu, a, push, tolerance)
