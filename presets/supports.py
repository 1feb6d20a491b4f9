"""Presets of supports: what an object rests on that is no object itself."""

from __future__ import annotations

import math
from typing import NamedTuple


class SupportPreset(NamedTuple):
    """A support: its contact law f = k x^a (1 + mu v), and what is behind it."""

    description: str
    source: str
    stiffness: float = 0.0
    """N/m^a; 0: the law is that of two materials."""
    dissipation: float = 0.0
    """s/m: times the load (N) it is the resistance (N s/m) of the contact at rest."""
    exponent: float = 1.0
    material: str = ""
    """Preset of the material that makes the law, with the object's own."""
    mass: float = 0.0
    """kg: what moves with the flesh of a hand, which presses from outside; 0: the object lies on it by its weight."""
    load: float = 0.0
    """N: with which such a hand presses, where none is given."""
    most: float = math.inf
    """N: the greatest load that may be set, an estimate: under more, neither flesh nor a pad is as its law has it."""
    area: float = 0.0
    """m^2 that it covers, as a resistance alone: no mode is spared; 0: it touches at a point."""
    resistance: float = 0.0
    """N s/m: of the ground; 0: it is rigid."""
    wavelength: float = 0.0
    """m: of the ground's bending waves at 1 kHz; 0: what moves one point of it moves no other."""


def plate_resistance(modulus: float, ratio: float, density: float, thickness: float) -> float:
    """Return the resistance (N s/m) of a point of a plate without an edge, of Young's modulus (Pa), Poisson's ratio,
    density (kg/m^3) and thickness (m): 8 sqrt(D m'') (Cremer, Heckl and Petersson, Structure-Borne Sound)."""
    bending = modulus * thickness**3 / (12.0 * (1.0 - ratio**2))
    return 8.0 * math.sqrt(bending * density * thickness)


def plate_wavelength(modulus: float, ratio: float, density: float, thickness: float) -> float:
    """Return the wavelength (m) of the same plate's bending waves at 1 kHz: 2 pi (D/(omega^2 m''))^(1/4)."""
    bending = modulus * thickness**3 / (12.0 * (1.0 - ratio**2))
    omega = 2e3 * math.pi
    return 2.0 * math.pi / math.sqrt(omega * math.sqrt(density * thickness / bending))


_TABLE = 3e9, 0.3, 700.0, 0.025  # Young's modulus (Pa), Poisson's ratio, density (kg/m^3), thickness (m)

SUPPORTS = {
    "felt": SupportPreset(
        "A pad of felt of 4 x 4 cm, 5 mm thick, on rigid ground",
        "stiffness over load: that of felt of an inch, on which any mass swings at some 20 Hz (Tyzzer and Hardy, J. "
        "Acoust. Soc. Am. 19, 1947, abstract), times 25.4/5; exponent: 2.2-3.5 of piano hammers (Hall and Askenfelt "
        "1988); dissipation: for a loss factor of 0.2 at 500 Hz, an estimate",
        stiffness=2e10, dissipation=0.5, exponent=3.0, most=10_000.0, area=1.6e-3,
    ),
    "foam": SupportPreset(
        "A block of soft polyurethane foam of 4 x 4 x 2 cm, on rigid ground",
        "Young's modulus 0.1 MPa and loss factor 0.3 at 500 Hz and 1 N: estimates, within what is measured of such "
        "foams (an estimate, after 0.05-0.3 MPa, 0.1-0.5)",
        stiffness=8e3, dissipation=0.75, exponent=1.0, most=10_000.0, area=1.6e-3,
    ),
    "finger": SupportPreset(
        "A fingertip that touches lightly",
        "at 1 N: stiffness 1 kN/m and resistance 1.5 N s/m of the pulp (Wiertlewski and Hayward, J. Biomech. 45, 2012, "
        "along the skin), and 6 g behind it (Hajian and Howe, J. Biomech. Eng. 119, 1997), both estimates after these; "
        "stiffening with load: an estimate",
        stiffness=2.5e5, dissipation=1.5, exponent=2.0, mass=0.006, load=1.0, most=200.0,
    ),
    "palm": SupportPreset(
        "The flat of a hand, laid on: 80 cm2",
        "at 50 N: 50 kN/m and 100 N s/m, as models of the palm have it (an estimate, after ISO 10068); stiffening with "
        "load and the mass of the flesh that moves with it: estimates; 80 cm2: 0.4 to 0.5 % of the body's surface "
        "(Rossiter et al., Burns 22, 1996), of 1.8 m2",
        stiffness=1.3e7, dissipation=2.0, exponent=2.0, mass=0.1, load=50.0, most=2_000.0, area=8e-3,
    ),
    "table": SupportPreset(
        "A large table top of chipboard, 25 mm thick",
        "resistance: a plate without an edge of 3 GPa, 700 kg/m^3 and Poisson's ratio 0.3 (estimates of "
        "chipboard); contact: Hertz's, of the object's material and wood, with a radius of 10 mm or `by_radius`",
        material="wood", resistance=plate_resistance(*_TABLE), wavelength=plate_wavelength(*_TABLE),
    ),
}  # fmt: skip
"""Supports by name."""
