"""A simulation's deeds on the straight way to the engine: commands, without the messages that say the same."""

from collections.abc import Callable, Sequence

import numpy as np

from ...dsp.engine.commands import COMMAND, Kind
from ...dsp.schema import STEERABLE
from ..osc.wire import Message
from ..world.deeds import Blow, Deed, Gains, Said, Steering
from .objects import PlayedObject
from .session import Session

_ROOM = 256  # commands that are sent together
_PLACES = {name: place for place, name in enumerate(STEERABLE)}


class Direct:
    """Sends deeds to a session's engine, as the messages would that say the same.

    What begins is a message, which is checked; the rest are numbers that are within their ranges as the simulation made
    them. say: carries a message out at a time (samples).
    """

    def __init__(self, session: Session, say: Callable[[Message, float], object]) -> None:
        self._session, self._engine, self._say = session, session.engine, say
        self._rows = np.zeros(_ROOM, COMMAND)
        blank = np.zeros(1, COMMAND)
        blank["channel"] = -1
        blank["strike"]["gain"] = 1.0
        whole = f"V{COMMAND.itemsize}"  # so that it is copied as bytes, and not field by field
        self._blank, self._bytes = blank.view(whole)[0], self._rows.view(whole)
        self._latest = 0.0
        self._column = {name: self._rows[name] for name in COMMAND.names or ()}
        self._strike = {name: self._rows["strike"][name] for name in COMMAND["strike"].names or ()}
        self._count = 0

    def send(self, deeds: Sequence[tuple[float, Deed]]) -> None:
        """Send deeds, each for its time (samples). EngineFull where they find no room."""
        for time, deed in deeds:
            if isinstance(deed, Blow):
                self._blow(time, deed)
            elif isinstance(deed, Gains):
                self._gains(time, deed)
            elif isinstance(deed, Said):
                self._flush()
                self._say(deed.message, time)
            elif number := self._session.gestures.number_of(deed.id):
                steers = isinstance(deed, Steering)
                n = self._add(time, Kind.STEER if steers else Kind.STOP)
                self._column["gesture"][n] = number
                if isinstance(deed, Steering):
                    self._column["parameter"][n] = _PLACES[deed.parameter]
                    self._column["value"][n] = deed.value
        self._flush()

    def _add(self, time: float, kind: Kind, to: PlayedObject | None = None) -> int:
        """Begin a command; its place among the rows."""
        if self._count == _ROOM:
            self._flush()
        n, column = self._count, self._column
        self._count += 1
        self._bytes[n] = self._blank
        self._latest = max(self._latest, time)
        column["time"][n], column["kind"][n] = time, kind
        if to:
            column["slot"][n], column["serial"][n] = to.handle.slot, to.handle.serial
        return n

    def _blow(self, time: float, blow: Blow) -> None:
        to = self._session.objects[blow.to]
        n, strike = self._add(time, Kind.IMPACT, to), self._strike
        if blow.by:
            by = self._session.objects[blow.by].handle
            self._column["by_slot"][n], self._column["by_serial"][n] = by.slot, by.serial
            strike["by_position"][n] = blow.by_place
        strike["velocity"][n], strike["position"][n] = blow.speed, blow.place
        strike["mass"][n], strike["stiffness"][n], strike["exponent"][n] = blow.mass, blow.stiffness, blow.exponent
        strike["dissipation"][n], strike["restitution"][n] = blow.dissipation, blow.restitution
        strike["gesture_level"][n] = self._session.scale.gesture(to.preset, "impact")

    def _gains(self, time: float, gains: Gains) -> None:
        to = self._session.objects[gains.to]
        for channel, gain in enumerate(gains.gains):
            n = self._add(time, Kind.PLACE, to)
            self._column["channel"][n], self._column["value"][n] = channel, gain

    def _flush(self) -> None:
        """Send what is gathered."""
        count, latest, self._count, self._latest = self._count, self._latest, 0, 0.0
        if count:
            self._engine.send_rows(self._rows[:count], latest)
