"""A simulation as it is reported step by step, and what is to be heard of it."""

import math
from collections.abc import Sequence
from ctypes import c_double, c_int32
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...dsp.bodies.material import Material, contact_between
from ...dsp.numerics.quantities import Range
from ...dsp.runtime.meter import decibels
from ...dsp.wording import expected
from ...presets import Presets
from ..osc.arguments import shown
from ..osc.wire import Argument
from .blows import Counts, Hit, blows_of, hits_of
from .bodies import Body, BodyMaker, Progress
from .checks import WorldError, require_number
from .gestures import Gestures, id_of, seed_of
from .grains import Grains
from .hearing import Hearing, begin_hearing
from .pairs import SOFT, Pair, Surfaces, law_of, pair_of
from .requests import Gains, Lying, Request, Said, Slide, Steering
from .step import Contacts, Event, Layer, Pose, Poses, checked_pose, checked_poses, events_of, put_pose, take_contacts
from .telling import (
    LOOK,
    NO_ROOM,
    NOT_LATER,
    NOT_TAKEN,
    OBJECTS,
    SURFACES,
    TELLING,
    TEMPLATES,
    begin_telling,
    link_engine,
    tell,
)
from .tracking.skins import round_of, skin_of
from .tracking.state import BLOW, BODIES, CHANGING, EVENTS, LIE, MATERIALS, MOVE, POINTS, REST, new_state

RANGES = {
    "gravity": Range(0.0, 1e3, "m/s^2"), "rest": Range(0.0, 1e5, "m/s"), "start": Range(-1e9, 1e9, "s"),
    "settle": Range(0.0, 1e9, "s"), "time": Range(-1e9, 1e9, "s"),
}  # fmt: skip
"""The ranges of the numbers that a simulation is made with, or that are reported besides its steps."""


class Simulation:
    """The bodies of a simulation, and what happens between them.

    presets: where materials, surfaces and objects are from. top: Hz, of modes. hearing: what is computed, and where it
    is heard. gravity: m/s^2. rest: m/s, below which an approach is no blow; what gravity gives in a step is none
    either, of which 0.05 s count at most. start: s, the time before the first step. progress: shows how objects of
    meshes are made.
    """

    def __init__(
        self,
        presets: Presets,
        top: float,
        hearing: Hearing | None = None,
        gravity: float = 9.81,
        rest: float = 0.01,
        start: float = 0.0,
        progress: Progress | None = None,
    ) -> None:
        for name, value in (("gravity", gravity), ("rest", rest), ("start", start)):
            require_number(name, value, RANGES[name])
        self._tell = tell.brief  # loaded now, or compiled
        self.bodies: list[Body] = []
        self._hits: tuple[int, list[Hit]] = 0, []  # of a step
        self.hearing = hearing or Hearing()
        self._settle = 0.0
        self.state = new_state(rest, gravity)
        self.start = np.array([start])
        self.state["time"] = start
        self._microphones = begin_hearing(self.hearing, self.state)
        self._presets = presets
        self._maker = BodyMaker(presets, top, progress)
        self._surfaces = Surfaces(presets)
        self._numbers: dict[str, int] = {}
        self._skins: list[NDArray[np.float64]] = []
        self._pairs: dict[tuple[int, int], Pair] = {}
        self.materials: list[Material] = []
        """Materials of bodies, by their numbers."""
        self.surfaces: list[str] = []
        """Presets of bodies that slide on each other, as far as they are known, by their numbers."""
        self._gestures = Gestures()
        self.state["seed"] = seed_of(self.hearing.seed)
        self.grains = Grains(presets, self.state, self.bodies, seed_of(self.hearing.seed))
        events = self.state["events"][0]
        self._whole, self._floats = (events.view(kind).reshape(EVENTS, -1) for kind in (np.int64, np.float64))
        at = self.state["time"].ctypes.data, self.start.ctypes.data
        self._now, self._began = c_double.from_address(at[0]), c_double.from_address(at[1])
        self._steps = self.state["steps"]
        self._blows = self.state["blows"][0].view((np.void, BLOW.itemsize))
        self._order = self.state["order"][0]
        self.struck: NDArray[np.int64] = self.state["struck"]
        """(1,): number of blows of the last step."""
        self._telling = np.zeros(1, TELLING)
        self._objects = np.zeros(1, OBJECTS)
        self._templates = np.zeros(SURFACES, TEMPLATES)
        heard = {"state": self.state, "microphones": self._microphones}
        begin_telling(self._telling, **heard, objects=self._objects, templates=self._templates)
        self._layer = Layer()
        self._own = self.telling(0, *self._layer.addresses)
        self._own_at = self._own.ctypes.data

    def telling(self, arrays: int, time: int, points: int, behind: int = 0, rows: int = 0) -> NDArray[np.void]:
        """Return a record of TELLING, by which steps are reported, by addresses: of a record of ARRAYS, 0 for the
        columns of `state` or rows; of the time (s), a float64; of the number of contacts, an int32; of how far these
        lie before the time (s), a float64, 0 if they do not; of a record of ROWS, 0 for none. It is kept as long as
        this is."""
        made = self._telling.copy()
        made["arrays"], made["time"], made["points"], made["behind"] = arrays, time, points, behind
        made["rows"] = rows
        return made

    def link(self, engine: NDArray[np.void], latency: float) -> None:
        """Send steering of slides and gains of bodies straight to an engine, (1,) of its STATE, a latency (s) after the
        step; call it before anything is reported."""
        for each in (self._telling, self._own):
            each["start"], each["latency"] = self.start.ctypes.data, latency
            link_engine(each, engine)

    def has_object(self, name: str, slot: int, serial: int) -> None:
        """Say which object of the engine a body is."""
        self._objects[0, self.number(name)] = slot, serial

    def has_gesture(self, slide: str, gesture: int) -> None:
        """Say which gesture of the engine a slide or a rest is, by their ids."""
        for (a, b), id in self._gestures.running.items():
            if id == slide:
                self.state["pairs"]["gesture"][0, self.state["place"][0, a, b] - 1] = gesture

    @property
    def time(self) -> float:
        """s: of the last step."""
        return self._now.value

    @property
    def began(self) -> float:
        """s: the simulation's time at the beginning of its sound."""
        return self._began.value

    @property
    def steps(self) -> int:
        """Number of steps that were taken."""
        return int(self._steps[0])

    @property
    def hits(self) -> list[Hit]:
        """The blows of the last step, the loudest first."""
        if not self.struck[0]:
            return []
        if self._hits[0] != self.steps:
            self._hits = self.steps, hits_of(self.blows, self.bodies)
        return self._hits[1]

    @property
    def blows(self) -> NDArray[np.void]:
        """The blows of the last step, the loudest first, copied: the bytes of records of the tracker's BLOW, (struck,).

        NumPy copies bytes several times faster than records.
        """
        found: NDArray[np.void] = self._blows.take(self._order[: self.struck[0]])
        return found

    @property
    def channels(self) -> int:
        """One for each microphone."""
        return len(self.hearing.microphones)

    @property
    def microphones(self) -> np.void:
        """The microphones and their places, a record of MICROPHONE_STATE."""
        record: np.void = self._microphones[0]
        return record

    def hears_nearby(self) -> None:
        """Send no gains of bodies: a listener in space hears them by their places."""
        self._microphones["told"], self._microphones["step"] = 0.0, np.inf

    @property
    def counts(self) -> Counts:
        """Counts of what was reported since the beginning, and what became of it."""
        names = ("hits", "faint", "over_budget", "unheard", "begun", "left_out", "lain", "grains")
        hits, faint, over, unheard, begun, crowded, lain, grains = (int(self.state[name][0]) for name in names)
        loudest = decibels((float(self.state["loudest_unheard"][0]) / 20e-6) ** 2)
        return Counts(hits, faint, over + unheard, loudest, begun, crowded, lain, grains)

    def number(self, name: str) -> int:
        """Return the number of a body, from 0 on. WorldError if there is none of that name."""
        if not isinstance(name, str) or name not in self._numbers:
            known = expected(name, list(self._numbers)) if self._numbers else "there is no body yet"
            raise WorldError(f"body {shown(name)}: no such body; {known}")
        return self._numbers[name]

    def add(
        self, name: str, shape: str, size: ArrayLike, material: str, pose: Pose | None = None, **about: Argument
    ) -> list[Request]:
        """Add a body, as BodyMaker makes it; what makes its object."""
        return self.put(self._maker.make(name, shape, size, material, **about), pose)

    def put(self, body: Body, pose: Pose | None = None) -> list[Request]:
        """Add a body that was made; what makes its object."""
        name, number = body.name, len(self.bodies)
        if name in self._numbers:
            raise WorldError(f"body {name}: there is one of that name already")
        if number == BODIES:
            raise WorldError(f"body {name}: expected at most {BODIES} bodies")
        record = self.state[0]
        record["lightness"][number] = 0.0 if body.held else 1.0 / body.mass
        record["yielding"][number] = 0.0 if body.held else 1.0 / np.array(body.inertia)
        record["rings"][number], record["surfaced"][number] = body.rings, body.surfaced
        record["reach"][number] = 0.5 * max(body.shape.edges)
        record["edges"][number], record["strip"][number] = body.shape.edges, body.shape.strip
        record["round"][number], record["flat"][number] = body.shape.round, body.shape.flat
        record["ringing"][number] = body.ringing
        if body.surfaced and body.modes and body.modes.faces:
            self._skins.append(skin_of(body.modes.faces))
            record["skin"][number], record["skin_faces"][number] = self._skins[-1].ctypes.data, len(self._skins[-1])
            record["round"][number] = round_of(body.modes.faces, float(record["reach"][number]))
        record["loudness"][number], record["material"][number] = body.loudness(), self.number_of_material(body.material)
        if pose is not None:
            put_pose(self.state, number, checked_pose(pose, f"body {name}"))
        self.bodies.append(body)
        record["bodies"] = len(self.bodies)
        self._numbers[name] = number
        return [Said(self.time, body.message())] if body.rings else []

    def number_of_material(self, material: Material) -> int:
        """Return the number of a material, of whose contacts with the others the law is known from then on."""
        if material not in self.materials:
            if len(self.materials) == MATERIALS:
                raise WorldError(f"material {material.name}: expected at most {MATERIALS} materials")
            self.materials.append(material)
            number = len(self.materials) - 1
            for n, other in enumerate(self.materials):
                law = contact_between(material, other, 1.0)
                self.state["law"][0, number, n] = self.state["law"][0, n, number] = law
                surface = self._surface(material, other)
                self.state["surface"][0, number, n] = self.state["surface"][0, n, number] = surface
        return self.materials.index(material)

    def _surface(self, a: Material, b: Material) -> int:
        """Return 1 and the number of the surface on which bodies of two materials slide; 0 where there is no room for
        it."""
        name = self._surfaces.between(a, b)
        if name not in self.surfaces:
            if len(self.surfaces) == SURFACES:
                return 0
            self.surfaces.append(name)
        return self.surfaces.index(name) + 1

    def has_template(self, surface: str, command: NDArray[np.void], least: float) -> None:
        """Say which command, (1,) of COMMAND, is a slide on a surface, and from which radius (m) on."""
        self._templates[self.surfaces.index(surface)] = least, command[0]

    def position_of(self, number: int, place: Sequence[float], what: str) -> float:
        """Return the position on a body's strike path that is nearest to a place (m) in its axes.

        WorldError for what is no place.
        """
        point = np.array(place, np.float64) if np.size(place) == 3 else np.full(3, np.nan)
        if not np.isfinite(point).all():
            raise WorldError(f"{what}: place = {place}: expected three numbers (m)")
        return self.bodies[number].position((float(point[0]), float(point[1]), float(point[2])))

    def take_back(self, name: str) -> None:
        """Forget the body that was added last."""
        if self.bodies and self.bodies[-1].name == name:
            self.bodies.pop()
            del self._numbers[name]
            self.state["bodies"] = len(self.bodies)

    def pair(self, a: str, b: str, **keys: Argument) -> None:
        """Say how the contact of two bodies differs from that of their materials: keys of `pairs.KEYS`."""
        first, second = sorted((self.number(a), self.number(b)))
        if first == second:
            raise WorldError(f"pair {a}, {b}: expected two bodies")
        pair = self._pairs[first, second] = pair_of(self._presets, a, b, keys)
        soft = SOFT.index(pair.support) if pair.support else -1
        self.state["support"][0, first, second] = soft + 1
        if soft >= 0:
            self.state["supports"][0, soft] = law_of(pair.support)
        self.state["slides_so"][0, first, second] = bool(pair.surface or pair.slide)
        self.state["bounce"][0, first, second] = 0.0 if math.isnan(pair.restitution) else 1.0 + pair.restitution

    def restart(self, time: float) -> None:
        """Forget all that touches, and go on at another time (s); bodies and pairs stay."""
        self.wait(time)
        for name in ("touching", "place", "heard", "lying", "sliding", "heard_blows", "loudest", "struck", "made"):
            self.state[name] = 0
        self.state["until"] = self.state["rung"] = self.state["loudest_at"] = -math.inf
        self._microphones["next"] = math.inf
        self._gestures = Gestures()
        self.grains.restart()
        self.settle(self._settle)

    def begin(self, time: float) -> None:
        """Begin its sound at a time (s), before anything was reported."""
        self._began.value = time
        self.wait(time)

    def settle(self, seconds: float) -> None:
        """Report no blow for a time (s) from now on, and from each time on at which it begins anew."""
        require_number("settle", seconds, RANGES["settle"])
        self._settle = seconds
        self.state["settles"] = self.time + seconds if seconds else -math.inf

    def wait(self, time: float) -> None:
        """Pass the time up to another (s), in which nothing is reported."""
        self._now.value = time

    def step(self, time: float, contacts: Contacts = (), poses: Poses | None = None) -> list[Request]:
        """Take a step's contacts and poses; what is to be heard of what happened since the step before."""
        comes = isinstance(time, float) and self.time < time <= RANGES["time"].high
        if comes and self._layer.lay(time, contacts, poses, self._numbers):
            found = self._tell(self._own_at)
            if found != NOT_TAKEN:
                return self.told(self._own, found)
        return self._step_with_care(time, contacts, poses)

    def _step_with_care(self, time: float, contacts: Contacts, poses: Poses | None) -> list[Request]:
        """Take a step of contacts and poses in any form; raise WorldError, which says what of them cannot be."""
        where = f"step {self.steps + 1}"

        def number(name: str) -> int:
            try:
                return self.number(name)
            except WorldError as error:
                raise WorldError(f"{where}: {error}") from None

        self._check(time, where)
        moved = checked_poses(poses, number, where)
        points = take_contacts(self.state, contacts, number, tuple(self._numbers), where)
        for body, pose in moved:
            put_pose(self.state, body, pose)
        return self.advance(time, points)

    def _check(self, time: float, where: str, advice: str = "") -> None:
        """Raise WorldError unless a step may come at a time. advice: what to do about it."""
        if not isinstance(time, float | Real):  # that it is a float is seen at once
            raise WorldError(f"{where}: time = {time!r}: expected a number")
        if not self.time < time <= RANGES["time"].high:
            latest = f"above {self.time}, that of the step before, and at most {RANGES['time'].high:g} s"
            raise WorldError(f"{where}: time = {time}: expected {latest}{advice}")

    def advance(self, time: float, points: int) -> list[Request]:
        """Take a step, as `step` does, where poses and so many contacts are in `state` already."""
        self._layer.tell(time, points)
        return self.told(self._own, self._tell(self._own_at))

    def told(self, telling: NDArray[np.void], found: int) -> list[Request]:
        """Return the requests of a step that was reported, for which `tell` returned a number."""
        if found >= 0 and not found & LOOK:
            return []
        before = float(telling["before"][0])
        if found == NOT_LATER:
            self._check(time_told(telling), f"step {self.steps + 1}", "; after a reset, restart() begins anew")
        if found == NO_ROOM:
            raise WorldError(f"step {self.steps}: no capacity for more events: compute the sound of these steps first")
        if found < 0:
            raise WorldError(
                f"step {self.steps + 1}: {self._fault(c_int32.from_address(int(telling['points'][0])).value)}"
            )
        return self._heard(before, not telling["entries"][0])

    def _fault(self, points: int) -> str:
        """Name what of the last step cannot be."""
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

    def _heard(self, before: float, all_of_it: bool) -> list[Request]:
        """Return the requests of the step since a time (s): all of them, or those of slides and rests alone that begin
        and end."""
        requests: list[Request] = []
        if self.state["due"][0]:
            requests += self.grains.tell()
        if all_of_it:
            microphones = self._microphones[0]
            for n in microphones["changed"][: microphones["found"]].tolist():
                gains = microphones["now"][n, : self.channels].tolist()
                requests.append(Gains(before, self.bodies[n].name, tuple(gains)))
            requests += blows_of(self.blows, self.bodies)
            changes = self.state["changes"][0, : int(self.state["changed"][0])].tolist()
            requests += [Steering(self.time, id_of(slide), CHANGING[n], value) for slide, _, n, value in changes]
        count = min(int(self.state["happened"][0]), EVENTS)
        for event in events_of(self._whole[:count], self._floats[:count]):
            if event.kind == REST:
                requests += self._gestures.rest(event)
            elif event.kind == MOVE:
                requests.append(self._begins(event))
            elif event.kind == LIE:
                requests.append(self._lies(event))
        return requests

    def _begins(self, event: Event) -> Slide:
        """Return the slide as which a standing contact is heard that begins to slip or to sweep."""
        a, b = self.bodies[event.a], self.bodies[event.b]
        to, by = (a, b) if event.side == 0 else (b, a)
        pair = self._pairs.get((event.a, event.b), Pair())
        surface = pair.surface or self._surfaces.between(a.material, b.material)
        return self._gestures.begin(event, to, by, surface, pair.slide)

    def _lies(self, event: Event) -> Lying:
        """Return the rest as which a standing contact is heard that neither slips nor sweeps."""
        a, b = self.bodies[event.a], self.bodies[event.b]
        to, by = (a, b) if event.side == 0 else (b, a)
        return self._gestures.lie(event, to, by, self._pairs.get((event.a, event.b), Pair()).support)


def time_told(telling: NDArray[np.void]) -> float:
    """Return the time of a step's contacts (s), by a record of TELLING."""
    time, behind = (int(telling[name][0]) for name in ("time", "behind"))
    return c_double.from_address(time).value - (c_double.from_address(behind).value if behind else 0.0)
