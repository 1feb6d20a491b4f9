"""Blows: how hard each is, whether it is heard, and the law of its contact."""

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ..scene.limits import LONGEST_CONTACT, Contact, longest
from .bodies import Body, contact_of, duration
from .hearing import Listener, Placing
from .pairs import Pair, restitution_of
from .requests import Blow
from .shapes import Vector
from .step import Event

_BLOWS_IN = 0.05  # s: the time over which blows are counted
_DULLEST = 0.02  # restitution: with less, a blow would hardly end
_FASTEST = 1e3  # m/s
_MASSES = 1e-9, 1e6  # kg


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


@dataclass
class Counts:
    """What was told and what became of it. hits: blows; faint: of these, those that nobody would hear; over_budget:
    those left out as too many came at once, and the same of gestures; gestures: slides and rolls that began; crowded:
    points of contact that found no room."""

    hits: int = 0
    faint: int = 0
    over_budget: int = 0
    gestures: int = 0
    crowded: int = 0


class Candidate(NamedTuple):
    """A blow: its pressure (Pa rms at a microphone), what it is, and what is to be heard of it, if something rings."""

    pressure: float
    hit: Hit
    blow: Blow | None


class Laws:
    """The laws of the contacts of some bodies. Each is found once for its pair and its radii."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._bodies = bodies
        self._known: dict[tuple[int, int, float, float], tuple[float, float, float, float]] = {}

    def of(self, first: int, second: int, local: tuple[Vector, Vector]) -> tuple[float, float, float, float]:
        """As `contact_of`, of two bodies by their numbers."""
        a, b = self._bodies[first], self._bodies[second]
        key = first, second, a.shape.radius_at(local[0]), b.shape.radius_at(local[1])
        if key not in self._known:
            self._known[key] = contact_of(a, b, local)
        return self._known[key]

    def forget(self) -> None:
        """Find them anew: a body has gone."""
        self._known.clear()


class Blows:
    """Judges the blows of a simulation's bodies. said: what a simulator says of a blow: its effective mass (kg) and
    restitution; NaN: nothing."""

    said: Callable[[Event], tuple[float, float]] | None = None

    def __init__(
        self, bodies: Sequence[Body], laws: Laws, pairs: Mapping[tuple[int, int], Pair], listener: Listener,
        placing: Placing,
    ) -> None:  # fmt: skip
        self._bodies, self._laws, self._pairs = bodies, laws, pairs
        self._listener, self._placing = listener, placing
        self._times: deque[float] = deque()

    def restart(self, listener: Listener) -> None:
        """Forget what was heard."""
        self._listener = listener
        self._times.clear()

    def heard(self, events: Sequence[Event], now: float, counts: Counts, hits: list[Hit]) -> list[Blow]:
        """The blows of some events that are heard at a time (s); all are added to `hits`, and counted."""
        while self._times and self._times[0] < now - _BLOWS_IN:
            self._times.popleft()
        room = self._listener.hearing.blows - len(self._times)
        found = []
        for pressure, hit, blow in sorted(map(self._candidate, events), key=lambda each: -each.pressure):
            counts.hits += 1
            if blow is None or not self._listener.is_heard(pressure, hit.time):
                counts.faint += 1
                hit = hit._replace(heard=False)
            elif room <= 0:
                counts.over_budget += 1
                hit = hit._replace(heard=False)
            else:
                room -= 1
                self._times.append(hit.time)
                found.append(blow)
            hits.append(hit)
        return found

    def _candidate(self, event: Event) -> Candidate:
        first, second, local = event.a, event.b, event.local
        a, b = self._bodies[first], self._bodies[second]
        stiffness, dissipation, exponent, _ = self._laws.of(first, second, local)
        speed, mass, told = event.speed, event.mass, event.restitution
        if self.said:
            said = self.said(event)
            mass, told = (old if math.isnan(new) else new for new, old in zip(said, (mass, told), strict=True))
        if (first, second) in self._pairs and not math.isnan(own := self._pairs[first, second].restitution):
            told = own
        restitution = restitution_of(dissipation, speed) if math.isnan(told) else min(max(told, 0.0), 1.0)
        impulse = mass * speed * (1.0 + restitution)
        lasting = duration(mass, stiffness, speed)
        gains = self._placing.loudest
        pressure = impulse * (a.loudness(lasting) * gains[first] + b.loudness(lasting) * gains[second])
        hit = Hit(event.time, a.name, b.name, speed, mass, restitution, impulse, event.point, event.normal, True)
        to, by, at, by_at = roles(a, b, event)
        lost = (dissipation, 0.0) if math.isnan(told) else (0.0, max(restitution, _DULLEST))
        law = Contact(mass, stiffness, lost[0], exponent, lost[1])
        met = min(speed, _FASTEST)
        if not to.rings or not _MASSES[0] <= mass <= _MASSES[1] or longest(met, law) > LONGEST_CONTACT:
            return Candidate(0.0, hit, None)
        other, other_place = (by.name, by.place(by_at)) if by.rings else ("", 0.0)
        blow = Blow(event.time, to.name, other, to.place(at), other_place, met, mass, stiffness, exponent, *lost)
        return Candidate(pressure, hit, blow)


def roles(a: Body, b: Body, event: Event) -> tuple[Body, Body, Vector, Vector]:
    """The body that is struck and the one that strikes, with the points."""
    if event.side == 0:
        return a, b, event.local[0], event.local[1]
    return b, a, event.local[1], event.local[0]
