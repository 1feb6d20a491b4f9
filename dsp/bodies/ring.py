"""Rings, tube walls, glasses, bowls and cans: walls that bend around their circumference."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from . import acceleration
from .acceleration import Click
from .air import DENSITY, Load
from .heard import Loaded, heard, loaded
from .material import Array, Material
from .modes import MOST_MODES, Indices, Modes, audible, path, require_positive
from .near import critical_frequency, near_field
from .radiation import wall as wall_air
from .radiation.sampling import between, members
from .radiation.thin import Profile
from .shell import wall_modes
from .unheard import FINER, Felt, with_unheard

_SIGN_AT = np.radians([13.0])  # around the wall: whose sign a mode's sound has
_SOLVED = 16  # orders of which the air's load is solved; above, of some
_FURTHER = 8  # times the orders that are heard: those that are felt
_NEARLY = 1.1  # times the highest frequency wanted: a pair's lower member and the air's mass bring a mode below it
_MOST_ROWS = 64  # up a can's wall
_GOLDEN = (3 - math.sqrt(5)) / 2  # where a can is struck, in its height: no mode of few half waves has a node there
CANTILEVER = np.array([1.8751040687, 4.6940911330, 7.8547574382])
"""Roots of cos(b) cosh(b) = -1: a wall held at its foot and free at its rim bends as a cantilever along its height."""


class Doublets(NamedTuple):
    """Imperfections of a round body: see `doublets`."""

    split: float
    imperfection: float
    seed: int = 0


def ring(
    material: Material,
    *,
    radius: float,
    thickness: float,
    length: float,
    top: float,
    split: float = 0.0,
    imperfection: float = 20.0,
    split_seed: int = 0,
) -> Modes:
    """Return the modes of a free ring or tube that bends in its plane, struck along half the circumference.

    Parameters
    ----------
    material : Material
        Material of the body.
    radius : float
        Radius of the middle line, m.
    thickness, length : float
        Thickness along the radius, and length along the axis, m.
    top : float
        Highest frequency of a mode, Hz.
    split : float, default 0
        Difference of frequency within each pair of modes, as a share; 0: a round body, without pairs.
    imperfection : float, default 20
        Angle between the strike path and the lower mode of a pair, degrees.
    split_seed : int, default 0
        Seed of random splits, of rms `split`, and angles; 0: all pairs are alike.

    Returns
    -------
    Modes
        The modes from 1 Hz up to `top`.

    Raises
    ------
    ValueError
        An argument is out of range, or the body has no such mode; the text names it.

    Notes
    -----
    The radial displacement is cos n theta, n >= 2. omega = n (n^2 - 1)/sqrt(n^2 + 1) sqrt(E h^2/(12 rho R^4)) (Hoppe
    1871), lowered by shear and rotation where waves are short, and by the air.
    """
    require_positive(radius=radius, thickness=thickness, length=length)
    order = np.arange(2.0, MOST_MODES + 2)
    mass = 2 * math.pi * radius * thickness * length * material.density
    frequency = _bending(material, radius, thickness, order)
    wall = _Wall(radius, length / 2, thickness * material.density, mass, mass / 2)
    made = _around(material, wall, [_bent(frequency, _uniform)], Doublets(split, imperfection, split_seed), top)
    return replace(made, clicks=ring_clicks(material, radius=radius, thickness=thickness, length=length))


def ring_clicks(
    material: Material, *, radius: float, thickness: float, length: float, **others: object
) -> tuple[Click, ...]:
    """Return the clicks of a ring; arguments as of `ring`."""
    mass = 2 * math.pi * radius * thickness * length * material.density
    return _clicks(material, thickness, acceleration.ring(mass, radius, length, mass / material.density))


def glass(
    material: Material,
    *,
    radius: float,
    height: float,
    thickness: float,
    top: float,
    rows: int = 1,
    split: float = 0.0,
    imperfection: float = 20.0,
    split_seed: int = 0,
) -> Modes:
    """Return the modes of a wine glass or bowl that is held at its foot, struck along half the rim.

    Parameters
    ----------
    material : Material
        Material of the body.
    radius, height, thickness : float
        Radius and height of the wall, and its thickness, m.
    top : float
        Highest frequency of a mode, Hz.
    rows : int, default 1
        Number of shapes up the wall, 1 to 3.
    split : float, default 0
        Difference of frequency within each pair of modes, as a share; 0: a round body, without pairs.
    imperfection : float, default 20
        Angle between the strike path and the lower mode of a pair, degrees.
    split_seed : int, default 0
        Seed of random splits, of rms `split`, and angles; 0: all pairs are alike.

    Returns
    -------
    Modes
        The modes from 1 Hz up to `top`.

    Raises
    ------
    ValueError
        An argument is out of range, or the body has no such mode; the text names it.

    Notes
    -----
    The displacement is cos n theta around it, and a cantilever's shape m up the wall. omega = omega_ring(n)
    sqrt(1 + b_m^4/(n^2 - 1)^2 (R/H)^4): for n = 2, m = 1 this is French's formula (Am. J. Phys. 51, 1983), whose factor
    4/3 is 1.875^4/9 rounded. Stretching of the wall is left out, as there, and so is the bottom of a bowl.
    """
    require_positive(radius=radius, height=height, thickness=thickness)
    if not 1 <= rows <= CANTILEVER.size:
        raise ValueError(f"rows = {rows}: expected 1 to {CANTILEVER.size}")
    order = np.arange(2.0, MOST_MODES + 2)
    mass = 2 * math.pi * radius * thickness * height * material.density
    ring = _bending(material, radius, thickness, order)
    made = [
        _bent(ring * np.sqrt(1 + root**4 / (order**2 - 1) ** 2 * (radius / height) ** 4), partial(_cantilever, root))
        for root in CANTILEVER[:rows]
    ]
    # A cantilever's tip moves by twice the rms of its length, whatever its mode.
    wall = _Wall(radius, height / 2, thickness * material.density, mass, mass / 8)
    clicks = glass_clicks(material, radius=radius, height=height, thickness=thickness)
    return replace(_around(material, wall, made, Doublets(split, imperfection, split_seed), top), clicks=clicks)


def glass_clicks(
    material: Material, *, radius: float, height: float, thickness: float, **others: object
) -> tuple[Click, ...]:
    """Return the clicks of a wine glass or bowl; arguments as of `glass`."""
    mass = 2 * math.pi * radius * thickness * height * material.density
    whole = acceleration.ring(mass, radius, height, mass / material.density)
    return _clicks(material, thickness, whole, held=True)


def can(
    material: Material,
    *,
    radius: float,
    height: float,
    thickness: float,
    top: float,
    split: float = 0.0,
    imperfection: float = 20.0,
    split_seed: int = 0,
) -> Modes:
    """Return the modes of a can's wall, struck along half the circumference, at 0.38 of the height.

    Parameters
    ----------
    material : Material
        Material of the body.
    radius, height, thickness : float
        Radius and height of the wall, and its thickness, m.
    top : float
        Highest frequency of a mode, Hz.
    split : float, default 0
        Difference of frequency within each pair of modes, as a share; 0: a round body, without pairs.
    imperfection : float, default 20
        Angle between the strike path and the lower mode of a pair, degrees.
    split_seed : int, default 0
        Seed of random splits, of rms `split`, and angles; 0: all pairs are alike.

    Returns
    -------
    Modes
        The modes from 1 Hz up to `top`.

    Raises
    ------
    ValueError
        An argument is out of range, or the body has no such mode; the text names it.

    Notes
    -----
    The can is a thin cylinder that its ends keep round: cos n theta around it, sines up it; frequencies as in shell.py.
    Neither its ends sound nor the air in it. The air acts as in an open tube.
    """
    require_positive(radius=radius, height=height, thickness=thickness)
    order = np.arange(2.0, MOST_MODES + 2)
    mass = 2 * math.pi * radius * thickness * height * material.density
    rows: list[_Family] = []
    for row in range(1, _MOST_ROWS + 1):
        frequency, heavier = wall_modes(material, radius, thickness, height, order, row)
        if rows and frequency.min() > top:
            break
        rows.append(_Family(frequency, partial(_sine, row), math.sin(math.pi * row * _GOLDEN), heavier))
    wall = _Wall(radius, height / 2, thickness * material.density, mass, mass / 4)
    clicks = _clicks(material, thickness, acceleration.cylinder(mass, height, 2 * radius), held=True)
    return replace(_around(material, wall, rows, Doublets(split, imperfection, split_seed), top), clicks=clicks)


def doublets(
    frequency: Array, order: Array, split: float, imperfection: float, seed: int = 0
) -> tuple[Array, Indices, Array]:
    """Return the modes cos and sin of n theta of a nearly round body, from those of the round one.

    frequency (Hz) and order n (k,); split: relative difference of frequency within a pair; imperfection: angle
    (degrees) of the nodal lines to the strike path; seed: 0 for pairs that are all alike. Return frequencies, indices
    into (k,), and phases p (rad) such that the shape is cos(n theta - p). A round body (split 0) and n = 0 have one
    member each, the one which the strike excites.

    Any other seed draws the pairs of a body whose thickness varies at random around it. Only the part of it that goes
    as 2n theta splits a pair of order n (C. H. J. Fox, J. Sound Vib. 142, 1990), and its cosine and sine are normal: so
    splits are Rayleigh-distributed with the root mean square `split`, and all angles are alike.
    """
    which = np.arange(frequency.size)
    if split == 0:
        return frequency, which, np.zeros_like(frequency)
    pairs = which[order > 0]
    own, turned = _drawn(frequency, order, seed) if seed else (np.ones_like(frequency), np.zeros_like(frequency))
    half = np.where(order > 0, split / 2 * own, 0.0)
    turn = order * math.radians(imperfection) + turned
    return (
        np.concatenate([frequency * (1 - half), (frequency * (1 + half))[pairs]]),
        np.concatenate([which, pairs]),
        np.concatenate([turn, turn[pairs] + math.pi / 2]),
    )


def _drawn(frequency: Array, order: Array, seed: int) -> tuple[Array, Array]:
    """Return each mode's split over its root mean square, and the phase (rad) of its lower member, drawn by its order
    and by its place among the frequencies (Hz) of that order: the same ones however many modes there are."""
    size, phase = np.empty_like(frequency), np.empty_like(frequency)
    for n in np.unique(order):
        mine = np.flatnonzero(order == n)
        mine = mine[np.argsort(frequency[mine], kind="stable")]
        draws = np.random.Generator(np.random.Philox(key=np.array([seed, n], np.uint64))).random((mine.size, 2))
        size[mine], phase[mine] = np.sqrt(-np.log1p(-draws[:, 0])), 2 * math.pi * draws[:, 1]
    return size, phase


def _bending(material: Material, radius: float, thickness: float, order: Array) -> Array:
    """Return the frequencies (Hz) of a ring, lowered by shear and rotation where the waves are short.

    That is the lower branch of Timoshenko's bar to first order in (k h)^2, k = n / R, for a rectangle's 5/6.
    """
    hoppe = order * (order**2 - 1) / np.sqrt(order**2 + 1) * thickness / radius**2
    hoppe *= math.sqrt(material.youngs_modulus / (12 * material.density)) / (2 * math.pi)
    shear = material.youngs_modulus / (5 / 6 * material.shear_modulus)
    return hoppe / np.sqrt(1 + (order * thickness / radius) ** 2 / 12 * (1 + shear))


def _clicks(material: Material, thickness: float, whole: Click, held: bool = False) -> tuple[Click, ...]:
    """Return the clicks of a wall: from about the point that is struck, and as a whole, as a plate of its thickness
    radiates. Where sound is shorter than the wall's radius, all waves around it but the breathing one bend as freely as
    a plate's."""
    areal, rigidity = material.density * thickness, material.contact_modulus * thickness**3 / 12
    return near_field(areal, whole, critical_frequency(areal, rigidity), held)


class _Wall(NamedTuple):
    """A wall's middle radius and half its height (m), kg/m^2, its mass and that of its radial motion alone (kg)."""

    radius: float
    half: float
    areal: float
    mass: float
    modal_mass: float


class _Family(NamedTuple):
    """Modes of one profile up the wall, by orders from 2 up, as they are without air: frequencies (Hz), the profile and
    its value where the wall is struck, and how much heavier each is than by its motion along the radius alone."""

    frequency: Array
    profile: Profile
    struck: float
    heavier: Array


def _bent(frequency: Array, profile: Profile) -> _Family:
    """Return a family of modes that do not stretch the wall: it also moves along its circumference, by 1/n of its
    radial motion. They are struck at their rim."""
    order = np.arange(2.0, frequency.size + 2)
    return _Family(frequency, profile, 1.0, 1 + 1 / order**2)


class _Row(NamedTuple):
    """Modes of a family in air: orders, peaks (kg^-1/2) where they are struck, and what the air makes of them, (k,).

    Modes that are too high to be heard are as without air.
    """

    order: Array
    peak: Array
    air: Loaded


def _row(wall: _Wall, family: _Family, top: float) -> _Row:
    """Return the modes of a family in air, as many as matter up to `top` (Hz)."""
    count = int(np.max(np.flatnonzero(family.frequency < _NEARLY * top), initial=-1)) + 1
    frequency = family.frequency[: _FURTHER * max(count, 1)]
    order = np.arange(2.0, frequency.size + 2)
    peak = 1 / np.sqrt(wall.modal_mass * family.heavier[: order.size])
    solved = members(count, _SOLVED)

    def load(now: Array) -> Load:
        found = wall_air.load_of(order[solved], wall.radius, wall.half, family.profile, now[solved])
        scaled = Load(found.resistance * peak[solved] ** 2, found.mass * peak[solved] ** 2)
        return between(np.log(order[solved]), scaled, np.log(order[:count]))

    guess = 2 * DENSITY * wall.radius / (order[:count] * wall.areal)
    air = loaded(frequency[:count], load, guess)
    still = np.zeros(frequency.size - count)
    return _Row(
        order,
        peak * family.struck,
        Loaded(
            np.append(air.frequency, frequency[count:]),
            np.append(air.resistance, still),
            np.append(air.shrinking, 1 + still),
        ),
    )


def _around(material: Material, wall: _Wall, families: Sequence[_Family], pairs: Doublets, top: float) -> Modes:
    """Return the modes of a wall in air, from the families that they are without."""
    found = [_row(wall, family, top) for family in families]
    order, peak = (np.concatenate([row[i] for row in found]) for i in (0, 1))
    frequency, resistance, shrinking = (np.concatenate([row.air[i] for row in found]) for i in range(3))
    frequency, which, phase = doublets(frequency, order, *pairs)
    keep = audible(frequency, top)
    others = np.setdiff1d(np.arange(frequency.size), keep)

    def shape(angle: Array, mode: Indices) -> Array:
        height = (peak * shrinking)[which[mode]]
        return np.asarray(height * np.cos(np.outer(angle, order[which[mode]]) - phase[mode]), np.float64)

    angles = math.pi * path(math.pi * FINER * order[which[keep]].max())
    shapes = shape(angles, keep), shape(_SIGN_AT, keep)[0]
    made = heard(material, frequency[keep], resistance[which[keep]], shapes, wall.mass)
    return with_unheard(made, Felt(frequency[others], shape(angles, others)), material.decay, top)


def _sine(waves: int, z: Array) -> Array:
    """Return the shape of so many half waves from end to end."""
    shape: Array = np.sin(waves * math.pi * (z + 1) / 2)
    return shape


def _uniform(z: Array) -> Array:
    return np.ones_like(z)


def _cantilever(root: float, z: Array) -> Array:
    """Return a cantilever's shape, 1 or -1 at its tip z = 1, its foot at z = -1."""
    y = root * (z + 1) / 2
    ratio = (math.cosh(root) + math.cos(root)) / (math.sinh(root) + math.sin(root))
    shape: Array = (np.cosh(y) - np.cos(y) - ratio * (np.sinh(y) - np.sin(y))) / 2
    return shape
