"""Objects that break: each cracks and falls silent, and its pieces fall on another, or on nothing that sounds.

Where a message does not say on what they fall, they do on an object called FLOOR, which is made where there is none.
"""

from collections.abc import Callable

from ...dsp.bodies.striker import StrikerSound, magnified
from ...dsp.engine.memory.commands import Command, Kind
from ...dsp.runtime.engine import NOW
from ...dsp.schema import GAIN, HEIGHT, OTHER_SEED, SETTINGS
from ..new_object import NEW
from ..osc.addresses import Call, calls
from ..osc.arguments import Refused, shown
from ..osc.wire import Message
from .contact_law import law_of
from .limits import Contact, require_short
from .macros import heard_as
from .makeup import Below, gain_of, on_grid
from .object_call import ObjectCall
from .objects import PlayedObject
from .transaction import Sent, Transaction

FLOOR, OF_FLOOR = "floor", "wooden-floor"
"""The object on which pieces fall if the message names none, and the preset of which it is made."""
NOTHING = "none"
"""Stands for a floor that is not heard."""
_ALIKE = 3.0
"""The steepness of thick parts: their masses differ by little. Cracks branch at a distance that goes as the stress to
the power -2 (swarm/pieces.py), and so as the thickness to the power 4 where a wall is bent: thick parts stay whole."""
_HEARD_AS = ("gain", "pan", "distance")

Translate = Callable[[Transaction, Call], None]


def shatter(translate: Translate, to: ObjectCall) -> None:
    """Break an object: its cracks are a gesture without an id, its pieces have that of the message."""
    values, engine, scale = to.values, to.transaction.engine, to.transaction.scale
    velocity = values.number("velocity")
    if "by" in values.words:
        raise Refused(f"by = {values.words['by']}: nothing but the speed breaks {to.name}; expected a striker")
    if "point" in values.vectors:
        raise Refused("point: the whole object breaks; expected position and spread")
    if velocity == 0.0:
        to.end_at_once()
        return
    onto = _onto(translate, to)
    law, landing = law_of(to, None), law_of(to, None, onto=onto)
    for each in (law, landing):
        require_short(velocity, each)
    number = to.start(to.id(to.transaction.gestures.made_for))
    seed = to.seed(number)
    motion = {
        **law._asdict(),
        **to.transaction.pulses(law.exponent),
        "velocity": velocity,
        "whole": values.number("wall_mass") or to.obj.mass,
        "pieces": values.number("pieces"),
        "height": values.number(HEIGHT.name),
        "steepness": values.number("steepness"),
        "position": values.numbers.get("position", 0.5),
        "spread": values.number("spread"),
        "seed": seed,
        "gain": GAIN.in_engine(values.number("gain")),
        "friction": to.transaction.laws.sliding_of(to.striker)["dynamic"],
    }
    sound = None if to.is_point_mass else to.transaction.laws.sound_of(to.striker)
    motion |= engine.lay_out_striker(sound) if sound else {}
    own = {"own_stiffness": law.stiffness, "own_dissipation": law.dissipation}
    below, here = onto or to.obj, to.obj.handle
    level = min(scale.at(0.0), scale.object(to.obj.preset))  # of all of it: a strike's would be too loud
    own["own_level"] = motion["level"] = level / scale.object(to.obj.preset)
    own["level"] = level / scale.object(below.preset)
    if to.is_played and to.obj.modes.sheet is None:  # a gain would have a plate swell as it never does
        whole = Command(NOW, "shatter", values={**motion, **own, "level": motion["level"]})
        pair = to.transaction.makeup.pair(
            heard_as(to.transaction, to.obj), to.obj.preset.position, whole, sound, to.obj.preset.level
        )
        if onto:
            falls = on_grid("shatter", {**motion, **landing._asdict(), **own})
            higher = round(onto.preset.level - to.obj.preset.level, 1)
            pair = pair._replace(below=Below(onto.modes, higher, tuple(sorted(falls.items()))))
        measure = to.transaction.measured(pair)
        factor = GAIN.in_engine(gain_of("shatter", velocity, measure, to.obj.preset.level))
        motion["level"] *= factor
        own = own | {name: own[name] * factor for name in ("own_level", "level")}
    pieces = {**motion, **landing._asdict(), **own, "stage": 1.0 if onto else 2.0}
    fall = (pieces, pieces | _thick_parts(to, law, landing, sound, seed)) if values.number("thick_mass") else (pieces,)
    _add(
        to,
        (to.obj, below),
        Command(NOW, "shatter", here, motion),
        *(Command(NOW, "shatter", below.handle, each, gesture=number, by=here if onto else None) for each in fall),
        Command(NOW, Kind.SET, here, value=1.0, parameter="damp"),
    )


def _thick_parts(
    to: ObjectCall, law: Contact, landing: Contact, sound: StrikerSound | None, seed: float
) -> dict[str, float]:
    """Return the values by which thick parts differ from the other pieces: each is a piece that is magnified.

    law, landing, sound, seed: of the other pieces, on what breaks and on what they fall on.
    """
    values, ratio = to.values, to.values.number("thick_ratio")
    larger = _magnified(landing, ratio)
    require_short(values.number("velocity"), larger)
    return {
        **larger._asdict(),
        "own_stiffness": _magnified(law, ratio).stiffness,
        **(to.transaction.engine.lay_out_striker(magnified(sound, ratio)) if sound else {}),
        "whole": values.number("thick_mass"),
        "pieces": values.number("thick_parts"),
        "steepness": _ALIKE,
        "seed": seed + OTHER_SEED,
    }


def _magnified(law: Contact, ratio: float) -> Contact:
    """Return the contact law of a piece that is larger by a ratio, in all its sizes alike."""
    return law._replace(mass=law.mass * ratio**3, stiffness=law.stiffness * ratio ** (2.0 - law.exponent))


def _onto(translate: Translate, to: ObjectCall) -> PlayedObject | None:
    """Return the object on which the pieces fall: the one that the message names, else the floor, which is made if need
    be; None if nothing is heard of it."""
    if "onto" not in to.values.words:
        to.chosen_keys["onto"] = FLOOR if to.name != FLOOR else NOTHING
        if to.name != FLOOR and not to.transaction.objects.at(FLOOR, to.transaction.time):
            _lay_floor(translate, to)
    name = to.values.words.get("onto") or str(to.chosen_keys["onto"])
    found = to.object_named(name)
    if found is None and name != NOTHING:
        raise Refused(f"onto = {shown(name)}: expected another object that is there, or {NOTHING}")
    return found


def _lay_floor(translate: Translate, to: ObjectCall) -> None:
    """Make the floor under an object: as near and as loud as that is."""
    settings, place = to.obj.settings, to.transaction.space.places.get(to.obj.handle.serial)
    heard = [(key, settings[key]) for key in _HEARD_AS if settings.get(key, 0.0) != SETTINGS[key].default]
    keys = [each for pair in heard for each in pair]
    translate(to.transaction, calls(Message(NEW, (FLOOR, OF_FLOOR, *keys)))[0])
    if place:
        translate(to.transaction, calls(Message(f"/object/{FLOOR}/place", place))[0])


def _add(to: ObjectCall, objects: tuple[PlayedObject, ...], *commands: Command) -> None:
    """Add the commands that the message stands for, for when all objects are there."""
    transaction = to.transaction
    time = max(transaction.objects.start_of(each, transaction.time) for each in objects)
    other = objects[1] if objects[1] is not to.obj else None
    sent = Sent(to.canonical, to.obj.handle.serial, other.handle.serial if other else 0, 0.0)
    for command in commands:
        transaction.add(command._replace(time=max(time, transaction.time)), sent)
