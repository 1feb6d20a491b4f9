"""The air, and what it does to a mode."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..numerics.constants import AIR_DENSITY, SPEED_OF_SOUND
from .material import Array

DENSITY, SPEED = AIR_DENSITY, SPEED_OF_SOUND
IMPEDANCE = DENSITY * SPEED


class Load(NamedTuple):
    """The air's load on each of n modes of mass-normalised shapes.

    resistance R (n,) in 1/s: the mode radiates the power R q'^2/2 at a modal velocity of amplitude q' (sqrt(kg) m/s),
    and decays by R/2 for it. mass (n,): the mass of the air that moves with the body, as a share of the body's.
    """

    resistance: Array
    mass: Array


Complex = npt.NDArray[np.complex128]


def load(impedance: Complex, frequency: Array) -> Load:
    """Return the load of complex modal impedances Z (1/s) with time as exp(-i omega t): R = Re Z, mass -Im Z/omega.

    Rounding may leave less than nothing of what hardly radiates; then it does not.
    """
    omega = 2 * math.pi * frequency
    return Load(np.maximum(impedance.real, 0.0), -impedance.imag / omega)


def endless_plate(areal: float, ratio: Array) -> Array:
    """Return the resistance (1/s) of an endless plate (kg/m^2), both sides, in waves faster than sound.

    ratio: the square of their speed over that of sound; of a plate that bends, the frequency over the critical one.
    """
    resistance: Array = 2 * IMPEDANCE / (areal * np.sqrt(1 - 1 / ratio))
    return resistance


def plate_mass(areal: float, waves: Array, frequency: Array) -> Array:
    """Return the mass of the air on both sides of an endless plate (kg/m^2) in waves (rad/m), as a share of its own.

    Waves faster than sound carry none.
    """
    slow = np.maximum(1 - (wavenumber(frequency) / waves) ** 2, 0.0)
    mass: Array = np.where(slow > 0, 2 * DENSITY / (areal * waves * np.sqrt(np.maximum(slow, 0.1))), 0.0)
    return mass


def wavenumber(frequency: Array) -> Array:
    """Return k = omega/c (rad/m) of frequencies (Hz)."""
    k: Array = 2 * math.pi * frequency / SPEED
    return k
