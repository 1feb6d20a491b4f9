"""The record of a step of contacts that have no closed form (`collocation.py`)."""

from typing import Annotated

from ..native.typed import Record, View, dtype_of
from ..numerics.legendre import FINE
from ..numerics.sums import AT_ONCE

NODES = 3
"""Gauss nodes of a step."""


def _in_lines(columns: int) -> int:
    """Return the number of columns, or so many more that `put_few` sets whole lines of them."""
    return -(-columns // AT_ONCE) * AT_ONCE


FREE_COUNT, GIVE_COUNT = _in_lines(3 * NODES + 2), _in_lines(2 * NODES * NODES + 3 * NODES)
SERIES_COUNT, PUSH_COUNT = _in_lines(FINE), _in_lines(NODES * FINE)
"""Products of a motion and of an answer; a power series, and what forces with an answer take off it
(`power_series.py`)."""


class Step(Record):
    """One step: compressions and their rates at its nodes, and the forces."""

    # Given: without the force.
    free_x: Annotated[View[float], NODES]  # m
    free_v: Annotated[View[float], NODES]  # m/s
    # Found; `f` also says where to start.
    f: Annotated[View[float], NODES]  # N
    x: Annotated[View[float], NODES]
    v: Annotated[View[float], NODES]


STEP = dtype_of(Step)
