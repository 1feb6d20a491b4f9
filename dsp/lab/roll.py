"""Rolls as data: the force of a roll over time, and its contacts one by one."""

import math
from typing import Any

import numpy as np
from numba import njit

from ..contact.collocation import CARDINAL, WEIGHTS
from ..contact.step_record import NODES
from ..numerics.checks import Array, checked, checked_scalar
from ..numerics.constants import STANDARD_GRAVITY
from ..numerics.legendre import KEPT
from ..rolling.body import begin_roll, fill_roll, next_event
from ..rolling.path import PIECES
from ..rolling.roll_record import ROLL

_FRAMES = 64
_LOOKS = 64  # at the compression in a step, to find the release
_HALVINGS = 40  # of what lies between two of them
_SLOWEST = 1_000.0  # Hz: below, _FRAMES are longer than a call can follow


@njit(error_model="numpy")
def _begin(roll, surface, place, k, mu, a, corners, coarseness):
    roll.path.surface = surface
    begin_roll(roll, place, k, mu, a, corners, coarseness)


@njit(error_model="numpy")
def _fill(roll, origin, rate, moments):
    for n in range(0, len(moments), _FRAMES):
        fill_roll(roll, origin + n / rate, rate, moments[n : n + _FRAMES])


@njit(error_model="numpy")
def _compression(roll, force, back):
    """Return the compression (m) `back` s before the end of the last step in contact, whose `force` (N) is the
    contact's."""
    path = roll.path
    along = roll.along - roll.modulated_speed * back
    piece = roll.piece
    while along < 0.0 and piece > 0:
        piece -= 1
        along += path.length[piece % PIECES]
    i = piece % PIECES
    level = path.level[i] + along * (path.incline[i] + 0.5 * path.curvature[i] * along)
    # The body's height, from m y'' = f - m g; the force's quadratic, as a power series of the time before the end.
    share = back / roll.span
    pushed = 0.0
    power = back * back / roll.m
    for k in range(NODES):
        coefficient = 0.0
        for n in range(NODES):
            coefficient += CARDINAL[k, n] * force[NODES - 1 - n]
        pushed += power * coefficient / ((k + 1) * (k + 2))
        power *= share
    return level - (roll.y - back * (roll.w + 0.5 * roll.modulated_gravity * back) + pushed)


@njit(error_model="numpy")
def _released(roll, force):
    """Return the time (s) at which the contact that the last step left behind ended: where the compression was 0."""
    late = 0.0
    early = roll.span
    for n in range(1, _LOOKS + 1):
        back = roll.span * n / _LOOKS
        if _compression(roll, force, back) > 0.0:
            early = back
            break
        late = back
    for _ in range(_HALVINGS):
        back = 0.5 * (late + early)
        if _compression(roll, force, back) > 0.0:
            early = back
        else:
            late = back
    return roll.t - late


@njit(error_model="numpy")
def _follow(roll, seconds, rows):
    """Return rows of begin, length, impulse, speed of approach of every contact that ends within some seconds."""
    count = 0
    inside = False
    force = np.zeros(NODES)
    while roll.t < seconds and roll.ended == 0 and count < len(rows):
        impacts = roll.impacts
        touching = roll.touching
        next_event(roll)
        if touching == 1 and inside:
            for i in range(NODES):
                # The force over the weight is heard, and fades with the roll.
                force[i] = roll.force[i] / roll.fade + roll.m * roll.g
                rows[count, 2] += roll.span * WEIGHTS[i] * force[i]
            if roll.touching == 0:
                inside = False
                released = _released(roll, force)
                rows[count, 1] = released - rows[count, 0]
                count += released <= seconds
        if roll.impacts > impacts:
            rows[count, 0], rows[count, 2], rows[count, 3] = roll.t, 0.0, roll.v_in
            inside = True
    return count


# A body has as many parameters as this; they are given by name.
def make_roll(
    surface: np.void,
    radius: float,
    m: float,
    k: float,
    mu: float,
    a: float,
    speed: float,
    gravity: float = STANDARD_GRAVITY,
    friction: float = 0.0,
    asymmetry: float = 0.0,
    corners: int = 0,
    roughness: float = 1.0,
    coarseness: float = 1.0,
    place: int = 0,
) -> np.void:
    """Return a body that rests on a surface and begins to roll.

    Parameters
    ----------
    surface : SURFACE record
        As `make_surface` returns it.
    radius : float
        Radius, m, above 0.
    m : float
        Mass, kg, above 0.
    k : float
        Stiffness, N/m^a, above 0.
    mu : float
        Dissipation, s/m, at least 0.
    a : float
        Exponent, 1 to 4.
    speed : float
        Speed, m/s, at least 0.
    gravity : float, default 9.80665
        Gravity, m/s^2, above 0.
    friction : float, default 0
        Share of the weight that slows the body.
    asymmetry : float, default 0
        Offset of the centre of mass, in radii, 0 to 1.
    corners : int, default 0
        Number of corners, 0 to 1000; 0: round.
    roughness : float, default 1
        Factor of the surface's heights, at least 0.
    coarseness : float, default 1
        Factor of the shortest wavelength that is followed, 1 to 64.
    place : int, default 0
        Beginning, in units of the surface.

    Returns
    -------
    ROLL record
        The body.

    Raises
    ------
    ValueError
        An argument is out of range; the text names it.
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
    given = {
        name: float(checked(name, value, low, high, strict)) for name, (value, low, high, strict) in limits.items()
    }
    roll: np.void = np.zeros(1, ROLL)[0]
    roll["target"]["mass"] = given.pop("m")
    law = [given.pop(name) for name in ("k", "mu", "a", "corners", "coarseness")]
    for name, value in given.items():
        roll["target"][name] = value
    _begin(roll, surface, int(place), *law)
    return roll


def roll_moments(roll: np.void, origin: float, seconds: float, rate: float) -> Array:
    """Continue a roll, and return the Legendre moments of the force f - m g over samples.

    Parameters
    ----------
    roll : ROLL record
        As `make_roll` returns it; it rolls on.
    origin : float
        Beginning of the first sample, s since it began to roll: where the last call ended.
    seconds : float
        Time to roll, s.
    rate : float
        Sampling rate, Hz, at least 1000.

    Returns
    -------
    array (round(seconds * rate), KEPT)
        float64, N s; zeros for a body at rest.

    Raises
    ------
    ValueError
        An argument is out of range; the text names it.
    """
    rate = checked_scalar("rate", rate, _SLOWEST, strict=False)
    moments = np.zeros((round(checked_scalar("seconds", seconds, 0.0, strict=False) * rate), KEPT))
    _fill(roll, checked_scalar("origin", origin, 0.0, strict=False), rate, moments)
    return moments


def roll_force(surface: np.void, seconds: float, rate: float, **body: Any) -> Array:
    """Return the force f - m g of a roll as its mean over each sample.

    Parameters
    ----------
    surface : SURFACE record
        As `make_surface` returns it.
    seconds : float
        Time to roll, s.
    rate : float
        Sampling rate, Hz, at least 1000.
    **body
        Arguments of `make_roll` except the surface.

    Returns
    -------
    array (round(seconds * rate),)
        float64, N.

    Raises
    ------
    ValueError
        An argument is out of range; the text names it.
    """
    return roll_moments(make_roll(surface, **body), 0.0, seconds, rate)[:, 0] * rate


def micro_impacts(surface: np.void, seconds: float, most: int = 1_000_000, **body: Any) -> Array:
    """Return the contacts that follow a flight of a rolling body.

    Parameters
    ----------
    surface : SURFACE record
        As `make_surface` returns it.
    seconds : float
        Time to roll, s.
    most : int, default 1000000
        Largest number of rows.
    **body
        Arguments of `make_roll` except the surface.

    Returns
    -------
    array (contacts, 4)
        float64: beginning (s), duration (s, within 0.1 % of the exact motion's), impulse (N s), and the speed at which
        body and path meet (m/s).

    Raises
    ------
    ValueError
        An argument is out of range; the text names it.
    """
    return roll_contacts(make_roll(surface, **body), seconds, most)


def roll_contacts(roll: np.void, seconds: float, most: int = 1_000_000) -> Array:
    """Continue a roll, and return the contacts on the way.

    Parameters
    ----------
    roll : ROLL record
        As `make_roll` returns it; it rolls on.
    seconds : float
        End, s since it began to roll.
    most : int, default 1000000
        Largest number of rows.

    Returns
    -------
    array (contacts, 4)
        float64, as of `micro_impacts`. A contact that began before the call is left out.
    """
    rows = np.zeros((most, 4))
    return rows[: _follow(roll, checked_scalar("seconds", seconds, 0.0), rows)].copy()
