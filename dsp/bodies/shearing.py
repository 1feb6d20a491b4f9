"""Shear coefficients of bars' sections, by which a bar that bends is the solid body to the second order of its depth
over the wave's length (J. R. Hutchinson, "Shear Coefficients for Timoshenko Beam Theory", J. Appl. Mech. 68, 2001).

Those of G. R. Cowper (J. Appl. Mech. 33, 1966) know the static shear alone: bars come out too low, by 0.7 % at the
fifth mode of one of 240 x 30 x 10 mm. Hutchinson's hold how a section widens where it is pressed, too: a wide bar is
stiffer, in waves that are not much longer than it is wide. In a strip it would get stiffer without end, and in short
waves too stiff; so from a bar on that is twice as wide as it is deep the coefficient stays as it is there.
"""

import numpy as np

from .material import Array, Material

_TERMS = np.arange(1.0, 25.0)[:, None]  # the series falls as n^-4 at least
_LEAST = 1.06  # of 1/coefficient
_WIDEST = 4.0  # from there on the coefficient is at its bound, and the series loses its digits
_PLAIN = 1.2  # 1/coefficient of a rectangle that does not widen


def rectangles_shear(material: Material, width: Array) -> Array:
    """Return the coefficients (p,) of rectangles that bend along their depth, by their widths over it (p,)."""
    nu, width = material.poisson_ratio, np.minimum(width, _WIDEST)
    square = width**2
    waves = _TERMS * np.pi / width
    series = (16 * nu**2 * width**5 * (waves - np.tanh(waves)) / ((_TERMS * np.pi) ** 5 * (1 + nu))).sum(axis=0)
    bulk = 4 / 45 * (-12 - 15 * nu + 5 * nu * square) + series
    inverse = np.maximum(-(9 / 4 * bulk + nu * (1 - square)) / (2 * (1 + nu)), _LEAST)
    return np.asarray(1 / (_PLAIN + (inverse - _PLAIN) * _softness(material)))


def tubes_shear(material: Material, bore: float) -> float:
    """Return the coefficient of a round section by its bore over its diameter."""
    nu, r = material.poisson_ratio, bore**2

    def inverse(nu: float) -> float:
        each = 7 + 34 * r + 7 * r**2, 12 + 48 * r + 12 * r**2, 4 + 16 * r + 4 * r**2
        return (each[0] + nu * each[1] + nu**2 * each[2]) / (6 * (1 + r) ** 2 * (1 + nu) ** 2)

    return 1 / (inverse(0.0) + (inverse(nu) - inverse(0.0)) * _softness(material))


def _softness(material: Material) -> float:
    """Return the shear modulus over that of an isotropic body: how a section widens hangs on the other moduli."""
    return 2 * (1 + material.poisson_ratio) * material.shear_modulus / material.youngs_modulus
