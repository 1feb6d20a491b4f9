"""The rebound of a soft contact, as MuJoCo has it: a spring and a damper whose force grows with the depth.

The reference acceleration is a_ref = -b v - k d r, of which the constraint applies the share d(r), the impedance
(MuJoCo, "Computation": "Solver parameters"). It is taken step by step as the simulator does.
"""

import numpy as np

from ..native.jit import kernel

SOFT = np.dtype(
    [
        (name, np.float64)
        for name in (
            "step",  # s
            "stiffness",  # k, 1/s^2
            "damping",  # b, 1/s
            "low", "high", "width", "middle", "power",  # of the impedance: a sigmoid of the depth over a width (m)
            "depth",  # m, as the contact is seen first
            "speed",  # m/s, of the approach
            "pushed",  # m/s^2: how other forces push the bodies together
        )
    ],
    align=True,
)  # fmt: skip
"""A contact of MuJoCo's."""

LEAST_IMPEDANCE, MOST_IMPEDANCE = 1e-4, 0.9999
"""As MuJoCo bounds it."""

_LONGEST = 1000  # steps of a blow that is followed


@kernel
def rebound_of(soft):
    """The share of its speed that the contact leaves: as it parts, or before other forces push it back."""
    depth, rate, least = soft.depth, soft.speed, soft.speed
    slows = False
    for _ in range(_LONGEST):
        impedance, before = _impedance(soft, depth), rate
        push = max(0.0, impedance * (soft.damping * rate + soft.stiffness * impedance * depth + soft.pushed))
        rate += soft.step * (soft.pushed - push)
        depth += soft.step * rate
        least = min(least, rate)
        if depth < 0.0 or (slows and rate > before):
            break
        slows |= rate < before
    return min(max(-least / soft.speed, 0.0), 1.0)


@kernel
def _impedance(soft, depth):
    """d(r)."""
    x = min(depth / max(soft.width, 1e-15), 1.0)
    if soft.power <= 1.0 or x == 0.0 or x == 1.0:
        y = x
    elif x <= soft.middle:
        y = x**soft.power / soft.middle ** (soft.power - 1.0)
    else:
        y = 1.0 - (1.0 - x) ** soft.power / (1.0 - soft.middle) ** (soft.power - 1.0)
    return min(max(soft.low + y * (soft.high - soft.low), LEAST_IMPEDANCE), MOST_IMPEDANCE)
