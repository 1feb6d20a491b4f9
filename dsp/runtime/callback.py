"""The engine as a C function with PortAudio's callback signature: the one compiled thing that makes sound.

Real time hands its address to PortAudio; offline and clock-driven rendering call the same code, so their bits agree.
"""

from ctypes import c_int64, c_void_p

import numpy as np

from ..engine.events.queue import look_again
from ..engine.memory.clock import lock
from ..engine.memory.state import QUANTUM, STATE, State
from ..engine.process import process
from ..native.jit import c_function, carray, kernel
from ..native.system import flush_denormals, monotonic_ns, restore_denormals, thread_id
from ..native.typed import View
from ..swarm.making import make_values
from .admission import answer, judge_command
from .copies import copy_modes
from .signature import C_LONG, OUTPUT_UNDERFLOW, PACED, SIGNATURE

_DUE, _NOW, _HEARD = 0, 1, 2  # times, s: by PACED alone; then PortAudio's, of the callback and of its sound
_LATELY = 0.1  # s
_HOLE, _HOLE_UNTOLD = 50e6, 1e9
"""ns by which a callback comes late after a hole in the sound: where the device says that it ran dry, and where it does
not: JACK does not report it, but no device holds as much sound as that."""


@c_function(*SIGNATURE)
def callback(_input: int, output: int, frames: int, times: int, flags: int, userdata: int) -> int:
    """Fill `output` with `frames` frames, channel by channel, from the state in `userdata`: a PaStreamCallback."""
    entered = monotonic_ns()
    frames = int(np.int64(frames) & C_LONG)
    mode = flush_denormals()
    state: State = carray(userdata, (1,), STATE)[0]
    if state.thread == 0:
        state.thread = thread_id()
    underflow = flags & OUTPUT_UNDERFLOW != 0
    state.stats.underflows += underflow
    first = state.position - QUANTUM + state.output.consumed
    told: View[float] = carray(times, (3,), np.float64)
    due = int(1e9 * told[_DUE]) if flags & PACED != 0 else entered
    if lock(state.clock, state.rate, due, first, frames, underflow):
        look_again(state.queue, state.position)
        _count_hole(state, first, underflow)
    channels = state.output.channels + state.output.sensors
    process(state, carray(output, (frames, channels), np.float32), frames)
    restore_denormals(mode)
    load = (monotonic_ns() - entered) * 1e-9 * state.rate / max(frames, 1)
    share = min(1.0, frames / state.rate)
    state.stats.latency_measured += (told[_HEARD] - told[_NOW] - state.stats.latency_measured) * share
    state.stats.load += (load - state.stats.load) * share
    state.stats.load_now += (load - state.stats.load_now) * min(1.0, share / _LATELY)
    state.stats.load_peak = max(load, state.stats.load_peak * (1.0 - share))
    state.stats.overruns += load > 1.0
    state.stats.callbacks += 1
    return 0


@kernel
def _count_hole(state: State, first: int, underflow: bool) -> None:
    """Count a hole in the sound before a frame, if the process or its device stood still there."""
    if state.clock.late > (_HOLE if underflow else _HOLE_UNTOLD):
        state.stats.hole_at = first
        state.stats.hole_last = 1e-9 * state.clock.late
        state.stats.holes += 1


@c_function(None, c_void_p, c_int64)
def make_pulses(userdata: int, number: int) -> None:
    """Make the values of a table of pulses of the state in `userdata`, for an engine without Python: number 0 is the
    first one."""
    state: State = carray(userdata, (1,), STATE)[0]
    table = state.pulses.tables[number]
    make_values(table, state.pulses.values[table.first[0] : table.first[0] + table.size], state.pulses.work)


@c_function(c_int64, c_void_p, c_int64, c_int64, c_int64)
def ask(userdata: int, question: int, first: int, count: int) -> int:
    """Answer what a host without Python asks of the state in `userdata`: see `admission.py`."""
    return answer(userdata, question, first, count)


@c_function(c_int64, c_void_p, c_void_p, c_int64)
def judge(userdata: int, command: int, tables: int) -> int:
    """Return the word by which a command is none for the state in `userdata`, -1 if that may take it; tables: of
    pulses that were made."""
    return judge_command(userdata, command, tables)


@c_function(c_int64, c_void_p, c_void_p, c_int64, c_void_p)
def copy(userdata: int, command: int, to: int, changes: int) -> int:
    """Copy the modes of an object of the state in `userdata`: see `copies.py`."""
    return copy_modes(userdata, command, to, changes)
