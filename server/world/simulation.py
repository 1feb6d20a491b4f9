"""A simulation as it is told step by step, and the messages by which it is heard."""

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...dsp.tracking.state import BODIES, EVENTS, HIT, MOVE, REST, new_state
from ...dsp.tracking.track import track
from ...dsp.wording import expected
from ...presets import Presets
from ..osc.arguments import shown
from ..osc.wire import Argument, Message
from .bodies import Body, BodyMaker, WorldError, contact_of, duration
from .gestures import Gestures
from .hearing import Hearing, Listener, Placing
from .pairs import Pair, Surfaces, pair_of, restitution_of
from .shapes import Vector
from .told import Contacts, Pose, Poses, take_contacts, take_pose, vector

_BLOWS_IN = 0.05  # s: the time over which blows are counted
_PLACED = 0.02  # s between two looks at where bodies are
_LONGEST = 0.9  # s: of a blow
_DULLEST = 0.02  # restitution: with less, a blow would hardly end


class Timed(NamedTuple):
    """A message and the time (s) of the simulation at which it is heard."""

    time: float
    message: Message


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


class Simulation:
    """The bodies of a simulation, and what happens between them.

    presets: where materials, surfaces and objects are from. top: Hz, of modes. hearing: what is computed, and where it
    is heard. gravity: m/s^2. rest: m/s, below which an approach is no blow; half of what gravity gives in a step is
    none either. start: s, the time before the first step.
    """

    def __init__(
        self,
        presets: Presets,
        top: float,
        hearing: Hearing | None = None,
        gravity: float = 9.81,
        rest: float = 0.01,
        start: float = 0.0,
    ) -> None:
        for name, value in (("gravity", gravity), ("rest", rest), ("start", start)):
            if not (math.isfinite(value) and (value >= 0.0 or name == "start")):
                raise WorldError(f"{name} = {value}: expected a number that is not negative")
        assert track.address  # its code is loaded now, or compiled, and not in the first step
        self.bodies: list[Body] = []
        self.counts = Counts()
        self.hits: list[Hit] = []
        """The blows of the last step."""
        self.state = new_state(rest, gravity)
        self.state["time"] = start
        self.steps = 0
        self.blow_of: Callable[[np.void], tuple[float, float]] | None = None
        """What a simulator says of a blow (an EVENT): its effective mass (kg) and restitution; NaN: nothing."""
        self._presets = presets
        self._maker = BodyMaker(presets, top)
        self._surfaces = Surfaces(presets)
        self._numbers: dict[str, int] = {}
        self._pairs: dict[tuple[int, int], Pair] = {}
        self._listener = Listener(hearing or Hearing())
        self._placing = Placing()
        self._placed_at = -math.inf
        self._blows: deque[float] = deque()
        self._gestures = Gestures(self._listener.hearing.gestures, self._listener.hearing.seed)

    @property
    def time(self) -> float:
        """s: of the last step."""
        return float(self.state["time"][0])

    @property
    def touching(self) -> int:
        """The pairs of bodies that touch, or did a moment ago."""
        return int(self.state["touching"][0])

    @property
    def channels(self) -> int:
        """One for each microphone."""
        return len(self._listener.hearing.microphones)

    def number(self, name: str) -> int:
        """The number of a body, from 0 on. WorldError if there is none of that name."""
        if name not in self._numbers:
            known = expected(name, list(self._numbers)) if self._numbers else "there is no body yet"
            raise WorldError(f"body {shown(name)}: no such body; {known}")
        return self._numbers[name]

    def add(
        self, name: str, shape: str, size: ArrayLike, material: str, pose: Pose | None = None, **about: Argument
    ) -> list[Timed]:
        """Add a body, as BodyMaker makes it; the messages that make its object."""
        if name in self._numbers:
            raise WorldError(f"body {name}: there is one of that name already")
        if len(self.bodies) == BODIES:
            raise WorldError(f"body {name}: expected at most {BODIES} bodies")
        body = self._maker.make(name, shape, size, material, **about)
        number = len(self.bodies)
        record = self.state[0]
        record["lightness"][number] = 0.0 if body.held else 1.0 / body.mass
        record["yielding"][number] = 0.0 if body.held else 1.0 / np.array(body.inertia)
        record["reach"][number] = 0.5 * max(body.shape.edges)
        if pose is not None:
            take_pose(self.state, number, pose, f"body {name}")
        self.bodies.append(body)
        record["bodies"] = len(self.bodies)
        self._numbers[name] = number
        self._placed_at = -math.inf
        return [Timed(self.time, body.message())] if body.rings else []

    def take_back(self, name: str) -> None:
        """Forget the body that was added last."""
        if self.bodies and self.bodies[-1].name == name:
            self.bodies.pop()
            del self._numbers[name]
            self.state["bodies"] = len(self.bodies)

    def pair(self, a: str, b: str, **keys: Argument) -> None:
        """Say how the contact of two bodies differs from that of their materials: keys of `pairs.KEYS`."""
        first, second = sorted((self.number(a), self.number(b)))
        self._pairs[first, second] = pair_of(self._presets, a, b, keys)

    def restart(self, time: float) -> None:
        """Forget all that touches, and go on at another time (s); bodies and pairs stay."""
        self.state["time"], self.state["touching"] = time, 0
        self.state["place"] = 0
        self.hits = []
        self._blows.clear()
        self._placed_at = -math.inf
        self._listener = Listener(self._listener.hearing)
        self._gestures = Gestures(self._listener.hearing.gestures, self._listener.hearing.seed)

    def step(self, time: float, contacts: Contacts = (), poses: Poses | None = None) -> list[Timed]:
        """Take a step's contacts and poses; the messages of what happened since the step before."""
        where = f"step {self.steps + 1}"

        def number(name: str) -> int:
            try:
                return self.number(name)
            except WorldError as error:
                raise WorldError(f"{where}: {error}") from None

        for name, pose in (poses or {}).items():
            take_pose(self.state, number(name), pose, f"{where}: body {name}")
        return self.advance(time, take_contacts(self.state, contacts, number, where))

    def advance(self, time: float, points: int) -> list[Timed]:
        """As `step`, where poses and the contacts' points are in `state` already."""
        before = self.time
        if not before < time < math.inf:
            raise WorldError(f"step {self.steps + 1}: time = {time}: expected above {before}, that of the step before")
        found = track(self.state.ctypes.data, points, time)
        if found < 0:
            raise WorldError(f"step {self.steps + 1}: {self._fault(points)}")
        self.steps += 1
        self.hits = []
        self.counts.crowded = int(self.state["left_out"][0])
        messages = self._placed(before, time)
        if found:
            events = self.state["events"][0, : min(found, EVENTS)]
            kinds = events["kind"]
            messages += self._struck(events[kinds == HIT])
            messages += self._moved(events[kinds != HIT])
        return messages

    def _fault(self, points: int) -> str:
        """What of the last step is not finite."""
        record = self.state[0]
        for number, body in enumerate(self.bodies):
            for name in ("position", "turn", "velocity", "spin"):
                if not np.isfinite(record[name][number]).all():
                    return f"body {body.name}: {name} = {record[name][number].tolist()}"
        for point in range(points):
            pair = record["pair"][point].tolist()
            names = [self.bodies[n].name if 0 <= n < len(self.bodies) else f"number {n}" for n in pair]
            if not all(0 <= n < len(self.bodies) for n in pair):
                return f"bodies {names[0]}, {names[1]}: expected numbers below {len(self.bodies)}"
            for name in ("point", "normal"):
                if not np.isfinite(record[name][point]).all():
                    value = record[name][point].tolist()
                    return f"bodies {names[0]}, {names[1]}: {name} = {value}: expected finite numbers"
        return f"{points} contacts: expected finite numbers"

    def _placed(self, before: float, time: float) -> list[Timed]:
        """The gains of bodies that have moved, from time to time; they hold from the step before on."""
        if time - self._placed_at < _PLACED:
            return []
        self._placed_at = time
        gains = self._listener.gains(self.state["position"][0, : len(self.bodies)])
        changed = self._placing.changed(gains)
        return [
            Timed(before, Message(f"/object/{self.bodies[n].name}/gains", tuple(map(float, gains[n]))))
            for n in changed.tolist()
            if self.bodies[n].rings
        ]

    def _gain(self, number: int) -> float:
        """How loud a body is at the microphone that hears it best."""
        return float(np.abs(self._placing.told[number]).max())

    def _struck(self, events: NDArray[np.void]) -> list[Timed]:
        """The messages of blows that are heard."""
        judged = [self._judged(event) for event in events]
        while self._blows and self._blows[0] < self.time - _BLOWS_IN:
            self._blows.popleft()
        room = self._listener.hearing.blows - len(self._blows)
        messages = []
        for pressure, hit, message in sorted(judged, key=lambda each: -each[0]):
            self.counts.hits += 1
            if message is None or not self._listener.is_heard(pressure, hit.time):
                self.counts.faint += 1
                hit = hit._replace(heard=False)
            elif room <= 0:
                self.counts.over_budget += 1
                hit = hit._replace(heard=False)
            else:
                room -= 1
                self._blows.append(hit.time)
                messages.append(Timed(hit.time, message))
            self.hits.append(hit)
        return messages

    def _judged(self, event: np.void) -> tuple[float, Hit, Message | None]:
        """A blow: its pressure (Pa rms at a microphone), what it is, and its message if something rings."""
        first, second = int(event["a"]), int(event["b"])
        a, b = self.bodies[first], self.bodies[second]
        local = (vector(event["local"][0]), vector(event["local"][1]))
        stiffness, dissipation, exponent, _ = contact_of(a, b, local)
        speed, mass, told = float(event["speed"]), float(event["mass"]), float(event["restitution"])
        if self.blow_of:
            said = self.blow_of(event)
            mass, told = (old if math.isnan(new) else new for new, old in zip(said, (mass, told), strict=True))
        given = self._pairs[first, second].restitution if (first, second) in self._pairs else math.nan
        given = told if math.isnan(given) else given
        restitution = restitution_of(dissipation, speed) if math.isnan(given) else min(max(given, 0.0), 1.0)
        impulse = mass * speed * (1.0 + restitution)
        lasting = duration(mass, stiffness, speed)
        pressure = impulse * sum(
            body.loudness(lasting) * self._gain(n) for n, body in ((first, a), (second, b)) if body.rings
        )
        hit = Hit(
            float(event["time"]), a.name, b.name, speed, mass, restitution, impulse,
            vector(event["point"]), vector(event["normal"]), True,
        )  # fmt: skip
        to, by, at, by_at = _roles(a, b, local)
        if not to.rings or lasting > _LONGEST or not 1e-9 <= mass <= 1e6:
            return 0.0, hit, None
        lost = ("dissipation", dissipation) if math.isnan(given) else ("restitution", max(restitution, _DULLEST))
        other = ("by", by.name, "by_position", by.place(by_at)) if by.rings else ()
        law = ("mass", mass, "stiffness", stiffness, *lost, "exponent", exponent)
        return pressure, hit, Message(f"/object/{to.name}/impact", (min(speed, 1e3), to.place(at), *other, *law))

    def _moved(self, events: NDArray[np.void]) -> list[Timed]:
        """The messages of standing contacts that begin to slip or sweep, do so otherwise, or rest."""
        messages: list[Timed] = []
        for event in events:
            key = first, second = int(event["a"]), int(event["b"])
            a, b = self.bodies[first], self.bodies[second]
            local = (vector(event["local"][0]), vector(event["local"][1]))
            to, by, at, by_at = _roles(a, b, local)
            side = 0 if to is a else 1
            kind = int(event["kind"])
            if kind == REST:
                found = self._gestures.rest(key)
            elif kind == MOVE or key not in self._gestures.running:
                if not to.rings:
                    continue
                law = contact_of(a, b, local)
                pair = self._pairs.get(key, Pair())
                surface = pair.surface or self._surfaces.between(a, b)
                mass = 1.0 / max(float(self.state["lightness"][0, n]) for n in key)
                found = self._gestures.begin(key, event, side, (to, by), (to.place(at), by.place(by_at)),
                                             _sliding(law, mass, surface, pair))  # fmt: skip
                self.counts.over_budget += not found and kind == MOVE
                self.counts.gestures += bool(found)
            else:
                found = self._gestures.steer(key, event, side, to.place(at))
            messages += [Timed(float(event["time"]), message) for message in found]
        return messages


def _roles(a: Body, b: Body, local: tuple[Vector, Vector]) -> tuple[Body, Body, Vector, Vector]:
    """The body that is struck and the one that strikes, with the points: what rings is struck, the heavier rather."""
    if (a.rings, a.held, a.mass) >= (b.rings, b.held, b.mass):
        return a, b, local[0], local[1]
    return b, a, local[1], local[0]


def _sliding(
    law: tuple[float, float, float, float], mass: float, surface: str, pair: Pair
) -> Mapping[str, float | str]:
    """The keys of a slide: its contact's law, its surface, and what its pair says."""
    stiffness, _, exponent, radius = law
    return {"mass": mass, "stiffness": stiffness, "exponent": exponent, "radius": radius, "surface": surface,
            **pair.slide}  # fmt: skip


def at_times(messages: Iterable[Timed]) -> list[Timed]:
    """Messages by their times; of one time as they came."""
    return sorted(messages, key=lambda each: each.time)
