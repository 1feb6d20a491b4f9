"""A sampled bristle, as it is usually simulated, beside the engine's friction: what it costs, and where it fails.

The bristle is elasto-plastic (Dupont et al., IEEE Trans. Automatic Control 47, 2002): of deflection z,

    z' = w (1 - alpha(z, w) s0 z sign(w)/g(w)),    f = s0 z + s1 z',    g = mu(w) N

with the slip speed w of slide.py's modes, which are exact. It is stepped by Euler's method, on the velocity of the last
sample, or by the trapezoidal rule, with an iteration for each sample.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from time import perf_counter_ns
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from ..friction.law import coefficient
from ..native.jit import kernel
from ..numerics.checks import Array
from .rubbed import extreme_rub
from .slide import BOWED, Rub, rub_cost, rub_modes

METHODS = ("located", "held", "elastic", "explicit bristle", "iterated bristle")
"""Two of a rigid contact, and three of an elastic one."""

STIFFNESS = 1e5
"""N/m: s0, or that of the elastic contact."""

_BREAKS = 0.7  # share of the steady deflection at which a bristle begins to slip
_ITERATIONS = 30
_ADHESIONS = 5
_REFERENCE = 64  # times the rate, for errors
_FAILS = 1e-6  # share of the work that friction may give back


class Bristled(NamedTuple):
    """A bristle's results for a rub: velocity at the samples' ends (m/s), the least loss by friction since the start
    (J), and the greatest work of the driver (J); infinity where it blows up."""

    velocity: Array
    least: float
    driven: float


@kernel
def _adhesion(z: float, w: float, steady: float) -> float:
    """Return alpha, 0 where the bristle only bends and 1 where it slips; steady: g/s0 (m)."""
    size, breaks = abs(z), _BREAKS * steady
    if z * w <= 0.0 or size <= breaks:
        return 0.0
    if size >= steady:
        return 1.0
    return 0.5 + 0.5 * math.sin(math.pi * (size - 0.5 * (steady + breaks)) / (steady - breaks))


@kernel
def _euler(
    z: float, w: float, h: float, load: float, law: tuple[float, float, float], bristle: tuple[float, float]
) -> tuple[float, float]:
    """Return the force now, and the deflection a sample later, by Euler's explicit step."""
    steady = load * coefficient(abs(w), law[0], law[1], law[2])[0] / bristle[0]
    rate = w - _adhesion(z, w, steady) * abs(w) * z / steady if steady > 0.0 else 0.0
    return bristle[0] * z + bristle[1] * rate, z + h * rate


@kernel
def _trapezoid(
    z: float, w: float, h: float, load: float, law: tuple[float, float, float], bristle: tuple[float, float]
) -> tuple[float, float]:
    """Return the mean force over a sample, and the deflection at its end, by the trapezoidal rule; alpha by a fixed
    point."""
    steady = load * coefficient(abs(w), law[0], law[1], law[2])[0] / bristle[0]
    after = z if steady > 0.0 else 0.0
    for _ in range(_ADHESIONS if steady > 0.0 else 0):
        lost = 0.5 * h * _adhesion(0.5 * (z + after), w, steady) * abs(w) / steady
        after = (z * (1.0 - lost) + h * w) / (1.0 + lost)
    return 0.5 * bristle[0] * (z + after) + bristle[1] * (after - z) / h, after


@kernel
def _iterate(
    z: float,
    w: float,
    free: float,
    give: float,
    h: float,
    load: float,
    law: tuple[float, float, float],
    bristle: tuple[float, float],
) -> float:
    """Solve w = free - give f(w) by Newton's method, with a slope by differences, from the last sample's w."""
    for _ in range(_ITERATIONS):
        rest = free - give * _trapezoid(z, w, h, load, law, bristle)[0] - w
        if abs(rest) <= 1e-10 * (abs(free) + abs(w)):
            break
        step = 1e-6 * (abs(w) + 1e-6)
        slope = (free - give * _trapezoid(z, w + step, h, load, law, bristle)[0] - w - step - rest) / step
        w -= rest / slope if slope != 0.0 else 0.0
    return w


@njit(error_model="numpy")
def _run(modes, drive, ways, law, bristle, velocity):
    """Take all samples: the least cumulated loss, and the greatest work."""
    a, turn, answer, mean_turn, mean_answer, c = modes
    speed, normal = drive
    h, iterated = ways
    give = 0.0
    for i in range(len(a)):
        give += (c[i] * mean_answer[i]).real
    z = w = v = lost = least = driven = most = 0.0
    for t in range(len(velocity)):
        load = 0.5 * (normal[t] + normal[t + 1])
        path = 0.5 * (speed[t] + speed[t + 1])
        free = path
        for i in range(len(a)):
            free -= (c[i] * a[i] * mean_turn[i]).real
        if iterated:
            w = _iterate(z, w, free, give, h, load, law, bristle)
            f, after = _trapezoid(z, w, h, load, law, bristle)
        else:
            f, after = _euler(z, speed[t] - v, h, load, law, bristle)
        lost += f * (free - give * f) * h - 0.5 * bristle[0] * (after * after - z * z)
        driven += f * path * h
        least, most = min(least, lost), max(most, abs(driven))
        z, v = after, 0.0
        for i in range(len(a)):
            a[i] = turn[i] * a[i] + answer[i] * f
            v += (c[i] * a[i]).real
        velocity[t] = v
        if not abs(v) < 1e6:
            return -math.inf, math.inf
    return least, most


def rub_bristle(rub: Rub, iterated: bool = False, stiffness: float = STIFFNESS) -> Bristled:
    """Run a rub, from rest, by a sampled bristle of a stiffness s0 (N/m)."""
    h = 1.0 / rub.rate
    omega = 2.0 * np.pi * rub.frequency
    p = -rub.sigma + 1j * omega
    turn = np.exp(p * h)
    mean = (turn - 1.0) / (p * h)
    c = -1j * p * rub.phi / omega
    answer = rub.phi * (turn - 1.0) / p
    modes = (np.zeros(len(p), complex), turn, answer, mean, rub.phi * (mean - 1.0) / p, c)
    velocity = np.full(len(rub.speed) - 1, math.inf)
    bristle = (stiffness, 2.0 * math.sqrt(stiffness * 1e-3))
    drive = np.asarray(rub.speed, float), np.asarray(rub.normal, float)
    return Bristled(velocity, *_run(modes, drive, (h, iterated), rub.law, bristle, velocity))


def bristle_cost(rub: Rub, iterated: bool) -> float:
    """Return the cost in ns a sample, its modes included."""
    shortest = math.inf
    for _ in range(7):
        start = perf_counter_ns()
        rub_bristle(rub, iterated)
        shortest = min(shortest, (perf_counter_ns() - start) / (len(rub.speed) - 1))
    return shortest


def rubbed(seconds: float = 0.1, rate: float = 48_000.0) -> Rub:
    """Return the rub of four modes by a driver at 0.1 m/s with 1 N."""
    samples = round(seconds * rate)
    drive, normal = np.full(samples + 1, 0.1), np.full(samples + 1, 1.0)
    frequency, phi = np.array([220.0, 587.0, 1190.0, 3100.0]), np.array([10.0, -8.0, 9.0, 6.0])
    return Rub(frequency, np.array([3.0, 5.0, 8.0, 20.0]), phi, drive, normal, BOWED, rate)


def _of(method: str, rub: Rub) -> Rub:
    return replace(rub, tangential=STIFFNESS) if method == "elastic" else rub


def velocity_of(method: str, rub: Rub) -> Array:
    """Return the point's velocity (m/s) at the samples' ends by one of METHODS."""
    if method.endswith("bristle"):
        return rub_bristle(rub, method.startswith("iterated")).velocity
    return rub_modes(_of(method, rub), method == "held", audited=False).velocity


def cost_of(method: str, rub: Rub) -> float:
    """Return the method's cost in ns per sample."""
    if method.endswith("bristle"):
        return bristle_cost(rub, method.startswith("iterated"))
    return rub_cost(_of(method, rub), method == "held")


def errors(factors: Sequence[int] = (1, 2, 4, 8)) -> Iterator[dict[str, Any]]:
    """Yield the rms error of the velocity over 0.1 s, over the driver's, and the cost (ns for each sample at 48 kHz),
    by method and factor on the rate. Each is compared with itself at 64 times the rate."""
    for method in METHODS:
        exact = velocity_of(method, rubbed(rate=48_000.0 * _REFERENCE))[_REFERENCE - 1 :: _REFERENCE]
        for factor in factors:
            rub = rubbed(rate=48_000.0 * factor)
            off = velocity_of(method, rub)[factor - 1 :: factor] - exact
            error = float(np.sqrt(np.mean(off**2))) / 0.1
            yield {"method": method, "factor": factor, "error": error, "ns": factor * cost_of(method, rub)}


def finer(rub: Rub, factor: int) -> Rub:
    """Return the same rub at a multiple of the rate."""
    course = np.arange(len(rub.speed))
    times = np.arange((len(rub.speed) - 1) * factor + 1) / factor
    speed, normal = np.interp(times, course, rub.speed), np.interp(times, course, rub.normal)
    return replace(rub, speed=speed, normal=normal, rate=rub.rate * factor, z=0.0)


def gain_of(method: str, rub: Rub, stiffness: float) -> float:
    """Return the most that friction has given back at any time, over the driver's greatest work; infinity if it blows
    up."""
    if method.endswith("bristle"):
        made = rub_bristle(rub, method.startswith("iterated"), stiffness)
        least, driven = made.least, made.driven
    else:
        course = rub_modes(replace(rub, tangential=stiffness * (method == "elastic")), method == "held", audited=False)
        least, driven = min(float(course.lost.min()), 0.0), float(np.abs(course.driven).max())
    if not math.isfinite(least):
        return math.inf
    return max(-least, 0.0) / driven if driven > 0.0 else 0.0


def extremes(count: int, factors: Sequence[int] = (1, 2, 4, 8), seed: int = 18) -> Iterator[dict[str, Any]]:
    """Yield a row for each rub, method and factor on the rate: how much energy friction gives back on random
    extremes."""
    rng = np.random.default_rng(seed)
    for case in range(count):
        rub, stiffness = extreme_rub(rng), float(np.exp(rng.uniform(np.log(1e3), np.log(1e7))))
        for factor in factors:
            same = finer(rub, factor)
            for method in METHODS:
                gain = gain_of(method, same, stiffness)
                fails = int(gain > _FAILS)
                yield {"case": case, "method": method, "factor": factor, "gain": gain, "fails": fails}
