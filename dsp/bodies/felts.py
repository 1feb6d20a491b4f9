"""Felts that hold a disc at its centre, as those of a cymbal on its stand: what they take from its modes.

A felt is a spring of stiffness k with a loss factor eta on either side. At the frequency omega it resists as a dashpot
of eta k/omega, and so takes eta k <phi^2>/(2 omega) (1/s) from a mode, <phi^2> its square over the felt, which covers
little more than where modes of the orders 0 and 1 move. How it stiffens the disc is left out: it moves the lowest of
these modes by some per cent.

That is of an even disc. The bow, bell and hammering of a cymbal mix its orders, so that all modes move at its stand, by
phi^2 = 1/M of its mass in the mean: a resistance R there takes R/(2 M) (1/s) from all alike, and heavy cymbals ring
longer, as recorded ones do, if by less than that: R is some 1.2 kg/s times the root of the mass over 1 kg. So crashes
ring 0.15 octaves of time shorter than the recordings that presets were made with, in the median, and rides 0.21 octaves
longer (tests.bench.decays). What 16 recordings of cymbals of 0.26 to 3.2 kg leave beside what the bronze and the air
take scatters from 0 to 5 kg/s. 0.85 kg/s follow at 3 kHz from felts of the figures below.
"""

from dataclasses import replace

import numpy as np

from .material import Array, Material

STIFFNESS = 8e4
"""N/m: two of 10 mm, each pressed by 10 N. On one of an inch any mass swings at some 20 Hz (Tyzzer and Hardy, J.
Acoust. Soc. Am. 19, 1947, abstract)."""
LOSS_FACTOR = 0.2
"""Loss factor of felt at 500 Hz, estimated, and the same at all frequencies."""
_RINGS = 16


def on_stand(material: Material, stand: float, mass: float) -> Material:
    """Return a material that also loses what a stand of a resistance (kg/s) takes from all modes of a mass (kg)."""
    return replace(material, alpha=material.alpha + stand / mass) if stand else material


def felt_losses(radius: float, frequency: Array, order: Array, radii: Array, along: Array) -> Array:
    """Return by how much felts of a radius over the disc's own raise the decay (1/s) of modes (n,), of frequencies (Hz)
    and angular orders, with radial shapes (p, n) at ascending radii (p,) over the disc's, mass-normalised."""
    r = radius * (np.arange(_RINGS) + 0.5) / _RINGS
    inside = np.searchsorted(radii, r, side="right") - 1
    slope = (along[inside + 1] - along[inside]) / (radii[inside + 1] - radii[inside])[:, None]
    shapes = np.ascontiguousarray((slope * (r - radii[inside])[:, None] + along[inside]).T)
    around = np.where(order == 0, 1.0, 0.5)
    mean = 2 / (radius * _RINGS) * (shapes**2 @ r) * around
    losses: Array = LOSS_FACTOR * STIFFNESS * mean / (4 * np.pi * frequency)
    return losses
