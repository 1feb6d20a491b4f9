"""Bodies that are rubbed, as modes: a bowed string, a bowed bar, a glass; and random extremes."""

import numpy as np
from numpy.typing import NDArray

from ..numerics.checks import Array
from .slide import BOWED, Rub, constant

STRING, IMPEDANCE = 147.0, 0.6
"""Hz, and kg/s: a cello's d string."""


def bowed_string(
    beta: float,
    force: float,
    speed: float = 0.1,
    seconds: float = 0.5,
    rate: float = 48_000.0,
    law: tuple[float, float, float] = BOWED,
    torsion: int = 26,
) -> Rub:
    """Return a string of 60 transverse modes and some torsional ones, bowed at beta of its length in Helmholtz motion.

    Torsion has a wave impedance of 1.8 kg/s, and 5.2 times the transverse frequency, as in Woodhouse, Acta Acustica
    united with Acustica 89, 2003.
    """
    i, j = np.arange(1, 61), np.arange(1, torsion + 1)
    frequency = np.concatenate([STRING * i * np.sqrt(1.0 + 2e-5 * i * i), 5.2 * STRING * j])
    mass = IMPEDANCE / (2.0 * STRING)
    size = np.sqrt(2.0 / mass)
    twist = size * np.sqrt(5.2 * IMPEDANCE / 1.8)
    phi = np.concatenate([size * np.sin(np.pi * i * beta), twist * np.sin(np.pi * j * beta)])
    sigma = np.pi * frequency / np.concatenate([np.full(60, 500.0), np.full(torsion, 45.0)])
    # Helmholtz's motion: at the bow v for 1 - beta of the period, -v (1 - beta)/beta for the rest.
    z = np.zeros(60 + torsion, complex)
    n = i * np.pi
    z[:60] = 2.0 * speed / (beta * n) * np.sin(n * (1.0 - beta)) / (size * np.sin(np.pi * i * beta))
    heard = frequency < 0.45 * rate
    samples = int(seconds * rate)
    rub = Rub(
        frequency[heard],
        sigma[heard],
        phi[heard],
        constant(speed, samples),
        constant(force, samples),
        law,
        rate,
        z[heard],
    )
    return rub


def bowed_bar(force: float, speed: float, seconds: float = 1.0, rate: float = 48_000.0) -> Rub:
    """Return a free bar of 220 Hz and 0.3 kg, bowed at its end."""
    ratios = np.array([1.0, 2.756, 5.404, 8.933, 13.344, 18.638, 24.812, 31.870])
    frequency = 220.0 * ratios
    samples = int(seconds * rate)
    phi = np.full(8, 2.0 / np.sqrt(0.3))
    sigma = np.pi * frequency / 800.0
    return Rub(frequency, sigma, phi, constant(speed, samples), constant(force, samples), BOWED, rate)


def rubbed_glass(force: float, speed: float = 0.1, seconds: float = 2.0, rate: float = 48_000.0) -> tuple[Rub, float]:
    """Return a glass of 620 Hz under a wet finger, disturbed by 1e-5 of its speed; and the rate of growth (1/s) by
    theory.

    A mode of shape phi grows at N |mu'(v)| phi^2/2 - sigma.
    """
    frequency = np.array([620.0, 1480.0, 2690.0, 4200.0, 6050.0, 8100.0])
    sigma = np.pi * frequency / np.array([1500.0, 1200.0, 1000.0, 900.0, 800.0, 700.0])
    phi = np.array([4.0, 3.6, 3.2, 2.8, 2.4, 2.0])
    static, dynamic, stribeck = law = (0.4, 0.2, 0.2)
    fall = (static - dynamic) / (1.0 + speed / stribeck)
    omega = 2.0 * np.pi * frequency
    bent = force * (dynamic + fall) * phi / (omega**2 + sigma**2)
    z: NDArray[np.complex128] = sigma * bent + 1j * omega * bent
    z[0] += 1e-5 * speed / phi[0]
    samples = int(seconds * rate)
    rub = Rub(frequency, sigma, phi, constant(speed, samples), constant(force, samples), law, rate, z)
    return rub, force * fall / (stribeck + speed) * phi[0] ** 2 / 2.0 - sigma[0]


def extreme_rub(rng: np.random.Generator, samples: int = 200) -> Rub:
    """Return anything that can be requested: 1 to 64 modes up to 20 kHz, 0.1 g to 10 kg, mN to 100 N, 0.1 mm/s to 10
    m/s."""
    modes = int(rng.choice([1, 2, 4, 8, 16, 32, 64]))

    def between(low: float, high: float, size: int | None = None) -> Array:
        return np.exp(rng.uniform(np.log(low), np.log(high), size))

    frequency = between(20.0, 20_000.0, modes)
    sigma = between(0.1, 1000.0, modes) * (rng.random() < 0.8)
    phi = rng.normal(size=modes) / np.sqrt(between(1e-4, 10.0))
    speed = between(1e-4, 10.0)
    times = np.arange(samples + 1)
    course = (np.ones(samples + 1), np.sin(times * rng.uniform(0.0, 3.0)), rng.normal(size=samples + 1))
    normal = np.full(samples + 1, between(1e-3, 100.0))
    if rng.random() < 0.5:
        normal = normal * rng.random(samples + 1) * (rng.random(samples + 1) < 0.8)
    dynamic = rng.uniform(0.0, 1.0)
    law = (dynamic + rng.uniform(0.0, 1.0), dynamic, float(between(1e-3, 1.0)))
    z = rng.normal(size=modes) + 1j * rng.normal(size=modes)
    z *= speed * between(1e-3, 10.0) / np.abs(phi).max() * (rng.random() < 0.5)
    rate = float(rng.choice([44_100.0, 48_000.0, 96_000.0]))
    return Rub(frequency, sigma, phi, speed * course[rng.integers(3)], normal, law, rate, z)


def slips_per_period(times: Array, since: float, seconds: float, frequency: float) -> float:
    """Return how many times per period it begins to slip, by the times of changes of branch (s), from a time (s) to the
    end."""
    return 0.5 * len(times[times > since]) / ((seconds - since) * frequency)
