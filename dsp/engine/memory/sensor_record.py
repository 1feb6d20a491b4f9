"""The record of a sensor on an object."""

from typing import Annotated

from ...native.typed import Record, View, View2D, dtype_of
from ...numerics.legendre import AHEAD
from ...resonator.sensed import SENSED_ROWS
from .capacity import MODES_PER_OBJECT
from .mounted import Mounted
from .records import ContactPoint


class SensorState(Record):
    """A sensor, what it needs of the modes under it, and what it has sensed in this quantum."""

    point: ContactPoint  # where it is; serial 0: on no object
    mounted: Mounted
    retuned: int  # of the object, when the rows were set
    count: int  # modes that it senses
    rows: Annotated[View2D[float], SENSED_ROWS, MODES_PER_OBJECT]
    pushed: float  # by forces over the sample: what they cause directly
    memory: Annotated[View[float], 2]  # of its filter
    sensed: Annotated[View[float], AHEAD]
    held: Annotated[View[float], AHEAD]  # what it sensed in the quantum before, as the limiter delays the sound


SENSOR = dtype_of(SensorState)
