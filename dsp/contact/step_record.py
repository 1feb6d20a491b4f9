"""The record of a step of contacts that have no closed form (`collocation.py`)."""

from typing import Annotated

from ..native.typed import Record, View, View2D, dtype_of
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
    """One step: x_i = free_x_i - sum_j give_x_ij f_j, v_i = free_v_i - sum_j give_v_ij f_j."""

    # Given: the motion without the force, and how far the nodes' forces (N) change it.
    free_x: Annotated[View[float], NODES]  # m
    free_v: Annotated[View[float], NODES]  # m/s
    give_x: Annotated[View2D[float], NODES, NODES]  # m/N
    give_v: Annotated[View2D[float], NODES, NODES]  # m/(s N)
    # Found; `f` also says where to start.
    f: Annotated[View[float], NODES]  # N
    x: Annotated[View[float], NODES]
    v: Annotated[View[float], NODES]
    linear: Annotated[View2D[float], NODES, NODES + 1]


STEP = dtype_of(Step)
