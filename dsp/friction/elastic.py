"""An elastic contact: it yields along the surface before it slips, and so squeaks and creaks.

It is a row of springs, each of which slips at its share of the limit (Iwan, J. Appl. Mech. 33, 1966). Their shares are
such that the contact follows the law of two spheres (Mindlin, J. Appl. Mech. 16, 1949) by straight pieces:

    f = mu N (1 - (1 - 2 k u/(3 mu N))^(3/2))

with the stretch u and the stiffness k (N/m, `tangential`) of a contact that has not slipped. Over a sample the force is
held at its mean over the stretch. So its work is what the springs store and what they lose as they slip, exactly, and
no slip gives energy. The mean never falls as the stretch grows: there is one solution, and Newton's method finds it
from the side where each step stays short of it. Order 2.

The limit follows law.py with a memory, mu' = (mu(|w|) - mu) |w|/L, as the force of a bristle does (Canudas de Wit et
al., IEEE Trans. Automatic Control 40, 1995): what touches is renewed over a length L (Rabinowicz, J. Appl. Phys. 22,
1951), here mu_s N/(2 k), a third of the stretch at which all of the contact slips.
"""

import math

import numpy as np

from ..native.jit import kernel
from .law import coefficient
from .record import SPRINGS, Friction

_STEPS = 40
_EXACT = 1e-15  # share of the stretch by which Newton's last step may differ
_MEMORY = 0.5  # L over mu_s N/k

_reach = np.arange(1, SPRINGS + 1) / SPRINGS  # where each slips, over where all do: 3 mu N/(2 k)
_slopes = -np.diff((1.0 - np.append(0.0, _reach)) ** 1.5, append=0.0) * SPRINGS / 1.5
STIFFNESS = _slopes[:-1] - _slopes[1:]
"""The springs' shares of k."""
SHARE = 1.5 * STIFFNESS * _reach
"""Shares of the springs in the limit; the sum is 1."""


@kernel
def stiffen(friction: Friction, tangential: float) -> None:
    """Set the contact's stiffness (N/m; 0: it is rigid). No spring gains energy by it: a stiffer one keeps its force,
    and a softer one its stretch."""
    if tangential == friction.tangential:
        return
    share = 0.0
    if friction.tangential > 0.0:
        share = min(tangential / friction.tangential, 1.0)
    else:
        friction.limit = friction.limit_ahead = friction.static
    before = friction.stored
    friction.stored = 0.0
    for i in range(SPRINGS):
        friction.pull[i] *= share
        if tangential > 0.0:
            friction.stored += 0.5 * friction.pull[i] ** 2 / (STIFFNESS[i] * tangential)
    friction.lost += before - friction.stored
    friction.tangential = tangential


@kernel
def step_elastic(friction: Friction, mean: float) -> None:
    """Take the sample with one force, `start`; mean: the point's mean velocity if no force acts (m/s)."""
    period = friction.period
    load = 0.5 * (friction.normal[0] + friction.normal[1])
    most = friction.limit_ahead * load
    # Make those springs slip that the limit (N) has fallen below; return the force of all (N).
    held = 0.0
    for i in range(SPRINGS):
        pull, bound = friction.pull[i], SHARE[i] * most
        if abs(pull) > bound:
            loss = 0.5 * (pull * pull - bound * bound) / (STIFFNESS[i] * friction.tangential)
            friction.lost += loss
            friction.stored -= loss
            pull = friction.pull[i] = math.copysign(bound, pull)
        held += pull
    path = 0.5 * (friction.drive[0] + friction.drive[1]) * period
    free, give = path - mean * period, friction.whole_mean * period
    sign = 1.0 if free >= give * held else -1.0
    # The stretch x >= 0 (m) over the sample, along `sign`, with x = free - give f(x), f being the mean force. f
    # is concave, so that Newton's method comes from 0 and never goes beyond the solution.
    way = sign * free
    stretch = 0.0
    for _ in range(_STEPS):
        force = rise = 0.0
        for i in range(SPRINGS):
            k, pull, bound = STIFFNESS[i] * friction.tangential, sign * friction.pull[i], SHARE[i] * most
            left = (bound - pull) / k
            if stretch <= left:
                force += pull + 0.5 * k * stretch
                rise += 0.5 * k
            else:
                force += bound - 0.5 * k * left * left / stretch
                rise += 0.5 * k * left * left / (stretch * stretch)
        step = (way - give * force - stretch) / (1.0 + give * rise)
        if step <= _EXACT * stretch:
            break
        stretch += step
    # Stretch the springs, and count what they store and lose (J); their mean force (N) along `sign`.
    force = stored = 0.0
    slipping = True
    for i in range(SPRINGS):
        k, pull, bound = STIFFNESS[i] * friction.tangential, sign * friction.pull[i], SHARE[i] * most
        left = (bound - pull) / k
        if stretch <= left:
            slipping = slipping and stretch == left
            force += pull + 0.5 * k * stretch
            pull += k * stretch
        else:
            force += bound - 0.5 * k * left * left / stretch
            friction.lost += bound * (stretch - left)
            pull = bound
        friction.pull[i] = sign * pull
        stored += 0.5 * pull * pull / k
    friction.stored = stored
    branch = sign if slipping else 0.0
    friction.events += branch != friction.branch
    friction.branch = branch
    friction.start, friction.slope = sign * force, 0.0
    friction.driven += friction.start * path
    # Update the limit to the slip, and predict it for the middle of the next sample, should that slip as fast.
    length = _MEMORY * friction.static * load / friction.tangential
    mu = coefficient(stretch / friction.period, friction.static, friction.dynamic, friction.stribeck)[0]
    kept = math.exp(-0.5 * stretch / length) if length > 0.0 else 0.0
    friction.limit = mu + (friction.limit - mu) * kept * kept
    friction.limit_ahead = mu + (friction.limit - mu) * kept
