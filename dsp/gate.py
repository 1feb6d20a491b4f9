"""Which contacts the closed form may answer for: the gate before the coupled solver.

On an object that gives way, the wall's pulse of the effective mass m* (engine.py) is an approximation. What it neglects
is told by sums over the modes: with r_i = m phi_i^2 and P_i the pulse's power spectrum at mode i over that at 0, the
unrest sum r_i (1 - P_i), and for an object that rings already, the change of its velocity while they touch,
sum |phi_i z_i| sqrt(1 - P_i)/v_in. Errors of the object's velocity, as a share of its greatest, were measured on
thousands of random contacts with up to 40 modes; UNREST is where nine of ten are below the level asked for. (Half of
them are below it up to several times that.)
"""

import numpy as np

from .jit import kernel

LEVELS = ("-40", "-60", "-80", "exact")
"""Accuracies of the object's velocity, in dB; their places are their numbers."""

UNREST = np.array([7e-3, 4e-4, 3e-5, 0.0])
"""Unrest up to which the closed form has that accuracy."""

TOLERANCE = np.array([1e-1, 1e-1, 1e-2, 1e-5])
"""Tolerances of the coupled solver for it."""

_HEAVY = 0.25  # sum r_i P_i from which on an object is too light, and strikers may touch it again


@kernel
def closed_form_will_do(level, share, bound, stir):
    """Whether the closed form has an accuracy (a number in LEVELS), given share = sum r_i P_i, bound = sum r_i and
    stir = sum |phi_i z_i| sqrt(1 - P_i)/v_in."""
    return share < _HEAVY and max(bound - share, 0.0) + stir < UNREST[level]
