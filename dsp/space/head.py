"""A spherical head: the delay and the shadow at each ear, by C. P. Brown and R. O. Duda, "A structural model for
binaural sound synthesis", IEEE Trans. Speech and Audio Processing 6, 1998."""

import math

from ..native.jit import kernel

_LEAST = 0.1  # of the shadow: amplitude at high frequencies behind the head
_DARKEST = math.radians(150.0)  # from the ear: there the shadow is deepest


@kernel
def ear_path(angle: float, radius: float) -> float:
    """Return by how much (m) the way to an ear is longer than to the head's middle, by the angle (rad) between the ear
    and the source: Woodworth's, for a source far away."""
    return -radius * math.cos(angle) if angle < 0.5 * math.pi else radius * (angle - 0.5 * math.pi)


@kernel
def ear_shadow(angle: float) -> float:
    """Return the amplitude of high frequencies at an ear, by the same angle: 2 beside it and 0.1 behind the head; of
    low ones it is 1."""
    return (1.0 + 0.5 * _LEAST) + (1.0 - 0.5 * _LEAST) * math.cos(angle / _DARKEST * math.pi)
