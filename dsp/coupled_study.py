"""Numerical experiments on coupled contacts: a striker and modes by themselves, sample by sample."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from .bank import FINE, LANES, RESPONSES, inject_fine, observe, receptance, set_mode, state_of
from .collocation import elastic
from .contact import checked
from .coupled import COUPLED, begin_coupled, respond_with, step_coupled


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
    return contact.contacts


@dataclass(frozen=True)
class Run:
    """A coupled contact, each sample: velocity of the object's point and of the striker (m/s), compression (m), total
    energy (J), contacts begun so far."""

    velocity: NDArray
    striker: NDArray
    compression: NDArray
    energy: NDArray
    contacts: NDArray
    steps: int
    held: int


def simulate(
    frequency: ArrayLike,
    sigma: ArrayLike,
    phi: ArrayLike,
    v_in: float,
    m: float,
    k: float,
    mu: float,
    a: float,
    *,
    rate: float = 48_000.0,
    samples: int = 1000,
    tolerance: float = 1e-5,
    push: float = 0.0,
    fraction: float = 0.0,
    ringing: ArrayLike = 0.0,
) -> Run:
    """A striker meets modes, `fraction` of a sample after the start.

    Modes: frequency (Hz), sigma (1/s), mass-normalised shape phi (kg^-1/2) at the point and state z at the start
    (`ringing`, complex, as bank.py), arrays of one length. The striker: v_in (m/s), m (kg), k (N/m^a), mu (s/m), a, a
    constant push (N). Arrays of `samples` values. ValueError names what is out of range.
    """
    frequency = checked("frequency", frequency, 0.0, 0.5 * rate)
    size = -(-max(len(frequency), 1) // LANES) * LANES
    modes = np.zeros((2, size))
    modes[0, : len(frequency)] = frequency
    modes[1, : len(frequency)] = checked("sigma", sigma, 0.0, strict=False)
    states = np.zeros(size, complex)
    states[: len(frequency)] = ringing
    shape = np.zeros((4, size))
    shape[1, : len(frequency)] = phi
    striker = (
        float(checked("v_in", v_in, 0.0, strict=False)), float(checked("m", m, 0.0)), float(checked("k", k, 0.0)),
        float(checked("mu", mu, 0.0, strict=False)), float(checked("a", a, 1.0, strict=False)), float(push),
        float(checked("fraction", fraction, 0.0, 1.0, strict=False)),
    )  # fmt: skip
    out = np.empty((samples, 5))
    contact = np.zeros(1, COUPLED)[0]
    _simulate(contact, striker, modes[0], modes[1], shape.ravel(), states, float(rate), float(tolerance), out)
    return Run(*out.T, steps=int(contact["steps"]), held=int(contact["held"]))
