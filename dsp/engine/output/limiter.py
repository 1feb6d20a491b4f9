"""The limiter at the end: no true peak leaves above -1 dB of full scale.

It looks ahead. The sound that it lets through is a quantum old, so that its gain comes down ahead of a peak, along a
line over QUANTUM frames, and is there in time. It goes up again as an exponential. Peaks between samples are found as
ITU-R BS.1770 does, by four values a sample: those about a quantum's end once the next one is there, in time as well.
"""

import math

import numpy as np

from ...native.jit import noinline_kernel
from ...native.typed import View2D
from ..memory.state import QUANTUM, State

_ATTACK = 1.0 / QUANTUM  # the most that the gain falls per frame
_RELEASE = 0.1  # s
_OVER = 0.9999  # gain above which a release is over
CEILING = 10.0 ** (-1.0 / 20.0)
"""Of a true peak; loudness standards and lossy formats ask for this much room below full scale."""
_AIM = 10.0 ** (-1.1 / 20.0)  # brings peaks a little lower: a gain that moves puts some back between samples
_NEAR = 0.5 * _AIM  # of samples: below, none between them is above
_BETWEEN = 3  # values between two samples
_HALF = 6  # samples on each side of them that count


def _kernel() -> View2D[float]:
    """Return the weights of 2 _HALF samples by which each value between the two middle ones follows from them."""
    x = np.arange(1 - _HALF, _HALF + 1) - np.arange(1, _BETWEEN + 1)[:, None] / (_BETWEEN + 1)
    weights = np.sinc(x) * np.cos(0.5 * np.pi * x / _HALF) ** 2
    made: View2D[float] = weights / weights.sum(axis=1, keepdims=True)
    return made


_WEIGHTS = _kernel()


@noinline_kernel
def limit(state: State) -> None:
    """Exchange the mix for the one before it, and bring its true peak down to CEILING, all channels alike.

    Count the frames that are turned down, and for whom. A limiter that is switched off lets go as it does after a peak,
    and delays the sound as before. An engine without a limiter has no delay either.
    """
    output = state.output
    if output.delay == 0:
        return
    # Exchange the mix for the one that was held.
    on = state.choices.limiter == 1
    mix, held, allowed = output.mix, output.held, output.allowed
    loudest = 0.0
    for n in range(QUANTUM):
        allowed[n] = allowed[QUANTUM + n]
        peak = 0.0
        for channel in range(output.channels):
            peak = max(peak, abs(mix[channel, n]))
        loudest = max(loudest, peak)
        allowed[QUANTUM + n] = min(_AIM / peak, 1.0) if on and peak > _AIM else 1.0
    if on and max(loudest, output.loudest) > _NEAR:
        for channel in range(output.channels):
            # Lower what the frames about each peak between samples allow, as far as the samples that it follows from
            # are there.
            for frame in range(QUANTUM - _HALF, 2 * QUANTUM - _HALF):
                peak = 0.0
                for k in range(_BETWEEN):
                    value = 0.0
                    for tap in range(2 * _HALF):
                        at = frame + 1 - _HALF + tap
                        value += _WEIGHTS[k, tap] * (held[channel][at] if at < QUANTUM else mix[channel][at - QUANTUM])
                    peak = max(peak, abs(value))
                if peak > _AIM:
                    allowed[frame] = min(allowed[frame], _AIM / peak)
                    allowed[frame + 1] = min(allowed[frame + 1], _AIM / peak)
    silent = loudest == 0.0 and output.loudest == 0.0
    output.loudest = loudest
    lowest = 1.0
    for n in range(2 * QUANTUM):
        lowest = min(lowest, allowed[n])
    for channel in range(output.channels):
        for n in range(QUANTUM):
            mix[channel, n], held[channel, n] = held[channel, n], mix[channel, n]
    if silent:
        output.limit = 1.0  # of what sounded before, nothing is left that could click
    if lowest == 1.0 and output.limit == 1.0:
        return
    gain = state.scratch.voices[0, 0]  # free by now
    # Fill the gain of the frames that leave: what all frames allow, with a line down to each, from the last one on.
    ahead = 1.0
    for n in range(2 * QUANTUM - 1, -1, -1):
        ahead = min(ahead + _ATTACK, output.allowed[n])
        if n < QUANTUM:
            gain[n] = ahead
    release = 1.0 - math.exp(-1.0 / (_RELEASE * state.rate))
    turned, limited = output.limit, state.stats.limited
    for n in range(QUANTUM):
        turned = min(gain[n], turned + (1.0 - turned) * release)
        state.stats.limited += turned < 1.0
        state.stats.limit_lowest = min(state.stats.limit_lowest, turned)
        for channel in range(output.channels):
            output.mix[channel, n] *= turned
            if output.allowed[n] < 1.0:  # rounding
                output.mix[channel, n] = min(max(output.mix[channel, n], -CEILING), CEILING)
    output.limit = 1.0 if turned > _OVER else turned
    for i in range(state.active if state.stats.limited > limited else 0):
        obj = state.objects[state.order[i]]
        obj.limited_energy += obj.energy
