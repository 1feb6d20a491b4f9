"""The air's load on the walls of rings, tubes, glasses and bells: thin cylinders that bend around themselves."""

import math

import numpy as np
from numpy.polynomial import legendre

from ...numerics.bessel import spherical_bessel
from ..air import DENSITY, IMPEDANCE, Load, load, wavenumber
from ..material import Array
from .closed import radial_function
from .quadrature import segment
from .thin import Profile, open_cylinder

_TERMS = 32
"""Legendre polynomials that a profile is made of: a cantilever's third shape leaves 1e-15."""
_LONG = 8.0  # radii: of a tube as long as this the inside radiates nothing that counts (0.4 dB)


def load_of(order: Array, radius: float, half: float, profile: Profile, frequency: Array) -> Load:
    """Return the load on modes profile(z) cos(m theta) of orders m (n,), of unit displacement: for a modal mass of 1
    kg.

    A cylinder of a middle radius and a length 2 `half`, in m, its ends open; z is -1..1 along it.
    """
    k = wavenumber(frequency)
    if 2 * half > _LONG * radius:
        return _long(order, radius, half, profile, frequency)
    return load(open_cylinder(order.astype(int), k, radius, half, profile), frequency)


def _long(order: Array, radius: float, half: float, profile: Profile, frequency: Array) -> Load:
    """Return R = rho c eps/pi^2 int |V(k cos t)|^2/(sin t |H_m'(k a sin t)|^2) dt; the mass of the air inside and
    outside."""
    k = wavenumber(frequency)
    z, wz = segment(-1, 1, 64)
    terms = np.arange(_TERMS)
    # The waves' integrals along z: e^(i q z) = sum (2 n + 1) i^n j_n(q) P_n(z), and the profile is smooth.
    series = half * (2 * terms + 1) * (legendre.legvander(z, _TERMS - 1).T @ (profile(z) * wz))
    series *= np.array([1.0, 1.0, -1.0, -1.0])[terms % 4]
    resistance = np.empty_like(k)
    for i, (m, each) in enumerate(zip(order, k, strict=True)):
        t, w = segment(0, math.pi / 2, 16 + 0.8 * each * half)
        wave = spherical_bessel(_TERMS, each * half * np.cos(t))
        power = (series[::2] @ wave[::2]) ** 2 + (series[1::2] @ wave[1::2]) ** 2
        around = 2 * math.pi if m == 0 else math.pi
        outward = radial_function(int(m), each * radius * np.sin(t)) * np.sin(t)
        resistance[i] = 2 * IMPEDANCE * around / math.pi**2 * (w * power / outward).sum()
    square = half * (profile(z) ** 2 * wz).sum()
    mass = 2 * DENSITY * math.pi * radius**2 * square / np.maximum(order, 1)
    return Load(resistance, mass)
