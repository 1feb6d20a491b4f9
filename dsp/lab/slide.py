"""Friction by itself: a driver that rubs modes, sample by sample, by the engine's bank and solver."""

from dataclasses import dataclass
from time import perf_counter_ns
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from ..friction.elastic import step_elastic, stiffen
from ..friction.located import step_located
from ..friction.record import FRICTION, Friction
from ..friction.stick_slip import begin_friction, respond_along, step_whole
from ..native.jit import kernel
from ..numerics.checks import Array, checked, checked_scalar
from ..numerics.legendre import FINE
from ..resonator.bank import inject_fine, inject_line, ring, state_of
from ..resonator.sizes import ROWS
from ..resonator.velocity import observe_velocity, sense, set_rows, set_shapes, velocity_response
from .coupled import Bank, Case, bank_of, motion_and_energy, restart, ring_on
from .held import step_held

_nodes, _weights = np.polynomial.legendre.leggauss(12)
_NODES, _WEIGHTS = 0.5 * (_nodes + 1.0), 0.5 * _weights

_MOST_TIMES = 65_536

BOWED = (0.8, 0.3, 0.1)
"""mu_s, mu_d and v_s (m/s) of a rosined bow."""


@dataclass(frozen=True)
class Rub:
    """A driver that rubs modes.

    frequency (Hz), sigma (1/s), phi (kg^-1/2): one number for each mode, (n,). speed (m/s) and normal force (N) of the
    driver at the samples' borders: arrays of one more than the samples, the same length. law: mu_s, mu_d, v_s (m/s).
    z: the modes' state at the start as in bank.py, complex, (n,) or one for all. tangential: stiffness of the contact
    along the surface, N/m; 0: it is rigid. ValueError names what is out of range.
    """

    frequency: Array
    sigma: Array
    phi: Array
    speed: Array
    normal: Array
    law: tuple[float, float, float] = BOWED
    rate: float = 48_000.0
    z: NDArray[np.complex128] | complex = 0.0
    tangential: float = 0.0

    def __post_init__(self) -> None:
        checked_scalar("rate", self.rate, 0.0)
        checked("frequency", self.frequency, 0.0, 0.5 * self.rate)
        checked("sigma", self.sigma, 0.0, strict=False)
        checked("normal", self.normal, 0.0, strict=False)
        if self.normal.shape != self.speed.shape or len(self.speed) < 2:
            raise ValueError(f"normal has the shape {self.normal.shape}: expected that of speed, {self.speed.shape}")


@dataclass(frozen=True)
class Course:
    """The course of a rub, float64, (samples,) each.

    velocity of the point at the samples' ends (m/s), force (N, mean over the sample), and in J since the start: the
    driver's work, friction's loss, rise of the modes' energy and of an elastic contact's, loss by the modes' damping.
    before: the modes' energy at the start, J. `branch` at the samples' ends. times (s): of the first 65,536 changes of
    branch. The rest are counts.
    """

    velocity: Array
    force: Array
    driven: Array
    lost: Array
    energy: Array
    stored: Array
    damped: Array
    branch: Array
    before: float
    times: Array
    events: int
    holds: int

    @property
    def balance(self) -> float:
        """Greatest |work - stored - lost| over the greatest of these, and of the energy at the start."""
        went = (self.energy, self.stored, self.lost, self.damped)
        rest = self.driven - sum(went)
        greatest = max(np.abs(each).max() for each in (self.driven, *went))
        return float(np.abs(rest).max() / max(greatest, self.before, 1e-300))


class _Rubbed(NamedTuple):
    """Modes as lab/coupled.py has them, and what friction needs of them."""

    bank: Bank
    rows: Array
    moments: Array
    heard: Array


def _rubbed(rub: Rub) -> _Rubbed:
    bank = bank_of(Case(rub.frequency, rub.sigma, rub.phi, 0.0, 1.0, 1.0, 0.0, 1.0, rub.rate, ringing=rub.z))
    return _Rubbed(bank, np.zeros(ROWS * bank.point.stride), np.zeros((2, FINE)), np.zeros((2, 1)))


@kernel
def _flow(z: complex, s: complex, t: float, start: float, slope: float) -> complex:
    """Return z after t samples: z' = s z + start + slope t. Series of (exp(x) - 1)/x and (exp(x) - 1 - x)/x^2, x = s
    t."""
    x = s * t
    if abs(x) < 1.0:
        first = second = term = 1.0 + 0.0j
        second *= 0.5
        for n in range(2, 20):
            term *= x * (1.0 / n)
            first += term
            second += term * (1.0 / (n + 1))
    else:
        one = x.conjugate() * (1.0 / (x.real * x.real + x.imag * x.imag))
        first = (np.exp(x) - 1.0) * one
        second = (first - 1.0) * one
    return z * (1.0 + x * first) + t * (start * first + slope * t * second)


@kernel
def _damping(bank: Bank, friction: Friction, whole: bool) -> float:
    """Return the loss (J) by the modes' damping over the coming sample, int 2 sigma q'^2 dt, by the exact flow of each
    mode."""
    total = 0.0
    h, modes, n = friction.period, bank.modes, bank.point.stride
    for i in range(n):
        omega = 2.0 * np.pi * bank.frequency[i]
        if omega == 0.0 or bank.sigma[i] == 0.0:
            continue
        re, im = state_of(modes.y1[i], modes.y2[i], modes.a1[i], modes.a2[i])
        z = complex(re, im)
        s = complex(-bank.sigma[i] * h, omega * h)
        lag = bank.sigma[i] / omega
        phi = bank.point.shape[n + i] * h
        for j in range(1 if whole else friction.count):
            eta, start, slope = 1.0, phi * friction.start, phi * friction.slope
            if not whole:
                eta, start, slope = friction.piece[j, 1], phi * friction.piece[j, 2], phi * friction.piece[j, 3]
            for q in range(len(_NODES)):
                there = _flow(z, s, eta * _NODES[q], start, slope)
                velocity = there.real - lag * there.imag
                total += 2.0 * bank.sigma[i] * h * eta * _WEIGHTS[q] * velocity * velocity
            z = _flow(z, s, eta, start, slope)
    return total


@kernel
def _step(friction: Friction, rubbed: _Rubbed, held: bool) -> bool:
    """Solve the coming sample; True if it had no event, else its moments are in rubbed.moments[1]."""
    modes, rows, moments = rubbed.bank.modes, rubbed.rows, rubbed.moments
    stride = len(modes.y1)
    third, end, mean, moment = sense(modes, rows, stride)
    whole = True
    if friction.tangential > 0.0:
        step_elastic(friction, mean)
    elif held:
        friction.slope = 0.0
        step_held(friction, end, mean)
    else:
        whole = step_whole(friction, third, end, mean, moment)
    if not whole:
        observe_velocity(modes, rows, stride, rubbed.bank.work, moments[0])
        step_located(friction, moments[0], moments[1])
    return whole


@kernel
def _give(friction: Friction, rubbed: _Rubbed, whole: bool) -> float:
    """Give the modes the force over the coming sample; its mean (N)."""
    period, bank = friction.period, rubbed.bank
    if whole:
        given = friction.start + 0.5 * friction.slope
        inject_line(bank.modes, bank.point, given * period, friction.slope * period / 6.0)
        return given
    inject_fine(bank.modes, bank.point, rubbed.moments[1])
    impulse: float = rubbed.moments[1, 0]
    return impulse / period


@kernel
def _begin(friction: Friction, rubbed: _Rubbed, tangential: float) -> None:
    begin_friction(friction, 1.0 / friction.period)
    stiffen(friction, tangential)
    bank, rows, n = rubbed.bank, rubbed.rows, rubbed.bank.point.stride
    restart(bank)
    for i in range(n):
        bank.work[i] = 1.0
    set_rows(bank.modes, bank.work, rows, n)
    set_shapes(n, bank.point, 1.0, rows, n)
    velocity_response(bank.modes, rows, n, bank.work, rubbed.moments[0])
    respond_along(friction, rubbed.moments[0])


@njit(error_model="numpy")
def _run(friction, rubbed, speed, normal, ways, out, times):
    """Take all samples; rubs: False for modes that nobody rubs; kept: False for the time that it takes, with nothing
    kept."""
    rubs, held, kept, audited, tangential = ways
    bank = rubbed.bank
    _begin(friction, rubbed, tangential)
    out[-1, 4] = motion_and_energy(bank)[1]
    damped = 0.0
    branch, count = friction.branch, 0
    for t in range(len(speed) - 1):
        friction.drive[0], friction.drive[1] = speed[t], speed[t + 1]
        friction.normal[0], friction.normal[1] = normal[t], normal[t + 1]
        given, whole = 0.0, True
        if rubs:
            whole = _step(friction, rubbed, held)
            damped += _damping(bank, friction, whole) if audited else 0.0
            given = _give(friction, rubbed, whole)
        if not kept:
            ring(bank.modes, rubbed.heard, 0, 1)
            continue
        for n in range(0 if whole else friction.count):
            if friction.piece[n, 4] != branch and count < len(times):
                branch = friction.piece[n, 4]
                times[count] = (t + friction.piece[n, 0]) * friction.period
                count += 1
        ring_on(bank.modes)
        out[t, 0], out[t, 4] = motion_and_energy(bank)
        out[t, 1], out[t, 2], out[t, 3] = given, friction.driven, friction.lost
        out[t, 5], out[t, 6], out[t, 7] = friction.branch, damped, friction.stored
    return count


def rub_cost(rub: Rub, held: bool = False) -> float:
    """Return the cost of friction in ns a sample, events included, without that of the modes' ringing."""
    out, times = np.zeros((1, 8)), np.zeros(1)
    speed, normal = np.asarray(rub.speed, float), np.asarray(rub.normal, float)

    def measured(rubs: bool) -> float:
        shortest = np.inf
        for _ in range(7):
            rubbed, friction = _rubbed(rub), _friction_of(rub)
            start = perf_counter_ns()
            _run(friction, rubbed, speed, normal, (rubs, held, False, False, float(rub.tangential)), out, times)
            shortest = min(shortest, (perf_counter_ns() - start) / (len(speed) - 1))
        return shortest

    return measured(True) - measured(False)


def _friction_of(rub: Rub) -> np.void:
    friction: np.void = np.zeros(1, FRICTION)[0]
    friction["static"], friction["dynamic"], friction["stribeck"] = rub.law
    friction["period"] = 1.0 / rub.rate
    return friction


def rub_modes(rub: Rub, held: bool = False, audited: bool = True) -> Course:
    """Run a rub; `held`: by one force a sample; unless `audited`, without damping's loss."""
    friction = _friction_of(rub)
    out = np.zeros((len(rub.speed), 8))
    times = np.zeros(_MOST_TIMES)
    speed, normal = np.asarray(rub.speed, float), np.asarray(rub.normal, float)
    count = _run(friction, _rubbed(rub), speed, normal, (True, held, True, audited, float(rub.tangential)), out, times)
    before = out[-1, 4]
    velocity, force, driven, lost, energy, branch, damped, stored = out[:-1].T
    counts = int(friction["events"]), int(friction["holds"])
    made = (velocity, force, driven, lost, energy - before, stored, damped, branch)
    return Course(*made, before, times[:count].copy(), *counts)


def constant(value: ArrayLike, samples: int) -> Array:
    """Return a value at the borders of so many samples."""
    return np.full(samples + 1, value, float)
