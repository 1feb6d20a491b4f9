"""The meaning of each message: one handler for every address that a score may hold.

A handler adds commands to a transaction, each with named values in SI units and with the canonical message, which says
the same and leaves no choice open.
"""

import math
from collections.abc import Callable
from functools import partial
from itertools import islice

from ...dsp.bodies.striker import StrikerSound
from ...dsp.engine.memory.commands import Command, Kind
from ...dsp.numerics.constants import STANDARD_GRAVITY
from ...dsp.runtime.engine import NOW
from ...dsp.schema import (
    BOUNCE,
    DROPS,
    GAIN,
    GESTURES,
    IMPULSE,
    ROLL,
    SETTINGS,
    SLIDE,
    STEERABLE,
    STRIKE,
    VELOCITY,
    Gesture,
)  # fmt: skip
from ...dsp.wording import MOST_COMPARED, there_are
from ...presets.kinds import DRY, SurfacePreset
from ..new_object import NEW, NewObject, new_object
from ..osc.addresses import Call, calls, unknown
from ..osc.arguments import Refused, Values, require_name, shown
from ..osc.patterns import is_pattern
from ..osc.space_verbs import PLACE
from ..osc.wire import Message
from .ahead import sent_ahead
from .contact_law import law_of, law_on
from .engine_messages import ENGINE_HANDLERS, Handler, changes
from .limits import (
    Contact,
    fall,
    most_rough,
    radius_of,
    require_rest,
    require_rollable,
    require_short,
    rim_speed,
    speed_by,
)
from .macros import MACRO_HANDLERS, as_turned, begin, heard_as, keep, messages_of, pressed
from .makeup import Played, argument_of, mixed, places_of, velocity_of
from .notes import copy_of, speed_of, tuned
from .object_call import ObjectCall, completed
from .objects import RETUNED, PlayedObject, Turn
from .placing import SPACE_HANDLERS, place_object
from .resting import cover, rest, stand
from .sensing import SENSOR_HANDLERS
from .shattering import shatter
from .steering import CHANGE_WORK, steer
from .touching import gathered, given_of, place_values
from .transaction import Sent, Transaction, is_off_path
from .turned import recall, time_of
from .world_messages import world_handlers

_SHARED = {each.name for each in STRIKE} | {"velocity"}
_SURFACE = "wood"
_ANY_RADIUS = 0.01  # m: of a roll that is steered, and so has one
_GESTURE_WORK = 400  # of carrying out a gesture on one object, as in patterns.work
_COPY_WORK = 10_000  # of making a copy for a note, where a pattern asks for many
_APPROACH = 0.01  # m/s: how fast a pressing striker is laid on


def translate(transaction: Transaction, call: Call) -> None:
    """Add what a call asks for to a transaction. Refused, PresetError or EngineFull say why not."""
    if call.verb is None:
        raise unknown(call.message.address) if transaction.explains() else Refused("no such address")
    handler = HANDLERS.get(call.verb.address)
    if handler is None:
        raise Refused("server-only message; not allowed in a score")
    handler(transaction, call, call.verb.parse(call.message.args))


def sync(number: int) -> Command:
    """Return a command that reports its number once all that was sent before it is done."""
    return Command(NOW, Kind.SYNC, value=number)


# Messages to objects


def _new(transaction: Transaction, call: Call, values: Values) -> None:
    engine, objects = transaction.engine, transaction.objects
    name = values.words["name"]
    require_name("name", name)
    if name == "new":
        raise Refused("name = new: expected another name, as /object/new is an address")
    if objects.at(name, transaction.time):
        raise Refused(f"name = {name}: there is such an object already; free it first")
    preset, modes = transaction.made_of(call, new_object)
    transaction.laws.forget()
    transaction.laws.of(preset.striker, preset.material)
    settings = {name: values.number(name) for name in SETTINGS}
    settings["tune"] = tuned(modes, values)
    handle, layout = engine.lay_out(modes, transaction.scale.object(preset))
    transaction.on_undo(lambda: engine.release(handle))
    obj = PlayedObject(handle, preset, modes, transaction.time, made=call.message.args, settings=settings)
    obj.settled |= {name: settings[name] for name in RETUNED}
    obj.macros |= obj.settled
    transaction.on_undo(objects.add(name, obj))
    in_engine = {name: setting.in_engine(settings[name]) for name, setting in SETTINGS.items()}
    _add(transaction, call.message, Command(NOW, Kind.NEW, values={**layout, **in_engine}), obj)
    if values.many:
        _place(transaction, call.message, values.many, obj)
    stand(transaction, call, name, obj)
    transaction.replies.append(Message("/done", (NEW, name)))


def _set(to: ObjectCall) -> None:
    ((setting, value),) = to.values.numbers.items()
    before = to.obj.settings.get(setting, value)
    to.obj.settings[setting] = value
    if setting in RETUNED:
        keep(to, Turn(time_of(to.transaction, to.obj), setting, value))
    to.transaction.on_undo(lambda: to.obj.settings.update({setting: before}))
    message = to.canonical
    for change in changes(Kind.SET, SETTINGS[setting], to.values):
        _add(to.transaction, message, change._replace(parameter=setting), to.obj)


def _gains(to: ObjectCall) -> None:
    if to.values.many:
        _place(to.transaction, to.canonical, to.values.many, to.obj)
    else:
        _add(to.transaction, to.canonical, Command(NOW, Kind.PLACE), to.obj)


def _place(transaction: Transaction, message: Message, gains: tuple[float, ...], obj: PlayedObject) -> None:
    """Give an object gains of its own, 0 in channels for which none is given; `message` stands for all commands."""
    channels = transaction.engine.channels
    if len(gains) > channels:
        raise Refused(f"{len(gains)} gains: expected at most {channels}, one for each channel")
    for channel in range(channels):
        gain = gains[channel] if channel < len(gains) else 0.0
        _add(transaction, message, Command(NOW, Kind.PLACE, value=gain, channel=channel), obj)


def _put(to: ObjectCall) -> None:
    _add(to.transaction, to.canonical, place_object(to), to.obj)


def _free(to: ObjectCall) -> None:
    """Free an object, and the copies of it on which its notes are played."""
    engine, obj, before = to.transaction.engine, to.obj, to.obj.freed
    freed = max(to.transaction.objects.start_of(obj, to.transaction.time), float(engine.position))
    if before <= freed:  # a pattern reaches a copy after what it is a copy of
        return
    for name, copy in obj.copies.items():
        if to.transaction.objects.at(name, to.transaction.time).get(name) is copy:
            translate(to.transaction, calls(Message(f"/object/{name}/free", to.call.message.args))[0])
    if before == math.inf:
        engine.leave(obj.handle)
        to.transaction.on_undo(lambda: engine.stay(obj.handle))
    to.transaction.on_undo(lambda: setattr(obj, "freed", before))
    obj.freed = freed
    _add(to.transaction, to.canonical, Command(NOW, Kind.FREE, value=to.values.number("at_once")), obj)


# Gestures


def _begin(gesture: Gesture, to: ObjectCall) -> None:
    """Begin a gesture by its argument and keys; one of 0 does nothing, unless a hand holds the striker."""
    values, argument = to.values, gesture.argument.name
    impulse = values.numbers.get(IMPULSE.name, 0.0)
    if values.number(argument) == impulse == 0.0 and not gesture.lasts:
        to.end_at_once()
        return
    if gesture.swarms and "by" in to.values.words:
        raise Refused(f"by = {to.values.words['by']}: grains hit {to.name}; expected a striker")
    by = to.striking_object()
    law = law_of(to, by)
    fastest = speed_by(impulse, law) if impulse else _FASTEST.get(gesture.name, _velocity)(values)
    require_short(fastest or _APPROACH, law)
    is_named = not gesture.single or "id" in values.words
    number = to.start(to.id(to.transaction.gestures.made_for)) if is_named else 0
    motion = {**_own_values(to, gesture), argument: values.number(argument)}
    if gesture.held:
        motion["velocity"] = _APPROACH
    if "seed" in motion:
        motion["seed"] = to.seed(number)
    if gesture.swarms:
        motion = gathered(to, motion)
        motion |= to.transaction.pulses(0.0 if gesture.swarms == DROPS else law.exponent)
    command = Command(NOW, gesture.name, gesture=number, values=motion)
    message = _strike(to, by, law, command)
    # A plate that swells takes its energy from what bends it, and would have what a cover loses back.
    covers = gesture.held and not (by or to.is_point_mass) and to.obj.modes.sheet is None
    if area := to.transaction.laws.area_of(to.striker) if covers else 0.0:
        lossy = {**motion, **law._asdict(), "restitution": 0.0, **place_values(to, None), "gain": 1.0}
        cover(to, message, command._replace(values=lossy), area)


def _velocity(values: Values) -> float:
    """Return the velocity (m/s) at which a striker meets the object: the one given, or that at which it is laid on."""
    return values.numbers.get("velocity", values.defaults.get("velocity", _APPROACH))


def _rim_speed(values: Values) -> float:
    return rim_speed(*map(values.number, ("flat", "radius", "angle", "gravity")))


def _grain_speed(values: Values) -> float:
    return values.number("speed")


def _fall_speed(values: Values) -> float:
    return fall(values.number("height"), 0.0, STANDARD_GRAVITY)[0]


_FASTEST: dict[str, Callable[[Values], float]] = {"spin": _rim_speed, "shake": _grain_speed, "pour": _fall_speed}


def _bounce(to: ObjectCall) -> None:
    values = to.values
    by = to.striking_object()
    law = law_of(to, by)
    gravity = values.number("gravity")
    velocity, seconds = fall(values.number("height"), values.number("velocity"), gravity)
    if velocity == 0.0:
        to.end_at_once()
        return
    require_short(velocity, law)
    require_rest(velocity, law, gravity)
    number = to.start(to.id(to.transaction.gestures.made_for))
    motion = {**_own_values(to, BOUNCE), "velocity": velocity, "delay": seconds, "seed": to.seed(number)}
    _strike(to, by, law, Command(NOW, "bounce", gesture=number, values=motion))


def _note(to: ObjectCall) -> None:
    """Carry out a note: make a tuned copy, if there is none, and strike it."""
    transaction, values = to.transaction, to.values
    note, velocity = values.numbers["note"], values.numbers["velocity"]
    if velocity == 0.0:
        return
    name = f"{to.name}.{note:g}"
    if not transaction.objects.at(name, transaction.time):
        if is_pattern(to.call.target):
            transaction.selection.charge(_COPY_WORK, to.call.target)
        new = calls(Message(NEW, copy_of(to.obj, name, note)))[0]
        with transaction.has_made(new, NewObject(to.obj.preset, to.obj.modes)):  # to make them again may take seconds
            translate(transaction, new)
        to.obj.copies[name] = transaction.objects[name]
        if to.obj.handle.serial in transaction.space.places:
            place = transaction.space.places[to.obj.handle.serial]
            translate(transaction, calls(Message(f"/object/{name}/place", place))[0])
        for message in messages_of(to.obj, name):
            translate(transaction, calls(message)[0])
    translate(transaction, calls(Message(f"/object/{name}/impact", (speed_of(velocity), *to.call.message.args[2:])))[0])


def _roll(to: ObjectCall) -> None:
    values = to.values
    surface = to.transaction.laws.surface(values.words.get("surface", _SURFACE))
    by = to.striking_object()
    id = to.id(lambda name: name)
    goes_on = to.goes_on(id)
    law = law_on(to, by, surface, goes_on, "rolls")
    speed, roughness = values.number("speed"), values.number("roughness")
    own_radius = to.contact_radius if to.by_materials else to.transaction.laws.radius_of(to.striker)
    radius = values.numbers.get("radius", values.defaults.get("radius", own_radius))
    if not radius and to.is_played:
        radius = radius_of(to.transaction.laws.of(to.striker, None).mass)
    if to.by_materials and not goes_on:
        to.say("radius", radius)
    if speed > 0.0 and not goes_on:
        if not radius:
            raise Refused(f"radius is missing: {to.striker} is no ball; expected its radius (m)")
        roughness = _rough(to, roughness, radius, surface)
    number = to.start(id)
    motion = {
        **_own_values(to, ROLL),
        "roughness": roughness,
        "speed": speed,
        "radius": radius or _ANY_RADIUS,
        "seed": to.seed(number),
    }
    given = given_of(ROLL, to)
    command = Command(NOW, "roll", gesture=number, values=motion, given=given, surface=surface.profile)
    _strike(to, by, law, command)


def _rough(to: ObjectCall, roughness: float, radius: float, surface: SurfacePreset) -> float:
    """Return the roughness that a body of a radius (m) feels: as much as it can, if macros ask for more, or whoever
    plays. Refused if a message does."""
    if not to.is_played:
        require_rollable(radius, surface, to.given.number("roughness"))
    return min(roughness, most_rough(radius, surface))


def _slide(to: ObjectCall) -> None:
    values, laws = to.values, to.transaction.laws
    surface = laws.surface(values.words.get("surface", _SURFACE))
    by = to.striking_object()
    id = to.id(lambda name: name)
    goes_on = to.goes_on(id)
    law = law_on(to, by, surface, goes_on, "slides")
    own = {**DRY, "radius": to.contact_radius} if to.by_materials else dict(laws.sliding_of(to.striker))
    own["force"] = pressed(to, law.mass * STANDARD_GRAVITY)
    own |= {key: value for key, value in (*values.defaults.items(), *values.numbers.items()) if key in own}
    motion = {**_own_values(to, SLIDE), **own}
    if "dynamic" not in values.numbers:
        motion["dynamic"] = min(motion["dynamic"], motion["static"])
    elif "static" not in values.numbers:
        motion["static"] = max(motion["dynamic"], motion["static"])
    if motion["dynamic"] > motion["static"]:
        raise Refused(f"dynamic = {motion['dynamic']:g}: expected at most static = {motion['static']:g}")
    if not goes_on:
        motion["roughness"] = _rough(to, motion["roughness"], motion["radius"], surface)
    motion |= {"speed": values.number("speed"), "seed": to.seed(number := to.start(id))}
    if "direction" in values.vectors:
        motion["along"] = values.numbers.get("along", 1.0)
    if "press" in values.words:
        motion["press"] = _press_of(to, values.words["press"])
    given = given_of(SLIDE, to)
    command = Command(NOW, "slide", gesture=number, values=motion, given=given, surface=surface.profile)
    _strike(to, by, law, command)


def _press_of(to: ObjectCall, id: str) -> int:
    """Return the number of a press on the object that goes on."""
    gestures = to.transaction.gestures
    if not gestures.is_running(id, f"/object/{to.name}/press"):
        raise Refused(f"press = {id}: expected the id of a press on {to.name} that goes on")
    return gestures.number_of(id)


def _own_values(to: ObjectCall, gesture: Gesture) -> dict[str, float]:
    """Return the values of a gesture's own keys that are given or have a default."""
    numbers, defaults = to.values.numbers, to.values.defaults
    return {
        key.name: numbers.get(key.name, defaults.get(key.name, 0.0)) for key in gesture.keys if key.name not in _SHARED
    }


_OF_GESTURES: dict[str, Callable[[ObjectCall], None]] = {
    "bounce": _bounce, "roll": _roll, "slide": _slide, "rest": rest, "shatter": partial(shatter, translate),
}  # fmt: skip
"""Handlers of gestures whose law, velocity or surface takes more than their values."""


def _strike(to: ObjectCall, by: PlayedObject | None, law: Contact, command: Command) -> Message:
    """Add the command of a gesture, with the values that every gesture has; return the message that it stands for."""
    transaction = to.transaction
    drops = GESTURES[str(command.kind)].swarms == DROPS
    sound = (
        None
        if by or to.is_point_mass or drops
        else transaction.laws.sound_of(to.striker, GESTURES[str(command.kind)].slips)
    )
    values = {
        **command.values,
        **(transaction.engine.lay_out_striker(sound) if sound else {}),
        **law._asdict(),
        **place_values(to, by),
        "gain": GAIN.in_engine(to.values.number("gain")),
    }
    played = None
    if to.is_played and not GESTURES[str(command.kind)].held:
        made_up, played = _make_up(to, command._replace(values=values), sound)
        values |= made_up
    message = to.canonical
    _add(transaction, message, command._replace(values=values), to.obj, by)
    begin(to, str(command.kind), command.gesture, played, to.base)
    return message


def _make_up(to: ObjectCall, command: Command, sound: StrikerSound | None) -> tuple[dict[str, float], Played | None]:
    """Return the values that make a gesture as loud as suits players, and what its level follows from if it lasts."""
    kind, preset, swells = str(command.kind), to.obj.preset, to.obj.modes.sheet is not None
    name, transaction, modes = argument_of(GESTURES[kind]), to.transaction, heard_as(to.transaction, to.obj)
    anywhere = command.values["on_surface"] or command.values.get("spread") == 1.0 or len(modes.along) == 1
    places = places_of(preset.position if anywhere else command.values["position"], preset.position, swells)
    pairs = [(transaction.makeup.pair(modes, at, command, sound, preset.level), share) for at, share in places]
    measure = mixed([(transaction.measured(pair), share) for pair, share in pairs])
    if swells and name == VELOCITY.name:
        velocity, level = velocity_of(kind, command.values[name], measure, preset.level)
        return {name: velocity, "level": level}, None
    played = Played(kind, measure, preset.level)
    return {"level": played.level_at(command.values[name])}, played if GESTURES[kind].lasts else None


def _work(call: Call, values: Values, transaction: Transaction) -> int:
    """Return the work of carrying out a call on one object."""
    assert call.verb
    if call.verb.action in GESTURES:
        return _GESTURE_WORK
    commands = transaction.engine.channels if call.verb.action == "gains" else len(values.points)
    return CHANGE_WORK * max(1, commands)


def _on_objects(handle: Callable[[ObjectCall], None]) -> Handler:
    """Return a handler that acts on every object that the NAME of an address matches."""

    def handle_all(transaction: Transaction, call: Call, values: Values) -> None:
        objects = transaction.objects.at(call.target, transaction.time, transaction.selection)
        if not objects:
            there = list(islice(transaction.objects.there(transaction.time), MOST_COMPARED))
            known = transaction.suggestion(call.target, there) or there_are(there)
            raise Refused(f"{shown(call.target)}: no such object; {known}")
        # One object is all that a message reaches without a pattern.
        transaction.selection.charge(_work(call, values, transaction) * (len(objects) - 1), call.target)
        for name, obj in objects.items():
            if len(objects) > 1:
                transaction.pause()
            assert call.verb
            given = completed(values, call.verb, obj.preset)
            recall(transaction, obj)
            to = ObjectCall(transaction, call, as_turned(given, call.verb.action, obj), name, obj, given)
            with sent_ahead(to, handle):
                handle(to)

    return handle_all


HANDLERS: dict[str, Handler] = {
    NEW: _new,
    **{
        f"/object/NAME/{name}": _on_objects(_OF_GESTURES.get(name, partial(_begin, gesture)))
        for name, gesture in GESTURES.items()
    },
    **dict.fromkeys((f"/object/NAME/{setting}" for setting in SETTINGS), _on_objects(_set)),
    **{address: _on_objects(partial(handle, translate)) for address, handle in MACRO_HANDLERS.items()},
    "/object/NAME/gains": _on_objects(_gains),
    PLACE: _on_objects(_put),
    "/object/NAME/free": _on_objects(_free),
    "/object/NAME/note": _on_objects(_note),
    **dict.fromkeys((f"/gesture/ID/{action}" for action in ("stop", "point", "by_point", *STEERABLE)), steer),
    **SENSOR_HANDLERS,
    **SPACE_HANDLERS,
    **ENGINE_HANDLERS,
    **world_handlers(translate),
}
"""Handlers by the address of the verb."""


# Commands


def _add(
    transaction: Transaction, message: Message, command: Command, obj: PlayedObject | None = None,
    by: PlayedObject | None = None,
) -> None:  # fmt: skip
    """Add a command to an object (None: to the engine), for when that and the one that strikes it are there; `message`
    is what it stands for."""
    time = transaction.time
    for each in (obj, by):
        time = max(time, transaction.objects.start_of(each, transaction.time)) if each else time
    placed = command._replace(time=time, handle=obj.handle if obj else None, by=by.handle if by else None)
    serial, by_serial = (each.handle.serial if each else 0 for each in (obj, by))
    transaction.add(placed, Sent(message, serial, by_serial, command.values.get("mass", 0.0), is_off_path(command)))
