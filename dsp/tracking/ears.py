"""Where bodies are heard: their gains at microphones, and which of those have changed.

A body at a distance r is heard by 1/r, times 1 - p + p cos(angle), the pattern p of the microphone to its direction.
"""

import math

import numpy as np

from ..native.jit import kernel
from .state import BODIES

MICROPHONES = 64

EARS = np.dtype(
    [
        ("count", np.int64),
        ("nearest", np.float64),  # m: a body that is nearer is as loud as there
        ("step", np.float64),  # share by which a gain changes before it is told
        ("position", np.float64, (MICROPHONES, 3)),
        ("direction", np.float64, (MICROPHONES, 3)),  # of length 1
        ("pattern", np.float64, MICROPHONES),
        # Of each body.
        ("until", np.float64, BODIES),  # s: up to when it sounds
        ("told", np.float64, (BODIES, MICROPHONES)),
        ("now", np.float64, (BODIES, MICROPHONES)),
        ("loudest", np.float64, BODIES),  # the gain at the microphone that hears it best
        ("sound", np.int64),  # how many bodies sound
        ("changed", np.int64, BODIES),  # numbers of bodies whose gains are to be told
    ],
    align=True,
)
"""Microphones, and how they hear each body."""


@kernel
def find_gains(ears, state):
    """Find the gains of all bodies, and list those that sound and whose gains are others than those told; how many."""
    found = 0
    ears.sound = 0
    for n in range(state.bodies):
        largest = 0.0
        for m in range(ears.count):
            square = along = 0.0
            for k in range(3):
                way = state.position[n, k] - ears.position[m, k]
                square += way * way
                along += way * ears.direction[m, k]
            distance = max(math.sqrt(square), ears.nearest)
            pattern = ears.pattern[m]
            ears.now[n, m] = (1.0 - pattern + pattern * (along / distance)) / distance
            largest = max(largest, abs(ears.now[n, m]))
        ears.loudest[n] = largest
        if ears.until[n] > state.time:
            ears.sound += 1
            changed = False
            for m in range(ears.count):
                if not abs(ears.now[n, m] - ears.told[n, m]) <= ears.step * largest:
                    changed = True
            if changed:
                ears.changed[found] = n
                found += 1
                for m in range(ears.count):
                    ears.told[n, m] = ears.now[n, m]
    return found
