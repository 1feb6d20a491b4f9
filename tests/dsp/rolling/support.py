"""Bodies that roll, and what they roll on."""

import numpy as np
from numba import njit

from carom.dsp.native.typed import dtype_of
from carom.dsp.numerics.legendre import AHEAD, KEPT
from carom.dsp.rolling.abreast import step_abreast
from carom.dsp.rolling.abreast_record import Abreast
from carom.dsp.rolling.body import fill_roll, goes_abreast
from carom.dsp.rolling.surface import make_surface

MARBLE = {"radius": 8e-3, "m": 5e-3, "k": 3e9, "mu": 3.0, "a": 1.5, "speed": 0.5}
STEEL_BALL = {"radius": 8e-3, "m": 0.017, "k": 2e8, "mu": 10.0, "a": 1.5, "speed": 0.8}
WHEEL = {"radius": 0.05, "m": 1.0, "k": 1e8, "mu": 10.0, "a": 1.5, "speed": 0.3}
SOFT_BALL = {"radius": 0.02, "m": 0.01, "k": 1e7, "mu": 2.0, "a": 1.5, "speed": 0.02}
GLASS = {"roughness": 1e-7, "correlation": 1e-3, "slope": 2.0}
WOOD = {"roughness": 3e-6, "correlation": 3e-3, "slope": 2.2}
CLOTH = {"roughness": 1e-5, "correlation": 2e-3, "slope": 2.0}
STONE = {"roughness": 3e-5, "correlation": 5e-3, "slope": 2.2}


def ground(seed: int = 0, **description: float) -> np.void:
    """Return a surface, of glass if nothing else is said."""
    return make_surface(**{**GLASS, **description, "seed": seed})


def flat() -> np.void:
    """Return a surface without any height."""
    return ground(roughness=0.0)


@njit(error_model="numpy")
def _play(abreast, rolls, first, rate, moments):
    count = 0
    for q in range(len(moments) // AHEAD):
        origin, here = (first + q) * AHEAD / rate, moments[q * AHEAD : (q + 1) * AHEAD]
        if goes_abreast(rolls[0], origin, rate):
            abreast.count, abreast.roll[0], abreast.origin[0] = 1, 0, origin
            step_abreast(abreast, rolls, rate)
            here[:, 0], here[:, 1] = abreast.first[:, 0], abreast.tilt[:, 0]
            count += 1
        else:
            fill_roll(rolls[0], origin, rate, here)
    return count


def played(body: np.void, first: int, quanta: int, rate: float) -> tuple[np.ndarray, int]:
    """Move a body over quanta, from the one of a number on, as the engine does; return the moments of its force, and in
    how many it went by samples."""
    moments, bodies = np.zeros((quanta * AHEAD, KEPT)), np.zeros(1, body.dtype)
    bodies[0] = body
    count = _play(np.zeros(1, dtype_of(Abreast))[0], bodies, first, float(rate), moments)
    for name in bodies.dtype.names:
        body[name] = bodies[0][name]
    return moments, count
