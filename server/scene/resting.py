"""Rests: an object that lies on another one, or on a support, on one place of its own or several."""

import math
from itertools import islice

import numpy as np

from ...dsp.bodies.covered import mean_squares
from ...dsp.bodies.ground import ground, position_of
from ...dsp.engine.memory.commands import Command, Handle, Kind
from ...dsp.numerics.constants import HARDEST_REST, STANDARD_GRAVITY
from ...dsp.runtime.engine import NOW
from ...dsp.schema import SETTINGS
from ...dsp.wording import MOST_COMPARED
from ...presets.schema import NO_REST
from ...presets.supports import SUPPORTS, SupportPreset
from ..osc.addresses import VERBS, Call
from ..osc.arguments import Refused, shown
from ..osc.wire import Message
from .contact_law import bent
from .object_call import ObjectCall
from .objects import PlayedObject
from .touching import feet_values, place_values
from .transaction import Sent, Transaction, is_off_path

_REST = "/object/NAME/rest"
_LAW = ("stiffness", "dissipation", "exponent")
_OF_A_POINT = {"stiffness", "exponent", "mass", "resistance"}
"""Keys of what touches at a point: where one is given, a support covers no area."""


def rest(to: ObjectCall) -> None:
    """Lay an object on what a message names; "none" lifts it from where it stands by itself."""
    what = to.values.words["what"]
    other = to.object_named(what)
    if other is None and what == NO_REST:
        if not to.obj.stands:
            text = f"{to.name} stands on nothing by itself; what a message laid down is lifted by /gesture/ID/stop"
            to.transaction.replies.append(Message("/warning", (text,)))
        _lift(to, to.canonical)
        return
    if other is None and what not in SUPPORTS:
        words = f"another object, {', '.join(SUPPORTS)} or {NO_REST}"
        raise Refused(f"what = {shown(what)}: expected {words}{_meant(to, what)}")
    support = None if other else SUPPORTS[what]
    feet = [place_values(to, other)] if support and support.mass else feet_values(to, other)  # a hand finds its place
    id = to.id(to.transaction.gestures.made_for)
    gesture = {to.start(id) for _ in feet}.pop()  # one number
    message = to.canonical
    most = _lay(to, message, other, support, gesture, feet)
    to.transaction.gestures.lay_on(id, what if other else "", most)
    if not (support and support.mass):  # it lies there by its weight, and so no longer where it stood
        _lift(to, message)


def stand(transaction: Transaction, call: Call, name: str, obj: PlayedObject) -> None:
    """Lay a new object on what it stands on by itself, if it does; `call` is that which makes it."""
    standing = obj.preset.standing
    if standing is None or standing.support == NO_REST:
        return
    verb = VERBS[_REST]
    values = verb.parse((standing.support,))
    obj.stands = transaction.gestures.nameless()
    to = ObjectCall(transaction, Call(call.message, verb, name), values, name, obj)
    _lay(to, call.message, None, SUPPORTS[standing.support], obj.stands, feet_values(to, None))


def _lift(to: ObjectCall, message: Message) -> None:
    """Take an object off what it stands on by itself."""
    stands = to.obj.stands
    if stands:
        _add(to, message, Command(NOW, Kind.STOP, gesture=stands))
        to.obj.stands = 0
        to.transaction.on_undo(lambda: setattr(to.obj, "stands", stands))


def _lay(
    to: ObjectCall, message: Message, other: PlayedObject | None, support: SupportPreset | None, gesture: int,
    feet: list[dict[str, float]],
) -> float:  # fmt: skip
    """Lay an object on another one or on a support, as a gesture of a number; `message` stands for all commands. Return
    the greatest load (N) that it takes."""
    command = Command(NOW, "rest", gesture=gesture)
    load, numbers = _load(to, support, len(feet)), to.values.numbers
    mass = numbers.get("mass", _mass(to, support, load))
    if load > HARDEST_REST * mass:
        raise Refused(f"load = {load:g}, mass = {mass:g}: expected at most {HARDEST_REST:g} N per kg")
    if support and "load" in numbers and load > support.most:
        raise Refused(f"load = {load:g}: expected at most {support.most:g} N on {to.values.words['what']}")
    most = min(HARDEST_REST * mass, max(support.most, load) if support else math.inf)
    values = {**_law(to, other, support), "mass": mass, "load": load, "gain": 1.0}
    resistance = numbers.get("resistance", support.resistance if support else 0.0)
    if other and resistance:
        raise Refused(f"resistance = {resistance:g}: expected none, as {to.values.words['what']} is an object")
    time = _time(to, other)
    covers = support.area if support and not _OF_A_POINT & numbers.keys() else 0.0
    if covers:
        _cover(to, message, [command._replace(time=time, values=values | foot) for foot in feet], covers)
        return most
    if other or not resistance:
        command = command._replace(time=time, by=other.handle if other else None)
        for foot in feet:
            _add(to, message, command._replace(values=values | foot), other)
        return most
    engine = to.transaction.engine
    places = tuple((foot["x"], foot["y"], foot["z"]) for foot in feet)
    wavelength = support.wavelength if support and feet[0]["on_surface"] else 0.0  # else the path's length is not known
    made = ground(resistance, engine.top_frequency, places, wavelength)
    laid = None if to.memory.ground else engine.lay_out(made, 1.0)
    under = [{"by_position": position_of(number, len(feet))} for number in range(len(feet))]
    rests = [command._replace(time=time, values=values | each) for each in map(dict.__or__, feet, under)]
    _lay_under(to, message, rests, laid)
    return most


def cover(to: ObjectCall, message: Message, press: Command, area: float) -> None:
    """Let a press that covers an area (m^2) take of all modes of the object, beside what it does at its point; message:
    that of the press."""
    _cover(to, message, [press._replace(time=_time(to, None))], area)


def _cover(to: ObjectCall, message: Message, feet: list[Command], area: float) -> None:
    """Lay on what covers an area (m^2) at each place, as commands say: their dissipation alone, without a spring."""
    preset, places = to.obj.preset, [dict(each.values) for each in feet]
    body = to.obj.modes, preset.shape, preset.geometry, preset.material, area
    if places[0]["on_surface"]:
        found = [mean_squares(*body, point=(foot["x"], foot["y"], foot["z"]))[0] for foot in places]
        squares = np.array(found + found[-1:] * (4 - len(found)))
        for number, foot in enumerate(places):
            foot["position"] = position_of(number, len(feet))
    else:
        squares = mean_squares(*body)
    rests = [each._replace(values=foot | {"stiffness": 0.0}) for each, foot in zip(feet, places, strict=True)]
    laid = None if to.memory.ground else to.transaction.engine.lay_out_cover(to.obj.modes, squares)
    _lay_under(to, message, rests, laid)


def _lay_under(
    to: ObjectCall, message: Message, rests: list[Command], laid: tuple[Handle, dict[str, float]] | None
) -> None:
    """Lay an object on a silent one, as commands say, which goes with the last of them; laid: that object and its
    layout, None where the message has been carried out before."""
    engine, before = to.transaction.engine, to.memory.ground
    if laid:
        handle, layout = laid
        to.memory.ground = handle
        to.transaction.on_undo(lambda: engine.release(handle))
        settings = {name: each.in_engine(each.default or 0.0) for name, each in SETTINGS.items()}
        _add(to, message, Command(rests[0].time, Kind.NEW, handle, {**layout, **settings}))
    for command in rests:
        _add(to, message, command._replace(by=to.memory.ground))
    if before:
        return
    _add(to, message, Command(rests[0].time, Kind.FREE, handle))
    engine.leave(handle)
    to.transaction.on_undo(lambda: engine.stay(handle))


def _meant(to: ObjectCall, what: str) -> str:
    """Ask whether a near name is meant, of an object or a support."""
    there = islice(to.transaction.objects.there(to.transaction.time), MOST_COMPARED)
    found = to.transaction.suggestion(what, [name for name in (*SUPPORTS, *there) if name != to.name])
    return f"; {found}" if found else ""


def _law(to: ObjectCall, other: PlayedObject | None, support: SupportPreset | None) -> dict[str, float]:
    """Return stiffness, dissipation and exponent: the support's, or those of two materials; given keys win."""
    preset, given = to.obj.preset, to.values.numbers
    if other:
        law = preset.struck_by(other.preset, to.contact_radius)
        to.warn_of_stand_ins(other, to.values.words["what"])
    elif support and support.material:
        law = preset.resting_on(support.material, to.contact_radius)
    else:
        assert support
        law = support.stiffness, support.dissipation, support.exponent
    if other or (support and support.material):
        law = law[0] * bent(to), *law[1:]
    return {key: given.get(key, value) for key, value in zip(_LAW, law, strict=True)}


def _load(to: ObjectCall, support: SupportPreset | None, feet: int) -> float:
    """Return the load (N) of each foot: the one given, a hand's, or its share of the object's weight."""
    usual = support.load if support and support.load else to.obj.mass * STANDARD_GRAVITY / feet
    return to.values.numbers.get("load", usual)


def _mass(to: ObjectCall, support: SupportPreset | None, load: float) -> float:
    """Return the mass (kg) on which the load acts: a hand's, or as much of the object's own as weighs that."""
    return support.mass if support and support.mass else min(load / STANDARD_GRAVITY, to.obj.mass)


def _time(to: ObjectCall, other: PlayedObject | None) -> float:
    """Return when the rest begins (samples): once both objects are there."""
    objects, time = to.transaction.objects, to.transaction.time
    return max(objects.start_of(each, time) for each in (to.obj, other) if each)


def _add(to: ObjectCall, message: Message, command: Command, on: PlayedObject | None = None) -> None:
    """Add a command of a rest, for which a message stands; `on`: the object that it rests on."""
    sent = Sent(message, to.obj.handle.serial, on.handle.serial if on else 0, 0.0, is_off_path(command))
    to.transaction.add(command._replace(handle=command.handle or to.obj.handle), sent)
