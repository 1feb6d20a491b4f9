"""What strings and tongues are heard through: a board, as a curve of its means.

The force at its bridge or clamp, F per unit modal velocity, puts the power |F|^2 Y/2 into the board. Y is the mean
conductance of a plate, 1/(8 sqrt(D m)) (Cremer, Heckl, Petersson, Structure-Borne Sound, 2005). Of this power the share
R/(R + eta omega) is radiated, R = 2 rho c sigma/m, with the efficiency of a plate in a wall: P c/(pi^2 S f_c)
sqrt(f/f_c) below the critical frequency, 1/sqrt(1 - f_c/f) above. Single modes of the board are left out, and below
its lowest one Y falls as f^4.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..material import Array
from .air import IMPEDANCE, SPEED

_JOIN = 1.25  # times the critical frequency: up to here from its inverse the efficiency follows a power law


@dataclass(frozen=True)
class Board:
    """A board's mass per area (kg/m^2), its rigidity (N m), the geometric mean of both directions, its loss factor, its
    area (m^2), its perimeter (m), and the frequency (Hz) of its lowest mode."""

    areal: float
    rigidity: float
    loss_factor: float
    area: float
    perimeter: float
    lowest: float

    def conductance(self, frequency: Array) -> Array:
        """Mean real mobility (s/kg) at the bridge."""
        found: Array = 1 / (8 * math.sqrt(self.rigidity * self.areal)) / (1 + (self.lowest / frequency) ** 4)
        return found

    def radiated_share(self, frequency: Array) -> Array:
        """The share of the board's power that becomes sound."""
        critical = SPEED**2 / (2 * math.pi) * math.sqrt(self.areal / self.rigidity)
        ratio = frequency / critical
        low = self.perimeter * SPEED / (math.pi**2 * self.area * critical) * np.sqrt(np.minimum(ratio, 1 / _JOIN))
        high = 1 / np.sqrt(1 - 1 / np.maximum(ratio, _JOIN))
        rise = np.clip((np.log(ratio) / math.log(_JOIN) + 1) / 2, 0, 1)
        resistance = 2 * IMPEDANCE / self.areal * low ** (1 - rise) * high**rise
        share: Array = resistance / (resistance + self.loss_factor * 2 * math.pi * frequency)
        return share


PIANO = Board(areal=4.0, rigidity=2000.0, loss_factor=0.02, area=1.4, perimeter=5.0, lowest=60.0)
"""8 mm of spruce with its ribs: a conductance of 1.4e-3 s/kg, where a piano's is 1e-3 within a factor of two from
100 Hz to 3 kHz (Giordano, J. Acoust. Soc. Am. 103, 1998). Losses: of 1 to 3 % (Ege, Boutillon, Rebillat, J. Sound Vib.
332, 2013)."""

BOX = Board(areal=7.0, rigidity=350.0, loss_factor=0.02, area=0.02, perimeter=0.6, lowest=150.0)
"""The top of a hollow box for tongues, 200 x 100 x 10 mm of hard wood, estimated: a conductance of 2.5e-3 s/kg. The
lowest mode is that of the air in it."""

BOARDS = {"piano": PIANO, "box": BOX}
