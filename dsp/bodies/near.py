"""Radiation of a thin body from about the point that is struck, beside that of its modes.

A plate or membrane whose waves are slower than sound radiates from its edges alone, which its modes hold; and from
where a force F acts, around which nothing cancels. An endless one gives

    p = rho F/(2 pi m r)

in all directions of either side, m (kg/m^2) being its mass per area (M. Heckl 1959; L. Cremer, M. Heckl, B. Petersson,
Structure-Borne Sound, ch. 6; F. Fahy and P. Gardonio, Sound and Structural Vibration, ch. 3: the power rho F^2/(2 pi c
m^2) of a side). It is heard as soon as the blow falls, however stiff the plate is, and holds most of the attack of
drums and cymbals below some kHz. Above the critical frequency modes radiate from all of the surface.

Where sound is longer than the body, it goes round the edge: what is left is the dipole of the body that moves as a
whole, which `acceleration` gives. So the whole is a band that begins as that dipole does and ends at the critical
frequency, made of a few clicks, each of which covers two octaves of it or less.

The sum errs by 2 dB in the middle of the band, whose ends are soft. The step from dipole to endless plate is that of
the sum, not of an exact solution; near the critical frequency an endless plate radiates more. The air's load on the
plate is left out, 1/(1 + 2 rho c/(i omega m)), which matters below rho c/(pi m): 380 Hz for a drum's head of 0.25 mm.
"""

import math

from .acceleration import Click
from .air import DENSITY, SPEED

_DAMPING = 0.95  # ratio, of each click: nearly what one complex mode can be
_SPREAD = 1.932  # the integral of a click's response in phase over the log of frequency, for a peak of 1
_OCTAVES = 2.0  # that a click covers at most
_LEAST = 1.0  # octaves: narrower bands are left out
_HIGHEST = 20_000.0  # Hz: where the band ends at the latest


def critical_frequency(areal: float, rigidity: float) -> float:
    """Return the frequency (Hz) at which waves in a plate of D (N m) and a mass per area (kg/m^2) are as fast as
    sound."""
    return SPEED**2 / (2 * math.pi) * math.sqrt(areal / rigidity)


def near_field(areal: float, whole: Click, critical: float, held: bool = False) -> tuple[Click, ...]:
    """Return the clicks of a thin body: of its mass per area (kg/m^2), up to its critical frequency (Hz).

    whole: the click of the body if it moved as a whole; that is all there is where the body is too small or too stiff
    for more, and nothing is if it is held.
    """
    flat = DENSITY / (2 * math.pi * areal)  # Pa/N
    natural = math.hypot(2 * math.pi * whole.frequency, whole.decay)
    rise = whole.strength / natural**2  # Pa/N per rad/s, at low frequencies
    octaves = math.log2(2 * math.pi * min(critical, _HIGHEST) * rise / flat)
    if octaves < _LEAST:
        return () if held else (whole,)
    count = math.ceil(octaves / _OCTAVES)
    ratio = 2 ** (octaves / count)
    peak = flat * math.log(ratio) / _SPREAD
    lowest = 2 * _DAMPING * peak / rise * (1 - ratio**-count) / (1 - 1 / ratio)
    clicks = []
    for omega in (lowest * ratio**i for i in range(count)):
        frequency = omega * math.sqrt(1 - _DAMPING**2) / (2 * math.pi)
        clicks.append(Click(frequency, _DAMPING * omega, 2 * _DAMPING * omega * peak))
    return tuple(clicks)
