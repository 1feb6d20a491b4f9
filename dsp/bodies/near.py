"""What a thin body radiates from about the point that is struck, beside what its modes radiate.

A plate or membrane whose waves are slower than sound radiates from its edges alone, which its modes hold; and from
where a force F acts, around which nothing cancels. An endless one gives

    p = rho F/(2 pi m r)

in all directions of either side, m (kg/m^2) being its mass per area (M. Heckl 1959; L. Cremer, M. Heckl, B. Petersson,
Structure-Borne Sound, ch. 6; F. Fahy and P. Gardonio, Sound and Structural Vibration, ch. 3: the power rho F^2/(2 pi c
m^2) of a side). It is heard as soon as the blow falls, as loud from a heavy plate as from a stiff one, and holds most of
the attack of drums and cymbals below some kHz. Above the critical frequency modes radiate from all of the surface.

Where sound is longer than the body, it goes round the edge: what is left is the dipole of the body that moves as a
whole, which `acceleration` gives. So the whole is a band that begins as that dipole does and ends at the critical
frequency, made of a few clicks, each of which covers some two octaves of it.

How far the sum errs: 1 dB of ripple in the band. The step from dipole to endless plate is that of the sum, not of an
exact solution; near the critical frequency an endless plate radiates more. The air's load on the plate is left out,
1/(1 + 2 rho c/(i omega m)), which matters below rho c/(pi m): 380 Hz for a drum's head of 0.25 mm.
"""

import math

from .acceleration import Click
from .radiation.air import DENSITY, SPEED

_DAMPING = 0.95  # ratio, of each click: nearly what one complex mode can be
_SPREAD = 1.932  # the integral of a click's response in phase over the log of frequency, for a peak of 1
_RATIO = 4.0  # about, of a click's frequency to that of the one below
_HIGHEST = 20_000.0  # Hz: where the band ends that has no critical frequency
_EDGE = 0.5  # of the lowest click's frequency: where the band begins


def critical_frequency(areal: float, rigidity: float) -> float:
    """The frequency (Hz) at which waves in a plate of D (N m) and a mass per area (kg/m^2) are as fast as sound."""
    return SPEED**2 / (2 * math.pi) * math.sqrt(areal / rigidity)


def near_field(areal: float, whole: Click, critical: float = math.inf) -> tuple[Click, ...]:
    """The clicks of a thin body: of its mass per area (kg/m^2), up to its critical frequency (Hz).

    whole: the click of the body if it moved as a whole; all there is of one that is too small or too stiff for more.
    """
    flat = DENSITY / (2 * math.pi * areal)  # Pa/N
    natural = math.hypot(2 * math.pi * whole.frequency, whole.decay)
    rise = whole.strength / natural**2  # Pa/N per rad/s, at low frequencies
    lowest = 2 * _DAMPING * math.log(_RATIO) / _SPREAD / (1 - 1 / _RATIO) * flat / rise
    octaves = math.log2(2 * math.pi * min(critical, _HIGHEST) / (_EDGE * lowest))
    count = round(octaves / math.log2(_RATIO))
    if count < 1:
        return (whole,)
    lowest *= 1 - _RATIO**-count
    clicks = []
    for i in range(count):
        omega = lowest * _RATIO**i
        strength = 2 * _DAMPING * omega * flat * math.log(_RATIO) / _SPREAD
        clicks.append(Click(omega * math.sqrt(1 - _DAMPING**2) / (2 * math.pi), _DAMPING * omega, strength))
    return tuple(clicks)
