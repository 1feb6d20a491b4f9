"""The accuracy of the closed form on objects that yield: the choice between it and the coupled solver.

On an object that yields, the wall's pulse of the effective mass m* is an approximation. Sums over the modes give its
error. With r_i = m phi_i^2, and P_i the pulse's power spectrum at mode i over that at 0, they are the residual
sum r_i (1 - P_i), and for an object that rings already sum |phi_i z_i|/v_in, by which its velocity may change at most
while they touch. Errors of the object's velocity, as a share of its greatest, were measured on thousands of random
contacts with up to 40 modes; RESIDUAL is where nine of ten are below the level requested. (Half of them are below it up
to several times that.)
"""

import numpy as np

from ..native.jit import kernel

LEVELS = ("-50", "-60", "-80", "exact")
"""Accuracies of the object's velocity, in dB; their places are their numbers."""

NUMBERS = {level: place for place, level in enumerate(LEVELS)} | {"-40": LEVELS.index("-50")}
"""The number of each word for one, an old one too."""

DEFAULT = LEVELS.index("-60")
"""The number of the accuracy that an engine begins with."""

RESIDUAL = np.array([7e-4, 4e-4, 3e-5, 0.0])
"""Residual up to which the closed form has that accuracy."""

TOLERANCE = np.array([1e-1, 1e-1, 1e-2, 1e-7])
"""Tolerances of the coupled solver for it, on objects that outweigh the striker: sum r_i below LIGHT."""

IN_BLOCKS = np.array([True, True, False, False])
"""Whether lasting contacts are solved in blocks (block.py)."""

LIGHT = 1.0
"""sum r_i from which on the object swings back and is touched again and again, by which errors grow."""

LIGHT_TOLERANCE = np.array([6e-3, 2e-3, 1e-4, 1e-9])
"""Tolerances there."""

STEPS_A_RADIAN = 0.32 * LIGHT_TOLERANCE**-0.25
"""Steps that a contact which rolls or slides takes for each radian of its swing, at these tolerances: 1.5 at -60, 57 at
`exact`. Their error is of the fourth order; 0.32 is the median of 50 random rolls and slides at `exact`, and within a
third at -80 where kinks of the path take no more."""

_HEAVY = 0.25  # sum r_i P_i from which on an object is too light
_CAUGHT_UP = 0.8  # of the speed a striker leaves with: swinging back with .94 of it, an object caught it up


@kernel
def closed_form_will_do(
    level: int, seen_mass_ratio: float, mass_ratio: float, ringing_ratio: float, restitution: float
) -> bool:
    """True if the closed form is as accurate as `level` (a number in LEVELS) asks, given seen_mass_ratio = sum r_i P_i,
    mass_ratio = sum r_i, ringing_ratio = sum |phi_i z_i|/v_in and the restitution e.

    The object's modes swing back with up to seen_mass_ratio (1 + e) v_in, and the striker leaves with e v_in.
    """
    single_contact = seen_mass_ratio * (1.0 + restitution) < _CAUGHT_UP * restitution
    residual = max(mass_ratio - seen_mass_ratio, 0.0) + ringing_ratio
    return seen_mass_ratio < _HEAVY and single_contact and residual < RESIDUAL[level]
