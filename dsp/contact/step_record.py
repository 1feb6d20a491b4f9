"""The record of a step of contacts that have no closed form (`collocation.py`)."""

from typing import Annotated

from ..native.typed import Record, View, View2D, dtype_of

NODES = 3
"""Gauss nodes of a step."""


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
