"""Tails: sound of modes that have left the spectral bank, taken out of the block that was laid out with them.

A block is finished when it begins. Modes that leave it are rung a second time, one sample at a time, to its end, and
subtracted.
"""

from ...native.jit import kernel
from ...native.typed import View2D
from ...resonator.bank import Modes, ring
from ..memory.capacity import OBJECTS
from ..memory.records import TAIL_MODES
from ..memory.state import QUANTUM, Object, State
from ..output.mix import sides_of


@kernel
def begin_tail(state: State, obj: Object, end: int) -> None:
    """Take an object's modes, as they are now, out of a block that ends at a sample."""
    tails, bank = state.tails, state.bank
    if tails.count == 0 or tails.top + obj.live > TAIL_MODES:
        tails.top = 0
    entry = tails.entries[(tails.first + tails.count) % OBJECTS]
    tails.count += 1
    entry.first, entry.size, entry.end = tails.top, obj.live, end
    tails.top += obj.live
    for side in range(sides_of(state)):
        entry.gain[side] = obj.place.gain[side]
    for i in range(obj.live):
        at, mode = entry.first + i, obj.first + i
        tails.y1[at], tails.y2[at] = bank.y1[mode], bank.y2[mode]
        tails.a1[at], tails.a2[at] = bank.a1[mode], bank.a2[mode]
        tails.balance[at] = bank.balance[mode]


@kernel
def ring_tails(state: State, out: View2D[float]) -> None:
    """Subtract a quantum of all tails from out (2, QUANTUM); forget those that are over."""
    tails, voice = state.tails, state.scratch.voices[0]
    for k in range(tails.count):
        entry = tails.entries[(tails.first + k) % OBJECTS]
        if entry.end <= state.position:
            continue
        first, last = entry.first, entry.first + entry.size
        modes = Modes(
            tails.y1[first:last], tails.y2[first:last], tails.a1[first:last], tails.a2[first:last],
            tails.balance[first:last], tails.y1[first:last],
        )  # fmt: skip
        ring(modes, voice, 0, QUANTUM)
        for side in range(sides_of(state)):
            for n in range(QUANTUM):
                out[side, n] -= entry.gain[side] * voice[side, n]
    while tails.count > 0 and tails.entries[tails.first % OBJECTS].end <= state.position + QUANTUM:
        tails.first += 1
        tails.count -= 1
