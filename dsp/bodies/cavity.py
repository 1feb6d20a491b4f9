"""The air in a hollow body, which is heard through its opening: Helmholtz's resonator, and the column behind it.

An opening of area A in a wall of thickness t moves a plug of air of length L' = t + 0.85 a (1 + i), a = sqrt(A/pi): its
end outside, and that inside, i = 1 or, in the end of a tube of radius b, 1 - 1.25 a/b (U. Ingard, J. Acoust. Soc.
Am. 25, 1953). A cavity small beside the wave is a spring, f = c/(2 pi) sqrt(A/(V L')). One of length L is a pipe
of section S = V/L that is closed at its other end: its waves end in the opening where

    cot(k L) = k L' S/A,

the lowest of which is Helmholtz's. With X the volume that has left the opening, and u = sin(k z)/(S sin(k L)) X the
displacement in the tube, such a mode has the mass m = rho L'/A + rho S int u^2 dz, and a wall that yields at z by a
volume D drives it by rho c^2 k cos(k z)/(S sin(k L)) D.

What it loses it radiates, as a source much smaller than its wave, sigma = rho omega^2/(8 pi c m) (L. Kinsler et al.,
Fundamentals of Acoustics, ch. 10), and in a tube loses at the wall (resonator_tube.py).
"""

import math
from dataclasses import dataclass

import numpy as np

from .added import Lines
from .air import DENSITY, SPEED
from .material import Array
from .resonator_tube import wall_loss

POWERS = {"volume": 3, "area": 2, "neck": 1, "length": 1, "wall": 1}
"""Powers of a body's size with which its cavity's dimensions go."""

_END = 0.85  # of the opening's radius: the air beside it that moves along
_CONFINED = 1.25  # times the ratio of radii: by how much less of it moves in a tube
_SMALL = 1.0  # k a: above that an opening is no small one any more
_STEPS = 60  # of bisection


@dataclass(frozen=True)
class Cavity:
    """The air in a hollow body, open through a hole or slit.

    Parameters
    ----------
    volume : float
        Volume of the air, m^3.
    area : float
        Area of the opening, m^2.
    neck : float
        Thickness of the wall at the opening, m.
    level : float, optional
        Level of the lowest mode against the shape's loudest, dB. Give this or `wall`.
    t60 : float, optional
        Decay time of all modes, s. Default: as they radiate.
    length : float, optional
        Length of a tube with the opening at its end, m. Default: a cavity that is small beside the wave.
    wall : float, optional
        Mass per area of a wall that a blow dents, kg/m^2.

    Raises
    ------
    ValueError
        An argument does not fit; the text names it.

    Notes
    -----
    A dent takes all of a blow's momentum J and yields as a limp sheet does, by J/wall (m^3/s), for at least as long as
    the air's modes take for a radian.
    """

    volume: float
    area: float
    neck: float
    level: float | None = None
    t60: float | None = None
    length: float | None = None
    wall: float | None = None

    def __post_init__(self) -> None:
        if (self.level is None) == (self.wall is None):
            raise ValueError("level, wall: expected one of the two")
        if self.length is not None and self.area >= self.volume / self.length:
            section = self.volume / self.length
            raise ValueError(f"area = {self.area:g}: expected less than the tube's section, {section:g} m2")

    def lines(self, lowest: float) -> Lines:
        k, mass, drive = self._small() if self.length is None else self._column(self.length)
        omega = SPEED * k
        decay = DENSITY * omega**2 / (8 * math.pi * SPEED * mass)
        if self.length is not None:
            decay = decay + SPEED * wall_loss(math.sqrt(self.volume / (math.pi * self.length)), omega / (2 * math.pi))
        t60 = np.full(k.size, self.t60) if self.t60 else math.log(1000) / decay
        loudness = DENSITY * drive / (4 * math.pi * mass * omega)  # Pa for a dent that grows by 1 m^3/s from t = 0
        if self.wall is not None:
            return Lines(omega / (2 * math.pi), t60, np.zeros(k.size), None, loudness / self.wall)
        assert self.level is not None
        return Lines(omega / (2 * math.pi), t60, self.level + 20 * np.log10(loudness / loudness[0]), None)

    def _plug(self, inside: float) -> float:
        """Return the length L' (m) of the air that moves in the opening."""
        return self.neck + _END * math.sqrt(self.area / math.pi) * (1 + inside)

    def _small(self) -> tuple[Array, Array, Array]:
        """Return the wavenumber (1/m), mass (kg/m^4) and drive (Pa/m^3) of the one mode of a small cavity."""
        plug = self._plug(1.0)
        k = math.sqrt(self.area / (self.volume * plug))
        return np.array([k]), np.array([DENSITY * plug / self.area]), np.array([DENSITY * SPEED**2 / self.volume])

    def _column(self, length: float) -> tuple[Array, Array, Array]:
        """Return the same of a tube's modes, as far as the opening is small beside the wave; drive: rms over places."""
        section, radius = self.volume / length, math.sqrt(self.area / math.pi)
        plug = self._plug(max(1 - _CONFINED * radius / math.sqrt(section / math.pi), 0.0))
        ratio = plug * section / (self.area * length)
        count = max(math.floor(_SMALL / radius * length / math.pi), 1)
        low = np.arange(count) * math.pi
        high = low + math.pi / 2  # cot x falls from infinity to 0 between them
        for _ in range(_STEPS):
            x = (low + high) / 2
            before = 1 / np.tan(x) > x * ratio
            low, high = np.where(before, x, low), np.where(before, high, x)
        x = (low + high) / 2
        k = x / length
        moved = length / 2 * (1 - np.sinc(2 * x / math.pi)) / np.sin(x) ** 2
        mass = DENSITY * (plug / self.area + moved / section)
        spread = np.sqrt((1 + np.sinc(2 * x / math.pi)) / 2)
        return k, mass, DENSITY * SPEED**2 * k * spread / (section * np.abs(np.sin(x)))
