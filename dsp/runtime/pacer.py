"""The engine by the clock, where there is no device: a compiled loop that needs no Python while it runs.

Anything that holds Python's interpreter for a while (a sort, the garbage collector) would stop a loop in Python, and
the sound.
"""

from ctypes import c_double, c_int64, c_void_p

import numpy as np
from numpy.typing import NDArray

from ..native.atomics import load_acquire
from ..native.jit import c_function, carray
from ..native.system import call_back, monotonic_ns, pause_ns
from ..native.typed import View, View2D
from .signature import OUTPUT_UNDERFLOW, PACED

_LONGEST_PAUSE = 20_000_000  # ns: the loop looks at least this often whether to stop
_SLEPT = 1_000_000_000  # ns behind after which the machine is thought to have slept: no rush to catch up


@c_function(None, c_void_p, c_int64, c_int64, c_double, c_void_p, c_int64, c_int64, c_void_p)
def pace(
    running: int, callback: int, state: int, rate: float, out: int, frames: int, channels: int, times: int
) -> None:
    """Compute blocks of so many frames as their time comes, while the int64 at `running` is not 0.

    callback, state: addresses. rate: Hz. out: of float32 (frames, channels). times: of float64 (3,), which the
    callback reads.
    """
    goes_on: View[int] = carray(running, (1,), np.int64)
    clock: View[float] = carray(times, (3,), np.float64)
    block: View2D[float] = carray(out, (frames, channels), np.float32)
    started = monotonic_ns()
    done = 0
    while load_acquire(goes_on, 0) != 0:
        now = monotonic_ns()
        due = started + int(done * 1e9 / rate)
        if due > now:
            pause_ns(min(due - now, _LONGEST_PAUSE))
            continue
        flags = PACED
        if now - due > _SLEPT:
            started += now - due
            due = now
            flags |= OUTPUT_UNDERFLOW
        done += frames
        clock[0], clock[1] = 1e-9 * due, 1e-9 * now
        clock[2] = 1e-9 * max(now, started + int(done * 1e9 / rate))  # a late block is heard at once, not in the past
        call_back(callback, block, frames, clock, flags, state)


def keep_pace(
    running: NDArray[np.int64],
    callback: int,
    state: int,
    rate: float,
    out: NDArray[np.float32],
    times: NDArray[np.float64],
) -> None:
    """Run `pace` with arrays, which stay for as long as it runs. running: (1,). out: (frames, channels). times:
    (3,)."""
    frames, channels = out.shape
    pace(running.ctypes.data, callback, state, rate, out.ctypes.data, frames, channels, times.ctypes.data)
