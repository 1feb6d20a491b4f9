"""A step of a simulation: contacts and poses, in the ways in which simulators have them, into the tracker's memory."""

import math
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...dsp.arguments import explain_all_arguments
from ...dsp.wording import expected
from .checks import WorldError, array_of
from .rows import FARTHEST, POSE_ROW, RANGES, ROWS, TOUCH_ROW, UNIT, rotation
from .shapes import Vector
from .tracking.state import POINTS, TOLD


@explain_all_arguments
class Touch(NamedTuple):
    """A point at which two bodies touch, or are about to. What a simulator does not know is NaN.

    Attributes
    ----------
    a, b : str
        Names of the bodies.
    point : (x, y, z)
        m, in the world.
    normal : (x, y, z)
        Of length 1, from a to b.
    approach : float, optional
        Speed at which they approach before the simulator pushes them apart, m/s. Default: by the bodies' velocities.
    slip : float, optional
        Speed at which they slip over each other, m/s. Default: by the bodies' velocities.
    depth : float, optional
        Depth by which they overlap, m.
    force : float, optional
        Normal force, N.
    mass : float, optional
        Effective mass along the normal, kg. Default: that of two free bodies.
    restitution : float, optional
        0 to 1. Default: the materials'.
    friction : float, optional
        Coefficient of friction in the simulator.
    impulse : float, optional
        Impulse of the normal force in the step, N s, in place of `approach`: as physics engines report it.
    """

    a: str
    b: str
    point: Sequence[float]
    normal: Sequence[float]
    approach: float = math.nan
    slip: float = math.nan
    depth: float = math.nan
    force: float = math.nan
    mass: float = math.nan
    restitution: float = math.nan
    friction: float = math.nan
    impulse: float = math.nan


@explain_all_arguments
class Pose(NamedTuple):
    """The pose of a body, in the world's axes.

    Attributes
    ----------
    position : (x, y, z)
        Centre of mass, m.
    turn : (w, x, y, z), default (1, 0, 0, 0)
        Quaternion of its axes.
    velocity : (x, y, z), default 0
        Velocity of the centre of mass, m/s.
    spin : (x, y, z), default 0
        Angular velocity, rad/s.
    """

    position: Sequence[float]
    turn: Sequence[float] = (1.0, 0.0, 0.0, 0.0)
    velocity: Sequence[float] = (0.0, 0.0, 0.0)
    spin: Sequence[float] = (0.0, 0.0, 0.0)


class Event(NamedTuple):
    """Something that happened between two bodies, as the tracker's EVENT."""

    kind: int
    a: int
    b: int
    side: int
    contact: int
    slide: int
    gesture: int
    seed: int
    time: float
    point: Vector
    normal: Vector
    local: tuple[Vector, Vector]
    speed: float
    mass: float
    restitution: float
    motion: tuple[float, ...]
    stiffness: float
    exponent: float
    radius: float
    patch: float
    by_place: float


Contacts = Iterable[Touch] | Mapping[str, ArrayLike]
"""Touches, or the columns of these as arrays: `pair` (n, 2) of bodies' numbers, `point` (n, 3), `normal` (n, 3)."""

Poses = Mapping[str, Pose]

_ROWS: dict[str, tuple[int, ...]] = {"pair": (2,), "point": (3,), "normal": (3,), **dict.fromkeys(TOLD, ())}
_TOUCHES, _POSES = {Touch}, {Pose}
_HEAD, _TOUCH, _POSE = struct.Struct("=d3q"), struct.Struct(f"={TOUCH_ROW}d"), struct.Struct(f"={POSE_ROW}d")


class Layer:
    """Rows of touches and poses, into which a step is laid that is reported as most are."""

    def __init__(self) -> None:
        rows = np.zeros(1, ROWS)
        self._bytes = memoryview(rows).cast("B")  # type: ignore[arg-type]
        self.addresses = rows["time"].ctypes.data, rows["points"].ctypes.data, 0, rows.ctypes.data
        """Addresses of the time, of the number of contacts, of no delay of these, and of the rows, as
        `Simulation.telling` takes them."""
        assert ROWS.fields
        self._touches, self._moved = ROWS.fields["touches"][1], ROWS.fields["moved"][1]

    def tell(self, time: float, points: int) -> None:
        """Say that a step has so many contacts at a time (s), which are in the tracker's columns, as its poses are."""
        _HEAD.pack_into(self._bytes, 0, time, points, 0, 0)

    def lay(self, time: float, contacts: Contacts, poses: Poses | None, numbers: Mapping[str, int]) -> bool:
        """Lay out a step of a list of Touch and a dictionary of Pose, and return True; False for others, or if a body
        or a number cannot be read. numbers: of bodies."""
        moved = {} if poses is None else poses
        if not (isinstance(contacts, list | tuple) and len(contacts) <= POINTS and isinstance(moved, dict)):
            return False
        if not (_TOUCHES.issuperset(map(type, contacts)) and _POSES.issuperset(map(type, moved.values()))):
            return False
        put, to, at = _TOUCH.pack_into, self._bytes, self._touches
        try:
            for a, b, (x, y, z), (u, v, w), *told in contacts:
                put(to, at, numbers[a], numbers[b], x, y, z, u, v, w, *told)
                at += _TOUCH.size
            at = self._moved
            for name, ((x, y, z), (w, u, v, t), (p, q, r), (k, m, n)) in moved.items():
                _POSE.pack_into(to, at, numbers[name], x, y, z, w, u, v, t, p, q, r, k, m, n)
                at += _POSE.size
        except (KeyError, TypeError, ValueError, struct.error):
            return False
        _HEAD.pack_into(to, 0, time, len(contacts), len(moved), 1)
        return True


def take_contacts(
    state: NDArray[np.void], contacts: Contacts, number: Callable[[str], int], names: Sequence[str], where: str
) -> int:
    """Put contacts into the tracker's memory; how many they are.

    number: of a body; names: of all bodies; where: the step, for an error.
    """
    columns: Mapping[str, ArrayLike]
    if not isinstance(contacts, tuple | list) and isinstance(contacts, Mapping):
        columns = contacts
    else:
        touches = _touches(contacts, where)
        if not touches:
            return 0
        columns = _columns(touches, number)
    for name in columns:
        if name not in _ROWS:
            raise WorldError(f"{where}: contacts: {name}: {expected(name, _ROWS)}")
    if missing := [name for name in ("pair", "point", "normal") if name not in columns]:
        raise WorldError(f"{where}: contacts: {missing[0]} is missing: expected pair, point and normal")
    count = len(np.asarray(columns["pair"]))
    if count > POINTS:
        raise WorldError(f"{where}: {count} contacts: expected at most {POINTS}")
    for name, row in _ROWS.items():
        target = state[name][0, :count]
        if name not in columns:
            target[...] = np.nan
            continue
        given = array_of(f"{where}: contacts: {name}", columns[name], "numbers")
        if given.shape != (count, *row):
            raise WorldError(f"{where}: contacts: {name}, of shape {given.shape}: expected {(count, *row)}")
        if name == "pair":
            _check_pairs(given, names, where)
        target[...] = given
    _check_contacts(state, count, names, where)
    return count


def _touches(contacts: Any, where: str) -> list[Touch]:
    """Return contacts that are Touches; raise WorldError for others."""
    if isinstance(contacts, Touch) or not isinstance(contacts, tuple | list | Iterable):
        raise WorldError(f"{where}: contacts = {contacts!r}: expected a list of Touch, or arrays by name")
    touches = list(contacts)
    for each in touches:
        if not isinstance(each, Touch):
            raise WorldError(f"{where}: contacts: {each!r}: expected a Touch")
    return touches


def _check_pairs(pairs: NDArray[np.float64], names: Sequence[str], where: str) -> None:
    """Raise WorldError for a pair that is not of two bodies."""
    for pair in pairs[~((pairs >= 0) & (pairs < len(names)) & (pairs % 1 == 0)).all(axis=1)].tolist():
        shown = ", ".join(names[int(n)] if n in range(len(names)) else f"number {n:g}" for n in pair)
        raise WorldError(f"{where}: bodies {shown}: expected numbers below {len(names)}")


def _check_contacts(state: NDArray[np.void], count: int, names: Sequence[str], where: str) -> None:
    """Raise WorldError for the first contact of which something is reported that cannot be."""
    told = {name: state[name][0, :count] for name in _ROWS}
    lengths = np.linalg.norm(told["normal"], axis=1)
    wrong = {
        "point": (~(np.abs(told["point"]) <= FARTHEST).all(axis=1), f"numbers up to {FARTHEST:g}"),
        "normal": (~(np.abs(lengths - 1.0) <= UNIT), "one of length 1"),
    }
    for name, within in RANGES.items():
        values = told[name]
        wrong[name] = ~(np.isnan(values) | ((values >= within.low) & (values <= within.high))), within.expected
    both = ~(np.isnan(told["impulse"]) | np.isnan(told["approach"])), "one of approach and impulse"
    for name, (places, words) in (*wrong.items(), ("impulse", both)):
        for n in np.flatnonzero(places):
            a, b = (names[body] for body in told["pair"][n])
            raise WorldError(f"{where}: bodies {a}, {b}: {name} = {told[name][n].tolist()}: expected {words}")


def _columns(touches: list[Touch], number: Callable[[str], int]) -> Mapping[str, ArrayLike]:
    """Return the columns of touches."""
    a, b, *rest = zip(*touches, strict=True)
    pair = [(number(first), number(second)) for first, second in zip(a, b, strict=True)]
    named: dict[str, Any] = dict(zip(Touch._fields[2:], rest, strict=True))
    return {"pair": np.array(pair), **named}


def checked_poses(poses: Poses | None, number: Callable[[str], int], where: str) -> list[tuple[int, Pose]]:
    """Return the numbers of bodies that have moved, and their poses. where: the step, for an error."""
    if poses is None:
        return []
    if not isinstance(poses, Mapping):
        raise WorldError(f"{where}: poses = {poses!r}: expected a mapping from names to Pose")
    return [(number(name), checked_pose(pose, f"{where}: body {name}")) for name, pose in poses.items()]


def checked_pose(pose: Pose, where: str) -> Pose:
    """Return a pose; raise WorldError if it cannot be one. where: the body, and the step, for an error."""
    if not isinstance(pose, Pose):
        raise WorldError(f"{where}: {pose!r}: expected a Pose")
    for name, wanted, values in zip(Pose._fields, (3, 4, 3, 3), pose, strict=True):
        try:
            whole = len(values) == wanted and all(abs(each) <= FARTHEST for each in values)
        except TypeError:
            whole = False
        if not whole:
            shown = tuple(values) if isinstance(values, Iterable) else values
            raise WorldError(f"{where}: {name} = {shown}: expected {wanted} numbers up to {FARTHEST:g}")
    if abs(math.hypot(*pose.turn) - 1.0) > UNIT:
        raise WorldError(f"{where}: turn = {tuple(pose.turn)}: expected a quaternion of length 1")
    return pose


def put_pose(state: NDArray[np.void], body: int, pose: Pose) -> None:
    """Put a body's pose into the tracker's memory."""
    record = state[0]
    record["position"][body] = record["about"][body] = pose.position
    record["turn"][body] = rotation.py_func(*pose.turn)
    record["velocity"][body] = pose.velocity
    record["spin"][body] = pose.spin


def events_of(whole: NDArray[np.int64], numbers: NDArray[np.float64]) -> list[Event]:
    """Return the events of a step, from rows of EVENT as integers and as floats."""
    found = []
    for (kind, a, b, side, *numbered), row in zip(whole[:, :8].tolist(), numbers[:, 8:].tolist(), strict=True):
        contact, slide, gesture, seed = numbered
        time, x, y, z, nx, ny, nz, ax, ay, az, bx, by, bz, speed, mass, restitution, _, *moving = row
        *motion, stiffness, exponent, radius, patch, by_place = moving
        local = (ax, ay, az), (bx, by, bz)
        found.append(
            Event(kind, a, b, side, contact, slide, gesture, seed, time, (x, y, z), (nx, ny, nz), local, speed, mass,
                  restitution, tuple(motion), stiffness, exponent, radius, patch, by_place)
        )  # fmt: skip
    return found
