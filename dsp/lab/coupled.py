"""Coupled contacts by themselves: a striker and modes, sample by sample, by the engine's bank and solver."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..contact.coupled import ContactLaw, begin_coupled, respond_with
from ..contact.coupled_group import step_together
from ..contact.coupled_records import COUPLED_GROUP, Coupled, CoupledGroup, Member
from ..contact.law import elastic
from ..contact.pulse import contact_time
from ..native.jit import kernel
from ..native.typed import Items, Record, View, dtype_of
from ..numerics.checks import Array, checked, checked_scalar
from ..numerics.legendre import FINE
from ..resonator.bank import MOBILITY, RESPONSES, Modes, Point, inject_fine, observe, receptance, state_of
from ..resonator.coefficients import set_mode
from ..resonator.simd import LANES

CONVERGED = 1e-7
"""Tolerance of the coupled solver as the reference for other solvers; tests compare it with DOP853."""


class Single(Record):
    """A contact as the solver takes it."""

    coupled: Coupled


MEMBER = dtype_of(Single)

NOT_KEPT = np.empty((0, 5))
"""Stands for the samples of a run that keeps none."""


@dataclass(frozen=True)
class Case:
    """A striker that meets modes.

    Parameters
    ----------
    frequency : float64 (n,)
        Frequencies of the modes, Hz.
    sigma : float64 (n,)
        Decay rates, 1/s.
    phi : float64 (n,)
        Mass-normalised shapes at the point, kg^-1/2.
    v_in : float
        Speed of the striker, m/s.
    m : float
        Its mass, kg.
    k : float
        Stiffness, N/m^a.
    mu : float
        Dissipation, s/m.
    a : float
        Exponent.
    rate : float, default 48000
        Sampling rate, Hz.
    samples : int, default 1000
        Number of samples.
    push : float, default 0
        Constant force on the striker, N.
    fraction : float, default 0
        Beginning of the contact, in samples after the start.
    ringing : complex128 (n,) or complex, default 0
        State of the modes at the start, as z in bank.py.

    Raises
    ------
    ValueError
        An argument is out of range; the text names it.
    """

    frequency: Array
    sigma: Array
    phi: Array
    v_in: float
    m: float
    k: float
    mu: float
    a: float
    rate: float = 48_000.0
    samples: int = 1000
    push: float = 0.0
    fraction: float = 0.0
    ringing: NDArray[np.complex128] | complex = 0.0

    def __post_init__(self) -> None:
        checked_scalar("rate", self.rate, 0.0)
        modes = {
            "frequency": checked("frequency", self.frequency, 0.0, 0.5 * self.rate),
            "sigma": checked("sigma", self.sigma, 0.0, strict=False),
            "phi": checked("phi", self.phi),
        }
        for name, values in modes.items():
            if values.shape != (len(self.frequency),):
                raise ValueError(f"{name} has the shape {values.shape}: expected one number for each frequency")
            object.__setattr__(self, name, values)
        for name in ("m", "k"):
            checked_scalar(name, getattr(self, name), 0.0)
        for name, least in (("v_in", 0.0), ("mu", 0.0), ("a", 1.0)):
            checked_scalar(name, getattr(self, name), least, strict=False)
        checked_scalar("push", self.push)
        checked_scalar("samples", self.samples, 0.0, strict=False)
        checked_scalar("fraction", self.fraction, 0.0, 1.0, strict=False)

    @property
    def energy(self) -> float:
        """Energy of striker and modes at the start, in J."""
        z = np.broadcast_to(self.ringing, np.shape(self.frequency))
        damping = self.sigma / (2.0 * np.pi * self.frequency)
        modal = (z.real - damping * z.imag) ** 2 + (1.0 + damping**2) * z.imag**2
        return 0.5 * float(self.m * self.v_in**2 + modal.sum())


@dataclass(frozen=True)
class Run:
    """The course of a case, (samples,) each, float64.

    velocity of the object's point and of the striker (m/s), compression (m), total energy (J), contacts begun so far;
    and the numbers of the solver's steps, and of those that held the force.
    """

    velocity: Array
    striker: Array
    compression: Array
    energy: Array
    contacts: Array
    steps: int = 0
    held: int = 0

    @classmethod
    def of(cls, out: Array, steps: int = 0, held: int = 0) -> "Run":
        """Return a run from its columns in the order of the fields, (samples, 5)."""
        velocity, striker, compression, energy, contacts = out.T
        return cls(velocity, striker, compression, energy, contacts, steps, held)

    def growth(self, case: Case) -> float:
        """Return the greatest rise of the total energy, over the greatest energy that striker or contact had."""
        energy = np.concatenate([[case.energy], self.energy])
        kinetic = 0.5 * case.m * self.striker**2
        stored = case.k * self.compression ** (case.a + 1.0) / (case.a + 1.0)
        rise = (energy - np.minimum.accumulate(energy)).max() / max(case.energy, kinetic.max(), stored.max())
        return float(rise) if math.isfinite(rise) else math.inf


def error(velocity: Array, expected: Array) -> float:
    """Return the greatest difference of two courses of velocity over the greatest expected one, in dB."""
    return 20.0 * math.log10(max(np.abs(velocity - expected).max() / np.abs(expected).max(), 1e-20))


class Bank(NamedTuple):
    """Modes as bank.py keeps them, their point, their start (2, n), and memory for a contact's work."""

    modes: Modes
    point: Point
    start: Array
    frequency: Array
    sigma: Array
    work: Array
    seen: Array
    moments: Array


def bank_of(case: Case) -> Bank:
    """Return the case's modes, padded to whole LANES; the point's shape has their phi in all four rows."""
    count = len(case.frequency)
    n = -(-max(count, 1) // LANES) * LANES
    y1, y2, a1, a2, balance, frequency, sigma = np.zeros((7, n))
    frequency[:count], sigma[:count] = case.frequency, case.sigma
    modes = Modes(y1, y2, a1, a2, balance, np.zeros(n // LANES * RESPONSES))
    shape = np.zeros((4, n))
    shape[:, :count] = case.phi
    for i in range(count):
        set_mode(modes, i, float(frequency[i]), float(sigma[i]), float(case.rate), 1.0)
    z = np.zeros(n, complex)
    z[:count] = case.ringing
    angle = 2.0 * np.pi * frequency / case.rate
    start = np.stack([z.imag, (z.imag * np.cos(angle) - z.real * np.sin(angle)) * np.exp(sigma / case.rate)])
    point = Point(shape.ravel(), n, 0, np.array([0.0, 1.0, 0.0, 0.0]))
    seen, moments = np.zeros((2, FINE))
    return Bank(modes, point, start, frequency, sigma, np.zeros(3 * n), seen, moments)


@kernel
def restart(bank: Bank) -> None:
    """Set the modes back to their start."""
    modes = bank.modes
    for i in range(len(modes.y1)):
        modes.y1[i] = bank.start[0, i]
        modes.y2[i] = bank.start[1, i]


@kernel
def ring_on(modes: Modes) -> None:
    """Ring the modes for one sample."""
    for i in range(len(modes.y1)):
        y = modes.a1[i] * modes.y1[i] + modes.a2[i] * modes.y2[i]
        modes.y2[i] = modes.y1[i]
        modes.y1[i] = y


@kernel
def motion_and_energy(bank: Bank) -> tuple[float, float]:
    """Return the velocity of the modes' point (m/s), and their energy (J)."""
    velocity = energy = 0.0
    modes = bank.modes
    n = len(modes.y1)
    for i in range(n):
        if bank.frequency[i] > 0.0:
            re, im = state_of(modes.y1[i], modes.y2[i], modes.a1[i], modes.a2[i])
            re = math.copysign(re, re * modes.response[i // LANES * RESPONSES + MOBILITY + i % LANES])
            damping = bank.sigma[i] / (2.0 * np.pi * bank.frequency[i])
            rate_of_q = re - damping * im
            velocity += bank.point.shape[n + i] * rate_of_q
            energy += 0.5 * (rate_of_q * rate_of_q + (1.0 + damping * damping) * im * im)
    return velocity, energy


@kernel
def step_alone(contacts: Items[Member], group: CoupledGroup, seen: View[float], moments: View[float]) -> None:
    """Take the first of the contacts through the coming sample by itself; see `step_together`."""
    group.size = 1
    group.member[0] = 0
    for n in range(FINE):
        group.observed[0, n] = seen[n]
    step_together(contacts, group)
    for n in range(FINE):
        moments[n] = group.moments[0, n]


@kernel
def keep_sample(row: View[float], bank: Bank, contact: Coupled) -> None:
    """Put a sample of a Run into its row: velocities (m/s), compression (m), energy (J), contacts begun."""
    velocity, energy = motion_and_energy(bank)
    row[0], row[1] = velocity, contact.v
    row[2] = max(contact.motion[0], 0.0)
    energy += 0.5 * contact.m * contact.v * contact.v - contact.push * contact.position
    row[3] = energy + elastic(contact.motion[0], contact.k, contact.a)
    row[4] = contact.contacts


@njit(error_model="numpy")
def _simulate(contacts, group, bank, case, samples, times, out):
    modes, point, work, seen, moments = bank.modes, bank.point, bank.work, bank.seen, bank.moments
    contact = contacts[0].coupled
    v, m, k, mu, a, push, fraction, rate, tolerance = case
    law = ContactLaw(m, k, mu, a)
    for _ in range(times):
        restart(bank)
        begin_coupled(contact, v, law, push, fraction, rate, tolerance)
        receptance(modes, point, work, seen)
        respond_with(contact, seen)
        for t in range(samples):
            observe(modes, point, work, seen)
            step_alone(contacts, group, seen, moments)
            inject_fine(modes, point, moments)
            ring_on(modes)
            if t < len(out):
                keep_sample(out[t], bank, contact)


def _simulation(case: Case, tolerance: float, contacts: NDArray[np.void]) -> Callable[..., None]:
    law = (case.v_in, case.m, case.k, case.mu, case.a, case.push, case.fraction, case.rate, tolerance)
    group = np.zeros(1, COUPLED_GROUP)[0]
    return partial(_simulate, contacts, group, bank_of(case), tuple(map(float, law)))


def simulate(case: Case, tolerance: float = 1e-5) -> Run:
    """Simulate a case by the coupled solver and the engine's bank of modes.

    Parameters
    ----------
    case : Case
        Striker and modes.
    tolerance : float, default 1e-5
        Largest error of a step, as a share of the momentum, above 0.

    Returns
    -------
    Run
        Velocities (m/s), compression (m), energy (J) and contacts begun, float64 (samples,) each.

    Raises
    ------
    ValueError
        The tolerance is out of range.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance = {tolerance:g}: expected above 0")
    contacts = np.zeros(1, MEMBER)
    out = np.empty((case.samples, 5))
    _simulation(case, tolerance, contacts)(case.samples, 1, out)
    contact = contacts[0]["coupled"]
    return Run.of(out, int(contact["steps"]), int(contact["held"]))


def simulation_loop(case: Case, samples: int, tolerance: float) -> Callable[[int], None]:
    """Return a function that simulates so many samples of a case the given number of times and keeps none, for
    `cost_of`."""
    simulation = _simulation(case, tolerance, np.zeros(1, MEMBER))
    return lambda times: simulation(samples, times, NOT_KEPT)


def random_cases(count: int, seed: int, yielding: tuple[float, float] = (1e-4, 1.0)) -> list[Case]:
    """Yield audible contacts: 1-40 modes up to 20 kHz, 0.05-50 samples, mu v_in 0-5, sum m phi^2 within `yielding`."""
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
        k = (float(contact_time(1.0, m, 1.0, mu, a)) * 48_000.0 / samples) ** (a + 1.0)
        frequency, sigma = np.sort(10.0 ** random.uniform(1.5, 4.3, n)), 10.0 ** random.uniform(0.0, 2.0, n)
        frames, fraction = int(2.0 * samples) + 40, random.uniform()
        cases.append(Case(frequency, sigma, phi, 1.0, m, k, mu, a, samples=frames, fraction=fraction))
    return cases


def extreme_case(random: np.random.Generator) -> Case:
    """Return any contact: 1-256 modes, k to 1e16, mu to 1e3, a 1-4, 8-192 kHz, sum m phi^2 to 30, pushed or not."""
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
