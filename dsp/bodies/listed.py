"""Modes that are given one by one."""

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from ..numerics.monotone import monotone_cubic
from .air import IMPEDANCE, wavenumber
from .heard import pressure
from .material import Array
from .modes import Modes, audible, columns
from .radiation.closed import sphere_efficiency
from .radiation.thin import open_cylinder

Each = float | Sequence[float]

_PLACES = 65  # along a path, of shapes that are measured at some positions
_LIP = 1.5  # radii over the order: the height from its lip in which a bell's motion falls by 1/e, estimated


def listed(
    *,
    frequency: Sequence[float],
    t60: Each,
    modal_mass: Each,
    mass: float,
    top: float,
    weight: Each | None = None,
    order: Each | None = None,
    radius: float | None = None,
    height: float | None = None,
    positions: Sequence[float] | None = None,
    gains: Sequence[Sequence[float]] | None = None,
) -> Modes:
    """Return modes that are given one by one.

    Parameters
    ----------
    frequency : sequence of float (n,)
        Frequencies, Hz.
    t60 : float or sequence (n,)
        Decay times, including what is radiated, s.
    modal_mass : float or sequence (n,)
        Modal masses, for shapes that are 1 at the striking point, kg.
    mass : float
        Mass of the whole body, kg.
    top : float
        Highest frequency of a mode, Hz; modes above it are left out.
    weight : float or sequence (n,), default 1
        Sound pressure at 1 m per velocity of the striking point, Pa per m/s, rms over directions.
    order : float or sequence (n,), optional
        Nodal meridians over two (a bell), or order of the Legendre polynomial (a sphere), in place of `weight`.
    radius : float, optional
        Radius of the body that radiates, m; needed with `order`.
    height : float, optional
        Height of a bell, m. Default: a sphere.
    positions : sequence of float (P,), optional
        Positions at which the shapes are known, 0 to 1, ascending. Default: the position does not matter.
    gains : sequence (n, P), optional
        Shape of each mode there.

    Returns
    -------
    Modes
        The modes up to `top`.

    Raises
    ------
    ValueError
        An argument does not fit; the text names it.

    Notes
    -----
    Shapes are interpolated between positions (pchip), and constant beyond. A bell is a thin open cylinder whose mode i
    moves as cos(order_i theta), most at its lip. With a radius no mode radiates more than it loses.
    """
    frequencies = np.asarray(frequency, dtype=np.float64)
    if (order is None) != (radius is None) or (height is not None and radius is None):
        raise ValueError(f"order = {order}, radius = {radius}, height = {height}: expected order and radius together")
    if weight is not None and order is not None:
        raise ValueError("weight and order: expected one of the two")
    given = {"t60": t60, "modal_mass": modal_mass, "weight": 1.0 if weight is None else weight, "order": order or 0}
    t60s, masses, weights, orders = columns(frequencies.size, "frequencies", **given)
    if not (np.all(frequencies > 0) and np.all(t60s > 0) and np.all(masses > 0)):
        raise ValueError("frequency, t60, modal_mass: expected positive numbers")
    shapes = _along_path(positions, gains, frequencies.size)
    keep = audible(frequencies, top)
    frequencies, masses = frequencies[keep], masses[keep]
    decay = math.log(1000) / t60s[keep]
    shape = 1 / np.sqrt(masses)
    if radius is None:
        sound = np.tile(weights[keep] * shape, (2, 1))
    else:
        resistance = _of_body(frequencies, orders[keep], radius, height) / masses
        sound = pressure(np.minimum(resistance, 2 * decay), shape)
    return Modes(
        frequency=frequencies,
        decay=decay,
        strike=shapes[:, keep] * shape,
        pressure=sound,
        mass=mass,
    )


def _along_path(positions: Sequence[float] | None, gains: Sequence[Sequence[float]] | None, count: int) -> Array:
    """Return the shapes (places, n) at equally spaced places 0..1."""
    if positions is None and gains is None:
        return np.ones((1, count))
    if positions is None or gains is None:
        raise ValueError("positions, gains: expected both together")
    at, rows = np.asarray(positions, np.float64), np.asarray(gains, np.float64)
    if rows.shape != (count, at.size):
        raise ValueError(f"gains: {rows.shape[0]} rows of {rows.shape[1]}: expected {count} of {at.size}")
    if np.any(np.diff(at) <= 0):
        raise ValueError(f"positions = {list(at)}: expected them to ascend")
    places = np.linspace(0, 1, _PLACES)
    if at.size == 1:
        return np.tile(rows[:, 0], (_PLACES, 1))
    return np.ascontiguousarray(monotone_cubic(at, rows, np.clip(places, at[0], at[-1])).T)


def _of_body(frequency: Array, order: Array, radius: float, height: float | None) -> Array:
    """Return the radiation resistance (kg/s) of modes of unit motion at their lip, or pole."""
    k = wavenumber(frequency)
    if height is None:
        efficiency = sphere_efficiency(order.astype(int), k * radius) / (2 * order + 1)
        return np.asarray(IMPEDANCE * 4 * math.pi * radius**2 * efficiency)
    half = height / 2
    resistance = np.empty(k.size)
    for m in np.unique(order):
        mine = np.flatnonzero(order == m)
        whole, profile = order[mine].astype(int), partial(_lip, m * half / radius)
        resistance[mine] = open_cylinder(whole, k[mine], radius, half, profile).real
    return resistance


def _lip(steepness: float, z: Array) -> Array:
    motion: Array = np.exp(-(1 - z) * steepness / _LIP)
    return motion
