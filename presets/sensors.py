"""Presets of sensors: what is mounted on bodies to hear them."""

from __future__ import annotations

from typing import NamedTuple

from ..dsp.bodies.sensor import Sensor
from ..dsp.wording import expected
from .schema import NoPreset


class SensorPreset(NamedTuple):
    """A sensor, and where its figures are from."""

    sensor: Sensor
    description: str
    source: str


_MURATA = (
    "resonance: Murata, catalogue P37E (2015), free at its node; damping of a disc that is glued down: an estimate"
)

SENSORS = {
    "ideal": SensorPreset(Sensor(), "Acceleration as it is", "no resonance"),
    "velocity": SensorPreset(Sensor("velocity"), "Velocity as it is, as a laser vibrometer's", "no resonance"),
    "accelerometer": SensorPreset(
        Sensor("acceleration", 50_000.0, 0.02),
        "A small ceramic accelerometer, screwed on",
        "resonance: at least 50 kHz by the data sheet of PCB's 352C33; damping: an estimate",
    ),
    "mems": SensorPreset(
        Sensor("acceleration", 45_000.0, 0.05),
        "A micromechanical accelerometer for vibrations",
        "resonance: 45 kHz by the data sheet of Analog Devices' ADXL1004; damping: an estimate",
    ),
    "piezo-20": SensorPreset(Sensor("acceleration", 6_300.0, 0.1), "A piezo disc of 20 mm, 7BB-20-6", _MURATA),
    "piezo-27": SensorPreset(Sensor("acceleration", 4_600.0, 0.1), "A piezo disc of 27 mm, 7BB-27-4", _MURATA),
    "piezo-35": SensorPreset(Sensor("acceleration", 2_800.0, 0.1), "A piezo disc of 35 mm, 7BB-35-3", _MURATA),
}
"""Sensors by name."""


def sensor_of(name: str) -> Sensor:
    """Return the sensor of a preset. NoPreset if there is none."""
    if name not in SENSORS:
        raise NoPreset(f"no sensor {name!r}", lambda: expected(name, SENSORS))
    return SENSORS[name].sensor
