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

About a point of a disc sound goes round the edge the sooner the nearer that is. Against waves that are slower than
sound a disc is still, so that the force is a source on one face of a rigid disc and a sink on the other. By reciprocity
that radiates as the disc's edge diffracts: as sqrt(tanh(k d)) at a distance d from an edge that is nearly straight, and
at low frequencies with sqrt(1 - (r/a)^2), as sound does that flows through the disc (`round_field`).

That is all of what the disc's modes and its motion as a whole radiate together, before waves come back from the edge.
Its elastic modes alone, without the motion as a whole, give 12 dB less at half the radius and 17 dB less at 0.8 of it,
where k a = 0.93.

The sum errs by 2 dB in the middle of the band, whose ends are soft. But for discs the step from dipole to endless plate
is that of the sum, not of an exact solution; near the critical frequency an endless plate radiates more. The air's load
on the plate is left out, 1/(1 + 2 rho c/(i omega m)), which matters below rho c/(pi m): 380 Hz for a drum's head of
0.25 mm.
"""

import math

import numpy as np

from .acceleration import Click
from .air import DENSITY, SPEED

_DAMPING = 0.95  # ratio, of each click: nearly what one complex mode can be
_SPREAD = 1.932  # the integral of a click's response in phase over the log of frequency, for a peak of 1
_OCTAVES = 2.0  # that a click covers at most
_LEAST = 1.0  # octaves: narrower bands are left out
_HIGHEST = 20_000.0  # Hz: where the band ends at the latest
_FIRST, _RINGING = 2.8, 0.4  # of a disc's first click: k a at its natural frequency, and its damping ratio
_WIDEST = 3.3  # ratio of a disc's clicks, in frequency
_PLACES = 129  # at which the shares of a disc's clicks are known
_RADII = 0.0, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99, 0.995, 1.0
_SHARES = (
    (1.33, 1.28, 1.06, 0.86, 0.61, 0.34, 0.11, 0.03, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (1.17, 1.18, 1.23, 1.29, 1.34, 1.33, 1.19, 1.05, 0.84, 0.68, 0.57, 0.44, 0.35, 0.25, 0.18, 0.0),
    (0.92, 0.92, 0.89, 0.88, 0.87, 0.90, 0.93, 0.92, 0.86, 0.75, 0.63, 0.48, 0.38, 0.27, 0.19, 0.0),
)
"""Shares of a disc's first three clicks at `_RADII`, over its radius: least squares, in dB, against the exact radiation
of a point source on a rigid disc, from k a of 0.1 to 30 and half the critical frequency, which k a is 12 to 100. The
sum is within 4 dB at each frequency, 3 dB in each octave, and 1.4 dB rms."""


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


def round_field(
    areal: float, radius: float, whole: Click, critical: float, held: bool = False
) -> tuple[Click, ...]:  # fmt: skip
    """Return the clicks of a thin disc of a radius (m), by their shares along a diameter; others as of `near_field`.

    Beyond the first three, which the edge all around shapes, shares are those of a straight edge.
    """
    clicks = near_field(areal, whole, critical, held)
    reach = 2 * math.pi * min(critical, _HIGHEST) * radius / SPEED  # k a
    if len(clicks) < 1 or clicks == (whole,):
        return clicks
    count = math.ceil(math.log(reach / _FIRST) / math.log(_WIDEST) + 0.5)
    ratio = (reach / _FIRST) ** (1 / (count - 0.5))
    peak = DENSITY / (2 * math.pi * areal) * math.log(ratio) / _SPREAD
    away = np.abs(np.linspace(-1, 1, _PLACES))
    found = []
    for i in range(count):
        wave = _FIRST * ratio**i
        shares = np.interp(away, _RADII, _SHARES[i]) if i < len(_SHARES) else np.sqrt(np.tanh(wave * (1 - away)))
        omega, damping = wave * SPEED / radius, _DAMPING if i else _RINGING
        frequency = omega * math.sqrt(1 - damping**2) / (2 * math.pi)
        beyond = 1 if i < count - 1 else ratio / (ratio - 1)  # the last one with the ends of all that would follow
        strength = 2 * damping * omega * peak * beyond
        found.append(Click(frequency, damping * omega, strength, tuple(shares.tolist())))
    return tuple(found)
