"""The table of an object's macros, as engine/bodies/reshaping.py reads it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..bodies.macros import Change
from ..engine.bodies.reshaping import AXES, COLUMNS, HEAD, ROWS
from ..numerics.constants import MACRO_NODES as NODES
from .plan import Plan


def table_of(plan: Plan, level: float, axes: Sequence[Sequence[Change]]) -> NDArray[np.float32]:
    """Return the values of a table: for a plan in the bank, whose output is `level` for 1 Pa, and the changes of its
    modes by setting and place."""
    size = plan.columns.shape[1]
    table = np.zeros(HEAD + ROWS * size, np.float32)
    head, rows = table[:HEAD].reshape(COLUMNS, AXES, NODES), table[HEAD:].reshape(-1, COLUMNS, size)
    own = plan.columns[:COLUMNS] * np.array([[1.0], [1.0], [level]])
    rows[0] = own
    rows[1] = own - rows[0].astype(np.float64)
    for axis, changes in enumerate(axes):
        for node, change in enumerate(changes):
            head[:, axis, node] = change.amplitude, change.pitch, change.stiffness
            to = rows[2 + axis * NODES + node]
            to[:] = np.array([[change.pitch], [change.loss], [change.sound]])
            to[1, plan.felt : plan.bent] = change.pitch  # a relief's damping ratio stays
            to[2, plan.bent : plan.heard] = change.click
            to[:, : plan.felt] = change.modes[:, plan.order]
    return table
