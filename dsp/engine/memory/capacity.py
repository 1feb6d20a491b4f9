"""The engine's room for modes and objects."""

from ...schema import CHANNELS
from .mounted import SENSORS

OBJECTS = 16_384
MOST_CHANNELS = int(CHANNELS.high)
MODES = 1_310_720
"""A million that are heard, and a quarter more for those beside them: reliefs, clicks, modes that are felt alone."""
MODES_PER_OBJECT = 4_096
SHAPE_VALUES = 96 * MODES
"""Values in the table of mode shapes: 96 positions for every mode, shared as objects need them."""
USUAL_OBJECTS = 512
"""Room for objects where nothing else is asked for."""
USUAL_MODES = 131_072
STEMS = 512
"""Objects whose shares of the mix can be kept."""
RAMPS = 4_096
"""Ramps that run or wait; each point of a list is one."""


def check_sizes(channels: int, modes: int, objects: int, sensors: int = 0) -> None:
    """Check the sizes of an engine; ValueError names the first that is not possible."""
    most_sensors = min(SENSORS, MOST_CHANNELS - channels)
    if channels <= MOST_CHANNELS and not 0 <= sensors <= most_sensors:
        raise ValueError(f"sensors = {sensors}: expected 0 to {most_sensors}, beside {channels} channels")
    most = int(CHANNELS.high), MODES, OBJECTS
    for name, value, high in zip(("channels", "modes", "objects"), (channels, modes, objects), most, strict=True):
        if not 1 <= value <= high:
            raise ValueError(f"{name} = {value}: expected 1 to {high}")
