"""Blows, as the tracker found them, and what becomes of contacts."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .bodies import Body
from .requests import Blow
from .shapes import Vector
from .tracking.state import BLOW


class Hit(NamedTuple):
    """A blow between two bodies.

    Attributes
    ----------
    time : float
        In s.
    a, b : str
        Names of the bodies.
    speed : float
        Speed of the approach, m/s.
    mass : float
        Effective mass, kg.
    restitution : float
        0 to 1.
    impulse : float
        Impulse of a rigid blow, N s: mass speed (1 + restitution).
    point : (x, y, z)
        In m.
    normal : (x, y, z)
        From a to b.
    heard : bool
        Whether it was loud enough to be computed.
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
    """Counts of what happened, and what became of it.

    Attributes
    ----------
    hits : int
        Blows.
    faint : int
        Blows, slides and rolls that nobody would hear.
    over_budget : int
        Blows, slides and rolls left out, as too many came at once: those that would be heard least.
    loudest : float
        Level of the loudest of these, as an estimate, dB over 20 uPa; -200: there is none.
    gestures : int
        Slides and rolls that began.
    crowded : int
        Points of contact for which there was no room.
    rests : int
        Rests that began.
    grains : int
        Blows of grains, which are heard together.
    """

    hits: int = 0
    faint: int = 0
    over_budget: int = 0
    loudest: float = -200.0
    gestures: int = 0
    crowded: int = 0
    rests: int = 0
    grains: int = 0


def hits_of(blows: NDArray[np.void], bodies: Sequence[Body]) -> list[Hit]:
    """Return the blows of a step, from the bytes of records of the tracker's BLOW, (n,)."""
    columns: dict[str, list[Any]] = {name: blows.view(BLOW)[name].tolist() for name in Hit._fields}
    for name in "a", "b":
        columns[name] = [bodies[number].name for number in columns[name]]
    for name in "point", "normal":
        columns[name] = [tuple(vector) for vector in columns[name]]
    columns["heard"] = [bool(heard) for heard in columns["heard"]]
    return [Hit(*each) for each in zip(*columns.values(), strict=True)]


class Hits(Sequence[Hit]):
    """The blows of some steps, made when they are requested, from the bytes of the tracker's records, (n,) for each."""

    def __init__(self, steps: Sequence[NDArray[np.void]], bodies: Sequence[Body]) -> None:
        self._steps, self._bodies = steps, bodies

    @cached_property
    def _all(self) -> list[Hit]:
        return [hit for blows in self._steps for hit in hits_of(blows, self._bodies)]

    def __len__(self) -> int:
        return sum(map(len, self._steps))

    def __getitem__(self, place: Any) -> Any:
        return self._all[place]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, list | tuple | Hits) and self._all == list(other)

    def __add__(self, other: Sequence[Hit]) -> list[Hit]:
        return self._all + list(other)

    def __radd__(self, other: Sequence[Hit]) -> list[Hit]:
        return list(other) + self._all

    def __repr__(self) -> str:
        return repr(self._all)

    def __reduce__(self) -> tuple[type[list[Hit]], tuple[list[Hit]]]:
        return list, (self._all,)


def blows_of(blows: NDArray[np.void], bodies: Sequence[Body]) -> list[Blow]:
    """Return the blows to be heard, from the bytes of records of the tracker's BLOW, (n,)."""
    return [_asked(blow, bodies) for blow in blows.view(BLOW) if blow["heard"]]


def _asked(blow: np.void, bodies: Sequence[Body]) -> Blow:
    side = int(blow["side"])
    both = bodies[int(blow["a"])], bodies[int(blow["b"])]
    to, by = both[side], both[1 - side]
    place, by_place = float(blow["place"][side]), float(blow["place"][1 - side])
    points = [
        body.point(blow[name][n].tolist()) for name in ("local", "facing") for body, n in ((to, side), (by, 1 - side))
    ]
    met, mass, stiffness, exponent, dissipation, left = (
        float(blow[name]) for name in ("met", "mass", "stiffness", "exponent", "dissipation", "left")
    )
    its, by_place = (by.name, by_place) if by.rings else ("", 0.0)
    law = met, mass, stiffness, exponent, dissipation, left
    return Blow(float(blow["time"]), to.name, its, place, by_place, *law, *points)
