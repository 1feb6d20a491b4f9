"""Sensors that are mounted on a body: what they measure, and how their own resonance colours it.

A sensor is a mass on a spring. Of the motion a(t) under it, it gives y with y''/w0^2 + 2 d y'/w0 + y = a: as it is
up to a third of its resonance, more about there, and less above.
"""

import math
from typing import NamedTuple

import numpy as np

from .material import Array

QUANTITIES = {"acceleration": "m/s^2", "velocity": "m/s"}
"""Quantities that are sensed, each with its unit; their places are their numbers."""

_FITTED = 0.95  # share of the Nyquist frequency up to which the filter is fitted
_POINTS = 400
_ROUNDS = 30


class Sensor(NamedTuple):
    """A sensor: its quantity, its resonance (Hz; 0: it has none) and the damping ratio of that."""

    quantity: str = "acceleration"
    resonance: float = 0.0
    damping: float = 0.05

    @property
    def unit(self) -> str:
        return QUANTITIES[self.quantity]

    def response(self, frequency: Array) -> Array:
        """Return the amplitude that it gives of a motion of 1 at frequencies (Hz)."""
        if self.resonance == 0.0:
            return np.ones_like(frequency)
        share = frequency / self.resonance
        return 1.0 / np.sqrt((1.0 - share**2) ** 2 + (2.0 * self.damping * share) ** 2)

    def filter(self, rate: float) -> tuple[float, ...]:
        """Return the filter of second order that does the same at a sampling rate (Hz): b0, b1, b2, a1, a2, with
        y[n] = b0 x[n] + b1 x[n-1] + b2 x[n-2] - a1 y[n-1] - a2 y[n-2].

        Its amplitudes are those of `response` within 0.3 dB up to 20 kHz at 48 kHz. Its poles are the sensor's own
        where it resonates below the Nyquist frequency, else they are fitted, too. M. Vicanek, "Matched second order
        digital filters", 2016, has the form in which the squares of amplitudes are fitted.
        """
        if self.resonance == 0.0:
            return 1.0, 0.0, 0.0, 0.0, 0.0
        theta = np.linspace(0.0, _FITTED * math.pi, _POINTS)[1:]
        wanted = self.response(theta * rate / (2.0 * math.pi)) ** 2
        found = [_fitted(theta, wanted, poles) for poles in (self._poles(rate), None)]
        return min(found, key=lambda each: _error(each, theta, wanted))

    def _poles(self, rate: float) -> tuple[float, float]:
        """Return a1 and a2 by which it rings between samples as it does."""
        omega = 2.0 * math.pi * self.resonance / rate
        turn = abs(1.0 - self.damping**2) ** 0.5 * omega
        left = math.exp(-self.damping * omega)
        if self.damping < 1.0:
            return -2.0 * left * math.cos(turn), left**2
        return -(math.exp(turn - self.damping * omega) + math.exp(-turn - self.damping * omega)), left**2


def _fitted(theta: Array, wanted: Array, poles: tuple[float, float] | None) -> tuple[float, ...]:
    """Return the filter whose squared amplitudes come nearest to those that are wanted, in decibels; poles: a1, a2 if
    they are given."""
    low, high, middle = _basis(theta)
    whole, alternating, cross = 1.0, 1.0, 0.0
    if poles:
        whole, alternating, cross = (1 + poles[0] + poles[1]) ** 2, (1 - poles[0] + poles[1]) ** 2, -4 * poles[1]
    below = whole * low + alternating * high + cross * middle
    for _ in range(1 if poles else _ROUNDS):
        columns = [high / wanted, middle / wanted, *([] if poles else [-high, -middle])]
        left = (below if poles else low) - whole * low / wanted
        top, bend, *more = np.linalg.lstsq(np.stack(columns, 1) / below[:, None], left / below, rcond=None)[0]
        if more:
            alternating, cross = more
            below = np.maximum(low + alternating * high + cross * middle, 1e-12)
    above, under = _factor(whole, top, bend), _factor(whole, alternating, cross)
    b0, b1, b2 = (each / under[0] for each in above)
    return b0, b1, b2, under[1] / under[0], under[2] / under[0]


def _basis(theta: Array) -> tuple[Array, Array, Array]:
    """Return the functions of which the squared amplitude of a polynomial of second order is a sum."""
    share = np.sin(theta / 2.0) ** 2
    return 1.0 - share, share, 4.0 * share * (1.0 - share)


def _factor(whole: float, alternating: float, cross: float) -> tuple[float, float, float]:
    """Return the polynomial of least phase with these shares of `_basis`; NaN where there is none."""
    if min(whole, alternating) < 0.0:
        return math.nan, math.nan, math.nan
    even = 0.5 * (math.sqrt(whole) + math.sqrt(alternating))
    if even * even + cross < 0.0:
        return math.nan, math.nan, math.nan
    first = 0.5 * (even + math.sqrt(even * even + cross))
    return first, 0.5 * (math.sqrt(whole) - math.sqrt(alternating)), -0.25 * cross / first


def _error(filter: tuple[float, ...], theta: Array, wanted: Array) -> float:
    """Return the largest error (dB) of a filter; infinite for one that is none, or grows."""
    b0, b1, b2, a1, a2 = filter
    if not (math.isfinite(b0 + b1 + b2) and abs(a2) < 1.0 and abs(a1) < 1.0 + a2):
        return math.inf
    z = np.exp(-1j * theta)
    found = np.abs((b0 + z * (b1 + z * b2)) / (1.0 + z * (a1 + z * a2))) ** 2
    return float(np.abs(10.0 * np.log10(found / wanted)).max())
