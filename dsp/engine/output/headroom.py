"""Headroom: a slow automatic level ahead of the limiter.

What goes on being too loud is turned down as a whole, so that the limiter has the sudden peaks alone. The level follows
an envelope of its peaks, down within a second and back up within some.
"""

import math

from ...native.jit import noinline_kernel
from ..memory.state import QUANTUM, State

AIM = 10.0 ** (-4.0 / 20.0)
"""Of the envelope, of full scale: peaks lie a little above it, and then below the limiter's ceiling."""
_RISE = 0.004  # s in which the envelope follows peaks above it, those of clicks too
_FALL = 4.0  # s in which it falls: longer than from one blow to the next
_DOWN, _UP = 1.0, 6.0  # s in which the level follows it down, and back up: too slow to be heard as a change
_OVER = 0.9999  # level above which it is at rest


@noinline_kernel
def keep_headroom(state: State) -> None:
    """Scale the mix by the level, which glides over the quantum; switched off, it comes back as after loud sound.

    An engine without a limiter has none.
    """
    output = state.output
    on = state.choices.headroom == 1
    if output.delay == 0 or not (on or output.headroom < 1.0):
        return
    peak = 0.0
    for channel in range(output.channels):
        for n in range(QUANTUM):
            peak = max(peak, abs(output.mix[channel, n]))
    step = QUANTUM / state.rate
    envelope = output.envelope * math.exp(-step / _FALL)
    if peak > envelope:
        envelope += (peak - envelope) * -math.expm1(-step / _RISE)
    output.envelope = envelope
    aim = AIM / envelope if on and envelope > AIM else 1.0
    before = output.headroom
    after = before + (aim - before) * -math.expm1(-step / (_DOWN if aim < before else _UP))
    after = 1.0 if aim == 1.0 and after > _OVER else after
    output.headroom = after
    state.stats.headroom = after
    if before == 1.0 and after == 1.0:
        return
    for n in range(QUANTUM):
        level = before + (after - before) * (n + 1) / QUANTUM
        for channel in range(output.channels):
            output.mix[channel, n] *= level
