"""The requests of a simulation to the sound, and the messages that say the same."""

from collections.abc import Iterable
from typing import NamedTuple

from ..osc.wire import Argument, Message

Point = tuple[float, ...]
"""Three coordinates (m) of a point of an object's surface; none where the object is touched at a place."""


class Said(NamedTuple):
    """A message that is carried out as it is: it makes a body's object."""

    time: float
    message: Message


class Blow(NamedTuple):
    """A blow on an object; by: what strikes and rings too, else empty. A restitution above 0 takes the place of the
    dissipation. Units as in the contact law; places are 0 to 1 on strike paths, points take their place, each with the
    contact's normal, outward, in the axes of the body."""

    time: float
    to: str
    by: str
    place: float
    by_place: float
    speed: float
    mass: float
    stiffness: float
    exponent: float
    dissipation: float
    restitution: float
    point: Point = ()
    by_point: Point = ()
    direction: Point = ()
    by_direction: Point = ()

    @property
    def message(self) -> Message:
        other = _other(self.by, self.by_place, self.by_point, self.by_direction)
        lost = ("restitution", self.restitution) if self.restitution else ("dissipation", self.dissipation)
        law = ("mass", self.mass, "stiffness", self.stiffness, *lost, "exponent", self.exponent)
        at = _at(self.place, self.point, self.direction)
        return Message(f"/object/{self.to}/impact", (self.speed, *at, *other, *law))


class Gains(NamedTuple):
    """The gains of an object in each channel."""

    time: float
    to: str
    gains: tuple[float, ...]

    @property
    def message(self) -> Message:
        return Message(f"/object/{self.to}/gains", self.gains)


class Slide(NamedTuple):
    """A slide that begins on an object; by: what slides and rings too, else empty. keys: of `/object/NAME/slide`, what
    holds for all slides of the pair there: its law, its surface, its friction."""

    time: float
    to: str
    by: str
    id: str
    place: float
    by_place: float
    slip: float
    sweep: float
    force: float
    seed: int
    keys: tuple[tuple[str, float | str], ...]
    point: Point = ()
    by_point: Point = ()

    @property
    def message(self) -> Message:
        other = _other(self.by, self.by_place, self.by_point)
        own = (part for pair in self.keys for part in pair)
        motion = ("force", self.force, "sweep", self.sweep, "id", self.id, "seed", self.seed)
        return Message(f"/object/{self.to}/slide", (self.slip, *_at(self.place, self.point), *other, *own, *motion))


class Lying(NamedTuple):
    """A rest that begins: an object lies on another one, or on a support. keys: its law and its mass, and where it
    lies on the other object; or the ground's resistance."""

    time: float
    to: str
    what: str
    id: str
    place: float
    load: float
    keys: tuple[tuple[str, float], ...]
    point: Point = ()
    by_point: Point = ()

    @property
    def message(self) -> Message:
        own = (part for pair in self.keys for part in pair)
        ground: tuple[Argument, ...] = ("by_point", *self.by_point) if self.by_point else ()
        at = *_at(self.place, self.point), *ground
        return Message(f"/object/{self.to}/rest", (self.what, *at, "load", self.load, *own, "id", self.id))


class Swarm(NamedTuple):
    """A swarm of blows on an object that begins. rate: 1/s; speed, evenness: as a shake has them; keys: what strikes,
    its law or a preset."""

    time: float
    to: str
    id: str
    place: float
    spread: float
    rate: float
    speed: float
    evenness: float
    seed: int
    keys: tuple[tuple[str, float | str], ...]

    @property
    def message(self) -> Message:
        own = (part for pair in self.keys for part in pair)
        steered = "speed", self.speed, "evenness", self.evenness
        named = "spread", self.spread, "id", self.id, "seed", self.seed
        return Message(f"/object/{self.to}/shake", (self.rate, self.place, *own, *steered, *named))


class Steering(NamedTuple):
    """A new value of a parameter of a slide, of a rest or of a swarm."""

    time: float
    id: str
    parameter: str
    value: float

    @property
    def message(self) -> Message:
        return Message(f"/gesture/{self.id}/{self.parameter}", (self.value,))


class Ending(NamedTuple):
    """The end of a slide, of a rest or of a swarm."""

    time: float
    id: str

    @property
    def message(self) -> Message:
        return Message(f"/gesture/{self.id}/stop", ())


Request = Said | Blow | Slide | Lying | Swarm | Gains | Steering | Ending
"""Each has the time (s) of the simulation at which it is heard."""


def _at(place: float, point: Point, direction: Point = ()) -> tuple[Argument, ...]:
    """Return the arguments that say where an object is touched, and along what, if not along its normal."""
    way: tuple[Argument, ...] = ("direction", *direction) if direction else ()
    return ("point", *point, *way) if point else (place,)


def _other(by: str, place: float, point: Point, direction: Point = ()) -> tuple[Argument, ...]:
    """Return the arguments that say what touches, with which place or point, and along what, if it rings."""
    if not by:
        return ()
    way: tuple[Argument, ...] = ("by_direction", *direction) if direction else ()
    return ("by", by, "by_point", *point, *way) if point else ("by", by, "by_position", place)


def in_order(requests: Iterable[Request]) -> list[Request]:
    """Order requests by their times; of one time as they came."""
    return sorted(requests, key=lambda request: request.time)
