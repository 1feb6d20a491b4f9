"""The board that strings and tongues are heard through, as a curve of its means.

The force at its bridge or clamp, F per unit modal velocity, puts the power |F|^2 Y/2 into the board. Y is the mean
conductance of a plate, 1/(8 sqrt(D m)) (Cremer, Heckl, Petersson, Structure-Borne Sound, 2005). Of this power the share
R/(R + eta omega) is radiated, R = 2 rho c sigma/m, with the efficiency of a plate in a wall: P c/(pi^2 S f_c)
sqrt(f/f_c) below the critical frequency, 1/sqrt(1 - f_c/f) above. Single modes of the board are left out, and below
its lowest one Y falls as f^4.

A ribbed board is one plate only as long as its waves are long. Where half of one fits between two ribs, waves stay
between these, and the board gives way as the bare panel does (Ege and Boutillon, Proc. ICA, 2010: the rise of a piano's
mobility above 1.1 kHz). The radiation of its waves there is left as it is, which errs to the loud side.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..air import IMPEDANCE, SPEED
from ..material import Array

_JOIN = 1.25  # times the critical frequency: up to here from its inverse the efficiency follows a power law


@dataclass(frozen=True)
class Board:
    """A board's mass per area (kg/m^2), its rigidity (N m), the geometric mean of both directions, its loss factor, its
    area (m^2), its perimeter (m), and the frequency (Hz) of its lowest mode.

    Of one with ribs: the frequency (Hz) from which waves stay between them, and the mean mobility (s/kg) of the bare
    panel, which is reached within an octave.
    """

    areal: float
    rigidity: float
    loss_factor: float
    area: float
    perimeter: float
    lowest: float
    between_ribs: float = math.inf
    panel: float = 0.0

    def conductance(self, frequency: Array) -> Array:
        """Return the mean real mobility (s/kg) at the bridge."""
        plate = 1 / (8 * math.sqrt(self.rigidity * self.areal))
        bare = np.clip(np.log2(frequency / self.between_ribs), 0, 1) if self.panel else 0.0
        found: Array = plate * (self.panel / plate) ** bare / (1 + (self.lowest / frequency) ** 4)
        return found

    def radiated_share(self, frequency: Array) -> Array:
        """Return the share of the board's power that becomes sound."""
        critical = SPEED**2 / (2 * math.pi) * math.sqrt(self.areal / self.rigidity)
        ratio = frequency / critical
        low = self.perimeter * SPEED / (math.pi**2 * self.area * critical) * np.sqrt(np.minimum(ratio, 1 / _JOIN))
        high = 1 / np.sqrt(1 - 1 / np.maximum(ratio, _JOIN))
        rise = np.clip((np.log(ratio) / math.log(_JOIN) + 1) / 2, 0, 1)
        resistance = 2 * IMPEDANCE / self.areal * low ** (1 - rise) * high**rise
        share: Array = resistance / (resistance + self.loss_factor * 2 * math.pi * frequency)
        return share


_SPRUCE = 0.008, 390.0, 11.5e9, 0.47e9
"""Thickness (m), density (kg/m^3), Young's modulus (Pa) along and across the grain, as recalled from Ege's thesis."""


def _bare(thickness: float, density: float, along: float, across: float) -> float:
    """Return the mean mobility (s/kg) of a panel of wood."""
    rigidity = math.sqrt(along * across) * thickness**3 / 12
    return 1 / (8 * math.sqrt(rigidity * density * thickness))


PIANO = Board(
    areal=4.0, rigidity=2000.0, loss_factor=0.02, area=1.4, perimeter=5.0, lowest=60.0,
    between_ribs=1100.0, panel=_bare(*_SPRUCE),
)  # fmt: skip
"""8 mm of spruce with its ribs: a conductance of 1.4e-3 s/kg, where a piano's is 1e-3 within a factor of two up to the
frequency from which waves stay between the ribs (Giordano, J. Acoust. Soc. Am. 103, 1998; Ege and Boutillon 2010), and
7e-3 s/kg above. Losses: of 1 to 3 % (Ege, Boutillon, Rebillat, J. Sound Vib. 332, 2013)."""

BOX = Board(areal=7.0, rigidity=350.0, loss_factor=0.02, area=0.02, perimeter=0.6, lowest=150.0)
"""The top of a hollow box for tongues, 200 x 100 x 10 mm of hard wood, estimated: a conductance of 2.5e-3 s/kg. The
lowest mode is that of the air in it."""

BOARDS = {"piano": PIANO, "box": BOX}
