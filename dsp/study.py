"""Numerical experiments on the rigid wall: the sampled methods and the closed form, each against the exact solution.

A law is (v_in, m, k, mu, a). Deviations are the paper's (27), (28): over the samples with x > 0 from the first on,
%dev(x) = 100 max |x_n - x(v_n)|/x_max, %dev(H) = 100 max |H(x_n, v_n) - H(v_n)|/|H_tau - H_0|, and
%err(v_out) = 100 (v - v_out)/v_out with v at the first sample where x <= 0.
"""

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from .contact import length_scale, paper_release_of, potential_at, potential_from_entry, restitution_of
from .jit import kernel
from .methods import CORRECTIONS, METHODS, SAMPLED, follow, start
from .pulse import MOMENTS, PULSE, advance, begin, contact_time, force_pulse

Law = tuple[float, float, float, float, float]

PAPER_CASES: dict[str, Law] = {
    "I": (0.5, 1e-2, 1e3, 0.5, 1.5),
    "1": (0.5, 1e-2, 1e7, 0.01, 1.3),
    "2": (1.0, 1e-2, 1e9, 0.5, 1.5),
}
"""The paper's cases: safe, low dissipation, hard; it samples them at 44.1 kHz."""

PAPER_RATE = 44_100.0

MOST_STEPS = 100_000
"""A contact is given up after this many steps, or ten times its exact duration and twenty steps."""


class Outcome(IntEnum):
    """What became of a contact; all but the first are failures."""

    SOUND = 0
    NOT_FINITE = 1
    STICKS = 2  # no release within ten times the exact duration, and some steps
    MISSED = 3  # it goes on into the wall
    FASTER = 4  # it leaves faster than it came
    GAINS = 5  # its energy rises by more than a thousandth on the way


@dataclass(frozen=True)
class Deviations:
    """What a method makes of one contact: %err(v_out), %dev(x), %dev(H), steps taken, outcome."""

    err_v_out: float
    dev_x: float
    dev_H: float
    steps: int
    outcome: Outcome


@kernel
def _run(contact, method, correction, v_in, m, k, mu, a, h, most, x, v):
    """Step through a contact, keeping x and v where there is room; returns the steps taken."""
    start(contact, method, correction, v_in, m, k, mu, a)
    n = 0
    lasts = True
    while lasts and n < most:
        lasts = follow(contact, h)
        n += 1
        if n < len(x):
            x[n] = contact.x
            v[n] = contact.v
    return n


@kernel
def _deviate(contact, method, correction, v_in, m, k, mu, a, h, most):
    """(final v, %dev(x), %dev(H), steps, outcome)."""
    w = mu * v_in
    length = length_scale(v_in, m, k, a)
    x_max = length * ((a + 1.0) * potential_at(0.0, w)) ** (1.0 / (a + 1.0))
    h_in = 0.5 * m * v_in * v_in
    dev_x = dev_h = highest = 0.0
    start(contact, method, correction, v_in, m, k, mu, a)
    n = 0
    lasts = True
    while lasts and n < most:
        lasts = follow(contact, h)
        n += 1
        x = contact.x
        v = contact.v
        if lasts:
            u = v / v_in
            energy = 0.5 * m * v * v + k * x ** (a + 1.0) / (a + 1.0)
            highest = max(highest, energy)
            # Beyond v_lim = -1/mu there is no trajectory to compare with.
            g = potential_from_entry(u, w) if w * u > -1.0 else 0.0
            dev_x = max(dev_x, abs(x - length * ((a + 1.0) * max(g, 0.0)) ** (1.0 / (a + 1.0))))
            dev_h = max(dev_h, abs(energy - m * v_in * v_in * (0.5 * u * u + g)))
    v = contact.v
    outcome = 0
    if not (math.isfinite(v) and math.isfinite(contact.x)):
        outcome = 1
    elif lasts:
        outcome = 2
    elif v >= 0.0:
        outcome = 3
    elif -v > v_in * (1.0 + 1e-9):
        outcome = 4
    elif highest > h_in * 1.001:
        outcome = 5
    lost = h_in * (1.0 - restitution_of(w) ** 2)
    return v, 100.0 * dev_x / x_max, 100.0 * dev_h / lost if lost > 0.0 else math.nan, n, outcome


@kernel
def _most_steps(v_in, m, k, mu, a, h):
    """Steps after which a contact is given up; the exact duration is estimated from above."""
    w = mu * v_in
    y_max = ((a + 1.0) * potential_at(0.0, w)) ** (1.0 / (a + 1.0))
    duration = length_scale(v_in, m, k, a) / v_in * (3.3 + w * y_max)
    return int(min(10.0 * duration / h + 20.0, MOST_STEPS))


@njit(error_model="numpy")
def _deviations(contact, method, correction, v_in, m, k, mu, a, h):
    most = _most_steps(v_in, m, k, mu, a, h)
    return _deviate(contact, method, correction, v_in, m, k, mu, a, h, most)


@njit(error_model="numpy")
def _trajectory(contact, method, correction, v_in, m, k, mu, a, h, x, v):
    return _run(contact, method, correction, v_in, m, k, mu, a, h, _most_steps(v_in, m, k, mu, a, h), x, v)


@njit(error_model="numpy")
def _outcomes(contact, method, correction, laws, h, out):
    for i in range(len(laws)):
        v_in, m, k, mu, a = laws[i]
        most = _most_steps(v_in, m, k, mu, a, h[i])
        out[i] = _deviate(contact, method, correction, v_in, m, k, mu, a, h[i], most)[4]


@njit(error_model="numpy")
def _closed_outcomes(pulse, laws, h, out):
    """The closed form as the engine uses it: release velocity, duration and every sample's moments."""
    moments = np.zeros(MOMENTS)
    for i in range(len(laws)):
        v_in, m, k, mu, a = laws[i]
        begin(pulse, v_in, m, k, mu, a, 1.0 / h[i])
        e = pulse.restitution
        given = 0.0
        samples = 0
        while pulse.time < pulse.duration and samples < MOST_STEPS:
            advance(pulse, min(pulse.time + 1.0, pulse.duration), pulse.time, moments)
            for n in range(MOMENTS):
                if not math.isfinite(moments[n]):
                    given = math.nan
            given += moments[0]
            samples += 1
        out[i] = 0
        if not (math.isfinite(given) and math.isfinite(pulse.duration) and pulse.duration > 0.0):
            out[i] = 1
        elif samples == MOST_STEPS and pulse.time < pulse.duration:
            out[i] = 2
        elif not abs(given / (m * v_in * (1.0 + e)) - 1.0) < 1e-9:
            out[i] = 3
        elif e > 1.0:
            out[i] = 4


@njit(error_model="numpy")
def _rebounds(contact, method, correction, v_in, m, k, mu, a, h, speeds):
    """Speeds after each of a sequence of contacts, each met with the speed of the last release; returns their number."""
    for i in range(len(speeds)):
        most = _most_steps(v_in, m, k, mu, a, h)
        v, _, _, _, outcome = _deviate(contact, method, correction, v_in, m, k, mu, a, h, most)
        if outcome == 1 or outcome == 2 or outcome == 3:
            return i
        v_in = -v
        speeds[i] = v_in
    return len(speeds)


@njit(error_model="numpy")
def _exact_rebounds(v_in, mu, speeds):
    for i in range(len(speeds)):
        v_in *= restitution_of(mu * v_in)
        speeds[i] = v_in


@njit(error_model="numpy")
def _repeat(contact, method, correction, v_in, m, k, mu, a, h, times, none):
    """Many contacts, for their cost; a method given as a constant is compiled for itself."""
    steps = 0
    most = _most_steps(v_in, m, k, mu, a, h)
    for _ in range(times):
        steps += _run(contact, method, correction, v_in, m, k, mu, a, h, most, none, none)
    return steps


@njit(error_model="numpy")
def _repeat_release(v_in, mu, times):
    total = 0.0
    for i in range(times):
        # A little different each time, or the loop would be taken out.
        total += v_in * restitution_of(mu * v_in * (1.0 + 1e-12 * i))
    return total


@njit(error_model="numpy")
def _repeat_paper_release(v_in, mu, times):
    total = 0.0
    for i in range(times):
        total += paper_release_of(v_in * (1.0 + 1e-12 * i), mu)
    return total


@njit(error_model="numpy")
def _repeat_pulse(pulse, v_in, m, k, mu, a, h, times):
    moments = np.zeros(MOMENTS)
    samples = 0
    for _ in range(times):
        begin(pulse, v_in, m, k, mu, a, 1.0 / h)
        while pulse.time < pulse.duration:
            advance(pulse, min(pulse.time + 1.0, pulse.duration), pulse.time, moments)
            samples += 1
    return samples


def deviations(method: str, correction: str, law: Law, rate: float) -> Deviations:
    """What a method with a correction makes of a law at `rate` Hz."""
    v, dev_x, dev_h, steps, outcome = _deviations(_state(), *_numbers(method, correction), *law, 1 / rate)
    v_in, _, _, mu, _ = law
    exact = -v_in * float(restitution_of(mu * v_in))
    return Deviations(100 * (v - exact) / exact, dev_x, dev_h, steps, Outcome(outcome))


def path(method: str, correction: str, law: Law, rate: float) -> tuple[NDArray, NDArray]:
    """x (m) and v (m/s) at every sample of a contact, from x = 0 to the first with x <= 0."""
    x, v = np.zeros((2, MOST_STEPS))
    v[0] = law[0]
    steps = _trajectory(_state(), *_numbers(method, correction), *law, 1 / rate, x, v)
    return x[: steps + 1].copy(), v[: steps + 1].copy()


def outcomes(method: str, correction: str, laws: ArrayLike, rates: ArrayLike) -> NDArray[np.int64]:
    """Outcome of each contact: laws (n, 5), rates (n,) in Hz; method "closed" is the closed form."""
    laws = np.ascontiguousarray(laws, np.float64)
    h = 1.0 / np.asarray(rates, np.float64)
    out = np.empty(len(laws), np.int64)
    if method == "closed":
        _closed_outcomes(np.zeros(1, PULSE)[0], laws, h, out)
    else:
        _outcomes(_state(), *_numbers(method, correction), laws, h, out)
    return out


def rebounds(method: str, correction: str, law: Law, rate: float, count: int) -> NDArray:
    """Speeds after each of `count` contacts of a sequence; fewer where a contact fails. "exact": the exact ones."""
    speeds = np.empty(count)
    if method == "exact":
        _exact_rebounds(law[0], law[3], speeds)
        return speeds
    return speeds[: _rebounds(_state(), *_numbers(method, correction), *law, 1 / rate, speeds)]


def force_spectrum_error(method: str, correction: str, law: Law, rate: float, top: float = 16_000.0) -> float:
    """Greatest error of a sampled force's spectrum from 0 to `top` Hz, over the exact one's value at 0.

    The force of each step is the momentum lost in it, held for the step.
    """
    v_in, m, _, mu, _ = law
    _, v = path(method, correction, law, rate)
    if not np.isfinite(v).all():
        return math.inf
    frequency = np.linspace(0.0, top, 65)
    h = 1 / rate
    middles = (np.arange(len(v) - 1) + 0.5) * h
    sampled = (m * -np.diff(v)) @ np.exp(-2j * np.pi * np.outer(middles, frequency)) * np.sinc(frequency * h)
    exact = force_spectrum(law, frequency)
    return float(np.abs(sampled - exact).max() / (m * v_in * (1 + float(restitution_of(mu * v_in)))))


def force_spectrum(law: Law, frequency: ArrayLike) -> NDArray[np.complex128]:
    """Fourier transform (N s) of the exact force at frequencies in Hz."""
    duration = contact_time(*law)
    nodes, weights = np.polynomial.legendre.leggauss(2000)
    t = 0.5 * duration * (nodes + 1)
    impulses = 0.5 * duration * weights * force_pulse(t, *law)
    return impulses @ np.exp(-2j * np.pi * np.outer(t, np.asarray(frequency)))


def _numbers(method: str, correction: str) -> tuple[int, int]:
    if method not in METHODS:
        raise ValueError(f"method = {method}: expected one of {', '.join(METHODS)}")
    if correction not in CORRECTIONS:
        raise ValueError(f"correction = {correction}: expected one of {', '.join(CORRECTIONS)}")
    return METHODS.index(method), CORRECTIONS[correction]


def _state() -> np.void:
    return np.zeros(1, SAMPLED)[0]
