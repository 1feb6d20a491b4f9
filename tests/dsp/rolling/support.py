"""Bodies that roll, and what they roll on."""

import numpy as np

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
