"""A step's touches and poses as rows of numbers, as Touch and Pose have them, into the tracker's memory."""

import math
from typing import Annotated

import numpy as np

from ...dsp.native.jit import kernel, noinline_kernel
from ...dsp.native.typed import Record, View, View2D, dtype_of
from ...dsp.numerics.quantities import Range
from .tracking.state import BODIES, POINTS, State

RANGES = {
    "approach": Range(-1e5, 1e5, "m/s"), "slip": Range(0.0, 1e5, "m/s"), "depth": Range(-1e5, 1e5, "m"),
    "force": Range(-1e12, 1e12, "N"), "mass": Range(1e-15, 1e9, "kg"), "restitution": Range(0.0, 1.0),
    "friction": Range(0.0, 1e6), "impulse": Range(0.0, 1e6, "N s"),
}  # fmt: skip
"""The range of each quantity of a touch that a simulator may report, in their order in a row. A body may be lighter or
heavier than what a gesture's striker may be: a blow has the nearest mass that it may have."""
FARTHEST = 1e6
"""m, m/s, rad/s: of a point, and of a body's place, velocity and spin along each axis, at most."""
UNIT = 1e-3
"""Share by which a normal's or a quaternion's length may differ from 1."""

_POINT, _NORMAL, _TOLD = 2, 5, 8  # places in a row of a touch, which begins with the numbers of both bodies
TOUCH_ROW = _TOLD + len(RANGES)
_PLACE, _TURN, _VELOCITY, _SPIN = 1, 4, 8, 11  # places in a row of a pose, which begins with the body's number
POSE_ROW = _SPIN + 3
_LEAST = np.array([each.low for each in RANGES.values()])
_MOST = np.array([each.high for each in RANGES.values()])


class Rows(Record):
    """A step as rows."""

    time: float  # s
    points: int  # contacts
    poses: int  # bodies that have moved
    laid: int  # 1: both are rows here; 0: they are in the tracker's columns already
    touches: Annotated[View2D[float], POINTS, TOUCH_ROW]
    moved: Annotated[View2D[float], BODIES, POSE_ROW]


ROWS = dtype_of(Rows)


@noinline_kernel
def take_rows(state: State, rows: Rows) -> bool:
    """Copy touches and poses into the tracker's memory; return False, and copy nothing, if one of them cannot be."""
    for n in range(rows.points):
        if not can_be_touch(rows.touches[n]):
            return False
    for n in range(rows.poses):
        if not can_be_pose(rows.moved[n]):
            return False
    for n in range(rows.points):
        take_touch(state, n, rows.touches[n])
    for n in range(rows.poses):
        take_pose(state, rows.moved[n])
    return True


@kernel
def can_be_touch(row: View[float]) -> bool:
    """True for a touch that can be: what is not reported of it is NaN."""
    fits = _is_near(row, _POINT, _TOLD) and _has_length(row, _NORMAL, _TOLD)
    for k in range(len(_LEAST)):
        value = row[_TOLD + k]
        fits = fits and (value != value or _LEAST[k] <= value <= _MOST[k])
    return fits and (row[_TOLD] != row[_TOLD] or row[_TOLD + 7] != row[_TOLD + 7])  # approach or impulse


@kernel
def can_be_pose(row: View[float]) -> bool:
    """True for a pose that can be."""
    return _is_near(row, _PLACE, POSE_ROW) and _has_length(row, _TURN, _VELOCITY)


@kernel
def _is_near(row: View[float], first: int, last: int) -> bool:
    """True if numbers of a row are at most FARTHEST."""
    near = True
    for k in range(first, last):
        near = near and abs(row[k]) <= FARTHEST
    return near


@kernel
def _has_length(row: View[float], first: int, last: int) -> bool:
    """True if numbers of a row have a length of 1."""
    square = 0.0
    for k in range(first, last):
        square += row[k] * row[k]
    return abs(math.sqrt(square) - 1.0) <= UNIT


@kernel
def take_touch(state: State, n: int, row: View[float]) -> None:
    """Copy a touch into the tracker's columns."""
    state.pair[n, 0], state.pair[n, 1] = int(row[0]), int(row[1])
    for k in range(3):
        state.point[n, k], state.normal[n, k] = row[_POINT + k], row[_NORMAL + k]
    state.approach[n], state.slip[n], state.depth[n] = row[_TOLD], row[_TOLD + 1], row[_TOLD + 2]
    state.force[n], state.mass[n] = row[_TOLD + 3], row[_TOLD + 4]
    state.restitution[n], state.friction[n], state.impulse[n] = row[_TOLD + 5], row[_TOLD + 6], row[_TOLD + 7]


@kernel
def take_pose(state: State, row: View[float]) -> None:
    """Copy a body's pose into the tracker's columns."""
    body = int(row[0])
    for k in range(3):
        state.position[body, k] = state.about[body, k] = row[_PLACE + k]
        state.velocity[body, k], state.spin[body, k] = row[_VELOCITY + k], row[_SPIN + k]
    turn = rotation(row[_TURN], row[_TURN + 1], row[_TURN + 2], row[_TURN + 3])
    for k in range(9):
        state.turn[body, k] = turn[k]


@kernel
def rotation(w: float, x: float, y: float, z: float) -> tuple[float, ...]:
    """Return the rotation matrix of a quaternion, row by row."""
    return (
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    )  # fmt: skip
