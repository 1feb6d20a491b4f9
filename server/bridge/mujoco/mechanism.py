"""MuJoCo's own account of a blow: the effective mass of the whole mechanism, and its contact's restitution.

The mass is 1/(J M^-1 J'), with J how fast the bodies close at the point for each of the model's velocities.
"""

import numpy as np

from ....dsp.native.jit import carray, kernel, noinline_kernel
from ....dsp.native.pointers import load_address, load_double, pointer_to
from ....dsp.native.typed import View, View2D
from ..tracking.state import Blow
from .arrays import Arrays, find_soft
from .functions import call_jacobian, call_solve
from .soft import rebound_of

_DOUBLE = 8  # bytes


@noinline_kernel
def ask_mechanism(arrays: Arrays, blow: Blow) -> None:
    """Say a blow's effective mass, if the mechanism yields, and its restitution."""
    mechanism = arrays.mechanism
    count = mechanism.velocities
    along: View[float] = carray(pointer_to(mechanism.along), (count,), np.float64)
    for k in range(count):
        along[k] = 0.0
    point: View[float] = carray(pointer_to(mechanism.point), (3,), np.float64)
    for k in range(3):
        point[k] = blow.point[k]
    _close(arrays, blow, blow.a, 1.0, along)
    _close(arrays, blow, blow.b, -1.0, along)
    call_solve(mechanism.solve, mechanism.model, mechanism.data, mechanism.answer, mechanism.along)
    answer: View[float] = carray(pointer_to(mechanism.answer), (count,), np.float64)
    lightness = pushed = 0.0
    smooth = load_address(mechanism.smooth)
    for k in range(count):
        lightness += along[k] * answer[k]
        pushed += along[k] * load_double(smooth + _DOUBLE * k)
    if lightness > 0.0:
        blow.mass = 1.0 / lightness
    if mechanism.own == 1:
        blow.restitution = _rebound(arrays, blow, pushed)


@kernel
def _close(arrays: Arrays, blow: Blow, body: int, sign: float, along: View[float]) -> None:
    """Add how fast a body's point moves along a blow's normal, for each of the model's velocities."""
    moving = body - arrays.first
    if moving < 0 or moving >= arrays.bodies:
        return
    mechanism = arrays.mechanism
    number = arrays.body[moving]
    call_jacobian(mechanism.jacobian, mechanism.model, mechanism.data, mechanism.slope, mechanism.point, number)
    slope: View2D[float] = carray(pointer_to(mechanism.slope), (3, mechanism.velocities), np.float64)
    for k in range(mechanism.velocities):
        for i in range(3):
            along[k] += sign * blow.normal[i] * slope[i, k]


@kernel
def _rebound(arrays: Arrays, blow: Blow, pushed: float) -> float:
    """Return the share of its speed that a blow's contact leaves, where other forces push the bodies together
    (m/s^2)."""
    mechanism = arrays.mechanism
    contact = load_address(arrays.contacts) + arrays.stride * blow.contact
    find_soft(mechanism, contact)
    soft = mechanism.soft
    soft.depth = max(load_double(contact + mechanism.margin) - load_double(contact + arrays.distance), 0.0)
    soft.speed, soft.pushed, soft.late = blow.speed, pushed, arrays.late
    soft.braked = 0.0
    if arrays.late == 1:
        soft.braked = _closes_now(arrays, blow, blow.a) - _closes_now(arrays, blow, blow.b)
    return rebound_of(soft)


@kernel
def _closes_now(arrays: Arrays, blow: Blow, body: int) -> float:
    """Return the speed of a body's point along a blow's normal at the end of a step (m/s): see `late` of ARRAYS."""
    moving = body - arrays.first
    if moving < 0 or moving >= arrays.bodies:
        return 0.0
    motion = arrays.before[moving]
    total = 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        rate = motion[3 + k]
        rate += motion[i] * (blow.point[j] - motion[6 + j]) - motion[j] * (blow.point[i] - motion[6 + i])
        total += rate * blow.normal[k]
    return total
