"""The limiter at the end: nothing leaves above full scale."""

import math

from ..native.jit import kernel
from .state import QUANTUM

_ATTACK = 1.0 / 32.0  # gain may fall this much per frame ahead of a peak, as far as the quantum shows it coming
_RELEASE = 0.1  # s
_OVER = 0.9999  # gain above which a release is over


@kernel
def limit(state):
    """Bring the mix within [-1, 1], all channels alike; count the frames that were turned down, and for whom.

    A limiter that is switched off lets go as it does after a peak.
    """
    output = state.output
    mix, channels = output.mix, output.channels
    peak = 0.0
    if state.choices.limiter == 1:
        for channel in range(channels):
            for n in range(QUANTUM):
                peak = max(peak, abs(mix[channel, n]))
    if peak <= 1.0 and output.limit == 1.0:
        return
    # Backwards: the gain that each frame allows, and a slope down to it; `voices` is free by now.
    gain = state.scratch.voices[0, 0]
    ahead = 1.0
    for n in range(QUANTUM - 1, -1, -1):
        loudest = 1.0
        if state.choices.limiter == 1:
            for channel in range(channels):
                loudest = max(loudest, abs(mix[channel, n]))
        ahead = min(ahead + _ATTACK, 1.0 / loudest)
        gain[n] = ahead
    release = 1.0 - math.exp(-1.0 / (_RELEASE * state.rate))
    held = output.limit
    lowest = 1.0
    for n in range(QUANTUM):
        held = min(gain[n], held + (1.0 - held) * release)
        state.stats.limited += held < 1.0
        lowest = min(lowest, held)
        for channel in range(channels):
            mix[channel, n] *= held
            if state.choices.limiter == 1:
                mix[channel, n] = min(max(mix[channel, n], -1.0), 1.0)
    output.limit = 1.0 if held > _OVER else held
    state.stats.limit_lowest = min(state.stats.limit_lowest, lowest)
    for i in range(state.active):
        obj = state.objects[state.order[i]]
        obj.limited_energy += obj.energy
