"""Objects that break: each cracks and falls silent, and its pieces fall on another, or on nothing that sounds."""

from ...dsp.engine.memory.commands import Command, Kind
from ...dsp.runtime.engine import NOW
from ...dsp.schema import GAIN, HEIGHT
from ..osc.arguments import Refused, shown
from .contact_law import law_of
from .limits import require_short
from .object_call import ObjectCall
from .objects import PlayedObject
from .transaction import Sent


def shatter(to: ObjectCall) -> None:
    """Break an object: its cracks are a gesture without an id, its pieces have that of the message."""
    values, engine = to.values, to.transaction.engine
    velocity = values.number("velocity")
    if "by" in values.words:
        raise Refused(f"by = {values.words['by']}: nothing but the speed breaks {to.name}; expected a striker")
    if "point" in values.vectors:
        raise Refused("point: cracks and pieces are all over; expected position and spread")
    if velocity == 0.0:
        to.end_at_once()
        return
    onto = _onto(to)
    law, landing = law_of(to, None), law_of(to, None, onto=onto)
    for each in (law, landing):
        require_short(velocity, each)
    number = to.start(to.id(to.transaction.gestures.made_for))
    motion = {
        **law._asdict(),
        **to.transaction.pulses(law.exponent),
        "velocity": velocity,
        "whole": to.obj.modes.mass,
        "pieces": values.number("pieces"),
        "height": values.number(HEIGHT.name),
        "steepness": values.number("steepness"),
        "position": values.numbers.get("position", 0.5),
        "spread": values.number("spread"),
        "gain": GAIN.in_engine(values.number("gain")),
        "seed": to.seed(number),
    }
    sound = None if to.is_point_mass else to.transaction.laws.sound_of(to.striker)
    motion |= engine.lay_out_striker(sound) if sound else {}
    own = {"own_stiffness": law.stiffness, "own_dissipation": law.dissipation}
    pieces = {**motion, **landing._asdict(), **own, "stage": 1.0 if onto else 2.0}
    here, below = to.obj.handle, (onto or to.obj).handle
    _add(
        to,
        (to.obj, onto or to.obj),
        Command(NOW, "shatter", here, motion),
        Command(NOW, "shatter", below, pieces, gesture=number, by=here if onto else None),
        Command(NOW, Kind.SET, here, value=1.0, parameter="damp"),
    )


def _onto(to: ObjectCall) -> PlayedObject | None:
    """Return the object on which the pieces fall, if the message names one."""
    if "onto" not in to.values.words:
        return None
    name = to.values.words["onto"]
    found = to.object_named(name)
    if found is None:
        raise Refused(f"onto = {shown(name)}: expected another object that is there")
    return found


def _add(to: ObjectCall, objects: tuple[PlayedObject, ...], *commands: Command) -> None:
    """Add the commands that the message stands for, for when all objects are there."""
    transaction = to.transaction
    time = max(transaction.objects.start_of(each, transaction.time) for each in objects)
    other = objects[1] if objects[1] is not to.obj else None
    sent = Sent(to.canonical, to.obj.handle.serial, other.handle.serial if other else 0, 0.0)
    for command in commands:
        transaction.add(command._replace(time=max(time, transaction.time)), sent)
