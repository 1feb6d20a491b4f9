"""The limiter at the end: nothing leaves above full scale.

It looks ahead. The sound that it lets through is a quantum old, so that its gain comes down ahead of a peak, along a
line over QUANTUM frames, and is there in time. It goes up again as an exponential.
"""

import math

from ...native.jit import kernel, noinline_kernel
from ...native.typed import View
from ..memory.state import QUANTUM, Output, State

_ATTACK = 1.0 / QUANTUM  # the most that the gain falls per frame
_RELEASE = 0.1  # s
_OVER = 0.9999  # gain above which a release is over


@noinline_kernel
def limit(state: State) -> None:
    """Exchange the mix for the one before it, and bring that within [-1, 1], all channels alike.

    Count the frames that are turned down, and for whom. A limiter that is switched off lets go as it does after a peak,
    and delays the sound as before. An engine without a limiter has no delay either.
    """
    output = state.output
    if output.delay == 0:
        return
    lowest = _exchange(output, state.choices.limiter == 1)
    if lowest == 1.0 and output.limit == 1.0:
        return
    gain = state.scratch.voices[0, 0]  # free by now
    _ramp(output.allowed, gain)
    release = 1.0 - math.exp(-1.0 / (_RELEASE * state.rate))
    held, limited = output.limit, state.stats.limited
    for n in range(QUANTUM):
        held = min(gain[n], held + (1.0 - held) * release)
        state.stats.limited += held < 1.0
        state.stats.limit_lowest = min(state.stats.limit_lowest, held)
        for channel in range(output.channels):
            output.mix[channel, n] *= held
            if output.allowed[n] < 1.0:  # rounding
                output.mix[channel, n] = min(max(output.mix[channel, n], -1.0), 1.0)
    output.limit = 1.0 if held > _OVER else held
    for i in range(state.active if state.stats.limited > limited else 0):
        obj = state.objects[state.order[i]]
        obj.limited_energy += obj.energy


@kernel
def _exchange(output: Output, on: bool) -> float:
    """Exchange the mix for the one that was held; return the lowest gain that a frame of either allows."""
    mix, held, allowed = output.mix, output.held, output.allowed
    lowest = 1.0
    for n in range(QUANTUM):
        allowed[n] = allowed[QUANTUM + n]
        loudest = 1.0
        for channel in range(output.channels):
            coming = mix[channel, n]
            mix[channel, n], held[channel, n] = held[channel, n], coming
            loudest = max(loudest, abs(coming))
        allowed[QUANTUM + n] = 1.0 / loudest if on else 1.0
        lowest = min(lowest, allowed[n], allowed[QUANTUM + n])
    return lowest


@kernel
def _ramp(allowed: View[float], gain: View[float]) -> None:
    """Fill the gain of the frames that leave: what all frames allow, with a line down to each, from the last one on."""
    ahead = 1.0
    for n in range(2 * QUANTUM - 1, -1, -1):
        ahead = min(ahead + _ATTACK, allowed[n])
        if n < QUANTUM:
            gain[n] = ahead
