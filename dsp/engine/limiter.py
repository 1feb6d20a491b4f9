"""The limiter at the end: nothing leaves above full scale."""

import math

from ..native.jit import kernel
from .state import QUANTUM

_ATTACK = 1.0 / 32.0  # gain may fall this much a frame ahead of a peak, as far as the quantum shows it coming
_RELEASE = 0.1  # s


@kernel
def limit(state):
    """Bring the mix within [-1, 1], both channels alike, and count the frames that were turned down."""
    left = state.mix[0]
    right = state.mix[1]
    peak = 0.0
    for n in range(QUANTUM):
        peak = max(peak, abs(left[n]), abs(right[n]))
    if peak <= 1.0 and state.limit == 1.0:
        return
    # Backwards: what each frame allows, and a slope down to it; `voices` is free by now.
    gain = state.voices[0, 0]
    ahead = 1.0
    for n in range(QUANTUM - 1, -1, -1):
        ahead = min(ahead + _ATTACK, 1.0 / max(1.0, abs(left[n]), abs(right[n])))
        gain[n] = ahead
    release = 1.0 - math.exp(-1.0 / (_RELEASE * state.rate))
    held = state.limit
    for n in range(QUANTUM):
        held = min(gain[n], held + (1.0 - held) * release)
        if held < 1.0:
            state.limited += 1
        state.limit_lowest = min(state.limit_lowest, held)
        left[n] = min(max(left[n] * held, -1.0), 1.0)
        right[n] = min(max(right[n] * held, -1.0), 1.0)
    state.limit = 1.0 if held > 0.9999 else held
