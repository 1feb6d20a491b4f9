"""Numerical experiments on the rigid wall: the sampled methods and the closed form, each against the exact solution.

A law is (v_in, m, k, mu, a). Deviations are equations (27) and (28) of Papetti, Avanzini, Rocchesso 2011 (see
contact/law.py): over the samples with x > 0 from the first on, %dev(x) = 100 max |x_n - x(v_n)|/x_max and
%dev(H) = 100 max |H(x_n, v_n) - H(v_n)|/|H_tau - H_0|. The error %err(v_out) = 100 (v - v_out)/v_out takes v at the
first sample where x <= 0.
"""

import math
from dataclasses import dataclass
from decimal import Decimal
from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from ..contact.closed_form import advance_pulse, begin_pulse
from ..contact.law import checked_law, length_scale, longest_time, potential_at, potential_from_entry, restitution_of
from ..contact.pulse_record import PULSE
from ..native.jit import kernel
from ..native.typed import View
from ..numerics.checks import Array, checked
from ..numerics.legendre import MOMENTS
from .reference import release_error, restitution
from .sampled import CORRECTIONS, METHODS, SAMPLED, Sampled, begin_sampled, step_sampled

Law = tuple[float, float, float, float, float]

PAPER_CASES: dict[str, Law] = {
    "I": (0.5, 1e-2, 1e3, 0.5, 1.5),
    "1": (0.5, 1e-2, 1e7, 0.01, 1.3),
    "2": (1.0, 1e-2, 1e9, 0.5, 1.5),
}
"""The cases of Papetti, Avanzini, Rocchesso 2011: safe, low dissipation, hard."""

PAPER_RATE = 44_100.0
"""Hz: the rate at which the paper samples them."""

RANGES = {
    "v_in": (1e-3, 1e2),
    "m": (1e-5, 10.0),
    "k": (1e3, 1e16),
    "mu": (1e-6, 1e3),
    "a": (1.0, 4.0),
    "rate": (8e3, 192e3),
}
"""Ranges in which failures are looked for, in SI units."""

_MU, _A, _LAW = 3, 4, 5
_LOSSLESS = 0.1  # share of scattered laws without dissipation

_GAIN = 1e-3  # share of its energy that a contact may gain and be called sound
_MOMENTUM_ERROR = 1e-9  # share of its momentum that the closed form's moments may miss and be called sound

MOST_STEPS = 100_000_000
"""A contact is given up after this many steps, or ten times its exact duration and twenty steps."""


class Outcome(IntEnum):
    """Outcome of a contact; all but SOUND are failures."""

    SOUND = 0
    NOT_FINITE = 1
    STICKS = 2  # no release within ten times the exact duration, and some steps
    MISSED = 3  # it goes on into the wall
    FASTER = 4  # it leaves with over a thousandth more energy than it came with
    GAINS = 5  # it had as much more on the way


@dataclass(frozen=True)
class Deviations:
    """Errors of a method on one contact: %err(v_out), %dev(x), %dev(H), the steps taken, the outcome."""

    err_v_out: float
    dev_x: float
    dev_h: float
    steps: int
    outcome: Outcome


@kernel
def run(
    contact: Sampled,
    scheme: tuple[int, int],
    law: tuple[float, float, float, float, float],
    h: float,
    most: int,
    x: View[float],
    v: View[float],
) -> int:
    """Step through a contact of a `law`, keeping x and v where there is room; return the steps taken.

    scheme: a method's and a correction's numbers; h: a step, s; most: the steps after which it is given up.
    """
    begin_sampled(contact, *scheme, *law)
    n = 0
    lasts = True
    while lasts and n < most:
        lasts = step_sampled(contact, h)
        n += 1
        if n < len(x):
            x[n] = contact.x
            v[n] = contact.v
    return n


@kernel
def _deviate(
    contact: Sampled, scheme: tuple[int, int], law: tuple[float, float, float, float, float], h: float, most: int
) -> tuple[float, float, float, int, Outcome]:
    """Return (final v, %dev(x), %dev(H), steps, outcome)."""
    v_in, m, k, mu, a = law
    w = mu * v_in
    length = length_scale(v_in, m, k, a)
    x_max = length * ((a + 1.0) * potential_at(0.0, w)) ** (1.0 / (a + 1.0))
    h_in = 0.5 * m * v_in * v_in
    dev_x = dev_h = highest = 0.0
    begin_sampled(contact, *scheme, *law)
    n = 0
    lasts = True
    while lasts and n < most:
        lasts = step_sampled(contact, h)
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
    lost = h_in * (1.0 - restitution_of(w) ** 2)
    outcome = _judge(contact, lasts, v_in, highest / h_in)
    return contact.v, 100.0 * dev_x / x_max, 100.0 * dev_h / lost if lost > 0.0 else math.nan, n, outcome


@kernel
def _judge(contact: Sampled, lasts: bool, v_in: float, highest: float) -> Outcome:
    """Judge a contact where it was left; `highest`: its greatest energy over the one that it came with."""
    v = contact.v
    if not (math.isfinite(v) and math.isfinite(contact.x)):
        return Outcome.NOT_FINITE
    if lasts:
        return Outcome.STICKS
    if v >= 0.0:
        return Outcome.MISSED
    if -v > v_in * (1.0 + 0.5 * _GAIN):
        return Outcome.FASTER
    if highest > 1.0 + _GAIN:
        return Outcome.GAINS
    return Outcome.SOUND


@kernel
def most_steps(law: tuple[float, float, float, float, float], h: float) -> int:
    """Return steps of h s after which a contact is given up."""
    return int(min(10.0 * longest_time(*law) / h + 20.0, MOST_STEPS))


@njit(error_model="numpy")
def _deviations(contact, scheme, law, h):
    return _deviate(contact, scheme, law, h, most_steps(law, h))


@njit(error_model="numpy")
def _trajectory(contact, scheme, law, h, x, v):
    return run(contact, scheme, law, h, most_steps(law, h), x, v)


@njit(error_model="numpy")
def _outcomes(contact, scheme, laws, h, out, v_out):
    for i in range(len(laws)):
        law = (laws[i, 0], laws[i, 1], laws[i, 2], laws[i, 3], laws[i, 4])
        v_out[i], _, _, _, out[i] = _deviate(contact, scheme, law, h[i], most_steps(law, h[i]))


@njit(error_model="numpy")
def _closed_outcomes(pulse, laws, h, out, v_out):
    """Run the closed form as the engine uses it: release velocity, duration and every sample's moments."""
    moments = np.zeros(MOMENTS)
    for i in range(len(laws)):
        v_in, m, k, mu, a = laws[i]
        begin_pulse(pulse, v_in, m, k, mu, a, 1.0 / h[i])
        e = pulse.restitution
        given = 0.0
        samples = 0
        while pulse.time < pulse.duration and samples < MOST_STEPS:
            advance_pulse(pulse, min(pulse.time + 1.0, pulse.duration), pulse.time, moments)
            for n in range(MOMENTS):
                if not math.isfinite(moments[n]):
                    given = math.nan
            given += moments[0]
            samples += 1
        v_out[i] = -v_in * e
        out[i] = Outcome.SOUND
        if not (math.isfinite(given) and math.isfinite(pulse.duration) and pulse.duration > 0.0):
            out[i] = Outcome.NOT_FINITE
        elif samples == MOST_STEPS and pulse.time < pulse.duration:
            out[i] = Outcome.STICKS
        elif not abs(given / (m * v_in * (1.0 + e)) - 1.0) < _MOMENTUM_ERROR:
            out[i] = Outcome.MISSED
        elif e > 1.0:
            out[i] = Outcome.FASTER


@njit(error_model="numpy")
def _durations(pulse, laws, rates, out):
    for i in range(len(laws)):
        v_in, m, k, mu, a = laws[i]
        begin_pulse(pulse, v_in, m, k, mu, a, rates[i])
        out[i] = pulse.duration


@njit(error_model="numpy")
def _rebounds(contact, scheme, law, h, speeds):
    """Find the speeds after each of a sequence of contacts, met with the speed of the last release; return how many."""
    v_in, m, k, mu, a = law
    for i in range(len(speeds)):
        met = (v_in, m, k, mu, a)
        v, _, _, _, outcome = _deviate(contact, scheme, met, h, most_steps(met, h))
        if outcome in (Outcome.NOT_FINITE, Outcome.STICKS, Outcome.MISSED):
            return i
        v_in = -v
        speeds[i] = v_in
    return len(speeds)


def deviations(method: str, correction: str, law: Law, rate: float) -> Deviations:
    """Return the errors of a method with a correction on a contact of a law, at `rate` Hz.

    ValueError names what is out of range, here and below.
    """
    v, dev_x, dev_h, steps, outcome = _deviations(
        new_contact(), numbers(method, correction), floats(law), _period(rate)
    )
    v_in, _, _, mu, _ = law
    error = 100 * release_error(v, v_in, mu) if math.isfinite(v) else math.nan
    return Deviations(error, dev_x, dev_h, steps, Outcome(outcome))


def path(method: str, correction: str, law: Law, rate: float) -> tuple[Array, Array]:
    """Return x (m) and v (m/s) by a method with a correction, (samples,) each, from x = 0 to the first sample with x <=
    0."""
    x, v = np.zeros((2, most_steps(floats(law), _period(rate)) + 1))
    v[0] = law[0]
    steps = _trajectory(new_contact(), numbers(method, correction), floats(law), _period(rate), x, v)
    return x[: steps + 1].copy(), v[: steps + 1].copy()


def durations(laws: ArrayLike, rates: ArrayLike) -> Array:
    """Return the durations of contacts in samples, (n,), by the engine's closed form; laws (n, 5), rates (n,) in Hz."""
    rows, rate = _checked_rows(laws, rates)
    out = np.empty(len(rows))
    _durations(np.zeros(1, PULSE)[0], rows, rate, out)
    return out


def outcomes(method: str, correction: str, laws: ArrayLike, rates: ArrayLike) -> tuple[NDArray[np.int64], Array]:
    """Return the outcome (an `Outcome`'s number) and final velocity (m/s) of contacts, (n,) each; laws (n, 5), rates
    (n,) in Hz.

    Method "closed" is the closed form as the engine uses it, without a correction.
    """
    rows, rate = _checked_rows(laws, rates)
    out, v_out = np.empty(len(rows), np.int64), np.empty(len(rows))
    if method == "closed":
        _closed_outcomes(np.zeros(1, PULSE)[0], rows, 1.0 / rate, out, v_out)
    else:
        _outcomes(new_contact(), numbers(method, correction), rows, 1.0 / rate, out, v_out)
    return out, v_out


def _checked_rows(laws: ArrayLike, rates: ArrayLike) -> tuple[Array, Array]:
    """Return laws (n, 5) and rates (n,), contiguous."""
    rows = np.ascontiguousarray(laws, np.float64)
    rate = np.ascontiguousarray(checked("rate", rates, 0.0))
    if rows.ndim != 2 or rows.shape[1] != _LAW or rate.shape != rows.shape[:1]:
        raise ValueError(f"laws of shape {rows.shape}, rates of shape {rate.shape}: expected (n, {_LAW}) and (n,)")
    checked_law(*rows.T)
    return rows, rate


def scattered_laws(count: int, seed: int, longest: float = 300.0) -> tuple[Array, Array]:
    """Draw at least `count` random laws (n, 5) and rates (n,) in Hz over RANGES, the same for the same seed.

    They are spread evenly in the logarithm, and evenly in a; a tenth of them has no dissipation; the ranges' corners
    are among them. Contacts that last over `longest` samples are left out.
    """
    draw = np.random.default_rng(seed)
    ends = np.array(list(RANGES.values()))
    parts = [np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(-1, len(ends))]
    kept = 0
    while kept < count:
        points = np.exp(draw.uniform(np.log(ends[:, 0]), np.log(ends[:, 1]), (count, len(ends))))
        points[:, _A] = draw.uniform(ends[_A, 0], ends[_A, 1], count)
        points[draw.random(count) < _LOSSLESS, _MU] = 0.0
        parts.append(points)
        parts = [part[durations(part[:, :5], part[:, 5]) <= longest] for part in parts]
        kept = sum(map(len, parts))
    points = np.concatenate(parts)
    return points[:, :5].copy(), points[:, 5].copy()


def rebounds(method: str, correction: str, law: Law, rate: float, count: int) -> Array:
    """Return the speeds (m/s) after each of `count` contacts in a sequence, by a method; fewer if one has no
    release."""
    speeds = np.empty(count)
    return speeds[: _rebounds(new_contact(), numbers(method, correction), floats(law), _period(rate), speeds)]


def exact_rebounds(law: Law, count: int) -> Array:
    """Return the exact speeds (m/s) after each of `count` contacts in a sequence."""
    v_in, _, _, dissipation, _ = floats(law)
    v, mu = Decimal(v_in), Decimal(dissipation)
    speeds = []
    for _ in range(count):
        v *= restitution(mu * v)
        speeds.append(float(v))
    return np.array(speeds)


def pareto(cost: ArrayLike, error: ArrayLike) -> NDArray[np.bool_]:
    """Return the Pareto front: (n,) bool, True for each point that no other point beats in both cost and error, (n,)
    each."""
    errors = np.asarray(error, np.float64)
    best = np.zeros(len(errors), bool)
    least = math.inf
    for i in np.lexsort((errors, np.asarray(cost, np.float64))):
        if errors[i] < least:
            least = errors[i]
            best[i] = True
    return best


def numbers(method: str, correction: str) -> tuple[int, int]:
    """Return the scheme of a method and a correction: their numbers."""
    if method not in METHODS:
        raise ValueError(f"method = {method}: expected one of {', '.join(METHODS)}")
    if correction not in CORRECTIONS:
        raise ValueError(f"correction = {correction}: expected one of {', '.join(CORRECTIONS)}")
    return METHODS.index(method), CORRECTIONS[correction]


def floats(law: Law) -> Law:
    """Return the law in float64, the type that kernels are compiled for."""
    v_in, m, k, mu, a = map(float, checked_law(*law))
    return v_in, m, k, mu, a


def _period(rate: float) -> float:
    return 1.0 / float(checked("rate", rate, 0.0))


def new_contact() -> np.void:
    """Return the memory for one contact that is stepped through: a SAMPLED record."""
    contact: np.void = np.zeros(1, SAMPLED)[0]
    return contact
