"""Sampled methods on a coupled contact, and every solver compared on many of them.

The methods are those of methods.py on the whole system of striker and modes, one step or several a sample; they begin
on a sample. Explicit ones are stable while the contact and every mode take several steps, and not beyond.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numba import njit

from .collocation import elastic, law
from .coupled_step import HELD
from .coupled_study import CONVERGED, Case, Run, error, simulate
from .methods import METHODS


@njit(error_model="numpy")
def _accelerate(place, speed, squares, losses, phi, m, k, mu, a):
    """Accelerations of the modes and, last, of the striker."""
    f = law(place[-1] - phi @ place[:-1], speed[-1] - phi @ speed[:-1], k, mu, a)
    out = np.empty_like(place)
    out[:-1] = phi * f - squares * place[:-1] - losses * speed[:-1]
    out[-1] = -f / m
    return out


@njit(error_model="numpy")
def _trapezoid(place, speed, f, h, squares, losses, phi, m, k, mu, a):
    """A step of the trapezoid rule, whose one unknown is the force at its end: Newton's method, safeguarded."""
    c = 0.5 * h
    divisor = 1.0 + c * (losses + c * squares)
    drift = (speed[:-1] * (2.0 - divisor) - h * squares * place[:-1]) / divisor
    answer = c * phi / divisor
    v_free = speed[-1] - c * f / m - phi @ (drift + answer * f)
    x_free = place[-1] - phi @ place[:-1] + c * (speed[-1] - phi @ speed[:-1] + v_free)
    give = c / m + phi @ answer
    low, high = 0.0, law(x_free, v_free, k, mu, a)
    new = min(f, high)
    for _ in range(200):
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
        if abs(step) <= 1e-13 * new:
            break
    after = np.empty_like(speed)
    after[:-1] = drift + answer * (f + new)
    after[-1] = speed[-1] - c * (f + new) / m
    place += c * (speed + after)
    speed[:] = after
    return new


@njit(error_model="numpy")
def _sample(method, substeps, squares, losses, phi, m, k, mu, a, place, speed, h, out):
    n = len(phi)
    kept = _accelerate(place, speed, squares, losses, phi, m, k, mu, a)
    f = 0.0
    contacts = 0
    inside = False
    for t in range(len(out)):
        for _ in range(substeps):
            if method == 0:
                f = _trapezoid(place, speed, f, h, squares, losses, phi, m, k, mu, a)
            elif method == 1:
                place += h * speed + 0.5 * h * h * kept
                half = speed + 0.5 * h * kept
                kept = _accelerate(place, half, squares, losses, phi, m, k, mu, a)
                speed[:] = half + 0.5 * h * kept
            elif method == 2:
                predicted = speed + h * kept
                place += 0.5 * h * (speed + predicted)
                new = _accelerate(place, predicted, squares, losses, phi, m, k, mu, a)
                speed += 0.5 * h * (kept + new)
                kept = new
            else:
                a1 = _accelerate(place, speed, squares, losses, phi, m, k, mu, a)
                v2 = speed + 0.5 * h * a1
                a2 = _accelerate(place + 0.5 * h * speed, v2, squares, losses, phi, m, k, mu, a)
                v3 = speed + 0.5 * h * a2
                a3 = _accelerate(place + 0.5 * h * v2, v3, squares, losses, phi, m, k, mu, a)
                v4 = speed + h * a3
                a4 = _accelerate(place + h * v3, v4, squares, losses, phi, m, k, mu, a)
                place += h / 6.0 * (speed + 2.0 * v2 + 2.0 * v3 + v4)
                speed += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            x = place[n] - phi @ place[:n]
            contacts += x > 0.0 and not inside
            inside = x > 0.0
        out[t, 0] = phi @ speed[:n]
        out[t, 1] = speed[n]
        out[t, 2] = max(x, 0.0)
        modal = np.sum(speed[:n] ** 2 + squares * place[:n] ** 2)
        out[t, 3] = 0.5 * m * speed[n] ** 2 + 0.5 * modal + elastic(x, k, a)
        out[t, 4] = contacts


def sample(case: Case, method: str, oversampling: int = 1) -> Run:
    """The case by a method of methods.METHODS on the whole system; without push, begun on a sample, at rest."""
    omega = 2.0 * np.pi * np.asarray(case.frequency)
    squares = omega**2 + np.asarray(case.sigma) ** 2
    place, speed = np.zeros((2, len(omega) + 1))
    speed[-1] = case.v_in
    out = np.empty((case.samples, 5))
    _sample(
        METHODS.index(method), oversampling, squares, 2.0 * np.asarray(case.sigma), np.asarray(case.phi, np.float64),
        case.m, case.k, case.mu, case.a, place, speed, 1.0 / (case.rate * oversampling), out,
    )  # fmt: skip
    return Run(out[:, 0], out[:, 1], out[:, 2], out[:, 3], out[:, 4], case.samples * oversampling)


@dataclass(frozen=True)
class Score:
    """How a solver does on many cases: median of the object's velocity's errors and what nine of ten are below (dB),
    share of wrong contact counts, worst growth of energy, mean steps."""

    median: float
    ninety: float
    wrong_counts: float
    growth: float
    steps: float


SOLVERS: dict[str, Callable[[Case], Run]] = {
    **{name: partial(sample, method=name) for name in METHODS},
    "rk4, 16 x": partial(sample, method="rk4", oversampling=16),
    "held": partial(simulate, tolerance=HELD),
    **{f"coupled, {tolerance:g}": partial(simulate, tolerance=tolerance) for tolerance in (1e-1, 1e-2, 1e-3, 1e-5)},
}
"""What `compare` compares: sampled methods, the held force, the coupled solver at tolerances."""


def compare(cases: list[Case]) -> dict[str, Score]:
    """Every solver on cases as if begun on a sample, against the coupled solver at CONVERGED."""
    cases = [replace(case, fraction=0.0) for case in cases]
    exact = [simulate(case, CONVERGED) for case in cases]
    return {name: _score(solver, cases, exact) for name, solver in SOLVERS.items()}


def _score(solver: Callable[[Case], Run], cases: list[Case], exact: list[Run]) -> Score:
    rows = []
    with np.errstate(over="ignore", invalid="ignore"):
        for case, truth in zip(cases, exact, strict=True):
            run = solver(case)
            deviation = error(run.velocity, truth.velocity)
            wrong = run.contacts[-1] != truth.contacts[-1]
            rows.append((deviation, wrong, run.growth(case), run.steps))
    deviations, wrong_counts, growth, steps = np.array(rows).T
    deviations[np.isnan(deviations)] = math.inf
    return Score(
        float(np.median(deviations)), float(np.quantile(deviations, 0.9, method="higher")), float(wrong_counts.mean()),
        float(growth.max()), float(steps.mean()),
    )  # fmt: skip
