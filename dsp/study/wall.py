"""Numerical experiments on the rigid wall: the sampled methods and the closed form, each against the exact solution.

A law is (v_in, m, k, mu, a). Deviations are the paper's (27), (28): over the samples with x > 0 from the first on,
%dev(x) = 100 max |x_n - x(v_n)|/x_max, %dev(H) = 100 max |H(x_n, v_n) - H(v_n)|/|H_tau - H_0|, and
%err(v_out) = 100 (v - v_out)/v_out with v at the first sample where x <= 0.
"""

import math
from dataclasses import dataclass
from decimal import Decimal
from enum import IntEnum
from functools import cache

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy.special import spherical_jn

from ..contact.closed_form import PULSE, advance, begin
from ..contact.law import length_scale, potential_at, potential_from_entry, restitution_of
from ..contact.sampled import CORRECTIONS, METHODS, SAMPLED, follow, start
from ..native.jit import kernel
from ..numerics.legendre import MOMENTS
from .reference import force_spectrum, release_error, restitution

Law = tuple[float, float, float, float, float]

PAPER_CASES: dict[str, Law] = {
    "I": (0.5, 1e-2, 1e3, 0.5, 1.5),
    "1": (0.5, 1e-2, 1e7, 0.01, 1.3),
    "2": (1.0, 1e-2, 1e9, 0.5, 1.5),
}
"""The paper's cases: safe, low dissipation, hard; it samples them at 44.1 kHz."""

PAPER_RATE = 44_100.0

SPECTRUM_TOP = 16_000.0
"""Up to where the error of a force's spectrum is looked at, in Hz."""

RANGES = {
    "v_in": (1e-3, 1e2),
    "m": (1e-5, 10.0),
    "k": (1e3, 1e16),
    "mu": (1e-6, 1e3),
    "a": (1.0, 4.0),
    "rate": (8e3, 192e3),
}
"""Where failures are looked for, in SI units."""

_MU, _A = 3, 4

_GAIN = 1e-3  # share of its energy that a contact may gain and be called sound

MOST_STEPS = 100_000_000
"""A contact is given up after this many steps, or ten times its exact duration and twenty steps."""


class Outcome(IntEnum):
    """What became of a contact; all but the first are failures."""

    SOUND = 0
    NOT_FINITE = 1
    STICKS = 2  # no release within ten times the exact duration, and some steps
    MISSED = 3  # it goes on into the wall
    FASTER = 4  # it leaves with over a thousandth more energy than it came with
    GAINS = 5  # it has had so on the way


@dataclass(frozen=True)
class Deviations:
    """What a method makes of one contact: %err(v_out), %dev(x), %dev(H), steps taken, outcome."""

    err_v_out: float
    dev_x: float
    dev_h: float
    steps: int
    outcome: Outcome


@kernel
def run(contact, method, correction, v_in, m, k, mu, a, h, most, x, v):
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
    elif -v > v_in * (1.0 + 0.5 * _GAIN):
        outcome = 4
    elif highest > h_in * (1.0 + _GAIN):
        outcome = 5
    lost = h_in * (1.0 - restitution_of(w) ** 2)
    return v, 100.0 * dev_x / x_max, 100.0 * dev_h / lost if lost > 0.0 else math.nan, n, outcome


@kernel
def most_steps(v_in, m, k, mu, a, h):
    """Steps after which a contact is given up; the exact duration is estimated from above."""
    w = mu * v_in
    y_max = ((a + 1.0) * potential_at(0.0, w)) ** (1.0 / (a + 1.0))
    duration = length_scale(v_in, m, k, a) / v_in * (3.3 + w * y_max)
    return int(min(10.0 * duration / h + 20.0, MOST_STEPS))


@njit(error_model="numpy")
def _deviations(contact, method, correction, v_in, m, k, mu, a, h):
    most = most_steps(v_in, m, k, mu, a, h)
    return _deviate(contact, method, correction, v_in, m, k, mu, a, h, most)


@njit(error_model="numpy")
def _trajectory(contact, method, correction, v_in, m, k, mu, a, h, x, v):
    return run(contact, method, correction, v_in, m, k, mu, a, h, most_steps(v_in, m, k, mu, a, h), x, v)


@njit(error_model="numpy")
def _outcomes(contact, method, correction, laws, h, out, v_out):
    for i in range(len(laws)):
        v_in, m, k, mu, a = laws[i]
        most = most_steps(v_in, m, k, mu, a, h[i])
        v_out[i], _, _, _, out[i] = _deviate(contact, method, correction, v_in, m, k, mu, a, h[i], most)


@njit(error_model="numpy")
def _closed_outcomes(pulse, laws, h, out, v_out):
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
        v_out[i] = -v_in * e
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
def _durations(pulse, laws, rates, out):
    for i in range(len(laws)):
        v_in, m, k, mu, a = laws[i]
        begin(pulse, v_in, m, k, mu, a, rates[i])
        out[i] = pulse.duration


@njit(error_model="numpy")
def _moments(pulse, v_in, m, k, mu, a, rate, moments):
    begin(pulse, v_in, m, k, mu, a, rate)
    for i in range(len(moments)):
        advance(pulse, min(i + 1.0, pulse.duration), float(i), moments[i])


@njit(error_model="numpy")
def _rebounds(contact, method, correction, v_in, m, k, mu, a, h, speeds):
    """Speeds after each of a sequence of contacts, met with the speed of the last release; returns how many."""
    for i in range(len(speeds)):
        most = most_steps(v_in, m, k, mu, a, h)
        v, _, _, _, outcome = _deviate(contact, method, correction, v_in, m, k, mu, a, h, most)
        if outcome == 1 or outcome == 2 or outcome == 3:
            return i
        v_in = -v
        speeds[i] = v_in
    return len(speeds)


def deviations(method: str, correction: str, law: Law, rate: float) -> Deviations:
    """What a method with a correction makes of a law at `rate` Hz."""
    v, dev_x, dev_h, steps, outcome = _deviations(sampled(), *numbers(method, correction), *law, 1 / rate)
    v_in, _, _, mu, _ = law
    error = 100 * release_error(v, v_in, mu) if math.isfinite(v) else math.nan
    return Deviations(error, dev_x, dev_h, steps, Outcome(outcome))


def path(method: str, correction: str, law: Law, rate: float) -> tuple[NDArray, NDArray]:
    """x (m) and v (m/s) at every sample of a contact, from x = 0 to the first with x <= 0."""
    x, v = np.zeros((2, most_steps(*law, 1 / rate) + 1))
    v[0] = law[0]
    steps = _trajectory(sampled(), *numbers(method, correction), *law, 1 / rate, x, v)
    return x[: steps + 1].copy(), v[: steps + 1].copy()


def durations(laws: ArrayLike, rates: ArrayLike) -> NDArray[np.float64]:
    """Durations in samples of contacts: laws (n, 5), rates (n,) in Hz."""
    laws = np.ascontiguousarray(laws, np.float64)
    out = np.empty(len(laws))
    _durations(np.zeros(1, PULSE)[0], laws, np.asarray(rates, np.float64), out)
    return out


def outcomes(
    method: str, correction: str, laws: ArrayLike, rates: ArrayLike
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Outcome and final velocity (m/s) of each contact: laws (n, 5), rates (n,) in Hz.

    Method "closed" is the closed form as the engine uses it, without a correction.
    """
    laws = np.ascontiguousarray(laws, np.float64)
    h = 1.0 / np.asarray(rates, np.float64)
    out, v_out = np.empty(len(laws), np.int64), np.empty(len(laws))
    if method == "closed":
        _closed_outcomes(np.zeros(1, PULSE)[0], laws, h, out, v_out)
    else:
        _outcomes(sampled(), *numbers(method, correction), laws, h, out, v_out)
    return out, v_out


def scattered_laws(count: int, seed: int, longest: float = 300.0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Laws (n, 5) and rates (n,) in Hz, at least `count` of them: spread over RANGES, evenly in the logarithm (a:
    evenly), a tenth of them without dissipation, and the ranges' corners. Contacts over `longest` samples are left out.
    """
    draw = np.random.default_rng(seed)
    ends = np.array(list(RANGES.values()))
    parts = [np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(-1, len(ends))]
    kept = 0
    while kept < count:
        points = np.exp(draw.uniform(np.log(ends[:, 0]), np.log(ends[:, 1]), (count, len(ends))))
        points[:, _A] = draw.uniform(ends[_A, 0], ends[_A, 1], count)
        points[draw.random(count) < 0.1, _MU] = 0.0
        parts.append(points)
        parts = [part[durations(part[:, :5], part[:, 5]) <= longest] for part in parts]
        kept = sum(map(len, parts))
    points = np.concatenate(parts)
    return points[:, :5].copy(), points[:, 5].copy()


def rebounds(method: str, correction: str, law: Law, rate: float, count: int) -> NDArray:
    """Speeds after each of `count` contacts of a sequence; fewer where a contact fails."""
    speeds = np.empty(count)
    return speeds[: _rebounds(sampled(), *numbers(method, correction), *law, 1 / rate, speeds)]


def exact_rebounds(law: Law, count: int) -> NDArray:
    """The exact speeds after each of `count` contacts of a sequence."""
    v, mu = Decimal(law[0]), Decimal(law[3])
    speeds = []
    for _ in range(count):
        v *= restitution(mu * v)
        speeds.append(float(v))
    return np.array(speeds)


def spectrum_error(method: str, correction: str, law: Law, rate: float, oversampling: int = 1) -> float:
    """Greatest error in dB of the force's spectrum from 0 to SPECTRUM_TOP, over the exact one's value at 0.

    A sampled method's force is the momentum lost in each step, held for the step; the closed form's ("closed") what the
    engine gives the modes: the Legendre moments of each sample at `rate`. Infinite where a method fails.
    """
    frequency = np.linspace(0.0, SPECTRUM_TOP, 65)
    exact = _exact_spectrum(law, SPECTRUM_TOP, len(frequency))
    if method == "closed":
        found = _closed_spectrum(law, rate, frequency)
    else:
        _, v = path(method, correction, law, rate * oversampling)
        if not np.isfinite(v).all():
            return math.inf
        found = _held_spectrum(law[1] * -np.diff(v), rate * oversampling, frequency)
    return 20 * math.log10(float(np.abs(found - exact).max() / abs(exact[0])))


def _held_spectrum(momenta: NDArray, rate: float, frequency: NDArray) -> NDArray:
    # Waves factor into those at the beginning of a row and those within it.
    size = math.isqrt(len(momenta)) + 1
    rows = np.pad(momenta, (0, -len(momenta) % size)).reshape(-1, size)
    turns = -2j * np.pi * frequency / rate
    within = np.exp(np.outer(np.arange(size) + 0.5, turns))
    beginning = np.exp(np.outer(np.arange(len(rows)) * size, turns))
    return ((rows @ within) * beginning).sum(axis=0) * np.sinc(frequency / rate)


def _closed_spectrum(law: Law, rate: float, frequency: NDArray) -> NDArray:
    moments = np.zeros((math.ceil(durations([law], [rate])[0]), MOMENTS))
    _moments(np.zeros(1, PULSE)[0], *law, rate, moments)
    turns = np.pi * frequency / rate
    orders = np.arange(MOMENTS)[:, None]
    of_moments = (2 * orders + 1) * (-1j) ** orders * spherical_jn(orders, turns)
    waves = np.exp(-1j * np.outer(2 * np.arange(len(moments)) + 1, turns))
    return ((moments @ of_moments) * waves).sum(axis=0)


@cache
def _exact_spectrum(law: Law, top: float, count: int) -> NDArray:
    return force_spectrum(*law, np.linspace(0.0, top, count))


def pareto(cost: ArrayLike, error: ArrayLike) -> NDArray[np.bool_]:
    """Which of some points no other one beats in both cost and error (n,)."""
    cost, error = np.asarray(cost, np.float64), np.asarray(error, np.float64)
    best = np.zeros(len(cost), bool)
    least = math.inf
    for i in np.lexsort((error, cost)):
        if error[i] < least:
            least = error[i]
            best[i] = True
    return best


def numbers(method: str, correction: str) -> tuple[int, int]:
    """A method's and a correction's numbers; ValueError names what there is not."""
    if method not in METHODS:
        raise ValueError(f"method = {method}: expected one of {', '.join(METHODS)}")
    if correction not in CORRECTIONS:
        raise ValueError(f"correction = {correction}: expected one of {', '.join(CORRECTIONS)}")
    return METHODS.index(method), CORRECTIONS[correction]


def sampled() -> np.void:
    """A place for a contact that is stepped through."""
    return np.zeros(1, SAMPLED)[0]
