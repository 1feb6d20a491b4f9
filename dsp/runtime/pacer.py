"""The engine by the clock, where there is no device: a compiled loop that needs no Python while it runs.

What holds Python's interpreter for a while (a sort, the garbage collector) would stop a loop in Python, and the sound.
"""

from functools import cache
from typing import Any

from numba import njit, types

from ..native.atomics import load_acquire
from ..native.system import call_back, monotonic_ns, pause_ns
from .callback import OUTPUT_UNDERFLOW
from .code_cache import kept

_LONGEST_PAUSE = 20_000_000  # ns: the loop looks at least this often whether to stop
_SLEPT = 1_000_000_000  # ns behind after which the machine is thought to have slept: no rush to catch up

_SIGNATURE = types.void(
    types.int64[::1], types.int64, types.int64, types.float64, types.float32[:, ::1], types.float64[::1]
)


def _pace(running, callback, state, rate, out, times):
    """Have blocks of `out`'s size computed as their time comes, while running[0] is not 0.

    running: int64 (1,). callback, state: addresses. rate: Hz. out: float32 (frames, channels). times: float64 (3,), in
    which the callback reads them as PortAudio's.
    """
    frames = len(out)
    started = monotonic_ns()
    done = 0
    while load_acquire(running, 0) != 0:
        now = monotonic_ns()
        due = started + int(done * 1e9 / rate)
        if due > now:
            pause_ns(min(due - now, _LONGEST_PAUSE))
            continue
        flags = 0
        if now - due > _SLEPT:
            started += now - due
            flags = OUTPUT_UNDERFLOW
        done += frames
        times[1] = 1e-9 * now
        times[2] = 1e-9 * (started + int(done * 1e9 / rate))
        call_back(callback, out, frames, times, flags, state)


@cache
def pacer() -> Any:
    """The loop, compiled; it holds no GIL."""
    return kept(lambda cached: njit(_SIGNATURE, nogil=True, error_model="numpy", cache=cached)(_pace))
