"""Strikers from their blows: how stiff each is, and how several on one body differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..numerics.checks import Array
from .blow import DISSIPATION, EXPONENT, Blow, pulse
from .pulses import unit_duration, unit_time
from .sums import Complex

MASS, VELOCITY = 0.02, 1.0
"""Mass (kg) and velocity (m/s) of a striker of which nothing is known."""

_DURATIONS = np.geomspace(3e-5, 2e-2, 121)  # s
_TRUST = 0.1  # in what an attack says of its blow's duration, against a spectrum's squared error (nepers)


@dataclass(frozen=True)
class Striker:
    """The contact law of a striker: kg, N/m^a, s/m and a; duration (s) of its contact with a rigid wall at m/s."""

    mass: float
    stiffness: float
    dissipation: float
    exponent: float
    duration: float
    velocity: float


def striker_of(duration: float, mass: float = MASS, velocity: float = VELOCITY) -> Striker:
    """Return the striker of a mass (kg) and Hertz's exponent whose contact at a velocity (m/s) lasts so long (s)."""
    unit = unit_duration(DISSIPATION * velocity, EXPONENT) * unit_time(velocity, mass, 1.0, EXPONENT)
    stiffness = (unit / duration) ** (EXPONENT + 1)  # a contact's time goes as k^(-1/(a+1))
    return Striker(mass, stiffness, DISSIPATION, EXPONENT, duration, velocity)


def durations(amplitude: Sequence[Complex], poles: Complex, blows: Sequence[Blow]) -> tuple[Array, Array]:
    """Return the durations (s) of blows at one point of a body, and their strengths against the shortest, by how their
    spectra differ.

    amplitude: of the modes (k,) after each blow. poles (k,) in 1/s. The body's part is common to all amplitudes and
    drops out of their ratios. The shortest blow is taken as it was found in its attack; of the others their attacks say
    somewhat, as spectra alone can't distinguish a longer blow from a stronger one.
    """
    first = int(np.argmin([blow.duration for blow in blows]))
    drives = np.array([_spectrum(each, poles) for each in _DURATIONS])
    size = np.array([np.abs(each) for each in amplitude])
    found, strength = np.full(len(blows), blows[first].duration), np.ones(len(blows))
    own = _spectrum(blows[first].duration, poles)
    for number in range(len(blows)):
        if number != first:
            weight = np.minimum(size[number] / size[number].max(), size[first] / size[first].max())
            weight = weight / weight.sum()
            apart = np.log(size[number] / size[first]) - np.log(drives / own)
            mean = apart @ weight
            doubt = _TRUST * np.log(_DURATIONS / blows[number].duration) ** 2
            best = int(np.argmin((apart - mean[:, None]) ** 2 @ weight + doubt))
            found[number], strength[number] = _DURATIONS[best], np.exp(mean[best])
    return found, strength


def _spectrum(duration: float, poles: Complex) -> Array:
    """Return the response of modes to a blow of 1 N s; no more than 60 dB less than to an ideal one."""
    spectrum: Array = np.maximum(np.abs(pulse(duration).transform(poles)), 1e-3)
    return spectrum
