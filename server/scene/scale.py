"""The scale of samples: a share of full scale, by the levels of presets, or a pressure in Pa."""

from typing import NamedTuple

from ...dsp.numerics.constants import FULL_SCALE_PRESSURE
from ...presets import ObjectPreset


class Scale(NamedTuple):
    """Levels of objects.

    calibrated: samples are pascals, whatever the presets' levels, times `amplified`. Else full_scale (Pa) is 1.0 of an
    object of level 0.
    """

    calibrated: bool = False
    full_scale: float = FULL_SCALE_PRESSURE
    amplified: float = 1.0

    def object(self, preset: ObjectPreset) -> float:
        """Return the value of a sample for each Pa of an object."""
        return self.at(preset.level)

    def at(self, level: float) -> float:
        """Return the value of a sample for each Pa of an object of a level (dB)."""
        return self.amplified if self.calibrated else _amplitude(level) / self.full_scale

    @property
    def said(self) -> str:
        """Meaning of a sample of 1.0, for the metadata of sound files."""
        return "1.0 is 1 Pa" if self.calibrated else f"1.0 is {self.full_scale:.6g} Pa of an object of level 0 dB"


USUAL_SCALE = Scale()


def _amplitude(level: float) -> float:
    """Return the amplitude of a level in dB."""
    return float(10.0 ** (level / 20.0))
