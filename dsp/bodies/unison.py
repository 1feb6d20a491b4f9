"""Unisons: strings in twos and threes that one hammer strikes and one bridge joins.

Each wire's partial loses what it puts into the board, and moves the others by it (G. Weinreich, "Coupled piano
strings", J. Acoust. Soc. Am. 62, 1977). With amplitudes a (W,) of W wires at omega_k, which lose
sigma by themselves and the amplitude b by the bridge's conductance,

    a_k' = (j omega_k - sigma) a_k - b sum_l a_l.

Struck alike, wires in tune die W times as fast as one does. What their mistuning turns out of phase stays, and is heard
after: the sound falls in two stages, or beats. The board's reactance is left out, as the mean of a plate's is 0.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .air import IMPEDANCE
from .material import Array
from .modes import MOST_MODES, Modes, ascending

_LEAST_FELT = 0.02  # of a partial: what is felt of each of its modes

Complex = npt.NDArray[np.complex128]


class Unison(NamedTuple):
    """Modes of the wires of each partial, (n, W): frequency (Hz), decay (1/s), and the part of each in the force at the
    bridge once a blow has moved all wires alike; 1 in all for each partial.

    The parts are complex where the wires beat.
    """

    frequency: Array
    decay: Array
    part: Complex


def unison(frequency: Array, decay: Array, passed_on: Array, wires: int, mistuning: float) -> Unison:
    """Return the modes of wires whose partials (n,) have a frequency (Hz) and a decay (1/s) each, without the bridge.

    passed_on (n,): the power that a wire alone puts into the board, of its energy per second (1/s). mistuning: from the
    lowest to the highest wire (cents).
    """
    apart = np.linspace(-0.5, 0.5, wires) * mistuning
    omega = 2 * np.pi * frequency[:, None] * 2 ** (apart / 1200)
    alone = (1j * omega - decay[:, None])[:, :, None] * np.eye(wires)
    s, shapes = np.linalg.eig(alone - passed_on[:, None, None] / 2)
    part: Complex = shapes.sum(axis=1) ** 2 / (shapes**2).sum(axis=1) / wires
    return Unison(np.abs(s) / (2 * np.pi), -s.real, part)


def in_unison(modes: Modes, own: Array, passed_on: Array, wires: int, mistuning: float, top: float) -> Modes:
    """Return the modes of several strings like one whose modes are given, (n,), up to `top` (Hz).

    own: the decay of the string's modes without the bridge (1/s). A hammer meets all wires, so that each mode's part is
    felt and heard; one that cancels others is felt as little as can be. No mode radiates more than it loses.
    """
    found = unison(modes.frequency, own, passed_on, wires, mistuning)
    felt = np.maximum(found.part.real, _LEAST_FELT)
    felt = np.sqrt(felt / felt.sum(axis=1, keepdims=True) / wires)
    heard = np.where(found.part.real < 0, -1.0, 1.0) * np.abs(found.part) / felt
    pressure, most = modes.pressure[0][:, None] * heard, np.sqrt(IMPEDANCE * found.decay / (2 * math.pi))
    pressure = np.clip(pressure, -most, most)
    of = np.repeat(np.arange(modes.frequency.size), wires)
    order = ascending(found.frequency.ravel())
    order = order[found.frequency.ravel()[order] <= top][:MOST_MODES]
    return replace(
        modes,
        frequency=found.frequency.ravel()[order],
        decay=found.decay.ravel()[order],
        strike=modes.strike[:, of[order]] * felt.ravel()[order],
        pressure=np.tile(pressure.ravel()[order], (2, 1)),
        mass=wires * modes.mass,
    )
