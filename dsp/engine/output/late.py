"""The late part of a room: sixteen delays that feed each other by a Hadamard matrix, and lose what T60 says.

The matrix is symmetric: a way through the delays and the same way backwards take as long, and add up where the signs of
its first and last delay, by which it is fed and by which a channel hears it, agree. With one sign for all delays they
did so in the first channel always, which was up to 3 dB too loud. The signs are a bent sequence (O. S. Rothaus, J.
Combinatorial Theory A 20, 1976): its product with each row of the matrix is as large, and no channel is louder.
"""

import math

from ...native.jit import noinline_kernel
from ...native.typed import View
from ...numerics.indices import index_of
from ...space.layouts import AMBISONICS, PAN
from ..memory.space_record import FRAMES, LATE_FRAMES, LATE_LINES, LINES, PATHS, WALLS_FADE, WALLS_TOLD
from ..memory.state import QUANTUM, State
from .fade import fade_length, left_of

_SILENCE = 1e-12  # energy of a quantum


@noinline_kernel
def furnish(state: State, told: View[float]) -> None:
    """Give space its walls and its late part: walls, corners (m), amplitude reflected, T60 (s; 0: none), that of high
    frequencies, and the amplitude of the late part at its beginning.

    Where something sounds, what comes by the old ones fades in this quantum, and what comes by the new in the next one.
    """
    space = state.surroundings
    for k in range(WALLS_TOLD):
        space.walls_told[k] = told[k]
    # Something may be on its way, by which the ear would hear that walls change.
    heard = space.late.on == 1 and space.late.energy > _SILENCE
    for n in range(LINES):
        heard |= space.lines[n].used == 1 and space.lines[n].last > state.position - FRAMES
    if space.on == 1 and heard:
        space.walls_change = WALLS_FADE
    else:
        let_walls_come(state)


@noinline_kernel
def let_walls_come(state: State) -> None:
    """Give space the walls and the late part that were set."""
    space = state.surroundings
    told = space.walls_told
    space.walls = int(told[0])
    for i in range(3):
        space.low[i], space.high[i] = told[1 + i], told[4 + i]
    space.reflected = told[7]
    for n in range(LINES):
        for p in range(1, PATHS):
            space.lines[n].paths[p].known = 0
    late, rate = space.late, state.rate
    late.on = int(told[8] > 0.0)
    late.energy = 0.0
    if late.on == 0:
        return
    total = 0.0
    for k in range(LATE_LINES):
        length = told[11] * rate * 0.55 * 3.1 ** (k / (LATE_LINES - 1))
        late.lengths[k] = max(2 * index_of(0.5 * length, LATE_FRAMES // 2) + 1, 17)
        total += late.lengths[k]
        seconds = late.lengths[k] / rate
        low, high = 10.0 ** (-3.0 * seconds / told[8]), 10.0 ** (-3.0 * seconds / told[9])
        share = min(high / low, 1.0)
        late.pole[k] = (1.0 - share) / (1.0 + share)
        late.feedback[k] = low
        late.memory[k] = 0.0
        for n in range(LATE_FRAMES):
            late.sound[k, n] = 0.0
    late.input = told[10] * math.sqrt(total / rate) / LATE_LINES
    late.at = 0


@noinline_kernel
def hear_late(state: State) -> None:
    """Add the late part of the room to every channel, and move it on by a quantum."""
    space, output = state.surroundings, state.output
    late, lines = space.late, space.weights
    channels, energy = output.channels, 0.0
    scale = 1.0 / math.sqrt(channels) if space.layout == PAN and channels > 2 else 1.0
    for n in range(QUANTUM):
        left = left_of(state.rate, space.faded + n + 1) if space.fading == 1 else 1.0
        if space.walls_change == WALLS_FADE:
            left *= 1.0 - (n + 1) / QUANTUM
        for k in range(LATE_LINES):
            taken = late.sound[k, (late.at - late.lengths[k]) % LATE_FRAMES]
            late.memory[k] = taken + late.pole[k] * (late.memory[k] - taken)
            lines[k] = late.feedback[k] * late.memory[k]
            energy += lines[k] * lines[k]
        # Exchange what is in the lines by a Hadamard matrix, which keeps its energy.
        step = 1
        while step < LATE_LINES:
            for k in range(LATE_LINES):
                if k & step == 0:
                    a, b = lines[k], lines[k + step]
                    lines[k], lines[k + step] = a + b, a - b
            step *= 2
        for k in range(LATE_LINES):
            lines[k] /= 4.0
        for channel in range(channels):
            order = int(math.sqrt(channel + 0.5)) if space.layout == AMBISONICS else 0
            total = scale * left / math.sqrt(2.0 * order + 1.0) * lines[channel % LATE_LINES]
            output.mix[channel, n] += math.sqrt(1.0 * LATE_LINES) * total
        for k in range(LATE_LINES):
            late.sound[k, late.at % LATE_FRAMES] = (
                lines[k] + (1.0 - 2.0 * (k & k >> 1 & 1 ^ k >> 2 & k >> 3 & 1)) * late.input * late.fed[n]
            )
        late.at += 1
    late.energy = energy
    if energy > _SILENCE:
        state.stats.sounding += 1
    if space.fading == 1 and space.faded + QUANTUM >= fade_length(state.rate):
        for k in range(LATE_LINES):
            late.memory[k] = 0.0
            for n in range(LATE_FRAMES):
                late.sound[k, n] = 0.0
