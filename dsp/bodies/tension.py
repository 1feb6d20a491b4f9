"""The rise of the tension of strings and membranes with what rings on them: `Modes.glide`.

A displaced string is longer by int (w')^2/2 dx, a membrane's area by int |grad w|^2/2 dA. Held at its ends or its edge,
it is stretched by that. The tension is taken to rise alike everywhere, as waves along it are much faster than those
across it:

    string    Delta T = (E S/L) int (w')^2/2 dx                 (G. Kirchhoff, 1876; G. Carrier, 1945)
    membrane  Delta T = E h/((1 - nu^2) A) int |grad w|^2/2 dA  (H. Berger, 1955)

With the potential energy V = T int (w')^2/2 dx (dA) that is Delta T/T = E S V/(L T^2), or E h V/((1 - nu^2) A T^2).
Averaged over a period V is half of the energy, so glide is half of these factors. Berger's rule errs: the energy of
stretching is 0.8 of it for the mode (0,1) of a round membrane by von Karman's equations, 1.2 for (0,2).
"""

import math

from .material import Material


def string_glide(material: Material, length: float, diameter: float, tension: float) -> float:
    """Return the glide, 1/J, of a string of a length and (core) diameter in m, under a tension in N."""
    section = math.pi * diameter**2 / 4
    return material.youngs_modulus * section / (2 * length * tension**2)


def membrane_glide(material: Material, radius: float, thickness: float, tension: float) -> float:
    """Return the glide, 1/J, of a round membrane of a radius and thickness in m, under a tension in N/m."""
    area = math.pi * radius**2
    return material.contact_modulus * thickness / (2 * area * tension**2)


CONE = 1.5
"""Coefficient of a membrane's own mass, `Modes.cone`, in the law of the tension about a striker.

A striker of velocity v pulls a cone out of the head, whose edge runs outwards at the speed c of waves; its slope is
v/c. Stretch along the cone tightens it at once, long before the head as a whole is stretched, by Delta T = eta E h
(v/c)^2/(2 (1 - nu^2)), with c^2 = (T + Delta T)/(rho h). So tau = Delta T/T follows from tau (1 + tau) =
eta E h rho h v^2/(2 (1 - nu^2) T^2) = glide x eta M x v^2. By von Karman's equations of a head struck in its middle,
with a stick of 12 g at 1 to 10 m/s, eta = 1.5 gives the force of the first 1.2 ms within 12 %, and within 30 % until
2 ms, as waves come back; without the cone it is 3.5 times too weak at 10 m/s. tests/dsp/bodies/test_tension.py.
"""
