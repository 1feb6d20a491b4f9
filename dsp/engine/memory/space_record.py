"""The records of space: a listener, lines in which the sound of objects travels, a room, and its late part."""

from enum import IntEnum
from typing import Annotated

from ...native.typed import Record, View, View2D, View3D, dtype_of, f32
from ...numerics.legendre import AHEAD
from ...sizes import CAPACITY
from .capacity import MOST_CHANNELS

LINES = CAPACITY.lines
FRAMES = 65_536
"""Frames that a line holds: the longest way is 468 m at 48 kHz. A power of two."""
KNOTS = FRAMES // AHEAD
"""Places of an object that a line holds: one for each quantum."""
PATHS = 7
"""Ways of a sound to the listener: the direct one, and by each of six walls."""
LATE_LINES = 16
WALLS_TOLD = 12
"""Numbers of a command for the walls and the late part."""
LATE_FRAMES = 16_384
"""Frames of each line of the late part. A power of two."""


class WallsChange(IntEnum):
    """What happens to a room's walls in this quantum."""

    NONE = 0
    FADE = 1  # those that are heard fade, and others come next
    COME = 2


# The same as plain numbers, which kernels compare with.
NO_CHANGE, WALLS_FADE, WALLS_COME = (int(change) for change in WallsChange)


class Pose(Record):
    """A place that is gone to evenly, and where it is now and was a quantum ago."""

    first: Annotated[View[float], 7]  # x y z (m), and the quaternion w x y z
    last: Annotated[View[float], 7]
    begin: float  # samples
    end: float
    now: Annotated[View[float], 7]
    before: Annotated[View[float], 7]


class Path(Record):
    """A way of a sound to the listener."""

    known: int  # 1: the rest is
    still: int  # 1: it goes on as it did
    place: float  # samples: when that left which arrives now
    slope: float  # samples a sample: how that goes on
    longer: Annotated[View[float], 2]  # samples by which the way to an ear is longer
    shadow: Annotated[View[float], 2]
    memory: Annotated[View2D[float], 2, 4]  # of each ear's filters: two of the air, and the shadow's
    air: Annotated[View[float], 2]  # poles of the air's filters
    gain: Annotated[View[float], MOST_CHANNELS]


class Line(Record):
    """A line: what an object has sounded, where it was, and its ways to the listener."""

    used: int
    number: int
    slot: int
    serial: int
    left: int  # 1: its object is gone, or in space no more
    since: int  # samples: before, it was silent
    last: int  # samples: after, it is silent
    written: int  # 1: in this quantum
    moved_at: int  # samples: the end of the quantum in which it last moved
    amplitude: float  # gain at the quantum's end
    pose: Pose
    paths: Annotated[View[Path], PATHS]


class Late(Record):
    """The late part of a room: a network of delays that feed each other."""

    on: int
    lengths: Annotated[View[int], LATE_LINES]
    feedback: Annotated[View[float], LATE_LINES]  # of low frequencies, each way
    pole: Annotated[View[float], LATE_LINES]  # of the filter that lets high ones go sooner
    memory: Annotated[View[float], LATE_LINES]
    input: float  # amplitude
    at: int
    energy: float  # what it holds
    sound: Annotated[View2D[float], LATE_LINES, LATE_FRAMES]
    fed: Annotated[View[float], AHEAD]


class Space(Record):
    """All of it."""

    on: int  # 1: there is a listener
    now: int  # samples: this quantum's end
    layout: int  # Layout (space/layouts.py)
    order: int
    head: float  # m
    speed: float  # m/s
    air: float  # dB/m at one frequency
    turned: float  # the cosine of what that turns by in a sample
    listener: Pose
    stays: int  # 1: the listener is where it was a quantum ago
    walls: int  # 0, 1 (a floor) or 6
    low: Annotated[View[float], 3]  # m: the room's corner
    high: Annotated[View[float], 3]  # m: the one across
    reflected: float  # amplitude
    walls_change: int  # WallsChange
    walls_told: Annotated[View[float], WALLS_TOLD]  # what comes
    fading: int  # 1: after a panic
    faded: int
    panicked: int  # samples: what left before fades
    lines: Annotated[View[Line], LINES]
    # By time first: what is heard of many lines in a quantum lies close together.
    knots: Annotated[View3D[float], KNOTS, LINES, 3]
    sounds: Annotated[View3D[f32], KNOTS, LINES, AHEAD]
    late: Late
    window: Annotated[View[float], 6 * AHEAD]
    places: Annotated[View[float], AHEAD]
    heard: Annotated[View2D[float], 2, AHEAD]
    weights: Annotated[View[float], AHEAD]
    taps: Annotated[View[float], 16]
    other: Annotated[View2D[float], 2, AHEAD]
    aim: Annotated[View[float], 4]
    asked: Annotated[View[float], MOST_CHANNELS]


SPACE = dtype_of(Space)
