"""A ball and a die that are dropped: their sound in Pa at 1 m against a derivation from the force of the blow."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import fftconvolve

from carom.dsp.runtime.engine import Engine
from carom.presets import Presets
from carom.server.osc.score import parse
from carom.server.render import Options, blocks

RATE = 48_000
FINE = 64
"""Times as many points for the derivation."""
RHO, C, G = 1.2, 343.0, 9.80665


def hertz_force(mass, radius, velocity, mu, *elastic):
    """Force (N) of a ball on a plane at FINE RATE, by the two bodies' (E, nu): m x'' = -4/3 E* sqrt(R) x^1.5 (1 + mu x')."""
    k = 4 / 3 / sum((1 - nu**2) / e for e, nu in elastic) * math.sqrt(radius)

    def force(x, v):
        return k * np.maximum(x, 0) ** 1.5 * (1 + mu * v)

    def left(t, y):
        return y[0] if t > 1e-7 else 1.0

    left.terminal = True
    run = solve_ivp(
        lambda _, y: [y[1], -force(*y) / mass], (0, 0.01), (0, velocity), rtol=1e-9, atol=1e-12, events=left,
        dense_output=True, max_step=2e-6,
    )  # fmt: skip
    t = np.arange(0, run.t_events[0][0], 1 / (FINE * RATE))
    return force(*run.sol(t))


def sphere_click(force, mass, radius):
    """Pressure (Pa) at 1 m, rms over directions, of a sphere on which a force acts, at FINE RATE.

    p(t) = rho a c/sqrt(3) int A(t - s) exp(-c s/a) (cos(c s/a) - sin(c s/a)) ds (Koss and Alfredson 1973).
    """
    x = C / radius * np.arange(int(30 * radius / C * FINE * RATE)) / (FINE * RATE)
    answer = RHO * radius * C / math.sqrt(3) * np.exp(-x) * (np.cos(x) - np.sin(x))
    return fftconvolve(force / mass, answer) / (FINE * RATE)


def peak(pressure, rate):
    """The greatest magnitude below 0.4 of RATE, between samples too."""
    spectrum = np.fft.rfft(pressure, 4096 * rate // RATE)
    return np.abs(np.fft.irfft(spectrum[: int(0.4 * 4096)], 4096 * 16)).max() * 16 * RATE / rate


def rendered(folder, name, line):
    """A render in Pa of what is told to an object `a`, at its left."""
    text = f"0 /object/new a {name}\n0 /object/a/{line}\n"
    options = Options(rate=RATE, seconds=0.5, calibrated=True)
    return np.concatenate(list(blocks(parse(text.encode(), "score"), Engine(RATE), Presets(folder), options)))[:, 0]
