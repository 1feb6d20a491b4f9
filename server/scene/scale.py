"""The scale of samples: a share of full scale, by the levels of presets, or a pressure in Pa."""

from dataclasses import dataclass

from ...dsp.numerics.constants import FULL_SCALE_PRESSURE
from ...presets import ObjectPreset


@dataclass(frozen=True)
class Scale:
    """Levels of objects and of gestures on them. calibrated: samples are pascals, whatever the presets' levels."""

    calibrated: bool = False

    def object(self, preset: ObjectPreset) -> float:
        """The value of a sample for each Pa of an object."""
        return 1.0 if self.calibrated else _amplitude(preset.level) / FULL_SCALE_PRESSURE

    def gesture(self, preset: ObjectPreset, kind: str) -> float:
        """The amplitude of gestures of a kind on an object, times their own gain."""
        return 1.0 if self.calibrated else _amplitude(preset.gesture_levels.get(kind, 0.0))


def _amplitude(level: float) -> float:
    """The amplitude of a level in dB."""
    return float(10.0 ** (level / 20.0))
