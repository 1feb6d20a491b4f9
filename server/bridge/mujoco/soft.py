"""The rebound of a soft contact, as MuJoCo has it: a spring and a damper whose force grows with the depth.

The reference acceleration is a_ref = -b v - k d r, of which the constraint applies the share d(r), the impedance
(MuJoCo, "Computation": "Solver parameters"). It is taken step by step as the simulator does.
"""

import math

from ....dsp.native.jit import kernel
from ....dsp.native.typed import Record, dtype_of


class Soft(Record):
    """A contact of MuJoCo's."""

    step: float  # s
    stiffness: float  # k, 1/s^2
    damping: float  # b, 1/s
    # Of the impedance, a sigmoid of the depth over a width (m):
    low: float
    high: float
    width: float
    middle: float
    power: float
    depth: float  # m, as the contact is seen first
    speed: float  # m/s, of the approach
    pushed: float  # m/s^2: how other forces push the bodies together
    late: float  # 1: the simulator's steps are Runge and Kutta's, and `depth` is that of the last of four stages
    braked: float  # m/s: how fast they close at that stage


SOFT = dtype_of(Soft)

LEAST_IMPEDANCE, MOST_IMPEDANCE = 1e-4, 0.9999
"""MuJoCo's bounds of the impedance."""

_LONGEST = 1000  # steps of a blow that is followed
_GUESSES = 20  # at the depth before it was seen


@kernel
def rebound_of(soft: Soft) -> float:
    """Return the share of its speed that the contact leaves: as it parts, or before other forces push it back."""
    depth, rate, least = _first_depth(soft), soft.speed, soft.speed
    slows = False
    for _ in range(_LONGEST):
        before = rate
        if soft.late == 1.0:
            depth, rate, _ = _runge_kutta(soft, depth, rate)
        else:
            rate += soft.step * _acceleration(soft, depth, rate)
            depth += soft.step * rate
        least = min(least, rate)
        if (depth < 0.0 and rate < 0.0) or (slows and rate > before):
            break
        slows |= rate < before
    return min(max(-least / soft.speed, 0.0), 1.0)


@kernel
def elasticity_of(soft: Soft) -> float:
    """Return the share of its speed that the contact leaves at most, of all depths at which it may be seen first.

    A damped spring leaves exp(-pi z/sqrt(1 - z^2)). Where one step turns the bodies round, that is
    d (b h + k d h^2) - 1, if they are as deep as they came in a step of h.
    """
    stiffness, braked = soft.stiffness, soft.high * soft.damping * soft.step
    at_once = braked + stiffness * (soft.high * soft.step) ** 2 - 1.0
    square = 0.25 * soft.damping * soft.damping
    swings = math.exp(-math.pi * math.sqrt(square / (stiffness - square))) if stiffness > square else 0.0
    return min(max(swings, at_once), 1.0)


@kernel
def _first_depth(soft: Soft) -> float:
    """Return the depth (m) at the beginning of the step in which the contact is seen."""
    if soft.late == 0.0:
        return soft.depth
    depth = soft.depth - 0.5 * soft.step * (soft.speed + soft.braked)
    for _ in range(_GUESSES):
        depth += soft.depth - _runge_kutta(soft, depth, soft.speed)[2]
    return depth


@kernel
def _runge_kutta(soft: Soft, depth: float, rate: float) -> tuple[float, float, float]:
    """Return the depth and its rate after a step, and the depth at its last stage."""
    half = 0.5 * soft.step
    push1 = _acceleration(soft, depth, rate)
    rate2 = rate + half * push1
    push2 = _acceleration(soft, depth + half * rate, rate2)
    rate3 = rate + half * push2
    push3 = _acceleration(soft, depth + half * rate2, rate3)
    last, rate4 = depth + soft.step * rate3, rate + soft.step * push3
    push4 = _acceleration(soft, last, rate4)
    sixth = soft.step / 6.0
    after = depth + sixth * (rate + 2.0 * rate2 + 2.0 * rate3 + rate4)
    return after, rate + sixth * (push1 + 2.0 * push2 + 2.0 * push3 + push4), last


@kernel
def _acceleration(soft: Soft, depth: float, rate: float) -> float:
    """Return the acceleration of the depth (m/s^2)."""
    if depth < 0.0:
        return soft.pushed
    impedance = _impedance(soft, depth)
    reference = soft.damping * rate + soft.stiffness * impedance * depth
    return soft.pushed - max(0.0, impedance * (reference + soft.pushed))


@kernel
def _impedance(soft: Soft, depth: float) -> float:
    """Return d(r)."""
    x = min(depth / max(soft.width, 1e-15), 1.0)
    if soft.power <= 1.0 or x == 0.0 or x == 1.0:
        y = x
    elif x <= soft.middle:
        y = x**soft.power / soft.middle ** (soft.power - 1.0)
    else:
        y = 1.0 - (1.0 - x) ** soft.power / (1.0 - soft.middle) ** (soft.power - 1.0)
    return min(max(soft.low + y * (soft.high - soft.low), LEAST_IMPEDANCE), MOST_IMPEDANCE)
