"""Rolling for those who study it: the force of a roll, and its micro-impacts one by one."""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..contact.collocation import WEIGHTS
from ..numerics.checks import checked
from ..numerics.legendre import MOMENTS
from ..rolling.body import ROLL, begin_roll, fill_roll, next_event

_FRAMES = 64
_SLOWEST = 1_000.0  # Hz: below, _FRAMES are longer than a call can follow


@njit(error_model="numpy")
def _begin(roll, surface, place, body):
    roll.path.surface = surface
    begin_roll(roll, place, *body)


@njit(error_model="numpy")
def _fill(roll, origin, rate, moments):
    for n in range(0, len(moments), _FRAMES):
        fill_roll(roll, origin + n / rate, rate, moments[n : n + _FRAMES])


@njit(error_model="numpy")
def _follow(roll, seconds, rows):
    """Rows of begin, length, impulse, speed of approach of every contact that ends within some seconds."""
    count = 0
    inside = False
    while roll.t < seconds and roll.ended == 0 and count < len(rows):
        impacts = roll.impacts
        touching = roll.touching
        next_event(roll)
        if touching == 1 and inside:
            for i in range(len(WEIGHTS)):
                rows[count, 2] += roll.span * WEIGHTS[i] * (roll.force[i] + roll.m * roll.g)
            if roll.touching == 0:
                rows[count, 1] = roll.t - rows[count, 0]
                count += 1
                inside = False
        if roll.impacts > impacts:
            rows[count, 0], rows[count, 2], rows[count, 3] = roll.t, 0.0, roll.v_in
            inside = True
    return count


def make_roll(
    surface: np.void,
    radius: float,
    m: float,
    k: float,
    mu: float,
    a: float,
    speed: float,
    gravity: float = 9.81,
    friction: float = 0.0,
    asymmetry: float = 0.0,
    corners: int = 0,
    roughness: float = 1.0,
    coarseness: float = 1.0,
    place: int = 0,
) -> np.void:
    """A body at rest on a surface of make_surface, rolling, as a ROLL record.

    radius (m), m (kg), k (N/m^a), gravity (m/s^2) > 0, mu (s/m) >= 0, a in [1, 4], speed (m/s) >= 0; friction: share
    of its weight that slows it; asymmetry in [0, 1]: distance of its centre of mass from its middle over its radius;
    corners in [0, 1000]: 0 if it is round; roughness >= 0: factor on the surface's heights; coarseness in [1, 64]:
    factor on the shortest wavelength that it feels; place: where it begins, in units of the surface. ValueError names
    what is out of range.
    """
    limits: dict[str, tuple[float, float, float, bool]] = {
        "radius": (radius, 0.0, math.inf, True),
        "m": (m, 0.0, math.inf, True),
        "k": (k, 0.0, math.inf, True),
        "mu": (mu, 0.0, math.inf, False),
        "a": (a, 1.0, 4.0, False),
        "speed": (speed, 0.0, math.inf, False),
        "gravity": (gravity, 0.0, math.inf, True),
        "friction": (friction, 0.0, math.inf, False),
        "asymmetry": (asymmetry, 0.0, 1.0, False),
        "corners": (corners, 0.0, 1000.0, False),
        "roughness": (roughness, 0.0, math.inf, False),
        "coarseness": (coarseness, 1.0, 64.0, False),
    }
    values = [float(checked(name, value, low, high, strict)) for name, (value, low, high, strict) in limits.items()]
    roll = np.zeros(1, ROLL)[0]
    _begin(roll, surface, int(place), tuple(values))
    return roll


def roll_moments(roll: np.void, origin: float, seconds: float, rate: float) -> NDArray:
    """Moments (N s) of the force over the samples of some seconds from `origin` (s since it began) on; it goes on.

    (round(seconds rate), MOMENTS) float64; the force is f - m g: a body at rest gives none.
    """
    moments = np.zeros((round(seconds * rate), MOMENTS))
    _fill(roll, float(origin), float(checked("rate", rate, _SLOWEST, strict=False)), moments)
    return moments


def roll_force(surface: np.void, seconds: float, rate: float, **body: Any) -> NDArray:
    """The force f - m g (N) of a roll, its mean over each sample: (round(seconds rate),) float64.

    `body`: the arguments of `make_roll` but the surface.
    """
    return roll_moments(make_roll(surface, **body), 0.0, seconds, rate)[:, 0] * rate


def micro_impacts(surface: np.void, seconds: float, most: int = 1_000_000, **body: Any) -> NDArray:
    """Every contact after a flight that ends within some seconds, one a row: (contacts, 4) float64.

    When it begins (s), how long it lasts (s), its impulse (N s) and the speed at which body and path meet (m/s);
    `most` at most. `body`: the arguments of `make_roll` but the surface.
    """
    rows = np.zeros((most, 4))
    return rows[: _follow(make_roll(surface, **body), float(seconds), rows)].copy()
