"""Which contacts the closed form may answer for: the gate before the coupled solver.

On an object that gives way, the wall's pulse of the effective mass m* (ladder.py) is an approximation. What it neglects
is told by sums over the modes: with r_i = m phi_i^2 and P_i the pulse's power spectrum at mode i over that at 0, the
unrest sum r_i (1 - P_i), and for an object that rings already, what its velocity may change by while they touch,
sum |phi_i z_i|/v_in at most. Errors of the object's velocity, as a share of its greatest, were measured on
thousands of random contacts with up to 40 modes; UNREST is where nine of ten are below the level asked for. (Half of
them are below it up to several times that.)
"""

import numpy as np

from ..native.jit import kernel

LEVELS = ("-40", "-60", "-80", "exact")
"""Accuracies of the object's velocity, in dB; their places are their numbers."""

UNREST = np.array([7e-3, 4e-4, 3e-5, 0.0])
"""Unrest up to which the closed form has that accuracy."""

TOLERANCE = np.array([1e-1, 1e-1, 1e-2, 1e-5])
"""Tolerances of the coupled solver for it."""

_HEAVY = 0.25  # sum r_i P_i from which on an object is too light
_CAUGHT_UP = 0.8  # of the speed a striker leaves with: swinging back with .94 of it, an object caught it up


@kernel
def closed_form_will_do(level, share, bound, stir, restitution):
    """Whether the closed form has an accuracy (a number in LEVELS), given share = sum r_i P_i, bound = sum r_i,
    stir = sum |phi_i z_i|/v_in and the restitution e: the object's modes swing back with up to
    share (1 + e) v_in, and the striker leaves with e v_in."""
    once = share * (1.0 + restitution) < _CAUGHT_UP * restitution
    return share < _HEAVY and once and max(bound - share, 0.0) + stir < UNREST[level]
