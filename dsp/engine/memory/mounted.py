"""A sensor as a command mounts it: a contact microphone, an accelerometer."""

from typing import Annotated

from ...native.typed import Record, View
from ...sizes import CAPACITY

SENSORS = CAPACITY.sensors
"""Sensors that an engine can have, each with a channel of its own after those of the sound."""


class Mounted(Record):
    """A sensor as a command mounts it."""

    acceleration: int  # 1; 0: it senses velocity
    position: float  # along the object's strike path
    on_surface: int  # 1: it is at the nearest point of the object's surface instead
    spot: Annotated[View[float], 3]  # m: to there
    direction: Annotated[View[float], 3]  # in which it senses, of length 1; zeros: along the normal
    filter: Annotated[View[float], 5]  # of its resonance: b0, b1, b2, a1, a2
    scale: float  # of a sample, for each unit of what is sensed
