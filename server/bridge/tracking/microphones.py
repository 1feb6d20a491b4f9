"""The gains of bodies at microphones, and which of them have changed.

A body at a distance r is heard by 1/r, times 1 - p + p cos(angle), the pattern p of the microphone to its direction.
"""

import math
from typing import Annotated

from ....dsp.native.jit import kernel, noinline_kernel
from ....dsp.native.typed import Record, View, View2D, dtype_of
from .state import BODIES, State

MICROPHONES = 64
_PLACED = 0.02  # s between two looks at where bodies are


class MicrophoneState(Record):
    """Microphones, and how they hear each body."""

    count: int
    nearest: float  # m: a body that is nearer is as loud as there
    step: float  # share by which a gain changes before it is sent
    position: Annotated[View2D[float], MICROPHONES, 3]
    direction: Annotated[View2D[float], MICROPHONES, 3]  # of length 1
    pattern: Annotated[View[float], MICROPHONES]
    # Of each body.
    told: Annotated[View2D[float], BODIES, MICROPHONES]
    now: Annotated[View2D[float], BODIES, MICROPHONES]
    loudest: Annotated[View[float], BODIES]  # the gain at the microphone that hears it best
    sound: int  # how many bodies sound
    found: int  # how many of them are to be sent
    next: float  # s: when to look again
    changed: Annotated[View[int], BODIES]  # numbers of bodies whose gains are to be sent


MICROPHONE_STATE = dtype_of(MicrophoneState)


@kernel
def gain_at(microphones: MicrophoneState, m: int, place: View[float]) -> float:
    """Return a microphone's gain for a sound's pressure at 1 m from a place (3,)."""
    square = along = 0.0
    for k in range(3):
        way = place[k] - microphones.position[m, k]
        square += way * way
        along += way * microphones.direction[m, k]
    distance = max(math.sqrt(square), microphones.nearest)
    pattern = microphones.pattern[m]
    return (1.0 - pattern + pattern * (along / distance)) / distance


@noinline_kernel
def find_gains(microphones: MicrophoneState, state: State) -> int:
    """Find the gains of all bodies, and list those that sound and whose gains have changed since; how many."""
    found = 0
    microphones.sound = 0
    for n in range(state.bodies):
        largest = 0.0
        for m in range(microphones.count):
            microphones.now[n, m] = gain_at(microphones, m, state.position[n])
            largest = max(largest, abs(microphones.now[n, m]))
        microphones.loudest[n] = largest
        if state.until[n] > state.time:
            microphones.sound += 1
            changed = False
            for m in range(microphones.count):
                if not abs(microphones.now[n, m] - microphones.told[n, m]) <= microphones.step * largest:
                    changed = True
            if changed:
                microphones.changed[found] = n
                found += 1
                for m in range(microphones.count):
                    microphones.told[n, m] = microphones.now[n, m]
    microphones.next = state.time + _PLACED if microphones.sound > 0 else math.inf
    microphones.found = found
    return found
