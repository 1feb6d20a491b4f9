"""The sound of a striker: its click, modes of its own, and a second pulse where its wall snaps through."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .acceleration import Click
from .air import IMPEDANCE

MOST_MODES = 12
"""Most modes of a striker, besides its click."""


class Ringing(NamedTuple):
    """Modes of a striker, n each: frequencies (Hz), decay rates (1/s) and weights (Pa per N s), as heard at 1 m.

    mobility (1/kg): the sum of 1/modal mass, twice the energy (J) that a short blow of 1 N s gives to them.
    """

    frequency: tuple[float, ...]
    decay: tuple[float, ...]
    weight: tuple[float, ...]
    mobility: float


class Snap(NamedTuple):
    """A second pulse into a striker's modes: a wall that was pushed in snaps back.

    These modes then ring by it alone: their give is the contact's own, whose force they follow without a sound. Its
    momentum is `momentum` (N s) at 1 m/s times velocity to the power `exponent`, and scatters by `scatter` (dB,
    standard deviation); it comes `delay` (s) after the contact's beginning.
    """

    momentum: float
    exponent: float
    scatter: float
    delay: float


class StrikerSound(NamedTuple):
    """The sound of a striker of a mass (kg): what its contact's force does to it, at 1 m.

    radius (m): of the body that clicks.
    """

    mass: float
    click: Click | None = None
    radius: float = 1.0
    ringing: Ringing | None = None
    snap: Snap | None = None


def magnified(sound: StrikerSound, ratio: float) -> StrikerSound:
    """Return the sound of a striker that is larger by a ratio, in all its sizes alike; without a second pulse.

    Frequencies and rates of decay go as 1/ratio, those of radiation too, and the pressure per N s as 1/ratio^2.
    """
    click, own, less = sound.click, sound.ringing, ratio**-2
    if click:
        click = Click(click.frequency / ratio, click.decay / ratio, click.strength * less)
    if own:
        frequency, decay = (tuple(each / ratio for each in column) for column in (own.frequency, own.decay))
        own = Ringing(frequency, decay, tuple(each * less for each in own.weight), own.mobility * less / ratio)
    return StrikerSound(sound.mass * ratio**3, click, sound.radius * ratio, own)


def ringing(
    frequency: Sequence[float],
    t60: float | Sequence[float],
    modal_mass: float | Sequence[float],
    radiated: float | Sequence[float] = 1.0,
) -> Ringing:
    """Return the modes by frequency (Hz), decay time (s), modal mass (kg) where they are struck, and radiated share of
    their loss.

    One value holds for all. ValueError names what does not fit.

    A mode that decays by sigma radiates the power 2 sigma `radiated` q'^2/2: G = sqrt(rho c 2 sigma radiated/(4 pi)).
    """
    frequencies = np.asarray(frequency, np.float64)
    if frequencies.size > MOST_MODES:
        raise ValueError(f"frequency: {frequencies.size} modes: expected at most {MOST_MODES}")
    columns = {"t60": t60, "modal_mass": modal_mass, "radiated": radiated}
    for name, column in columns.items():
        if np.size(column) not in (1, frequencies.size):
            raise ValueError(f"{name}: {np.size(column)} values: expected {frequencies.size}, or one")
    t60s, masses, shares = (np.broadcast_to(column, frequencies.shape) for column in columns.values())
    decay = math.log(1000) / t60s
    weight = np.sqrt(IMPEDANCE * decay * shares / (2 * math.pi * masses))
    listed = [tuple(map(float, each)) for each in (frequencies, decay, weight)]
    return Ringing(listed[0], listed[1], listed[2], float((1 / masses).sum()))
