"""A simulation's requests on the straight way to the engine: commands, without the messages that say the same."""

from collections.abc import Callable, Sequence

import numpy as np

from ...dsp.engine.memory.commands import COMMAND, NUMBERS, Kind
from ...dsp.native.addresses import as_bytes
from ...dsp.schema import STEERABLE
from ...dsp.schema_records import VALUES
from ..bridge.requests import Blow, Ending, Gains, Lying, Request, Said, Slide, Steering, Swarm
from ..osc.wire import Message
from .session import Session

_PLACES = {name: place for place, name in enumerate(STEERABLE)}
_GESTURE, _STEER, _STOP, _PLACE = int(Kind.GESTURE), int(Kind.STEER), int(Kind.STOP), int(Kind.PLACE)
_BLOW = NUMBERS["impact"]

_Known = tuple[bool, bool, bool, tuple[str, ...], tuple[float | str, ...]]
"""Facts known of a slide: whether what slides rings, whether each of both is touched at a point, the names of the
slide's keys, and the values of those that are checked."""

_CHECKED = ("surface", "radius", "roughness")


class Direct:
    """Sends requests to a session's engine, as the messages would that say the same.

    Objects, rests, swarms, and the first slide of a radius on a surface, are messages, which are checked; all else is
    numbers that are within their ranges as the simulation made them. say: carries a message out at a time (samples).
    """

    def __init__(self, session: Session, say: Callable[[Message, float], object]) -> None:
        self._session, self._say, self._ring = session, say, session.engine.ring
        blank = np.zeros(1, COMMAND)
        blank["channel"] = -1
        blank["values"]["gain"] = blank["values"]["level"] = 1.0
        rows = self._ring.entries
        self._blank = as_bytes(blank)[0]
        self._slides: dict[_Known, np.void] = {}
        self._column = {name: rows[name] for name in COMMAND.names or ()}
        self._values = {name: rows["values"][name] for name in VALUES.names or ()}

    def send(self, requests: Sequence[tuple[float, Request]]) -> None:
        """Send requests in the order of their times (samples). EngineFull where they find no room."""
        waiting: list[tuple[float, Request]] = []
        for time, request in requests:
            new = isinstance(request, Slide) and self._known(request) not in self._slides
            if isinstance(request, Said | Lying | Swarm) or new:
                self._write(waiting)
                waiting = []
                self._say(request.message, time)
                if isinstance(request, Slide):
                    last = (self._ring.sent - 1) % len(self._ring.bytes)
                    self._slides[self._known(request)] = self._ring.bytes[last].copy()
            elif not isinstance(request, Steering | Ending) or self._session.gestures.number_of(request.id):
                waiting.append((time, request))
        self._write(waiting)

    def _known(self, slide: Slide) -> _Known:
        names = tuple(name for name, _ in slide.keys)
        at = bool(slide.point), bool(slide.by_point)
        return bool(slide.by), *at, names, tuple(value for name, value in slide.keys if name in _CHECKED)

    def _write(self, requests: Sequence[tuple[float, Request]]) -> None:
        """Write requests into the engine's ring."""
        if not requests:
            return
        count = sum(len(request.gains) if isinstance(request, Gains) else 1 for _, request in requests)
        self._ring.require_room(count, requests[-1][0])
        number = self._ring.sent
        for time, request in requests:
            if isinstance(request, Blow):
                self._blow(number, time, request)
            elif isinstance(request, Steering | Ending):
                self._change(number, time, request)
            elif isinstance(request, Slide):
                self._begin(number, time, request)
            elif isinstance(request, Gains):
                self._gains(number, time, request)
            number += len(request.gains) if isinstance(request, Gains) else 1
        self._ring.publish(number)

    def _add(self, number: int, time: float, like: np.void, kind: int = -1) -> int:
        """Begin a command, as another is; its place in the ring."""
        column = self._column
        n = number % len(self._ring.bytes)
        self._ring.bytes[n] = like
        column["number"][n], column["time"][n] = number, time
        if kind >= 0:
            column["kind"][n] = kind
        return n

    def _blow(self, number: int, time: float, blow: Blow) -> None:
        strike = self._values
        n = self._add(number, time, self._blank, _GESTURE)
        self._column["what"][n] = _BLOW
        self._aim(n, blow.to, blow.by)
        if blow.by:
            strike["by_position"][n] = blow.by_place
        strike["velocity"][n], strike["position"][n] = blow.speed, blow.place
        strike["mass"][n], strike["stiffness"][n], strike["exponent"][n] = blow.mass, blow.stiffness, blow.exponent
        strike["dissipation"][n], strike["restitution"][n] = blow.dissipation, blow.restitution
        self._put(n, blow)

    def _aim(self, n: int, to: str, by: str) -> None:
        """Say which object a command is for, and which strikes it, if one does."""
        objects, column = self._session.objects, self._column
        handle = objects[to].handle
        column["slot"][n], column["serial"][n] = handle.slot, handle.serial
        if by:
            handle = objects[by].handle
            column["by_slot"][n], column["by_serial"][n] = handle.slot, handle.serial

    def _begin(self, number: int, time: float, slide: Slide) -> None:
        """Begin a slide as one of the same radius on the same surface began before."""
        n = self._add(number, time, self._slides[self._known(slide)])
        values = self._values
        self._aim(n, slide.to, slide.by)
        for name, value in slide.keys:
            if name not in _CHECKED:
                values[name][n] = value
        self._session.gestures.collect()  # those that have ended
        self._column["gesture"][n] = self._session.gestures.start(slide.id, f"/object/{slide.to}/slide", None).number
        values["position"][n], values["by_position"][n] = slide.place, slide.by_place
        values["speed"][n], values["sweep"][n], values["force"][n] = slide.slip, slide.sweep, slide.force
        values["seed"][n] = slide.seed
        self._put(n, slide)

    def _put(self, n: int, at: Blow | Slide) -> None:
        """Say at which points of their surfaces bodies touch, if they have any."""
        values = self._values
        if at.point:
            values["on_surface"][n], (values["x"][n], values["y"][n], values["z"][n]) = 1.0, at.point
        if at.by and at.by_point:
            values["by_on_surface"][n] = 1.0
            values["by_x"][n], values["by_y"][n], values["by_z"][n] = at.by_point
        if isinstance(at, Blow):
            for prefix, way in (("", at.direction), ("by_", at.by_direction if at.by else ())):
                for axis, value in zip("xyz", way, strict=False):
                    values[f"{prefix}direction_{axis}"][n] = value

    def _change(self, number: int, time: float, request: Steering | Ending) -> None:
        """Steer or end a slide, a rest or a swarm."""
        steers = isinstance(request, Steering)
        n = self._add(number, time, self._blank, _STEER if steers else _STOP)
        self._column["gesture"][n] = self._session.gestures.number_of(request.id)
        if isinstance(request, Steering):
            self._column["parameter"][n], self._column["value"][n] = _PLACES[request.parameter], request.value

    def _gains(self, number: int, time: float, gains: Gains) -> None:
        to, column = self._session.objects[gains.to].handle, self._column
        for channel, gain in enumerate(gains.gains):
            n = self._add(number + channel, time, self._blank, _PLACE)
            column["slot"][n], column["serial"][n] = to.slot, to.serial
            column["channel"][n], column["value"][n] = channel, gain
