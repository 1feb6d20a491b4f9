"""The instruments of a plug-in, and their parameters."""

import math
from typing import NamedTuple

from ...dsp.macros import MACROS as OF_OBJECTS
from ...dsp.macros import NEUTRAL


class Macro(NamedTuple):
    """A parameter of an instrument. usual: NaN if it is the object's own; high: of STRIKER the last one's place."""

    name: str
    unit: str
    low: float
    high: float
    usual: float


MACROS = (
    Macro("Position", "", 0.0, 1.0, math.nan),
    Macro("Striker", "", 0.0, math.nan, 0.0),
    Macro("Tune", "semitones", -24.0, 24.0, 0.0),
    Macro("Decay", "times", 0.1, 10.0, 1.0),
    Macro("Damp", "", 0.0, 1.0, 0.0),
    Macro("Release damp", "", 0.0, 1.0, 0.0),
    Macro("Gain", "dB", -40.0, 12.0, 0.0),
    Macro("Pan", "", -1.0, 1.0, 0.0),
    *(Macro(name.capitalize(), "", each.number.low, each.number.high, NEUTRAL) for name, each in OF_OBJECTS.items()),
)
"""In the order of the enum in `clap/instrument.h`: hosts know them by their places."""


class Instrument(NamedTuple):
    """An object as a plug-in: the names by which hosts know it, and how the score makes it."""

    name: str
    description: str
    id: str
    position: float
    gain: float
    pan: float
    decay: float
    damp: float

    @property
    def title(self) -> str:
        """The name that a host shows."""
        return f"Carom {self.name}"

    @property
    def uri(self) -> str:
        """Its name in LV2."""
        return f"urn:{self.id.replace('.', ':')}"
