"""Grains: what so many small bodies do that a swarm is heard in place of their blows.

Of N blows in a time T with the impulse J and the energy E the swarm has as many: the rate N/T, and speeds v of which a
share exp(-(v/s)^k) is greater. Their means are s G(1 + 1/k) and s^2 G(1 + 2/k), with the gamma function G, so that

    G(1 + 1/k)^2/G(1 + 2/k) = J^2/(2 E N m (1 + e)^2),    s = 2 (1 + e) (E/J) G(1 + 1/k)/G(1 + 2/k)

for grains of mass m and restitution e. Where k is out of bounds the impulse and the energy stay, and the count gives.
"""

import math
import reprlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...dsp.contact.estimate import LONGEST_CONTACT, longest_estimate
from ...dsp.contact.law import restitution
from ...dsp.numerics.quantities import Range
from ...dsp.schema import MASS, MOST_BLOWS
from ...dsp.wording import expected
from ...presets import Presets
from ..osc.arguments import shown
from .bodies import Body
from .checks import WorldError, require_number
from .requests import Ending, Request, Steering, Swarm
from .tracking.grains import LINGERS
from .tracking.state import GRAINS, HEAPS

EVENEST, LEAST_EVEN = 10.0, 0.5
_IDLE = 0.5  # s without a blow, after which a swarm ends
_LEAST_SPREAD = 0.2
_AWAY = 0.05  # of a strike path, by which the blows must have moved to be reported
_HERTZ = 1.5
_ROUNDS = 5  # for a speed and the restitution there
_BOTH = 20.0 * math.log10(2.0)  # dB: two grains that hit each other sound at once
_DULLEST = 0.02  # restitution
_SLOWEST, _FASTEST = 1e-9, 100.0  # m/s
_SHARE, _FLOW = Range(0.0, 1e3), Range(1e-12, 1e12, or_zero=True)  # of a strike path; of a flow, in SI units
_SEEDS = 2**31
_LAW = ("mass", "stiffness", "exponent", "restitution")
_SUMS = ("count", "impulse", "energy", "momentum", "mass", "stiffness", "place", "square", "point")


_Key = tuple[int, int, int]
"""A kind, a body, and 1 where grains hit each other."""


class Flow(NamedTuple):
    """Blows of grains on a body over a time. blows: how many, which need not be whole; impulse: N s and energy: J
    of all."""

    blows: float
    impulse: float
    energy: float


class Course(NamedTuple):
    """The course of a shake: its rate (1/s), speed (m/s) and evenness."""

    rate: float
    speed: float
    evenness: float


def course_of(flow: Flow, seconds: float, mass: float, left: float) -> Course:
    """Return how a swarm of grains of a mass (kg) and a restitution goes that has a flow in so many seconds."""
    both, twice = mass * (1.0 + left), 2.0 * (1.0 + left) * flow.energy / flow.impulse
    wanted = flow.impulse / (both * flow.blows) / twice
    low, high = LEAST_EVEN, EVENEST
    for _ in range(40):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if _mean(middle) ** 2 < wanted * _square(middle) else (low, middle)
    evenness = math.sqrt(low * high)
    speed = min(max(twice * _mean(evenness) / _square(evenness), _SLOWEST), _FASTEST)
    rate = flow.impulse / (both * speed * _mean(evenness)) / seconds
    return Course(min(rate, MOST_BLOWS), speed, evenness)


def _mean(evenness: float) -> float:
    return math.gamma(1.0 + 1.0 / evenness)


def _square(evenness: float) -> float:
    return math.gamma(1.0 + 2.0 / evenness)


@dataclass
class _Running:
    """A swarm that goes on. mass: kg and left, the restitution: of its grains."""

    id: str
    mass: float
    left: float
    place: float
    course: Course
    silent: float = 0.0
    """s for which nothing was reported."""


class Grains:
    """The kinds of grains of a simulation, in its tracker's memory, and their swarms."""

    def __init__(self, presets: Presets, state: NDArray[np.void], bodies: Sequence[Body], seed: int) -> None:
        self._presets, self._state, self._bodies, self._seed = presets, state[0], bodies, seed
        self._kinds: dict[str, str] = {}  # their strikers by their names
        self._running: dict[_Key, _Running] = {}
        self._made = 0

    def declare(self, name: str, bodies: Sequence[int], striker: str) -> float:
        """Make bodies a kind of grains, or a striker if there are none; the exponent of their contacts. WorldError says
        what cannot be."""
        for what, value in (("grains", name), ("striker", striker)):
            if not isinstance(value, str):
                raise WorldError(f"{what} = {reprlib.repr(value)}: expected a name")
        if name in self._kinds:
            raise WorldError(f"grains {shown(name)}: there are some of that name already")
        if len(self._kinds) == GRAINS:
            raise WorldError(f"grains {shown(name)}: expected at most {GRAINS} kinds")
        if bool(striker) == bool(len(bodies)):
            raise WorldError(f"grains {shown(name)}: expected either bodies or a striker")
        exponent = _HERTZ
        if striker:
            try:
                exponent = self._presets.striker(striker).exponent
            except ValueError as error:
                raise WorldError(f"grains {shown(name)}: {error}") from None
        kind = len(self._kinds) + 1
        for number in bodies:
            if self._bodies[number].held or self._state["grain"][number]:
                what = "it is held" if self._bodies[number].held else "it is one of others"
                raise WorldError(f"grains {shown(name)}: body {self._bodies[number].name}: {what}")
        self._kinds[name] = striker
        ringing = [number for number in bodies if self._state["rings"][number]]
        self._state["grain"][list(bodies)], self._state["rings"][ringing[1:]] = kind, 0
        self._state["sounds"][kind] = ringing[0] if ringing else -1
        return exponent

    def take_back(self, name: str) -> None:
        """Forget the kind that was declared last."""
        kind = len(self._kinds)
        of_it = self._state["grain"][: len(self._bodies)] == kind
        for number in map(int, np.flatnonzero(of_it)):
            self._state["rings"][number], self._state["grain"][number] = self._bodies[number].rings, 0
        self._state["sounds"][kind] = -1
        del self._kinds[name]

    @property
    def some(self) -> bool:
        """True if there is a kind."""
        return bool(self._kinds)

    def restart(self) -> None:
        """Forget what goes on."""
        self._running.clear()
        self._state["piled"], self._state["told_at"] = 0, math.nan

    def poured(self) -> Callable[[], None]:
        """Return what takes back all that is poured from now on up to the end of the step."""
        state, time, piled = self._state, float(self._state["time"]), int(self._state["piled"])
        heaps, until, grains = state["heaps"].copy(), state["until"].copy(), int(state["grains"])

        def take_back() -> None:
            if float(state["time"]) == time:
                state["heaps"], state["until"], state["grains"], state["piled"] = heaps, until, grains, piled

        return take_back

    def pour(self, name: str, on: int, count: float, place: float | None, **told: float | None) -> None:
        """Add blows of grains on a body to the next report, of a speed (m/s, rms), an impulse (N s) or an energy (J).

        WorldError names what cannot be."""
        where = f"grains {shown(name)}"
        if not self._kinds.get(name):
            known = [each for each, striker in self._kinds.items() if striker]
            raise WorldError(f"{where}: no such grains with a striker; {expected(name, known)}")
        body, given = self._bodies[on], {key: value for key, value in told.items() if value is not None}
        if not given:
            raise WorldError(f"{where}: expected speed, impulse or energy")
        for key, value in (("count", count), ("position", place or 0.0), *given.items()):
            require_number(f"{where}: {key}", value, _SHARE if key == "position" else _FLOW)
        if not body.rings or not count or not all(given.values()):
            return
        mass, stiffness, _, exponent = self._presets.striker(self._kinds[name]).contact(body.material)
        flow, left = self._flow(name, body, count, given)
        heap = self._heap(list(self._kinds).index(name) + 1, on)
        momentum = flow.impulse / (1.0 + left)
        at = 0.5 if place is None else min(place, 1.0)
        heap["exponent"], weighed = exponent, (mass, stiffness, at, at * at)
        for key, value in zip(_SUMS, (*flow, momentum, *(momentum * each for each in weighed)), strict=False):
            heap[key] += value
        self._state["grains"] += round(count)
        until = float(self._state["time"]) + body.ringing + LINGERS
        self._state["until"][on] = max(self._state["until"][on], until)

    def _flow(self, name: str, body: Body, count: float, told: dict[str, float]) -> tuple[Flow, float]:
        """Return a flow of which some is reported, and the restitution; what is not reported is as of a gas."""
        preset = self._presets.striker(self._kinds[name])
        mass, _, dissipation, _ = preset.contact(body.material)
        left, speed = 1.0, told.get("speed") or math.sqrt(2.0 * told.get("energy", 0.0) / (count * mass))
        for _ in range(_ROUNDS):
            by_impulse = told.get("impulse", 0.0) / (count * mass * (1.0 + left) * _mean(2.0))
            left = preset.restitution or float(restitution(1.0, dissipation * (speed or by_impulse)))
            left = max(left, _DULLEST)
        speed = speed or by_impulse
        energy = told.get("energy", 0.5 * count * mass * speed * speed)
        return Flow(count, told.get("impulse", count * mass * (1.0 + left) * speed * _mean(2.0)), energy), left

    def _heap(self, kind: int, body: int) -> np.void:
        """Return the heap of a kind and a body. WorldError where there is no room."""
        heaps, count = self._state["heaps"], int(self._state["piled"])
        found: np.void
        for found in heaps[:count]:
            if (found["kind"], found["body"]) == (kind, body):
                return found
        if count == HEAPS:
            raise WorldError(f"grains: expected at most {HEAPS} bodies that they hit")
        self._state["piled"] = count + 1
        heaps[count] = 0
        heaps[count]["kind"], heaps[count]["body"] = kind, body
        found = heaps[count]
        return found

    def tell(self) -> list[Request]:
        """Return how swarms begin, go on and end by what was piled up since the last call."""
        state, requests = self._state, list[Request]()
        time, seconds = float(state["time"]), float(state["time"] - state["told_at"])
        heaps, kept = state["heaps"], 0
        for n in range(int(state["piled"])):
            key = int(heaps[n]["kind"]), int(heaps[n]["body"]), int(heaps[n]["both"])
            requests += self._told(key, heaps[n], time, seconds)
            if key in self._running:
                for name in _SUMS:
                    heaps[n][name] = 0.0
                heaps[kept] = heaps[n]
                kept += 1
        state["piled"], state["told_at"] = kept, time
        return requests

    def _told(self, key: _Key, heap: np.void, time: float, seconds: float) -> list[Request]:
        running, momentum = self._running.get(key), float(heap["momentum"])
        flow = Flow(float(heap["count"]), float(heap["impulse"]), float(heap["energy"]))
        if not min(momentum, flow.impulse, flow.energy) > 0.0:
            return self._pauses(key, time, seconds) if running else []
        place, spread = self._place(key[1], heap, momentum)
        if running is None:
            return self._begins(key, heap, flow, (time, seconds), (place, spread))
        running.silent, before = 0.0, running.course
        running.course = course_of(flow, seconds, running.mass, running.left)
        changes = zip(Course._fields, running.course, before, strict=True)
        found: list[Request] = [Steering(time, running.id, name, now) for name, now, was in changes if now != was]
        if abs(place - running.place) > _AWAY:
            running.place = place
            found.append(Steering(time, running.id, "position", place))
        return found

    def _pauses(self, key: _Key, time: float, seconds: float) -> list[Request]:
        """Return how a swarm goes on without a blow."""
        running = self._running[key]
        running.silent += seconds
        if running.silent >= _IDLE:
            del self._running[key]
            return [Ending(time, running.id)]
        paused, running.course = running.course.rate == 0.0, running.course._replace(rate=0.0)
        return [] if paused else [Steering(time, running.id, "rate", 0.0)]

    def _place(self, body: int, heap: np.void, momentum: float) -> tuple[float, float]:
        """Return where on a body's strike path blows fall, and over which share of it."""
        its, place = self._bodies[body], float(heap["place"]) / momentum
        if its.surfaced:
            return its.position(tuple(heap["point"] / momentum)), 0.5
        spread = math.sqrt(12.0 * max(float(heap["square"]) / momentum - place * place, 0.0))
        return min(max(place, 0.0), 1.0), min(max(spread, _LEAST_SPREAD), 1.0)

    def _begins(
        self, key: _Key, heap: np.void, flow: Flow, at: tuple[float, float], where: tuple[float, float]
    ) -> list[Request]:
        """Return how a swarm begins: not at all if its grains would stay too long where they land, as single ones."""
        (time, seconds), (place, spread), momentum = at, where, float(heap["momentum"])
        mass, left = float(heap["mass"]) / momentum, min(max(flow.impulse / momentum - 1.0, _DULLEST), 1.0)
        mass = min(max(mass, MASS.low), MASS.high)  # impulse and energy stay
        course = course_of(flow, seconds, mass, left)
        law = (mass, float(heap["stiffness"]) / momentum, float(heap["exponent"]), left)
        lost = 1.5 * (1.0 - left) / left
        if longest_estimate.py_func(course.speed, *law[:3], lost) > LONGEST_CONTACT:
            return []
        keys: tuple[tuple[str, float | str], ...] = tuple(zip(_LAW, law, strict=True))
        striker = list(self._kinds.values())[key[0] - 1]
        if striker:
            keys = (("striker", striker), *keys)
        if key[2]:
            keys = (*keys, ("gain", _BOTH))
        id, seed = f"grains.{self._made}", (self._seed + self._made) % _SEEDS
        self._made += 1
        self._running[key] = _Running(id, mass, left, place, course)
        return [Swarm(time, self._bodies[key[1]].name, id, place, spread, *course, seed, keys)]
