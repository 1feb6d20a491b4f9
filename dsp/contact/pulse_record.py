"""The record of a force pulse that goes on (`closed_form.py`)."""

from typing import Annotated

from ..native.typed import Record, View, View2D, dtype_of

DEGREE = 12
"""Gauss nodes of a phase's time."""
ROOM = 16
"""Room for as many coefficients of its power series."""
NODES = 8
"""Gauss nodes of a phase of a pulse."""


class Pulse(Record):
    """State of one contact: phase 0 compresses, phase 1 releases."""

    time_series: Annotated[View2D[float], 2, ROOM]  # samples from the phase's contact end, over x = 2 zeta - 1
    slowness: Annotated[View[float], 2 * DEGREE]  # samples per zeta at the nodes
    node_time: Annotated[View[float], 2 * NODES]  # samples: see `find_nodes`
    node_impulse: Annotated[View[float], 2 * NODES]  # N s
    span: Annotated[View[float], 2]  # |U| at the contact end
    phase_time: Annotated[View[float], 2]  # samples
    w: Annotated[View[float], 2]  # mu v_in, negative in the release
    exponent: float
    momentum: float  # m v_in, N s
    restitution: float
    duration: float  # samples
    time: float  # samples since the beginning: how far the moments have been taken
    zeta: float
    u: float


PULSE = dtype_of(Pulse)
