"""An engine of one screen in the place of Carom's, which compiles in a second: it sounds by all that an export carries.

It takes commands at their samples, in the order in which they came. What a command makes it read of its memory and of
the command itself moves the sound from there on, by functions of the portable library and by sums over modes that
become vectors. So a word or a command that is missing, wrong or late, and a function or a sum that differs by a bit, is
heard.
"""

import math
from ctypes import c_int64, c_void_p

import numpy as np

from carom.dsp.engine.memory.commands import KIND_GESTURE, KIND_NEW, KIND_PANIC, Event
from carom.dsp.engine.memory.state import END_RESTED, ENDED, RING, STATE, Bank, State
from carom.dsp.native.jit import c_function, carray, kernel, noinline_kernel, simd_kernel
from carom.dsp.native.typed import View
from carom.dsp.runtime.admission import answer, judge_command
from carom.dsp.runtime.copies import copy_modes
from carom.dsp.runtime.signature import SIGNATURE
from carom.dsp.swarm.making import make_values

HEAVY = 50.0
"""kg: a gesture of such a mass finds no room, and is counted as left out."""


@simd_kernel
def _sum_of(bank: Bank, first: int, size: int) -> float:
    """Return a sum over an object's modes, in vectors."""
    total = 0.0
    for i in range(first, first + size):
        total += bank.weight[i] * bank.frequency[i] + bank.sigma[i]
    return total


@kernel
def _sum_of_pulses(values: View[float], first: int, size: int) -> float:
    """Return a sum over values of a table of pulses."""
    total = 0.0
    for i in range(first, first + size):
        total += values[i] * (i % 7)
    return total


@kernel
def _folded(x: float) -> float:
    """Return a number from -1 to 1 by all functions of the portable library."""
    u = x - math.floor(x)
    small = math.exp(-u) + np.exp2(u) + math.log(1.0 + u) + np.log2(1.0 + u) + math.log1p(u) + math.expm1(u)
    return math.sin(small + (1.5 + u) ** u + math.cos(u) + math.atan2(u, 0.3) + math.acos(u) + math.sinh(u))


@noinline_kernel
def _take(state: State, event: Event) -> float:
    """Return what a command adds to the sound, and end the gesture that it begins."""
    told = float(event.kind) + event.value
    if event.kind == KIND_NEW:
        told += _sum_of(state.bank, event.layout.first, event.layout.size) + event.settings.pan
    elif event.kind == KIND_GESTURE:
        told += event.values.velocity + event.values.stiffness + event.values.position
        if event.values.pulses > 0.0:
            table = state.pulses.tables[int(event.values.pulses) - 1]
            told += table.width[1] + _sum_of_pulses(state.pulses.values, table.first[3], table.block[3])
        state.ends.entries[state.ends.written[0] % ENDED, 0] = event.gesture
        state.ends.entries[state.ends.written[0] % ENDED, 1] = END_RESTED
        state.ends.written[0] += 1
        if event.values.mass >= HEAVY:
            state.stats.contacts_dropped += 1
            state.stats.nonlinear_dropped += 1
            state.stats.loudest_dropped = 0.5
    elif event.kind == KIND_PANIC:
        told += 0.5
    return told


@kernel
def _is_due(state: State, position: int) -> bool:
    """True if the next command is to be taken at a sample."""
    if state.ring.read[0] >= state.ring.written[0]:
        return False
    return state.ring.entries[state.ring.read[0] % RING].time <= position


@c_function(*SIGNATURE)
def callback(_input: int, output: int, frames: int, _times: int, _flags: int, userdata: int) -> int:
    """Fill `output` with `frames` frames, as Carom's callback does."""
    state: State = carray(userdata, (1,), STATE)[0]
    out: View[np.float32] = carray(output, (frames * state.output.channels,), np.float32)
    for n in range(frames * state.output.channels):
        while _is_due(state, state.position + n // state.output.channels):
            told = _take(state, state.ring.entries[state.ring.read[0] % RING])
            state.stats.load = _folded(state.stats.load + told)
            state.ring.read[0] += 1
        out[n] = state.stats.load * math.cos(0.01 * (state.position * state.output.channels + n))
    state.position += frames
    return 0


@c_function(None, c_void_p, c_int64)
def make_pulses(userdata: int, number: int) -> None:
    """Make the values of a table of pulses, as Carom's function does."""
    state: State = carray(userdata, (1,), STATE)[0]
    table = state.pulses.tables[number]
    make_values(table, state.pulses.values[table.first[0] : table.first[0] + table.size], state.pulses.work)


@c_function(c_int64, c_void_p, c_int64, c_int64, c_int64)
def ask(userdata: int, question: int, first: int, count: int) -> int:
    """Answer what a host asks, as Carom's function does."""
    return answer(userdata, question, first, count)


@c_function(c_int64, c_void_p, c_void_p, c_int64)
def judge(userdata: int, command: int, tables: int) -> int:
    """Return the word by which a command is none for the state in `userdata`, -1 if that may take it; tables: of
    pulses that were made."""
    return judge_command(userdata, command, tables)


@c_function(c_int64, c_void_p, c_void_p, c_int64, c_void_p)
def copy(userdata: int, command: int, to: int, changes: int) -> int:
    """Copy the modes of an object of the state in `userdata`: as Carom's function does."""
    return copy_modes(userdata, command, to, changes)
