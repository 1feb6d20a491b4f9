"""Sensors on objects: their names and their channels."""

from collections.abc import Callable
from typing import NamedTuple

from ...dsp.bodies.sensor import Sensor
from ...dsp.engine.memory.capacity import MOST_CHANNELS
from ...dsp.engine.memory.mounted import SENSORS
from ...dsp.runtime.engine import Engine
from ..osc.arguments import Refused


class Mounted(NamedTuple):
    """A sensor that is mounted: on which object, where, its number, and the value of a sample of 1.0."""

    object: str
    position: float
    number: int
    sensor: Sensor
    full: float = 1.0

    @property
    def unit(self) -> str:
        return self.sensor.unit


class SensorTable:
    """The sensors of an engine by name, and the last that had each channel."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self.there: dict[str, Mounted] = {}
        self.channels: dict[int, tuple[str, Mounted]] = {}
        """The name and the sensor of each channel, by number."""
        self.grows = False
        """True if an engine gets a channel for each sensor as it is mounted."""
        self._latest = 0.0

    def time_of(self, time: float) -> float:
        """Return the time (samples) of a command about a sensor: sensors come and go in the order of their messages, so
        that it waits for those before."""
        return max(time, self._latest) if self._latest > self._engine.position else time

    def took_place(self, time: float) -> Callable[[], None]:
        """Remember the time (samples) of a command; return how to undo it."""
        before, self._latest = self._latest, max(self._latest, time)

        def undo() -> None:
            self._latest = before

        return undo

    def free_number(self, name: str) -> int:
        """Return the number of a channel that no sensor has: the last one of this name, else one that no sensor ever
        had, if there is such a one. Refused if all are taken."""
        taken = {each.number for each in self.there.values()}
        most = min(SENSORS, MOST_CHANNELS - self._engine.channels) if self.grows else self._engine.sensors
        former = [n for n, (last, _) in self.channels.items() if last == name]
        fresh = [n for n in range(most) if n not in self.channels]
        number = next((n for n in (*former, *fresh, *range(most)) if n not in taken), -1)
        if number < 0:
            chosen = f" beside {self._engine.channels} channels" if self.grows else ", as was chosen at the start"
            raise Refused(f"no channel for another sensor: expected at most {most}{chosen}")
        return number

    def add(self, name: str, mounted: Mounted) -> Callable[[], None]:
        """Add a sensor; return how to undo it."""
        before, width = self.channels.get(mounted.number), self._engine.sensors
        self.there[name] = mounted
        self.channels[mounted.number] = name, mounted
        self._engine.sensors = max(width, mounted.number + 1)

        def undo() -> None:
            del self.there[name]
            self._engine.sensors = width
            if before:
                self.channels[mounted.number] = before
            else:
                del self.channels[mounted.number]

        return undo
