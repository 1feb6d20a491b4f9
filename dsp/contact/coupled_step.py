"""A step of a coupled contact (coupled.py) while it lasts: by collocation, or with the force held."""

import math

from ..native.jit import kernel
from ..native.typed import View
from ..numerics.legendre import FINE
from .coupled_records import Coupled
from .law import elastic

HELD = math.inf
"""Tolerance of one held step a sample: the cheapest, for when there is no time."""

TRIALS = 40
FINEST = 2.0**-16  # of the step tried first: where it comes to this, the force is held
_LEAST_SWING = 1e-5  # of the compression at which a striker rests: an amplitude that counts as heard in any case
LEAST = 1e-12  # samples: the force is held no shorter, or steps that fail one after the other come to nothing
RETRY = 0.25  # of a step whose equations are not solved
REFINE = 0.5  # of a step whose energy is not right
ROUNDING = 1e-14  # share of the momentum at hand that needs no force


@kernel
def set_powers(contact: Coupled, eta: float) -> None:
    """Scale the motion of a contact to times of a step of `eta` samples."""
    even, odd, square = 1.0, eta, eta * eta
    for n in range(0, FINE, 2):
        contact.power[n], contact.power[n + 1] = even, odd
        even *= square
        odd *= square
    for n in range(FINE):
        contact.moved[n] = contact.motion[n] * contact.power[n]


@kernel
def speed_of(contact: Coupled, x: float, v: float) -> float:
    """Return the greatest of two speeds that kinetic and elastic energy amount to: now, and where compression and rate
    are x and v. Of what rests energy is about its rest, of the mass that is felt there."""
    x0, v0 = contact.motion[0], contact.motion[1] / contact.period
    if contact.swing > 0.0:
        square, rest = contact.swing * contact.swing * contact.m / contact.mass, contact.rest_compression
        least = _LEAST_SWING * _LEAST_SWING * square * rest * rest
        now, then = v0 * v0 + square * (x0 - rest) * (x0 - rest), v * v + square * (x - rest) * (x - rest)
        return math.sqrt(max(now, then, least))
    share = 2.0 / contact.mass
    now, then = elastic(x0, contact.k, contact.a), elastic(x, contact.k, contact.a)
    return math.sqrt(max(v0 * v0 + share * now, v * v + share * then))


@kernel
def give_of(answer: View[float], eta: float) -> float:
    """Return the distance (m) by which a point yields to 1 N held for a step, by its answer (FINE, m/(N sample)) to
    it."""
    give = 0.0
    power = eta
    for n in range(1, FINE):
        power *= eta
        give += answer[n] * power / (n + 1)
    return give
