"""Coupled contacts by themselves: a striker and modes, sample by sample, through the engine's bank and solver."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .bank import FINE, LANES, RESPONSES, inject_fine, observe, receptance, set_mode, state_of
from .collocation import elastic
from .contact import checked
from .coupled import COUPLED, begin_coupled, respond_with, step_coupled
from .pulse import contact_time

CONVERGED = 1e-7
"""Tolerance of the coupled solver when it is what others are measured against; tests hold it against DOP853."""


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


@njit(error_model="numpy")
def _simulate(contact, striker, frequency, sigma, shape, ringing, rate, tolerance, out):
    n = len(shape) // 4
    y1, y2, a1, a2 = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    response = np.zeros(n // LANES * RESPONSES)
    work = np.zeros(3 * n + FINE * LANES)
    seen, moments = np.zeros(FINE), np.zeros(FINE)
    weights = np.array([0.0, 1.0, 0.0, 0.0])
    for i in range(n):
        set_mode(i, frequency[i], sigma[i], rate, 1.0, y1, y2, a1, a2, response)
        angle = 2.0 * np.pi * frequency[i] / rate
        y1[i] = ringing[i].imag
        y2[i] = (ringing[i].imag * np.cos(angle) - ringing[i].real * np.sin(angle)) * np.exp(sigma[i] / rate)
    v, m, k, mu, a, push, fraction = striker
    begin_coupled(contact, v, m, k, mu, a, push, fraction, rate, tolerance)
    receptance(a1, a2, response, shape, n, 0, weights, work, seen)
    respond_with(contact, seen)
    for t in range(len(out)):
        observe(y1, y2, a1, a2, response, shape, n, 0, weights, work, seen)
        step_coupled(contact, seen, moments)
        inject_fine(y1, y2, response, shape, n, 0, weights, moments)
        velocity = 0.0
        energy = 0.5 * m * contact.v * contact.v - push * contact.position + elastic(contact.motion[0], k, a)
        for i in range(n):
            y = a1[i] * y1[i] + a2[i] * y2[i]
            y2[i] = y1[i]
            y1[i] = y
            if frequency[i] > 0.0:
                re, im = state_of(y1[i], y2[i], a1[i], a2[i])
                damping = sigma[i] / (2.0 * np.pi * frequency[i])
                rate_of_q = re - damping * im
                velocity += shape[n + i] * rate_of_q
                energy += 0.5 * (rate_of_q * rate_of_q + (1.0 + damping * damping) * im * im)
        out[t, 0] = velocity
        out[t, 1] = contact.v
        out[t, 2] = max(contact.motion[0], 0.0)
        out[t, 3] = energy
        out[t, 4] = contact.contacts


def simulate(case: Case, tolerance: float = 1e-5) -> Run:
    """The case by the coupled solver (coupled.py) and the engine's bank of modes."""
    count = len(case.frequency)
    size = -(-max(count, 1) // LANES) * LANES
    modes = np.zeros((2, size))
    modes[:, :count] = case.frequency, case.sigma
    states = np.zeros(size, complex)
    states[:count] = case.ringing
    shape = np.zeros((4, size))
    shape[1, :count] = case.phi
    striker = (case.v_in, case.m, case.k, case.mu, case.a, case.push, case.fraction)
    out = np.empty((case.samples, 5))
    contact = np.zeros(1, COUPLED)[0]
    _simulate(
        contact, tuple(map(float, striker)), modes[0], modes[1], shape.ravel(), states,
        float(case.rate), float(tolerance), out,
    )  # fmt: skip
    return Run(out[:, 0], out[:, 1], out[:, 2], out[:, 3], out[:, 4], int(contact["steps"]), int(contact["held"]))


def random_cases(count: int, seed: int, most_yielding: float = 1.0) -> list[Case]:
    """Contacts as they are heard: 1-40 modes up to 20 kHz, .05-50 samples, mu v_in 0-5, sum r 1e-4-1 of the most."""
    random = np.random.default_rng(seed)
    cases = []
    for _ in range(count):
        n = int(random.integers(1, 41))
        m = 10.0 ** random.uniform(-3.0, -1.0)
        phi = random.normal(size=n)
        phi *= math.sqrt(most_yielding * 10.0 ** random.uniform(-4.0, 0.0) / (m * phi @ phi))
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
