"""Space as a command sets it: a place that is gone to, a listener, walls."""

from typing import Annotated

from ...native.typed import Record, View, dtype_of


class Told(Record):
    """Space as a command sets it: a pose, and for a listener or a room their values."""

    pose: Annotated[View[float], 7]
    over: float  # s
    values: Annotated[View[float], 16]


TOLD = dtype_of(Told)
