"""Conversion of an OSC time tag to the engine's clock, so that its sound is heard at that time."""

import time

from ..dsp.native.system import clock_ns
from ..dsp.runtime.engine import NOW, Engine
from .osc.arguments import Refused
from .osc.wire import IMMEDIATELY, unix_ns

_SAME_MOMENT = 2_000  # ns
_TRIES = 4  # at reading two clocks at the same moment
_FURTHEST_AHEAD = 3600.0  # s that a time tag may lie in the future; how late it is counts up to that


def time_of(time_tag: int, engine: Engine) -> float:
    """Return the time of a time tag for `Engine.send`; NOW for 0 and 1. Refused if it lies too far ahead."""
    if time_tag <= IMMEDIATELY:
        return NOW
    wall, clock = _clocks()
    ahead = unix_ns(time_tag, wall) - wall
    if ahead > _FURTHEST_AHEAD * 1e9:
        raise Refused(f"time tag: {ahead / 1e9:.0f} s ahead; expected at most {_FURTHEST_AHEAD:.0f} s")
    ahead = max(ahead, -round(_FURTHEST_AHEAD * 1e9))  # a clock that was never set says nothing of how late
    # From here on the wall clock may be set without moving what waits.
    return engine.stamp(clock + ahead)


def _clocks() -> tuple[int, int]:
    """Return the wall clock and the engine's, in ns, read at the same moment: as near as a few tries come."""
    tries = []
    for _ in range(_TRIES):
        before, wall, after = clock_ns(), time.time_ns(), clock_ns()
        tries.append((after - before, wall, (before + after) // 2))
        if after - before < _SAME_MOMENT:
            break
    return min(tries)[1:]
