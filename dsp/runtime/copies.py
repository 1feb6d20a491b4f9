"""Objects that are made like others, for hosts without Python: of another size or material, by similarity.

An object shares the table of shapes of the one that it is like, and has modes of its own. The laws are those of the
macros (`bodies/macros.py`): in another size s frequencies go with 1/s, shapes with s^-3/2, pressures with s^-1/2; in
another material they go with the wave speed and the density, and the material takes what it takes at the new
frequencies.
"""

import math

import numpy as np

from ..engine.memory.capacity import MODES
from ..engine.memory.commands import COMMAND, KIND_NEW, Event
from ..engine.memory.state import STATE, State
from ..native.jit import carray, kernel, noinline_kernel
from ..native.typed import Items, View
from ..numerics.constants import LOSS_FACTOR_AT

SIZE, SPEED, DENSITY, OWN, OTHER = 0, 1, 2, 3, 7
"""Places in a row of changes: octaves of the size, of the wave speed, of the density; then the losses of both
materials: alpha, beta, loss factor and exponent."""
CHANGES = OTHER + 4
_MOST = 10.0  # octaves


@noinline_kernel
def copy_modes(memory: int, command: int, to: int, changes: int) -> int:
    """Copy the modes of the object that a command makes to others, and have the command make an object of these.

    memory: address of the engine's state; command: of a NEW; changes: of CHANGES numbers. Returns the first mode after
    these, or 0 where there is no room for them or something cannot be.
    """
    state: State = carray(memory, (1,), STATE)[0]
    event: Event = carray(command, (1,), COMMAND)[0]
    change: View[float] = carray(changes, (CHANGES,), np.float64)
    layout = event.layout
    first, size = layout.first, layout.size
    fits = event.kind == KIND_NEW and first >= 0 and size > 0 and first + size <= to and to + size <= MODES
    for k in range(CHANGES):
        fits = fits and abs(change[k]) < 1e12
    for k in range(OWN):
        fits = fits and abs(change[k]) <= _MOST
    if not fits:
        return 0
    bank, larger, faster, denser = state.bank, change[SIZE], change[SPEED], change[DENSITY]
    pitch, click = 2.0 ** (faster - larger), 2.0 ** (1.5 * larger - 0.5 * denser)
    sound = 2.0 ** (faster - 0.5 * denser - 0.5 * larger)
    for i in range(size):
        frequency, sigma, weight = bank.frequency[first + i], bank.sigma[first + i], bank.weight[first + i]
        if layout.bent <= i < layout.unheard:
            weight *= click
        else:
            sigma = _lost(frequency, sigma, pitch, 2.0 ** (faster - denser - larger), change)
            frequency *= pitch
            weight *= sound
        bank.frequency[to + i], bank.sigma[to + i], bank.weight[to + i] = frequency, sigma, weight
        bank.balance[to + i] = bank.balance[first + i]
    layout.first, layout.sheet, layout.lighter = to, -1, -1.5 * larger - 0.5 * denser
    return to + size


@kernel
def _lost(frequency: float, sigma: float, pitch: float, thinner: float, change: View[float]) -> float:
    """Return the decay (1/s) of a mode: what its material takes, and the rest."""
    own = _taken(frequency, change[OWN : OWN + 4])
    if (pitch == 1.0 and thinner == 1.0) or not own > 0.0:
        return sigma * thinner
    taken = min(own, sigma)
    return (sigma - taken) * thinner + taken * _taken(frequency * pitch, change[OTHER : OTHER + 4]) / own


@kernel
def _taken(frequency: float, material: Items[float]) -> float:
    """Return what a material takes of a mode (1/s), as `Material.decay` has it."""
    turns = 2.0 * math.pi * frequency
    rubbed = math.pi * material[2] * LOSS_FACTOR_AT * (frequency / LOSS_FACTOR_AT) ** material[3]
    taken: float = rubbed + 0.5 * (material[0] + material[1] * turns * turns)
    return taken
