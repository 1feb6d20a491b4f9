"""A simulation as it is told step by step, and what is to be heard of it."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ...dsp.tracking.state import BODIES, EVENTS, HIT, MOVE, POINTS, REST, new_state
from ...dsp.tracking.track import track, track_arrays
from ...dsp.wording import expected
from ...presets import Presets
from ..osc.arguments import shown
from ..osc.wire import Argument
from .blows import Blows, Counts, Hit, Laws, roles
from .bodies import Body, BodyMaker, WorldError
from .gestures import Gestures
from .hearing import Hearing, Listener, Placing
from .pairs import Pair, Surfaces, pair_of
from .requests import Gains, Request, Said
from .step import Contacts, Event, Pose, Poses, events_of, take_contacts, take_pose


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
        self._track, self._track_arrays = track.bare, track_arrays.bare  # loaded now, or compiled
        self.bodies: list[Body] = []
        self._counts = Counts()
        self.hits: list[Hit] = []
        """The blows of the last step."""
        self.hearing = hearing or Hearing()
        self.state = new_state(rest, gravity, self.hearing.gestures)
        self.state["time"] = self.time = start
        self.steps = 0
        self._presets = presets
        self._maker = BodyMaker(presets, top)
        self._surfaces = Surfaces(presets)
        self._numbers: dict[str, int] = {}
        self._pairs: dict[tuple[int, int], Pair] = {}
        self._laws = Laws(self.bodies)
        listener = Listener(self.hearing)
        self._placing = Placing(self.hearing, self.state)
        self._blows = Blows(self.bodies, self._laws, self._pairs, listener, self._placing)
        self._gestures = Gestures(self.hearing.seed)
        events = self.state["events"][0]
        self._whole, self._floats = (events.view(kind).reshape(EVENTS, -1) for kind in (np.int64, np.float64))
        self._address = self.state.ctypes.data
        self._now = self.state["time"]

    @property
    def channels(self) -> int:
        """One for each microphone."""
        return len(self.hearing.microphones)

    @property
    def counts(self) -> Counts:
        """What was told since the beginning, and what became of it."""
        unheard, crowded = (int(self.state[name][0]) for name in ("unheard", "left_out"))
        return replace(self._counts, over_budget=self._counts.over_budget + unheard, crowded=crowded)

    def ask_of_blows(self, said: Callable[[Event], tuple[float, float]]) -> None:
        """Ask a simulator what it says of each blow: its effective mass (kg) and restitution; NaN: nothing."""
        self._blows.said = said

    def number(self, name: str) -> int:
        """The number of a body, from 0 on. WorldError if there is none of that name."""
        if name not in self._numbers:
            known = expected(name, list(self._numbers)) if self._numbers else "there is no body yet"
            raise WorldError(f"body {shown(name)}: no such body; {known}")
        return self._numbers[name]

    def add(
        self, name: str, shape: str, size: ArrayLike, material: str, pose: Pose | None = None, **about: Argument
    ) -> list[Request]:
        """Add a body, as BodyMaker makes it; what makes its object."""
        if name in self._numbers:
            raise WorldError(f"body {name}: there is one of that name already")
        if len(self.bodies) == BODIES:
            raise WorldError(f"body {name}: expected at most {BODIES} bodies")
        body = self._maker.make(name, shape, size, material, **about)
        number = len(self.bodies)
        record = self.state[0]
        record["lightness"][number] = 0.0 if body.held else 1.0 / body.mass
        record["yielding"][number] = 0.0 if body.held else 1.0 / np.array(body.inertia)
        record["rings"][number] = body.rings
        record["reach"][number] = 0.5 * max(body.shape.edges)
        if pose is not None:
            take_pose(self.state, number, pose, f"body {name}")
        self.bodies.append(body)
        record["bodies"] = len(self.bodies)
        self._numbers[name] = number
        return [Said(self.time, body.message())] if body.rings else []

    def take_back(self, name: str) -> None:
        """Forget the body that was added last."""
        if self.bodies and self.bodies[-1].name == name:
            self.bodies.pop()
            del self._numbers[name]
            self.state["bodies"] = len(self.bodies)
            self._laws.forget()

    def pair(self, a: str, b: str, **keys: Argument) -> None:
        """Say how the contact of two bodies differs from that of their materials: keys of `pairs.KEYS`."""
        first, second = sorted((self.number(a), self.number(b)))
        self._pairs[first, second] = pair_of(self._presets, a, b, keys)

    def restart(self, time: float) -> None:
        """Forget all that touches, and go on at another time (s); bodies and pairs stay."""
        self.wait(time)
        self.state["touching"] = self.state["place"] = self.state["heard"] = 0
        self.hits = []
        self._placing.silence()
        self._blows.restart(Listener(self.hearing))
        self._gestures = Gestures(self.hearing.seed)

    def wait(self, time: float) -> None:
        """Let time pass up to another (s), in which nothing is told."""
        self._now[0] = self.time = time

    def step(self, time: float, contacts: Contacts = (), poses: Poses | None = None) -> list[Request]:
        """Take a step's contacts and poses; what is to be heard of what happened since the step before."""
        where = f"step {self.steps + 1}"

        def number(name: str) -> int:
            try:
                return self.number(name)
            except WorldError as error:
                raise WorldError(f"{where}: {error}") from None

        for name, pose in (poses or {}).items():
            take_pose(self.state, number(name), pose, f"{where}: body {name}")
        return self.advance(time, take_contacts(self.state, contacts, number, where))

    def advance(self, time: float, points: int, arrays: int = 0) -> list[Request]:
        """As `step`, where poses and so many contacts are in `state` already, or in the arrays of a simulator: then the
        address of a record of ARRAYS."""
        before = self.time
        if not before < time < math.inf:
            raise WorldError(f"step {self.steps + 1}: time = {time}: expected above {before}, that of the step before")
        if arrays:
            found = self._track_arrays(self._address, arrays, points, time)
        else:
            found = self._track(self._address, points, time)
        if found < 0:
            raise WorldError(f"step {self.steps + 1}: {self._fault(points)}")
        self.steps += 1
        self.time = time
        if self.hits:
            self.hits = []
        return self._heard(before, found) if found or time >= self._placing.next else []

    def _fault(self, points: int) -> str:
        """What of the last step cannot be."""
        if points > POINTS:
            return f"{points} contacts: expected at most {POINTS}"
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

    def _heard(self, before: float, found: int) -> list[Request]:
        """What is to be heard of so many events since a time (s)."""
        count = min(found, EVENTS)
        events = events_of(self._whole[:count], self._floats[:count]) if count else []
        for event in events:
            if event.kind in (HIT, MOVE):
                self._sounds(event.a)
                self._sounds(event.b)
        placed = self._placing.look(self.time)
        requests: list[Request] = [Gains(before, self.bodies[n].name, tuple(gains)) for n, gains in placed]
        hits = [event for event in events if event.kind == HIT]
        if hits:
            requests += self._blows.heard(hits, self.time, self._counts, self.hits)
        for event in events:
            if event.kind != HIT:
                requests += self._moved(event)
        return requests

    def _sounds(self, number: int) -> None:
        """A body sounds, for as long as it rings, or on and on where it slides."""
        body = self.bodies[number]
        if body.rings:
            slides = any(number in pair for pair in self._gestures.running)
            self._placing.sounds(number, math.inf if slides else self.time + body.ringing)

    def _moved(self, event: Event) -> list[Request]:
        """What is to be heard of a standing contact that begins to slip or sweep, does so otherwise, or rests."""
        key = first, second = event.a, event.b
        a, b = self.bodies[first], self.bodies[second]
        to, by, at, by_at = roles(a, b, event.local)
        side = 0 if to is a else 1
        if event.kind == REST:
            ended = self._gestures.rest(key, event)
            for n in key if ended else ():
                self._sounds(n)
            return ended
        if key in self._gestures.running:
            return self._gestures.steer(key, event, side, to.place(at))
        law = self._laws.of(first, second, event.local)
        pair = self._pairs.get(key, Pair())
        surface = pair.surface or self._surfaces.between(a, b)
        mass = 1.0 / max(float(self.state["lightness"][0, n]) for n in key)
        begun = self._gestures.begin(key, event, side, (to, by), (to.place(at), by.place(by_at)),
                                     _sliding(law, mass, surface, pair))  # fmt: skip
        self._counts.gestures += 1
        for n in key:
            self._sounds(n)
        self._placing.next = self.time  # so that they are placed in the next step
        return begun


def _sliding(
    law: tuple[float, float, float, float], mass: float, surface: str, pair: Pair
) -> Mapping[str, float | str]:
    """The keys of a slide: its contact's law, its surface, and what its pair says."""
    stiffness, _, exponent, radius = law
    return {"mass": mass, "stiffness": stiffness, "exponent": exponent, "radius": radius, "surface": surface,
            **pair.slide}  # fmt: skip
