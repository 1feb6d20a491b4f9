"""The course of ramps: once a quantum each gives its parameter the value for the quantum's end, as a command would.

From there it glides as it always does, so that a ramp has no steps that are heard. A parameter that users know in dB or
semitones goes by equal ratios.
"""

import math

import numpy as np

from ...macros import ENGINE_SETTINGS
from ...native.jit import kernel, noinline_kernel
from ...native.records import field
from ...native.typed import View
from ...schema import MAIN_GAIN, STEERABLE, gestures_steered_by
from ..bodies.reshaping import set_of
from ..memory.commands import KIND_GAIN, KIND_STEER
from ..memory.order import wake
from ..memory.ramp_list import keep_ramp
from ..memory.records import Ramp
from ..memory.state import QUANTUM, State
from .steering import set_target, target_of

_STEERED_BY_RATIOS: View[bool] = np.array(
    [*(any(each.by_ratios for each in gestures_steered_by(name).values()) for name in STEERABLE), True]
)
"""The last is that of a level."""
_SET_BY_RATIOS: View[bool] = np.array([setting.by_ratios for setting in ENGINE_SETTINGS.values()])
_GAIN_BY_RATIOS = MAIN_GAIN.by_ratios
_STRAIGHT = 1e-3  # a curve below it is as good as a straight line


@noinline_kernel
def run_ramps(state: State) -> None:
    """Bring what ramps change to this quantum, in the order in which they came."""
    kept = 0
    for i in range(state.ramps.count):
        ramp = state.ramps.entries[i]
        if ramp.begin >= state.position + QUANTUM or _goes_on(state, ramp):
            keep_ramp(state, kept, i)
            kept += 1
    state.ramps.count = kept


@kernel
def _goes_on(state: State, ramp: Ramp) -> bool:
    """Advance a ramp; return False if it is over, or its target is gone."""
    if not _has_target(state, ramp):
        return False
    if ramp.begun == 0:
        ramp.begun = 1
        # The value that a ramp's parameter was last set to.
        if ramp.kind == KIND_GAIN:
            ramp.first = state.choices.gain
        elif ramp.kind == KIND_STEER:
            ramp.first = target_of(state, state.contacts[ramp.place], ramp.parameter)
        else:
            ramp.first = field(state.objects[ramp.place].settings, ramp.parameter)
    left = ramp.end - (state.position + QUANTUM)
    value = _between(ramp, 1.0 - left / (ramp.end - ramp.begin)) if left > 0.0 else ramp.last
    if ramp.kind == KIND_GAIN:
        state.choices.gain = value
    elif ramp.kind == KIND_STEER:
        set_target(state, state.contacts[ramp.place], ramp.parameter, value)
    else:
        set_of(state, state.objects[ramp.place], ramp.parameter, value)
        wake(state, ramp.place)
    return left > 0.0


@kernel
def _has_target(state: State, ramp: Ramp) -> bool:
    """True if the gesture or object that a ramp changes is there."""
    if ramp.kind == KIND_GAIN:
        return True
    if ramp.kind == KIND_STEER:
        contact = state.contacts[ramp.place]
        return contact.gesture != 0 and contact.command == ramp.serial
    obj = state.objects[ramp.place]
    return obj.used == 1 and obj.serial == ramp.serial


@kernel
def _between(ramp: Ramp, share: float) -> float:
    """Return the value at a share of a ramp's time."""
    if abs(ramp.curve) > _STRAIGHT:
        share = math.expm1(ramp.curve * share) / math.expm1(ramp.curve)
    by_ratios = _GAIN_BY_RATIOS
    if ramp.kind != KIND_GAIN:
        by_ratios = (_STEERED_BY_RATIOS if ramp.kind == KIND_STEER else _SET_BY_RATIOS)[ramp.parameter]
    if by_ratios and ramp.first > 0.0:
        ratio: float = (ramp.last / ramp.first) ** share
        return ramp.first * ratio
    return ramp.first + (ramp.last - ramp.first) * share
