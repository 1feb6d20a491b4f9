"""Blows, as the tracker found them, and what becomes of contacts."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .bodies import Body
from .requests import Blow
from .shapes import Vector


class Hit(NamedTuple):
    """A blow between two bodies.

    time: s; speed: of the approach, m/s; mass: effective, kg; impulse: of a rigid blow, N s, mass speed (1 +
    restitution); point: m; normal: from a to b; heard: whether it was loud enough to be computed.
    """

    time: float
    a: str
    b: str
    speed: float
    mass: float
    restitution: float
    impulse: float
    point: Vector
    normal: Vector
    heard: bool


@dataclass(frozen=True)
class Counts:
    """What was told and what became of it. hits: blows; faint: of these, those that nobody would hear, and the same of
    gestures; over_budget: those left out as too many came at once, and the same of gestures, of which some had begun;
    gestures: slides and rolls that began; crowded: points of contact that found no room."""

    hits: int = 0
    faint: int = 0
    over_budget: int = 0
    gestures: int = 0
    crowded: int = 0


def hits_of(blows: NDArray[np.void], bodies: Sequence[Body]) -> list[Hit]:
    """The blows of a step, from records of the tracker's BLOW."""
    found = []
    for blow in blows:
        speed, mass, restitution, impulse = (float(blow[name]) for name in ("speed", "mass", "restitution", "impulse"))
        a, b = bodies[int(blow["a"])].name, bodies[int(blow["b"])].name
        point, normal = _vector(blow["point"]), _vector(blow["normal"])
        found.append(
            Hit(float(blow["time"]), a, b, speed, mass, restitution, impulse, point, normal, bool(blow["heard"]))
        )
    return found


def _vector(values: NDArray[np.float64]) -> Vector:
    x, y, z = values.tolist()
    return x, y, z


def blows_of(blows: NDArray[np.void], bodies: Sequence[Body]) -> list[Blow]:
    """What is to be heard of blows, from records of the tracker's BLOW."""
    return [_asked(blow, bodies) for blow in blows if blow["heard"]]


def _asked(blow: np.void, bodies: Sequence[Body]) -> Blow:
    side = int(blow["side"])
    both = bodies[int(blow["a"])], bodies[int(blow["b"])]
    to, by = both[side], both[1 - side]
    place, by_place = float(blow["place"][side]), float(blow["place"][1 - side])
    law = (float(blow[name]) for name in ("met", "mass", "stiffness", "exponent", "dissipation", "left"))
    return Blow(float(blow["time"]), to.name, by.name if by.rings else "", place, by_place if by.rings else 0.0, *law)
