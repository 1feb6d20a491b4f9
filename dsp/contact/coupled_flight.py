"""The flight of a coupled striker (coupled.py): where it meets the object, and how long it surely touches nothing."""

import math

from ..native.jit import kernel
from ..native.typed import View
from ..numerics.legendre import FINE
from .coupled_records import Coupled
from .power_series import value_at

_LOOKS = 8  # at the gap, in a sample
_NEWTON_STEPS = 50
_EXACT = 1e-15  # relative width of a bracket that ends the search
_AGES = 1e12  # samples that are as good as for ever
_LEAST_SPEED = 1e-300  # m/s: keeps a quotient finite


@kernel
def fly(motion: View[float], left: float) -> tuple[float, bool]:
    """Return the samples until x comes up to 0, at most `left`, and whether it does."""
    fastest, power = motion[1], left  # (x - x0)/t at most
    for n in range(2, FINE):
        fastest += max(motion[n], 0.0) * power
        power *= left
    if motion[0] <= 0.0 and (fastest < 0.0 or motion[0] + fastest * left < 0.0):
        return left, False
    high = low = 0.0
    meets = False
    slope = motion[1]
    for n in range(1, _LOOKS + 1):
        before, low = low, left * n / _LOOKS
        x, after = value_at(motion, low)
        high = low
        if x <= 0.0 and slope > 0.0 and after < 0.0:
            # It may have looked in between: at its greatest, about there.
            high = before + (low - before) * slope / (slope - after)
            x = value_at(motion, high)[0]
        slope = after
        if x > 0.0:
            low = before
            meets = True
            break
    if not meets:
        return left, False
    # Newton's method within the bracket, from outside to the first point inside.
    guess = high
    for _ in range(_NEWTON_STEPS):
        x, slope = value_at(motion, guess)
        if x > 0.0:
            high = guess
        else:
            low = guess
        guess -= x / slope
        if not low < guess < high:
            guess = 0.5 * (low + high)
        if high - low <= _EXACT * high:
            break
    return high, True


@kernel
def apart_for(contact: Coupled, distance: float, speed: float, acceleration: float, faster: float) -> float:
    """Return for how many whole samples from now striker and object surely stay apart: those may be left to `fly_on`.

    To be asked right after `step_together`; `distance`, `speed` and `acceleration` bound the object's point, by
    `bank.reach`, and others may make it faster by so much (m/s). Where no acceleration is known, it is infinite. 0
    while they touch, infinity if the striker is gone for good.
    """
    gap = -contact.motion[0]
    if contact.touching or contact.wait >= 0.0 or gap <= 0.0:
        return 0.0
    if contact.push <= 0.0 and contact.v <= 0.0 and contact.position < -distance:
        return math.inf
    pushed = max(contact.push, 0.0) / contact.m
    # The closing gap, by speeds or from the rate at which it closes now, and the way back into the object's reach; the
    # latest one.
    near = _until(gap, contact.v + speed + faster, pushed)
    if acceleration < math.inf:
        near = max(near, _until(gap, contact.motion[1] / contact.period + faster, pushed + acceleration))
    if pushed == 0.0 and contact.v < 0.0 and contact.position + contact.v * near < -distance:
        return math.inf  # out of reach before the gap may have closed
    far = _until(-distance - contact.position, contact.v, pushed)
    samples = max(near, far, 0.0) / contact.period
    return float(math.floor(samples)) if samples < _AGES else math.inf


@kernel
def _until(way: float, speed: float, acceleration: float) -> float:
    """Return seconds until way >= 0 is covered; 0 if there is none."""
    if way <= 0.0:
        return 0.0
    root = math.sqrt(max(speed * speed + 2.0 * acceleration * way, 0.0))
    if speed >= 0.0:
        return 2.0 * way / max(speed + root, _LEAST_SPEED)
    return (root - speed) / acceleration if acceleration > 0.0 else math.inf


@kernel
def fly_on(contact: Coupled, samples: float) -> None:
    """Advance a striker that touches nothing by whole samples, without a search for a meeting."""
    time = samples * contact.period
    contact.position += time * (contact.v + 0.5 * time * contact.push / contact.m)
    contact.v += time * contact.push / contact.m
