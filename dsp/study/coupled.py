"""Coupled contacts by themselves: a striker and modes, sample by sample, through the engine's bank and solver."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..contact.closed_form import contact_time
from ..contact.collocation import elastic
from ..contact.coupled import COUPLED, begin_coupled, respond_with, step_coupled
from ..native.jit import kernel
from ..numerics.checks import checked
from ..numerics.legendre import FINE
from ..resonator.bank import LANES, RESPONSES, inject_fine, observe, receptance, set_mode, state_of

CONVERGED = 1e-7
"""Tolerance of the coupled solver when it is what others are measured against; tests hold it against DOP853."""

NOT_KEPT = np.empty((0, 5))
"""No place for a run's samples."""


@dataclass(frozen=True)
class Case:
    """A striker that meets modes `fraction` of a sample after the start.

    Modes: frequency (Hz), sigma (1/s), mass-normalised shape phi (kg^-1/2) at the point and state z at the start
    (`ringing`, complex, as bank.py), arrays of one length. The striker: v_in (m/s), m (kg), k (N/m^a), mu (s/m), a,
    constant push (N). ValueError names what is out of range.
    """

    frequency: NDArray
    sigma: NDArray
    phi: NDArray
    v_in: float
    m: float
    k: float
    mu: float
    a: float
    rate: float = 48_000.0
    samples: int = 1000
    push: float = 0.0
    fraction: float = 0.0
    ringing: NDArray | complex = 0.0

    def __post_init__(self) -> None:
        checked("rate", self.rate, 0.0)
        checked("frequency", self.frequency, 0.0, 0.5 * self.rate)
        checked("sigma", self.sigma, 0.0, strict=False)
        checked("phi", self.phi, -math.inf)
        for name in ("m", "k"):
            checked(name, getattr(self, name), 0.0)
        for name, least in (("v_in", 0.0), ("mu", 0.0), ("a", 1.0)):
            checked(name, getattr(self, name), least, strict=False)
        checked("push", self.push, -math.inf)
        checked("fraction", self.fraction, 0.0, 1.0, strict=False)

    @property
    def energy(self) -> float:
        """Striker's and modes' at the start, in J."""
        z = np.broadcast_to(self.ringing, np.shape(self.frequency))
        damping = self.sigma / (2.0 * np.pi * self.frequency)
        modal = (z.real - damping * z.imag) ** 2 + (1.0 + damping**2) * z.imag**2
        return 0.5 * float(self.m * self.v_in**2 + modal.sum())


@dataclass(frozen=True)
class Run:
    """What became of a case, at each sample: velocity of the object's point and of the striker (m/s), compression (m),
    total energy (J), contacts begun so far; and the number of steps, and of those with the force held."""

    velocity: NDArray
    striker: NDArray
    compression: NDArray
    energy: NDArray
    contacts: NDArray
    steps: int = 0
    held: int = 0

    @classmethod
    def of(cls, out: NDArray, steps: int = 0, held: int = 0) -> "Run":
        """From its columns in that order, (samples, 5)."""
        velocity, striker, compression, energy, contacts = out.T
        return cls(velocity, striker, compression, energy, contacts, steps, held)

    def growth(self, case: Case) -> float:
        """The greatest rise of the total energy, over the greatest energy that striker or contact had."""
        energy = np.concatenate([[case.energy], self.energy])
        kinetic = 0.5 * case.m * self.striker**2
        stored = case.k * self.compression ** (case.a + 1.0) / (case.a + 1.0)
        rise = (energy - np.minimum.accumulate(energy)).max() / max(case.energy, kinetic.max(), stored.max())
        return float(rise) if math.isfinite(rise) else math.inf


def error(velocity: NDArray, expected: NDArray) -> float:
    """Greatest difference of velocities over their greatest, in dB."""
    return 20.0 * math.log10(max(np.abs(velocity - expected).max() / np.abs(expected).max(), 1e-20))


class Bank(NamedTuple):
    """Modes as bank.py keeps them, where they start from (2, n), and memory for a contact's work."""

    y1: NDArray
    y2: NDArray
    a1: NDArray
    a2: NDArray
    start: NDArray
    frequency: NDArray
    sigma: NDArray
    response: NDArray
    shape: NDArray
    weights: NDArray
    work: NDArray
    seen: NDArray
    moments: NDArray


def bank_of(case: Case) -> Bank:
    """The case's modes, padded to whole LANES; `shape` has its phi in all four rows."""
    count = len(case.frequency)
    n = -(-max(count, 1) // LANES) * LANES
    y1, y2, a1, a2, frequency, sigma = np.zeros((6, n))
    frequency[:count], sigma[:count] = case.frequency, case.sigma
    response, shape = np.zeros(n // LANES * RESPONSES), np.zeros((4, n))
    shape[:, :count] = case.phi
    for i in range(count):
        set_mode(i, float(frequency[i]), float(sigma[i]), float(case.rate), 1.0, y1, y2, a1, a2, response)
    z = np.zeros(n, complex)
    z[:count] = case.ringing
    angle = 2.0 * np.pi * frequency / case.rate
    start = np.stack([z.imag, (z.imag * np.cos(angle) - z.real * np.sin(angle)) * np.exp(sigma / case.rate)])
    work, weights = np.zeros(3 * n + FINE * LANES), np.array([0.0, 1.0, 0.0, 0.0])
    seen, moments = np.zeros((2, FINE))
    return Bank(y1, y2, a1, a2, start, frequency, sigma, response, shape.ravel(), weights, work, seen, moments)


@kernel
def restart(bank):
    """Bring the modes back to their start."""
    for i in range(len(bank.y1)):
        bank.y1[i] = bank.start[0, i]
        bank.y2[i] = bank.start[1, i]


@kernel
def ring_on(bank):
    """Let the modes ring for a sample."""
    for i in range(len(bank.y1)):
        y = bank.a1[i] * bank.y1[i] + bank.a2[i] * bank.y2[i]
        bank.y2[i] = bank.y1[i]
        bank.y1[i] = y


@kernel
def motion_and_energy(bank):
    """The velocity of the modes' point (m/s), and their energy (J)."""
    velocity = energy = 0.0
    n = len(bank.y1)
    for i in range(n):
        if bank.frequency[i] > 0.0:
            re, im = state_of(bank.y1[i], bank.y2[i], bank.a1[i], bank.a2[i])
            damping = bank.sigma[i] / (2.0 * np.pi * bank.frequency[i])
            rate_of_q = re - damping * im
            velocity += bank.shape[n + i] * rate_of_q
            energy += 0.5 * (rate_of_q * rate_of_q + (1.0 + damping * damping) * im * im)
    return velocity, energy


@njit(error_model="numpy")
def _simulate(contact, bank, striker, rate, tolerance, samples, times, out):
    y1, y2, a1, a2, _, _, _, response, shape, weights, work, seen, moments = bank
    n = len(y1)
    v, m, k, mu, a, push, fraction = striker
    for _ in range(times):
        restart(bank)
        begin_coupled(contact, v, m, k, mu, a, push, fraction, rate, tolerance)
        receptance(a1, a2, response, shape, n, 0, weights, work, seen)
        respond_with(contact, seen)
        for t in range(samples):
            observe(y1, y2, a1, a2, response, shape, n, 0, weights, work, seen)
            step_coupled(contact, seen, moments)
            inject_fine(y1, y2, response, shape, n, 0, weights, moments)
            ring_on(bank)
            if t < len(out):
                velocity, energy = motion_and_energy(bank)
                out[t, 0] = velocity
                out[t, 1] = contact.v
                out[t, 2] = max(contact.motion[0], 0.0)
                energy += 0.5 * m * contact.v * contact.v - push * contact.position
                out[t, 3] = energy + elastic(contact.motion[0], k, a)
                out[t, 4] = contact.contacts


def _simulation(case: Case, tolerance: float, contact: np.void) -> Callable[..., None]:
    law = (case.v_in, case.m, case.k, case.mu, case.a, case.push, case.fraction)
    return partial(_simulate, contact, bank_of(case), tuple(map(float, law)), float(case.rate), float(tolerance))


def simulate(case: Case, tolerance: float = 1e-5) -> Run:
    """The case by the coupled solver (coupled.py) and the engine's bank of modes."""
    contact = np.zeros(1, COUPLED)[0]
    out = np.empty((case.samples, 5))
    _simulation(case, tolerance, contact)(case.samples, 1, out)
    return Run.of(out, int(contact["steps"]), int(contact["held"]))


def simulation_loop(case: Case, samples: int, tolerance: float) -> Callable[[int], None]:
    """What computes so many samples of it, as often as it is told, and keeps nothing: for cost.py."""
    simulation = _simulation(case, tolerance, np.zeros(1, COUPLED)[0])
    return lambda times: simulation(samples, times, NOT_KEPT)


def random_cases(count: int, seed: int, yielding: tuple[float, float] = (1e-4, 1.0)) -> list[Case]:
    """Contacts as they are heard: 1-40 modes up to 20 kHz, .05-50 samples, mu v_in 0-5, sum r within `yielding`."""
    least, most = map(math.log10, yielding)
    random = np.random.default_rng(seed)
    cases = []
    for _ in range(count):
        n = int(random.integers(1, 41))
        m = 10.0 ** random.uniform(-3.0, -1.0)
        phi = random.normal(size=n)
        phi *= math.sqrt(10.0 ** random.uniform(least, most) / (m * phi @ phi))
        mu, a = random.uniform(0.0, 5.0), random.choice([1.0, 1.3, 1.5, 2.5])
        samples = 10.0 ** random.uniform(math.log10(0.05), math.log10(50.0))
        k = (contact_time(1.0, m, 1.0, mu, a) * 48_000.0 / samples) ** (a + 1.0)
        frequency, sigma = np.sort(10.0 ** random.uniform(1.5, 4.3, n)), 10.0 ** random.uniform(0.0, 2.0, n)
        frames, fraction = int(2.0 * samples) + 40, random.uniform()
        cases.append(Case(frequency, sigma, phi, 1.0, m, k, mu, a, samples=frames, fraction=fraction))
    return cases


def extreme_case(random: np.random.Generator) -> Case:
    """A contact from anywhere: 1-256 modes, k to 1e16, mu to 1e3, a 1-4, 8-192 kHz, sum r to 30, pressed or not."""
    n = int(2.0 ** random.uniform(0.0, 8.0))
    rate = random.uniform(8e3, 192e3)
    m = 10.0 ** random.uniform(-5.0, 1.0)
    phi = random.normal(size=n)
    phi *= math.sqrt(10.0 ** random.uniform(-4.0, 1.5) / (m * phi @ phi))
    lossy, damped, pressed, curved = random.uniform(size=4) < (0.8, 0.8, 0.3, 0.8)
    return Case(
        np.sort(np.geomspace(20.0, 0.475 * rate, 4096)[random.integers(0, 4096, n)]),
        10.0 ** random.uniform(-2.0, 3.0, n) * damped, phi, 10.0 ** random.uniform(-3.0, 2.0), m,
        10.0 ** random.uniform(3.0, 16.0), 10.0 ** random.uniform(-4.0, 3.0) * lossy,
        random.uniform(1.0, 4.0) if curved else 1.0, rate, 100, m * 10.0 ** random.uniform(-1.0, 4.0) * pressed,
        random.uniform(),
    )  # fmt: skip
