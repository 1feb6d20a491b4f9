"""Spherical harmonics to order 3, in the order ACN and with the scale SN3D: x in front, y left, z up."""

import math

from ..native.jit import kernel
from ..native.typed import View


@kernel
def harmonics(gains: View[float], order: int, x: float, y: float, z: float) -> None:
    """Set the gains (order + 1)^2 of a plane wave from a direction of length 1."""
    gains[0] = 1.0
    if order >= 1:
        gains[1], gains[2], gains[3] = y, z, x
    if order >= 2:
        r3 = math.sqrt(3.0)
        gains[4], gains[5], gains[6] = r3 * x * y, r3 * y * z, 0.5 * (3.0 * z * z - 1.0)
        gains[7], gains[8] = r3 * x * z, 0.5 * r3 * (x * x - y * y)
    if order >= 3:
        a, b, c = math.sqrt(5.0 / 8.0), math.sqrt(15.0), math.sqrt(3.0 / 8.0)
        gains[9], gains[10] = a * y * (3.0 * x * x - y * y), b * x * y * z
        gains[11], gains[12] = c * y * (5.0 * z * z - 1.0), 0.5 * z * (5.0 * z * z - 3.0)
        gains[13], gains[14] = c * x * (5.0 * z * z - 1.0), 0.5 * b * z * (x * x - y * y)
        gains[15] = a * x * (x * x - 3.0 * y * y)
