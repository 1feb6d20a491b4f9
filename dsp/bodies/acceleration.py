"""Acceleration noise: the click of a body that a blow moves as a whole.

A rigid body that is accelerated is a dipole. Its far pressure at 1 m, rms over directions, follows the acceleration A
through one damped resonance,

    p(s) = g A(s) s/(s^2 + 2 z w0 s + w0^2),

which has the body's right limits, whatever its shape. At low frequencies p = rho Q s A/(4 pi sqrt(3) c), where Q (m^3)
is the volume of the air that it displaces and takes along (its added mass over rho); at high ones
p = rho c sqrt(S/(4 pi)) A/s, where S (m^2) is the integral of cos^2 over its surface, cos being the share of the motion
along the normal. So g = rho c sqrt(S/(4 pi)) and w0^2 = c^2 sqrt(12 pi S)/Q; only the damping ratio z is the shape's.

For a sphere this is exact: Q = 2 pi a^3, S = 4 pi a^2/3, z = 1/sqrt(2) give p = rho a^2/sqrt(3) A s'/(s'^2 + 2 s' + 2),
s' = s a/c (G. H. Koss and R. J. Alfredson, J. Sound Vib. 27, 1973: exp(-c t/a) (cos(c t/a) - sin(c t/a))). The others'
z are fitted to exact solutions in air of thin discs, rectangles and closed cylinders; each function states its error.
The equivalent body by volume and added mass is the idea of J. Chadwick, C. Zheng and D. James (ACM Trans. Graph. 31,
2012).

A click is left out of what loses energy: the air takes less than 1e-3 of what a body heavier than air is given. Nor is
turning heard, which a blow beside the centre of mass adds.
"""

import math
from typing import NamedTuple

import numpy as np

from .air import IMPEDANCE, SPEED
from .material import Array

_SPHERE = math.sqrt(0.5)  # damping ratio
_DISC = 0.466
_RING = 0.85
_MOST_DAMPED = 0.95  # what one complex mode can be: beyond 1 there are two real poles
_SPHERE_ADDED = 0.5  # added mass over displaced
_THICK = 0.45  # by which a square section's added mass is more than a thin strip's


class Click(NamedTuple):
    """A body's sound as it is accelerated: what 1 N s at t = 0 gives at 1 m, rms over directions, is

    p(t) = strength exp(-decay t) (cos(omega t) - decay/omega sin(omega t)), omega = 2 pi frequency.
    """

    frequency: float
    """Hz"""
    decay: float
    """1/s"""
    strength: float
    """Pa per N s"""
    along: tuple[float, ...] = (1.0,)
    """Its shares at equally spaced positions along the strike path; one: it is alike everywhere."""

    def rows(self, count: int) -> Array:
        """Return its shares at so many equally spaced positions along the strike path."""
        return np.interp(np.linspace(0, 1, count), np.linspace(0, 1, len(self.along)), self.along)


def sphere(mass: float, radius: float) -> Click:
    """Return the click of a sphere, exact; mass in kg, radius in m."""
    volume = 4 / 3 * math.pi * radius**3
    return _click(mass, (1 + _SPHERE_ADDED) * volume, 4 / 3 * math.pi * radius**2, _SPHERE)


def disc(mass: float, radius: float, thickness: float = 0.0) -> Click:
    """Return the click of a free disc along its axis; lengths in m.

    Q = 8/3 a^3 d + pi a^2 h with d for its thickness (`_thick`), S = 2 pi a^2. Of a thin one within 2 dB at every
    frequency, 0.6 dB rms.
    """
    volume = math.pi * radius**2 * thickness
    added = 8 / 3 * radius**3 * _thick(thickness, 2 * radius)
    return _click(mass, added + volume, 2 * math.pi * radius**2, _DISC)


def rectangle(mass: float, length: float, width: float, volume: float) -> Click:
    """Return the click of a free plate or bar along its normal; lengths in m, volume (m^3) of its matter.

    The added volume is pi/4 w^2 l/(1 + 0.726 (w/l)^1.15) for sides l >= w, within 1 % of thin plates' (M. K. Meyerhoff,
    J. Ship Res. 14, 1970), times a factor for the thickness (`_thick`). Within 2 dB of thin plates up to l = 10 w, 0.9
    dB rms; within 5 dB of longer ones. Of boxes as thick as half their width or more, up to l = 4 w, within 1.5 dB of
    boundary elements.
    """
    long, short = max(length, width), min(length, width)
    slenderness, thickness = long / short, volume / (length * width)
    added = math.pi / 4 * short**2 * long / (1 + 0.726 * slenderness**-1.15) * _thick(thickness, short)
    damping = math.sqrt(0.185 + 0.0434 * slenderness + 0.23 * (thickness**2 / (length * width)) ** 0.7)
    return _click(mass, added + volume, 2 * length * width, damping)


def cylinder(mass: float, length: float, diameter: float) -> Click:
    """Return the click of a free rod or closed tube across its axis; lengths in m.

    Q = 2 pi a^2 l, S = pi a l. Within 1 dB up to l = 10 diameters, 5 dB of longer ones, its ends left out.
    """
    area = math.pi / 4 * diameter**2
    damping = math.sqrt(0.41 + 0.0387 * length / diameter)
    return _click(mass, 2 * area * length, math.pi / 2 * diameter * length, damping)


def ring(mass: float, radius: float, length: float, volume: float) -> Click:
    """Return the click of an open ring or tube across its axis; lengths in m, volume (m^3) of its matter.

    The added volume goes from that of a narrow strip bent round, pi^2 l^2 a/4, to that of a long tube, 2 pi a^2 l, in
    which air moves along; within 5 % in between. Within 4 dB rms: where the wavelength is about the circumference the
    sides cancel, which one resonance can't say.
    """
    strip, tube = math.pi**2 / 4 * length**2 * radius, 2 * math.pi * radius**2 * length
    added = (strip**-1.6 + tube**-1.6) ** (-1 / 1.6)
    return _click(mass, added + volume, 2 * math.pi * radius * length, _RING)


def body(mass: float, volume: float, area: float) -> Click:
    """Return the click of a free body of any shape, the mean over the directions that it may be struck in.

    volume (m^3) of its matter, area (m^2) of its surface. The added volume is 8/9 a^3 with a^2 = area/(2 pi): exact for
    thin discs (their mean over directions), and for a sphere Q is 6 % high. S is a third of the area, as of all closed
    bodies in the mean.
    """
    added = 8 / 9 * (area / (2 * math.pi)) ** 1.5
    return _click(mass, added + volume, area / 3, _SPHERE)


def _thick(thickness: float, width: float) -> float:
    """Return how many times the added mass of a thin plate one of a thickness has, that moves along it.

    1 + 0.45 sqrt(h/w), w the shorter side: within 4 % of endless bars (1.14, 1.21, 1.36, 1.51 and 1.70 at h/w = 0.1,
    0.2, 0.5, 1 and 2: C. E. Brennen, A review of added mass and fluid inertial forces, 1982), and of cubes (1.41 by
    boundary elements, 1.49 by DNV-RP-C205).
    """
    return 1 + _THICK * math.sqrt(thickness / width)


def _click(mass: float, volume: float, area: float, damping: float) -> Click:
    """Return the click of a body of a mass (kg), from Q (m^3), S (m^2) and the damping ratio z."""
    natural = SPEED * math.sqrt(math.sqrt(12 * math.pi * area) / volume)
    damping = min(damping, _MOST_DAMPED)
    decay, omega = natural * damping, natural * math.sqrt(1 - damping**2)
    strength = IMPEDANCE * math.sqrt(area / (4 * math.pi)) / mass
    return Click(omega / (2 * math.pi), decay, strength)
