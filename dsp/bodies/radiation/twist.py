"""Radiation of a bar of rectangular section that twists.

R = (rho c k b/(2 pi)) int_0^pi |V(k cos t)|^2 S(k b sin t) dt, V(q) = int phi exp(-i q x) dx, as of a bar that bends:
phi is the velocity of the edges, the twist times b, half the width. S is the resistance per length, over rho c b, of an
endless strip whose velocity is y/b across it, free in the air: one side pushes where the other draws, two dipoles
against each other. A thick bar's narrow faces push air too: FLATNESS says by how much more or less its quadrupole is,
and `thick` what its whole section does where it is not small against the wave.
"""

import math

import numpy as np

from ..air import IMPEDANCE, wavenumber
from ..material import Array
from ..ritz import quadrature
from .thick import turning

REACH = (0.1, 40.0)
RESISTANCE = (
    4.82319e-08, 7.76111e-08, 1.24891e-07, 2.00981e-07, 3.23449e-07, 5.20577e-07, 8.37916e-07, 1.34884e-06,
    2.17156e-06, 3.49664e-06, 5.63131e-06, 9.07124e-06, 1.46166e-05, 2.35599e-05, 3.79915e-05, 6.12955e-05,
    9.89592e-05, 0.000159896, 0.000258621, 0.000418835, 0.000679391, 0.00110427, 0.00179942, 0.00294161,
    0.00482833, 0.00796575, 0.0132263, 0.0221365, 0.0374117, 0.0639591, 0.110736, 0.193947,
    0.341182, 0.590286, 0.959222, 1.36553, 1.62021, 1.63751, 1.50894, 1.34296,
    1.19581, 1.10542, 1.14486, 1.35206, 1.44825, 1.3516, 1.23954, 1.26713,
    1.3983, 1.32542, 1.2722, 1.37653, 1.30496, 1.34218, 1.32269, 1.34541,
    1.31078, 1.34905, 1.33701, 1.31747, 1.31959, 1.32309, 1.32291, 1.32534,
)  # fmt: skip
"""S at equal steps of ln k b over REACH, by Galerkin's method on the jump of the pressure; pi^2 (k b)^5/2048 below,
4/3 above. The tests compute it anew."""

THICKNESS = (0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
FLATNESS = (1.0, 1.128, 1.276, 1.490, 1.862, 2.164, 2.379, 2.480, 2.434, 2.205, 1.752, 1.032, 0.0)
"""The quadrupole of a turning rectangle over that of a flat strip, by thickness over width: exterior potential flow by
panels of sources. A square has none."""


class Twist:
    """A bar that twists: half its length and half its width (m), and at nodes (p,) in -1..1 of a quadrature of weights
    (p,) its modes' twist (p, n) in kg^-1/2 / m, mass-normalised, and its thickness (p,) in m."""

    def __init__(
        self, sides: tuple[float, float], nodes: Array, weights: Array, twist: Array, thickness: Array
    ) -> None:
        self._half, self._half_width = sides
        self._nodes, self._share = nodes, weights * self._half
        self._twist = twist
        ratio = thickness / (2 * self._half_width)
        usual = float(np.mean(ratio))
        self._aspect, self._larger = min(usual, 1 / usual), max(usual, 1.0)
        self._strength = np.interp(np.minimum(ratio, 1 / ratio), THICKNESS, FLATNESS) * np.where(ratio > 1, ratio**4, 1)

    def resistance(self, frequency: Array) -> Array:
        """Return R (n,) in 1/s: the power is R q'^2/2 at a modal velocity of amplitude q' (sqrt(kg) m/s)."""
        strongest = float(self._strength.max())
        found = np.empty_like(frequency)
        for mode, k in enumerate(wavenumber(frequency)):
            nodes, weights = quadrature(16 + math.ceil(0.8 * self._half * k))
            angle = math.pi / 4 * (nodes + 1)
            x = k * self._half_width * np.sin(angle)
            phase = np.exp(-1j * k * self._half * np.outer(np.cos(angle), self._nodes))
            phi = self._half_width * self._share * self._twist[:, mode]
            flat, thick = phase @ phi, phase @ (phi * self._strength / (strongest or 1.0))
            low = 1 / (1 + x**2)
            power = np.abs(flat + (thick - flat) * low) ** 2 * strip(x) * (1 + (strongest**2 - 1) * low**2)
            power *= turning(x * self._larger, self._aspect)
            found[mode] = IMPEDANCE * k * self._half_width / math.pi * (math.pi / 4 * power @ weights)
        return found


def strip(x: Array) -> Array:
    """Return S of an endless flat strip that turns about its middle line, at x = k b."""
    at = np.log(np.maximum(x, 1e-12))
    grid = np.log(np.geomspace(*REACH, len(RESISTANCE)))
    within = np.exp(np.interp(at, grid, np.log(RESISTANCE)))
    return np.where(x < REACH[0], math.pi**2 / 2048 * x**5, np.where(x > REACH[1], 4 / 3, within))
