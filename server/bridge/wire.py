"""A simulation that is reported over OSC: `/world/...`, message by message, and a step at a time."""

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

from ...presets import Presets
from ..osc.addresses import VERBS, Call
from ..osc.arguments import shown
from ..osc.patterns import match
from ..osc.wire import Argument
from ..osc.world_verbs import BODY, TOUCHED
from .bodies import Body, BodyMaker
from .checks import WorldError
from .hearing import Hearing, Microphone
from .requests import Request
from .simulation import Simulation
from .step import Pose, Touch
from .telling import tell

Undo: TypeAlias = Callable[[], object]
"""Takes back what was reported, until the step ends."""


class TellsWorld:
    """The simulation that messages report: its bodies, and what was reported since the last step."""

    def __init__(self, presets: Presets, top: float, channels: int) -> None:
        self._presets, self._top = presets, top
        self._microphones: Sequence[Microphone] = (Microphone((0.0, 0.0, 0.0)),) * channels
        self._simulation: Simulation | None = None
        self._touches: list[Touch] = []
        self._poses: dict[str, Pose] = {}

    def of(self, *names: str) -> Simulation:
        """Return the simulation that has bodies of these names. WorldError if there is none."""
        if self._simulation is None:
            raise WorldError(f"body {shown(names[0])}: no such body; there is no body yet")
        for name in names:
            self._simulation.number(name)
        return self._simulation

    @property
    def told(self) -> Simulation | None:
        """The simulation, if a body was made."""
        return self._simulation

    @property
    def simulation(self) -> Simulation:
        """The simulation, which begins with its first body."""
        if self._simulation is None:
            self._simulation = Simulation(self._presets, self._top, Hearing(self._microphones), start=-1.0)
        return self._simulation

    def place_microphones(self, places: Sequence[float]) -> None:
        """Place the microphones, before the first body: three numbers (m) for each channel."""
        channels = len(self._microphones)
        if self._simulation is not None and (self._simulation.bodies or self._simulation.grains.some):
            raise WorldError("microphones: expected before the first body")
        if len(places) != 3 * channels:
            raise WorldError(f"{len(places)} places: expected {3 * channels}, three for each of {channels} channels")
        self._microphones = [Microphone((x, y, z)) for x, y, z in zip(*[iter(places)] * 3, strict=True)]
        self._simulation = None  # one whose bodies were taken back has the microphones of before

    def pose(self, name: str, values: Sequence[float]) -> Undo:
        """Keep a body's pose until the step ends."""
        if len(values) not in (3, 7, 10, 13):
            raise WorldError(f"body {name}: {len(values)} values: expected 3, 7, 10 or 13")
        self.of(name)
        parts = [tuple(values[first:last]) for first, last in ((0, 3), (3, 7), (7, 10), (10, 13))]
        poses, before = self._poses, self._poses.get(name)
        poses[name] = Pose(*(part for part in parts if part))
        return lambda: poses.pop(name) if before is None else poses.update({name: before})

    def touch(self, a: str, b: str, numbers: dict[str, float]) -> Undo:
        """Keep a point of contact until the step ends."""
        self.of(a, b)
        point, normal = ([numbers[f"{sign}{axis}"] for axis in "xyz"] for sign in ("", "n"))
        told = {each.name: numbers.get(each.name, math.nan) for each in TOUCHED}
        touches = self._touches
        touches.append(Touch(a, b, point, normal, **told))
        return touches.pop

    def grains(self, name: str, pattern: str, striker: str) -> float:
        """Make bodies whose names match a pattern grains, or a striker; the exponent of their contacts."""
        simulation = self.simulation
        numbers = [number for number, body in enumerate(simulation.bodies) if pattern and match(pattern, body.name)]
        if pattern and not numbers:
            numbers = [simulation.number(pattern)]  # which says that there is none
        return simulation.grains.declare(name, numbers, striker)

    def pour(self, name: str, on: str, told: dict[str, float]) -> Undo:
        """Add blows of grains on a body to what the next step reports."""
        keys = {key: told.get(key) for key in ("speed", "impulse", "energy")}
        simulation = self.of(on)
        undo = simulation.grains.poured()
        simulation.grains.pour(name, simulation.number(on), told["count"], told.get("position"), **keys)
        return undo

    def step(self, time: float) -> tuple[float, list[Request]]:
        """End a step: the time of the step before, and what is to be heard of what happened since."""
        touches, poses = self._touches, self._poses
        self._touches, self._poses = [], {}
        simulation = self._simulation
        if simulation is None:
            return time, []
        before = max(simulation.time, 0.0) if simulation.steps else time
        return before, simulation.step(time, touches, poses)

    def end(self) -> list[str]:
        """Forget the simulation; the names of its objects."""
        names = [body.name for body in self._simulation.bodies if body.rings] if self._simulation else []
        self._simulation = None
        self._touches, self._poses = [], {}
        return names


def new_body(call: Call, presets: Presets, top: float) -> Body:
    """Make the body that a call of BODY asks for, with modes up to `top` (Hz). Any thread may ask; it can take seconds.

    Refused says why there is none.
    """
    values = VERBS[BODY].parse(call.message.args)
    _ = tell.brief  # loaded now, or compiled, and not where others wait
    words, numbers = values.words, values.numbers
    size = [numbers[axis] for axis in "xyz" if axis in numbers]
    about: dict[str, Argument] = {key: value for key, value in numbers.items() if key not in ("x", "y", "z")}
    if "object" in words:
        about["object"] = words["object"]
    return BodyMaker(presets, top).make(words["name"], words["shape"], size, words["material"], **about)
