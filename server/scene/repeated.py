"""A blow that is repeated, with another velocity or position: its command is written as it was translated before."""

from collections.abc import Hashable
from typing import NamedTuple

import numpy as np

from ...dsp.bodies.striker import StrikerSound
from ...dsp.contact.estimate import LONGEST_CONTACT
from ...dsp.engine.memory.commands import NUMBERS, Kind
from ...dsp.engine.memory.state import RING
from ...dsp.schema import IMPACT, POSITION, VELOCITY
from ..osc.addresses import calls
from ..osc.wire import Argument, Message
from .limits import Contact, longest
from .session import Session
from .transaction import Sent

_MOST = 256  # blows that are remembered, of 2 kB each
_OTHERS = {"by", "point"}  # with which more than its own value follows from the position


class Blow(NamedTuple):
    """A blow that is remembered: its command, the object's serial, its law, what sounds of its striker, and the id of
    its gesture."""

    command: np.void
    serial: int
    law: Contact
    sound: StrikerSound | None
    id: str


class Repeated:
    """Blows on the objects of a session that no message changes, by all of what defines them but velocity and
    position."""

    def __init__(self, session: Session, known: dict[Hashable, Blow]) -> None:
        """Take a session, and what is remembered of those that were the same but for the sizes of their objects:
        no law follows from these."""
        self._session, self._ring = session, session.engine.ring
        entries, values = self._ring.entries, self._ring.entries["values"]
        self._columns = [entries[name] for name in ("number", "time", "gesture")]
        self._velocity, self._position = values["velocity"], values["position"]
        self._sound, self._sound_serial = values["sound"], values["sound_serial"]
        self._known = known

    def send(self, message: Message, time: float) -> bool:
        """Carry out a message at a time (samples), as `Session.perform` does; False, and nothing is done, where it
        is no blow that is remembered, or one that has to be looked at."""
        told, velocity, position = _parts(message)
        blow = self._known.get(told)
        if blow is None or not isinstance(velocity, int | float) or not isinstance(position, int | float | None):
            return False
        within = None if position is None else POSITION.within(position)
        velocity = VELOCITY.within(velocity)
        if not velocity or (within is None) != (position is None) or longest(velocity, blow.law) > LONGEST_CONTACT:
            return False
        self._ring.require_room(1, time)
        number = self._ring.sent
        n, (numbers, times, gestures) = number % RING, self._columns
        self._ring.bytes[n] = blow.command
        numbers[n], times[n] = number, time
        gestures[n] = self._session.gestures.start(blow.id, message.address, None).number
        self._velocity[n] = velocity
        if within is not None:
            self._position[n] = within
        if blow.sound:
            laid = self._session.engine.lay_out_striker(blow.sound)
            self._sound[n], self._sound_serial[n] = laid["sound"], laid["sound_serial"]
        self._ring.publish(number + 1)
        self._session.on_sent(number, [Sent(message, blow.serial, 0, blow.law.mass)])
        return True

    def remember(self, message: Message) -> None:
        """Remember the blow of a message, if it can be repeated; nothing was carried out since."""
        target = calls(message)[0].target
        obj, given = self._session.objects.get(target), dict(zip(message.args[1::2], message.args[2::2], strict=False))
        n = (self._ring.sent - 1) % RING
        sent, values = self._ring.entries[n], self._ring.entries["values"][n]
        if (sent["kind"], sent["what"]) != (Kind.GESTURE, NUMBERS[IMPACT.name]) or len(self._known) >= _MOST:
            return
        if obj is None or obj.modes.faces is not None or "id" not in given or given.keys() & _OTHERS:
            return
        law = Contact(*(float(values[name]) for name in Contact._fields))
        sound = self._session.engine.striker_at(int(values["sound"]))
        command = self._ring.bytes[n].copy()
        self._known[_parts(message)[0]] = Blow(command, obj.handle.serial, law, sound, str(given["id"]))


def _parts(message: Message) -> tuple[tuple[Argument, ...], Argument, Argument]:
    """Return all parts of a message but the velocity and the position of a blow, and these; None where it has
    none."""
    args = list(message.args)
    velocity, position = args[0] if args else None, None
    keys = args[1::2]
    if "position" in keys and len(args) % 2:
        place = 2 * keys.index("position") + 2
        position, args[place] = args[place], None
    return (message.address, *args[1:]), velocity, position
