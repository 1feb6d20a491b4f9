"""The clock: which sample is whose time, by a delay-locked loop on the times at which the callback is entered.

Blocks are requested in bursts and too late by up to milliseconds; the loop follows the device's mean pace, and so
gives the time of a sample to a fraction of one. After F. Adriaensen, "Using a DLL to filter time", Linux Audio
Conference 2005.
"""

import math
from typing import Annotated

from ...native.atomics import fence, store_release
from ...native.jit import kernel
from ...native.typed import Record, View, dtype_of
from ...numerics.constants import GRID

_FIRST_BANDWIDTH, _LAST_BANDWIDTH = 1.0, 0.05  # Hz
_FASTEST = 0.5  # rad a block: beyond, the loop would overshoot
_LOST = 50e6  # ns of error after which it begins anew


class Clock(Record):
    """The loop that says which sample is whose time."""

    turn: Annotated[View[int], 8]  # odd while the next four change
    origin: int  # CLOCK_MONOTONIC in ns when the loop began, 0: not yet
    time: float  # ns since then
    sample: int  # whose time that is
    period: float  # ns a sample
    bandwidth: float  # Hz
    begun: int  # times the loop began anew
    latency: float  # samples between a callback and its sound
    late: float  # ns by which the last callback came later than the loop thought


CLOCK = dtype_of(Clock)


@kernel
def lock(clock: Clock, rate: float, entered: int, sample: int, frames: int, gap: bool) -> bool:
    """Take in that a callback was entered at `entered` (ns) for `frames` frames from `sample` on.

    Begins anew, and returns true, at the first call, after a gap in the sound, and when it is 50 ms wrong.
    """
    predicted = clock.time + (sample - clock.sample) * clock.period
    error = entered - clock.origin - predicted
    anew = clock.origin == 0 or gap or abs(error) > _LOST
    clock.late = 0.0 if clock.origin == 0 else error
    store_release(clock.turn, 0, clock.turn[0] + 1)
    fence()  # a release alone lets what follows become visible before it: a reader would take half of it for whole
    clock.sample = sample
    if anew:
        clock.origin = entered
        clock.time = 0.0
        clock.period = 1e9 / rate
        clock.bandwidth = _FIRST_BANDWIDTH
        clock.begun += 1
    else:
        omega = min(_FASTEST, 2.0 * math.pi * clock.bandwidth * frames / rate)
        clock.time = predicted + math.sqrt(2.0) * omega * error
        clock.period += omega * omega * error / max(frames, 1)
        # As the mean over all that was seen would narrow: its bandwidth falls as 1/t.
        narrower = clock.bandwidth / (1.0 + clock.bandwidth * frames / rate)
        clock.bandwidth = max(_LAST_BANDWIDTH, narrower)
    store_release(clock.turn, 0, clock.turn[0] + 1)
    return anew


@kernel
def sample_at(clock: Clock, time: int) -> float:
    """Return the sample, on the grid of events, that is heard at a CLOCK_MONOTONIC time in ns."""
    sample = clock.sample + (time - clock.origin - clock.time) / clock.period - clock.latency
    return math.floor(sample * GRID + 0.5) / GRID
