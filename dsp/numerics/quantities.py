"""Bounds of every number that comes from outside: what it measures, by its unit, and the range that it may have.

A number whose range is not finite, or reaches beyond what its unit allows, can't be declared. So products of a few of
them neither overflow nor vanish, wherever a message, a preset, a score or a simulator takes them from.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple


class Bounds(NamedTuple):
    """What numbers of a unit measure, the least magnitude that is not 0, and the greatest."""

    measures: str
    least: float
    most: float


BOUNDS: Mapping[str, Bounds] = {
    "": Bounds("a share, a factor or a count", 1e-12, 2.0**63),
    "times": Bounds("a ratio", 1e-9, 1e6),
    "%": Bounds("a percentage", 1e-9, 100.0),
    "s": Bounds("a time", 1e-12, 1e9),
    "1/s": Bounds("a rate", 1e-9, 1e7),
    "Hz": Bounds("a frequency", 1e-6, 1e6),
    "semitones": Bounds("an interval", 1e-9, 120.0),
    "cents": Bounds("an interval", 1e-9, 1200.0),
    "m": Bounds("a length, or a place", 1e-12, 1e5),
    "m2": Bounds("an area", 1e-12, 1e6),
    "m3": Bounds("a volume", 1e-12, 1e6),
    "1/m": Bounds("a density along a line", 1e-9, 1e9),
    "degrees": Bounds("an angle", 1e-9, 360.0),
    "m/s": Bounds("a velocity", 1e-12, 1e5),
    "rad/s": Bounds("a spin", 1e-12, 1e6),
    "m/s^2": Bounds("an acceleration", 1e-9, 1e3),
    "kg": Bounds("a mass", 1e-15, 1e9),
    "kg/m": Bounds("a mass of a length", 1e-9, 1e3),
    "kg/m2": Bounds("a mass of an area", 1e-6, 1e6),
    "kg m2": Bounds("a moment of inertia", 1e-30, 1e15),
    "kg/m3": Bounds("a density", 1e-6, 1e9),
    "N": Bounds("a force", 1e-9, 1e12),
    "1/N": Bounds("a count for each force", 1e-9, 1e6),
    "N/m": Bounds("a stiffness, or a tension along an edge", 1e-6, 1e12),
    "N/m^a": Bounds("a stiffness of a contact", 1e-6, 1e21),
    "N s": Bounds("an impulse", 1e-12, 1e6),
    "N s/m": Bounds("a resistance", 1e-6, 1e12),
    "kg/s": Bounds("a resistance", 1e-9, 1e6),
    "s/m": Bounds("a dissipation of a contact", 1e-12, 1e6),
    "J": Bounds("an energy", 1e-18, 1e9),
    "1/J": Bounds("a change for each energy", 1e-9, 1e6),
    "Pa": Bounds("a pressure, or a modulus", 1e-9, 1e13),
    "Pa per m/s": Bounds("a pressure for each velocity", 1e-12, 1e6),
    "degrees Celsius": Bounds("a temperature", 1e-9, 1e3),
    "dB": Bounds("a level", 1e-9, 1000.0),
    "dBFS": Bounds("a level", 1e-9, 300.0),
}
"""The bounds of all numbers, by their unit."""


class Ranged:
    """What has a range of numbers of a unit, ends included. ValueError where it is not finite, or beyond its unit's
    bounds.

    In a range that reaches to 0 or across it, a number that is less than the least of its unit is 0: too
    little to matter.
    """

    low: float
    high: float
    unit: str
    or_zero: bool
    """0 is allowed besides, and says that there is none."""

    def __post_init__(self) -> None:
        if self.unit not in BOUNDS:
            raise ValueError(f"unit = {self.unit!r}: expected one of {', '.join(map(repr, BOUNDS))}")
        _, least, most = BOUNDS[self.unit]
        if not -most <= self.low < self.high <= most or (self.or_zero and self.low <= 0.0):
            raise ValueError(f"{self.allowed}: expected a range within {-most:g} to {most:g}")
        if any(0.0 < abs(end) < least for end in (self.low, self.high)):
            raise ValueError(f"{self.allowed}: expected no end that is less than {least:g}, but 0")

    @cached_property
    def least(self) -> float:
        """The least magnitude that is not taken for 0."""
        return BOUNDS[self.unit].least

    def within(self, value: float) -> float | None:
        """Return a number as it is used; None for one that is not in the range, as NaN is not."""
        if not self.low <= value <= self.high:
            return 0.0 if self.or_zero and value == 0 else None
        return 0.0 if -self.least < value < self.least else float(value)

    @property
    def bounds(self) -> str:
        """The range, with the unit; six digits that do not say a whole number are all of them."""
        ends = (f"{end:g}" if float(f"{end:g}") == end or end % 1 else f"{end:.0f}" for end in (self.low, self.high))
        return f"{' to '.join(ends)} {self.unit}".rstrip()

    @property
    def allowed(self) -> str:
        """The range, and 0 if that is allowed besides."""
        return f"0, or {self.bounds}" if self.or_zero else self.bounds

    @property
    def expected(self) -> str:
        """What an error says that is expected."""
        return f"0, or from {self.bounds}" if self.or_zero else f"a number from {self.bounds}"


@dataclass(frozen=True)
class Range(Ranged):
    """A range of numbers of a unit."""

    low: float
    high: float
    unit: str = ""
    or_zero: bool = False


@dataclass(frozen=True)
class Parameter(Ranged):
    """A number that users give: its name, the range that is allowed (bounds included), its unit and its meaning."""

    name: str
    low: float
    high: float
    unit: str = ""
    help: str = ""
    default: float | None = None
    """The value where none is given; None: it comes from the striker or the object, or it must be given."""
    useful: tuple[float, float] | None = None
    """The range that a fader should cover, by ratios where it spans more than a factor of 30; None: all there is."""
    steerable: bool = False
    """A running gesture takes a new value."""
    glide: float = 0.0
    """Time constant in s with which a running gesture approaches a new value; 0: at once."""
    whole: bool = False
    """Only whole numbers are allowed."""
    steered: str = ""
    """The time at which a running gesture takes a new value, if not at once."""
    or_zero: bool = False
    otherwise: str = ""
    """What the value is where none is given, if no number says it: "the striker's"."""

    def __str__(self) -> str:
        usual = f", usually {self.useful[0]:g} to {self.useful[1]:g}" if self.useful else ""
        return f"{self.name} {self.allowed}".rstrip() + usual

    @property
    def by_ratios(self) -> bool:
        """True if equal steps of it are equal ratios in the engine."""
        return self.unit in ("dB", "semitones")

    def in_engine(self, value: float) -> float:
        """Return a value as the engine takes it: dB as an amplitude, semitones as a ratio of frequencies, others
        unchanged."""
        if self.unit == "dB":
            return float(10.0 ** (value / 20.0))
        if self.unit == "semitones":
            return float(2.0 ** (value / 12.0))
        return value
