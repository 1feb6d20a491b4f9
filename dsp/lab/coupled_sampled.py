"""Sampled methods on a coupled contact, for comparison with the coupled solver.

The methods are those of sampled.py on the whole system of striker and modes, in one step or several per sample;
contacts begin on a sample. Explicit methods are stable while the contact and every mode take several steps.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from numba import njit

from ..contact.law import elastic, law
from ..native.jit import simd_kernel
from ..native.typed import View, View2D
from ..numerics.checks import Array
from .coupled import NOT_KEPT, Case, Run
from .sampled import METHODS

_STAGES = np.array([0.0, 0.5, 0.5, 1.0])  # of RK4, in steps
_SHARES = np.array([1.0, 2.0, 2.0, 1.0]) / 6.0

_NEWTON_STEPS = 200
_SOLVED = 1e-13  # relative change of the force that ends Newton's method

_WORK = 8  # rows of memory, each for the modes and, last, the striker


@simd_kernel
def _compression(row: View[float], phi: View[float]) -> float:
    """Return the contact's compression from displacements, or its rate from velocities."""
    n = len(phi)
    give = 0.0
    for i in range(n):
        give += phi[i] * row[i]
    return row[n] - give


@simd_kernel
def _accelerate(
    place: View[float],
    speed: View[float],
    modes: tuple[View[float], View[float], View[float]],
    striker: tuple[float, float, float, float],
    out: View[float],
) -> None:
    """Put the accelerations of the modes and of the striker into `out`."""
    squares, losses, phi = modes
    m, k, mu, a = striker
    n = len(phi)
    f = law(_compression(place, phi), _compression(speed, phi), k, mu, a)
    for i in range(n):
        out[i] = phi[i] * f - squares[i] * place[i] - losses[i] * speed[i]
    out[n] = -f / m


@simd_kernel
def _verlet(
    place: View[float],
    speed: View[float],
    modes: tuple[View[float], View[float], View[float]],
    striker: tuple[float, float, float, float],
    h: float,
    work: View2D[float],
) -> None:
    kept, half = work[0], work[1]
    for i in range(len(place)):
        place[i] += h * speed[i] + 0.5 * h * h * kept[i]
        half[i] = speed[i] + 0.5 * h * kept[i]
    _accelerate(place, half, modes, striker, kept)
    for i in range(len(place)):
        speed[i] = half[i] + 0.5 * h * kept[i]


@simd_kernel
def _heun(
    place: View[float],
    speed: View[float],
    modes: tuple[View[float], View[float], View[float]],
    striker: tuple[float, float, float, float],
    h: float,
    work: View2D[float],
) -> None:
    kept, predicted, new = work[0], work[1], work[2]
    for i in range(len(place)):
        predicted[i] = speed[i] + h * kept[i]
        place[i] += 0.5 * h * (speed[i] + predicted[i])
    _accelerate(place, predicted, modes, striker, new)
    for i in range(len(place)):
        speed[i] += 0.5 * h * (kept[i] + new[i])
        kept[i] = new[i]


@simd_kernel
def _runge_kutta(
    place: View[float],
    speed: View[float],
    modes: tuple[View[float], View[float], View[float]],
    striker: tuple[float, float, float, float],
    h: float,
    work: View2D[float],
) -> None:
    v, at, acceleration, moved, gained = work[1], work[2], work[3], work[4], work[5]
    for i in range(len(place)):
        v[i] = acceleration[i] = moved[i] = gained[i] = 0.0
    for s in range(4):
        for i in range(len(place)):
            at[i] = place[i] + _STAGES[s] * h * v[i]
            v[i] = speed[i] + _STAGES[s] * h * acceleration[i]
            moved[i] += _SHARES[s] * h * v[i]
        _accelerate(at, v, modes, striker, acceleration)
        for i in range(len(place)):
            gained[i] += _SHARES[s] * h * acceleration[i]
    for i in range(len(place)):
        place[i] += moved[i]
        speed[i] += gained[i]


@simd_kernel
def _prepare(modes: tuple[View[float], View[float], View[float]], h: float, work: View2D[float]) -> None:
    """Put the trapezoid rule's coefficients of the modes into `work`: of free motion, and of the answer to a force."""
    squares, losses, phi = modes
    c = 0.5 * h
    for i in range(len(phi)):
        divisor = 1.0 + c * (losses[i] + c * squares[i])
        work[3, i] = (2.0 - divisor) / divisor
        work[4, i] = h * squares[i] / divisor
        work[5, i] = c * phi[i] / divisor


@simd_kernel
def _trapezoid(
    place: View[float],
    speed: View[float],
    f: float,
    modes: tuple[View[float], View[float], View[float]],
    striker: tuple[float, float, float, float],
    h: float,
    work: View2D[float],
) -> float:
    """Take a step of the trapezoid rule; return the force at its end, its one unknown, by safeguarded Newton's
    method."""
    phi = modes[2]
    m, k, mu, a = striker
    after, keeping, pulling, answer = work[1], work[3], work[4], work[5]
    n = len(phi)
    c = 0.5 * h
    give = c / m
    for i in range(n):
        after[i] = keeping[i] * speed[i] - pulling[i] * place[i] + answer[i] * f
        give += phi[i] * answer[i]
    after[n] = speed[n] - c * f / m
    v_free = _compression(after, phi)
    x_free = _compression(place, phi) + c * (_compression(speed, phi) + v_free)
    low, high = 0.0, law(x_free, v_free, k, mu, a)
    new = min(f, high)
    for _ in range(_NEWTON_STEPS):
        x, v = x_free - c * give * new, v_free - give * new
        residual = new - law(x, v, k, mu, a)
        if residual > 0.0:
            high = new
        else:
            low = new
        slope = 1.0
        if x > 0.0 and 1.0 + mu * v > 0.0:
            slope += give * k * x ** (a - 1.0) * (a * c * (1.0 + mu * v) + mu * x)
        step = residual / slope
        if not low < new - step < high:
            step = new - 0.5 * (low + high)
        new -= step
        if abs(step) <= _SOLVED * new:
            break
    for i in range(n):
        after[i] += answer[i] * new
    after[n] -= c * new / m
    for i in range(n + 1):
        place[i] += c * (speed[i] + after[i])
        speed[i] = after[i]
    return new


@njit(error_model="numpy")
def _sample(scheme, modes, striker, v_in, work, samples, times, out):
    method, substeps, h = scheme
    squares, _, phi = modes
    m, k, _, a = striker
    n = len(phi)
    place, speed = work[6], work[7]
    for _ in range(times):
        work[:] = 0.0
        speed[n] = v_in
        _prepare(modes, h, work)
        f = 0.0
        contacts = 0
        inside = False
        for t in range(samples):
            for _ in range(substeps):
                if method == 0:
                    f = _trapezoid(place, speed, f, modes, striker, h, work)
                elif method == 1:
                    _verlet(place, speed, modes, striker, h, work)
                elif method == 2:
                    _heun(place, speed, modes, striker, h, work)
                else:
                    _runge_kutta(place, speed, modes, striker, h, work)
                if t < len(out):
                    touches = _compression(place, phi) > 0.0
                    contacts += touches and not inside
                    inside = touches
            if t < len(out):
                x = _compression(place, phi)
                out[t, 0] = speed[n] - _compression(speed, phi)
                out[t, 1] = speed[n]
                out[t, 2] = max(x, 0.0)
                out[t, 3] = 0.5 * m * speed[n] ** 2 + elastic(x, k, a)
                out[t, 3] += 0.5 * np.sum(speed[:n] ** 2 + squares * place[:n] ** 2)
                out[t, 4] = contacts


def _sampling(case: Case, method: str, oversampling: int) -> Callable[[int, int, Array], None]:
    omega, sigma = 2.0 * np.pi * np.asarray(case.frequency), np.asarray(case.sigma, np.float64)
    modes = (omega**2 + sigma**2, 2.0 * sigma, np.asarray(case.phi, np.float64))
    striker = tuple(map(float, (case.m, case.k, case.mu, case.a)))
    work = np.empty((_WORK, len(omega) + 1))
    h = 1.0 / (case.rate * oversampling)
    return partial(_sample, (METHODS.index(method), oversampling, h), modes, striker, float(case.v_in), work)


def sample(case: Case, method: str, oversampling: int = 1) -> Run:
    """Simulate a case by a method of sampled.py's METHODS, at `oversampling` steps per sample.

    The case's push, fraction and ringing are left out: contacts begin on a sample, with an object at rest.
    """
    out: Array = np.empty((case.samples, 5))
    _sampling(case, method, oversampling)(case.samples, 1, out)
    return Run.of(out, case.samples * oversampling)


def sampling_loop(case: Case, samples: int, method: str, oversampling: int) -> Callable[[int], None]:
    """Return a function that computes so many samples of a case the given number of times and keeps none, for
    `cost_of`."""
    sampling = _sampling(case, method, oversampling)
    return lambda times: sampling(samples, times, NOT_KEPT)
