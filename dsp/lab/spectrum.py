"""The spectrum of a contact's force as methods give it to the modes, against the exact one."""

import math
from functools import cache

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import spherical_jn

from ..contact.closed_form import advance_pulse, begin_pulse
from ..contact.pulse_record import PULSE
from ..numerics.checks import Array
from ..numerics.legendre import MOMENTS
from .reference import force_spectrum
from .wall import Law, durations, floats, path

SPECTRUM_TOP = 16_000.0
"""Highest frequency, in Hz, at which the error of a force's spectrum is evaluated."""

_FREQUENCIES = 65

Spectrum = NDArray[np.complex128]


@njit(error_model="numpy")
def _moments(pulse, law, rate, moments):
    begin_pulse(pulse, *law, rate)  # type: ignore[call-arg]
    for i in range(len(moments)):
        advance_pulse(pulse, min(i + 1.0, pulse.duration), float(i), moments[i])


def spectrum_error(method: str, correction: str, law: Law, rate: float, oversampling: int = 1) -> float:
    """Return the greatest error in dB of the force's spectrum from 0 to SPECTRUM_TOP, over the exact one's value at 0.

    A sampled method's force is the momentum lost in each step, held for the step; the closed form's ("closed") what the
    engine gives the modes: the Legendre moments of each sample at `rate`. Infinite where a method fails.
    """
    frequency = np.linspace(0.0, SPECTRUM_TOP, _FREQUENCIES)
    exact = _exact_spectrum(floats(law))
    if method == "closed":
        found = _closed_spectrum(law, rate, frequency)
    else:
        _, v = path(method, correction, law, rate * oversampling)
        if not np.isfinite(v).all():
            return math.inf
        found = _held_spectrum(law[1] * -np.diff(v), rate * oversampling, frequency)
    return 20 * math.log10(float(np.abs(found - exact).max() / abs(exact[0])))


def _held_spectrum(momenta: Array, rate: float, frequency: Array) -> Spectrum:
    """Return the spectrum of momenta (N s) that are each spread evenly over a step of 1/rate s."""
    # Waves factor into those at the beginning of a row and those within it.
    size = math.isqrt(len(momenta)) + 1
    rows = np.pad(momenta, (0, -len(momenta) % size)).reshape(-1, size)
    turns = -2j * np.pi * frequency / rate
    within = np.exp(np.outer(np.arange(size) + 0.5, turns))
    beginning = np.exp(np.outer(np.arange(len(rows)) * size, turns))
    spectrum: Spectrum = ((rows @ within) * beginning).sum(axis=0) * np.sinc(frequency / rate)
    return spectrum


def _closed_spectrum(law: Law, rate: float, frequency: Array) -> Spectrum:
    """Return the spectrum of the Legendre moments of each sample."""
    moments = np.zeros((math.ceil(durations([law], [rate])[0]), MOMENTS))
    _moments(np.zeros(1, PULSE)[0], floats(law), float(rate), moments)
    turns = np.pi * frequency / rate
    orders = np.arange(MOMENTS)[:, None]
    of_moments = (2 * orders + 1) * (-1j) ** orders * spherical_jn(orders, turns)
    waves = np.exp(-1j * np.outer(2 * np.arange(len(moments)) + 1, turns))
    spectrum: Spectrum = ((moments @ of_moments) * waves).sum(axis=0)
    return spectrum


@cache
def _exact_spectrum(law: Law) -> Spectrum:
    return force_spectrum(*law, np.linspace(0.0, SPECTRUM_TOP, _FREQUENCIES))
