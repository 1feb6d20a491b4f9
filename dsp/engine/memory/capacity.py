"""The engine's room for modes and objects."""

from ...schema import CHANNELS
from ...sizes import CAPACITY
from .mounted import SENSORS

OBJECTS = CAPACITY.objects
MOST_CHANNELS = int(CHANNELS.high)
MODES = CAPACITY.modes
MODES_PER_OBJECT = 4_096
SHAPE_VALUES = 96 * MODES
"""Values in the table of mode shapes: 96 positions for every mode, shared as objects need them."""
FACE = 14
"""Values of a surface's triangle beside mode shapes: the row of its first corner, that row's corner and the next two
(m), the middle of the sphere about them and its radius."""
USUAL_OBJECTS = min(512, OBJECTS)
"""Room for objects where nothing else is requested."""
USUAL_MODES = min(131_072, MODES)
DIRECTED = CAPACITY.directed
"""Most modes of an object that a contact with a direction acts on."""
STEMS = CAPACITY.stems
RAMPS = CAPACITY.ramps


def check_sizes(channels: int, modes: int, objects: int, sensors: int = 0) -> None:
    """Check the sizes of an engine; ValueError names the first that is not possible."""
    most_sensors = min(SENSORS, MOST_CHANNELS - channels)
    if channels <= MOST_CHANNELS and not 0 <= sensors <= most_sensors:
        raise ValueError(f"sensors = {sensors}: expected 0 to {most_sensors}, beside {channels} channels")
    most = int(CHANNELS.high), MODES, OBJECTS
    for name, value, high in zip(("channels", "modes", "objects"), (channels, modes, objects), most, strict=True):
        if not 1 <= value <= high:
            raise ValueError(f"{name} = {value}: expected 1 to {high}")
