"""Hits whose modes are known, and how well modes can be known at all."""

from dataclasses import dataclass

import numpy as np

RATE = 24_000.0


@dataclass(frozen=True)
class Modes:
    """Modes: frequency (Hz), decay (1/s), amplitude (complex), all (k,)."""

    frequency: np.ndarray
    decay: np.ndarray
    amplitude: np.ndarray

    @property
    def poles(self) -> np.ndarray:
        return -self.decay + 2j * np.pi * self.frequency

    def sound(self, seconds: float, rate: float = RATE) -> np.ndarray:
        """Return their sum, by plain sines."""
        t = np.arange(round(seconds * rate)) / rate
        return sum((c * np.exp(p * t)).real for c, p in zip(self.amplitude, self.poles, strict=True))


def modes(count: int, seed: int, apart: float = 40.0) -> Modes:
    """Return the modes between 100 Hz and 10 kHz, at least so far apart (Hz), within 20 dB, of T60 from 0.2 to 2 s."""
    random = np.random.default_rng(seed)
    frequency = np.sort(random.uniform(100, 10_000 - count * apart, count)) + apart * np.arange(count)
    t60 = np.exp(random.uniform(np.log(0.2), np.log(2), count))
    amplitude = 10 ** (random.uniform(-20, 0, count) / 20) * np.exp(2j * np.pi * random.random(count))
    return Modes(frequency, np.log(1000) / t60, amplitude)


def cramer_rao(known: Modes, seconds: float, noise: float, rate: float = RATE) -> tuple[np.ndarray, np.ndarray]:
    """Return the least standard deviations of frequency (Hz) and decay (1/s) in white noise of an rms: of any unbiased
    estimate.

    From the Fisher matrix of all 4 k parameters, J^T J/noise^2, J the derivatives of all samples.
    """
    t = np.arange(round(seconds * rate)) / rate
    ringing = np.exp(np.outer(t, known.poles))
    moved = t[:, None] * ringing * known.amplitude
    jacobian = np.hstack([ringing.real, -ringing.imag, -moved.real, -2 * np.pi * moved.imag])
    scale = np.sqrt(np.sum(jacobian**2, axis=0))
    bounds = noise * np.sqrt(np.diag(np.linalg.inv((jacobian.T @ jacobian) / np.outer(scale, scale)))) / scale
    count = len(t) and len(known.frequency)
    return bounds[3 * count :], bounds[2 * count : 3 * count]
