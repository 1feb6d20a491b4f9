"""A thin disc that moves in free air, solved otherwise: the oblate spheroid of no thickness, by separated variables.

In oblate coordinates r = a sqrt((1 + x^2)(1 - y^2)), z = a x y the disc is x = 0, and a motion that is alike on both
sides drives the functions that are odd in y alone. Outside, each runs outwards as R(x), which is integrated inwards
from where it is a spherical Hankel function.
"""

import math

import numpy as np
from scipy import special
from scipy.integrate import solve_ivp

from carom.dsp.bodies.air import DENSITY, SPEED


def impedance(order, x, radius, profile, count=6):
    """Return the impedance (kg/s) of profile(r/a) cos(m theta) on both sides at k a = x, time as exp(-i omega t)."""
    nodes, weights = np.polynomial.legendre.leggauss(120)
    y, weights = (nodes + 1) / 2, weights / 2
    total = 0
    for n in range(order + 1, order + 1 + 2 * count, 2):
        angular = special.obl_ang1_cv(order, n, x, special.obl_cv(order, n, x), y)[0]
        norm = 2 * (weights * angular**2).sum()
        driven = 2 * (weights * y * profile(np.sqrt(1 - y**2)) * angular).sum()
        total += driven**2 / norm * _outward(order, n, x)
    turn = 2 * math.pi if order == 0 else math.pi
    return 1j * DENSITY * x * SPEED / radius * radius**3 * turn * total


def _outward(order, n, c):
    """Return R over R' at x = 0 of ((1 + x^2) R')' = (lambda - c^2 x^2 - m^2/(1 + x^2)) R."""
    eigenvalue = special.obl_cv(order, n, c)
    far = max(300 / c, 40.0)

    def slope(x, state):
        value, flux = state[0] + 1j * state[1], state[2] + 1j * state[3]
        change = flux / (1 + x * x), (eigenvalue - (c * x) ** 2 - order**2 / (x * x + 1)) * value
        return [part for each in change for part in (each.real, each.imag)]

    start = [special.spherical_jn(n, c * far, after) + 1j * special.spherical_yn(n, c * far, after) for after in (0, 1)]
    start[1] *= c * (1 + far**2)
    state = [part for each in start for part in (each.real, each.imag)]
    value = solve_ivp(slope, (far, 0), state, "DOP853", rtol=1e-10, atol=1e-14).y[:, -1]
    return (value[0] + 1j * value[1]) / (value[2] + 1j * value[3])
