"""Thick bars: by how much more or less an endless one radiates than the dipole or the quadrupole of its section has it.

Those hold where the section is small against the wave. Where it is not, the sound of a bar's one side goes round its
narrow faces to the other: a section as thick as wide radiates 3 dB less than its dipole, a third as thick 1.3 dB more,
and one that moves along its longer side 10 dB less.
"""

import numpy as np

from ..material import Array

REACH, STEPS = (0.05, 6.4), 22
"""x = k b, b half the width across which the air is pushed: equal steps of ln x."""
ASPECTS = (0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0, 5.0, 10.0)
"""Thickness, along which it moves, over width."""
SWAYS = (
    (0.22, 0.22, 0.23, 0.24, 0.25, 0.28, 0.31, 0.36, 0.43, 0.52, 0.63, 0.75, 0.79, 0.64, 0.27, -0.01, -0.06, 0.00,
     0.06, 0.17, 0.01, 0.05),
    (0.02, 0.03, 0.04, 0.06, 0.08, 0.12, 0.17, 0.25, 0.37, 0.52, 0.71, 0.89, 0.95, 0.70, 0.18, -0.16, -0.16, -0.05,
     0.06, 0.18, -0.03, 0.05),
    (0.07, 0.08, 0.09, 0.12, 0.15, 0.20, 0.28, 0.39, 0.55, 0.76, 1.00, 1.21, 1.18, 0.70, -0.06, -0.43, -0.32, -0.11,
     0.05, 0.16, -0.07, 0.03),
    (0.11, 0.12, 0.14, 0.17, 0.21, 0.28, 0.37, 0.51, 0.69, 0.92, 1.16, 1.29, 1.07, 0.32, -0.56, -0.82, -0.54, -0.20,
     0.02, 0.08, -0.10, 0.01),
    (0.05, 0.07, 0.09, 0.12, 0.17, 0.24, 0.34, 0.48, 0.66, 0.87, 1.06, 1.06, 0.65, -0.27, -1.14, -1.23, -0.75, -0.29,
     -0.04, 0.00, -0.07, 0.02),
    (0.08, 0.10, 0.12, 0.15, 0.20, 0.27, 0.37, 0.50, 0.66, 0.81, 0.87, 0.66, -0.01, -1.07, -1.87, -1.72, -0.98, -0.39,
     -0.10, 0.01, -0.07, 0.02),
    (0.05, 0.06, 0.09, 0.12, 0.17, 0.23, 0.31, 0.40, 0.49, 0.50, 0.32, -0.21, -1.18, -2.34, -2.96, -2.43, -1.28,
     -0.53, -0.17, 0.03, -0.12, 0.01),
    (0.07, 0.08, 0.10, 0.13, 0.17, 0.21, 0.25, 0.27, 0.21, 0.00, -0.52, -1.44, -2.69, -3.91, -4.26, -3.11, -1.62,
     -0.78, -0.27, -0.09, -0.12, 0.00),
    (0.03, 0.04, 0.05, 0.07, 0.08, 0.07, 0.03, -0.11, -0.41, -1.00, -1.98, -3.35, -4.89, -6.06, -5.64, -3.93, -2.45,
     -1.21, -0.48, -0.16, -0.16, 0.00),
    (0.06, 0.06, 0.05, 0.03, -0.03, -0.15, -0.39, -0.83, -1.59, -2.77, -4.39, -6.30, -8.00, -7.95, -7.17, -5.84,
     -3.57, -1.95, -0.87, -0.34, -0.23, -0.04),
    (-0.04, -0.07, -0.15, -0.29, -0.53, -0.97, -1.69, -2.83, -4.48, -6.69, -9.22, -10.37, -10.32, -11.29, -10.28,
     -8.56, -5.87, -3.53, -1.82, -0.80, -0.44, -0.13),
    (-0.31, -0.52, -0.88, -1.48, -2.44, -3.92, -6.09, -9.08, -11.77, -11.94, -13.42, -15.20, -15.70, -15.82, -15.15,
     -13.02, -10.10, -7.04, -4.35, -2.34, -1.22, -0.48),
)  # fmt: skip
"""dB, of a bar that moves along its thickness, by aspect and x. The tests compute it anew by boundary elements."""
TURNED = (0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85)
"""Thickness over width of a bar that twists: a square's quadrupole is none."""
TURNS = (
    (0.07, 0.07, 0.08, 0.09, 0.11, 0.14, 0.18, 0.25, 0.36, 0.51, 0.71, 0.97, 1.26, 1.55, 1.79, 1.93, 1.87, 1.13, 0.22,
     0.08, 0.27, 0.14),
    (0.02, 0.03, 0.04, 0.06, 0.08, 0.13, 0.19, 0.29, 0.44, 0.66, 0.97, 1.36, 1.82, 2.29, 2.69, 2.90, 2.68, 1.38, 0.12,
     0.05, 0.34, 0.04),
    (0.02, 0.03, 0.05, 0.07, 0.10, 0.16, 0.24, 0.37, 0.57, 0.86, 1.28, 1.83, 2.51, 3.22, 3.84, 4.11, 3.52, 1.40,
     -0.15, -0.06, 0.25, -0.17),
    (0.08, 0.09, 0.11, 0.13, 0.17, 0.23, 0.32, 0.47, 0.70, 1.03, 1.51, 2.16, 2.97, 3.86, 4.60, 4.77, 3.60, 0.81,
     -0.64, -0.24, -0.11, -0.10),
    (0.03, 0.04, 0.05, 0.08, 0.12, 0.18, 0.28, 0.43, 0.66, 1.00, 1.50, 2.17, 3.02, 3.92, 4.61, 4.50, 2.81, -0.20,
     -1.05, -0.06, 0.13, 0.74),
    (0.02, 0.03, 0.05, 0.07, 0.11, 0.16, 0.25, 0.39, 0.61, 0.92, 1.37, 1.97, 2.68, 3.36, 3.63, 2.86, 0.62, -1.63,
     -0.13, 1.33, 1.74, 1.01),
    (0.24, 0.24, 0.25, 0.26, 0.28, 0.32, 0.37, 0.44, 0.56, 0.72, 0.94, 1.20, 1.44, 1.50, 1.06, -0.23, -1.72, -1.03,
     1.84, 2.37, 2.27, 1.76),
)  # fmt: skip
"""dB, of a bar that twists, likewise."""


def swaying(x: Array, aspect: float) -> Array:
    """Return the power of a bar that moves along its thickness, over that of its dipole, at x = k b."""
    beyond = max(aspect / ASPECTS[-1], 1.0)  # a taller one is as tall against the wave at another x
    return _between(x * beyond, aspect, ASPECTS, SWAYS)


def turning(x: Array, aspect: float) -> Array:
    """Return the power of a bar that twists, over that of its quadrupole, at x = k b."""
    return _between(x, aspect, TURNED, TURNS)


def _between(x: Array, aspect: float, aspects: tuple[float, ...], table: tuple[tuple[float, ...], ...]) -> Array:
    """Return a power at x from a table in dB, which is 0 of a flat strip."""
    rows = np.array([[0.0] * STEPS, *table])
    place = float(np.interp(aspect, (0.0, *aspects), np.arange(len(rows))))
    low = min(int(place), len(rows) - 2)
    row = rows[low] + (place - low) * (rows[low + 1] - rows[low])
    at = np.log(np.maximum(x, 1e-12))
    found: Array = 10 ** (np.interp(at, np.log(np.geomspace(*REACH, STEPS)), row) / 10)
    return found
