"""Macros: how they change an object's modes, and the values of its gestures."""

import random
from bisect import insort
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from operator import itemgetter

from ...dsp.bodies.macros import Change, changed, share_of, sum_of
from ...dsp.bodies.material import Material
from ...dsp.bodies.modes import Modes
from ...dsp.engine.memory.commands import Command, Handle, Kind
from ...dsp.macros import GLIDE, MACROS, MORPH, NEUTRAL, SHAPING
from ...dsp.numerics.constants import MACRO_NODES as NODES
from ...dsp.numerics.quantities import Parameter
from ...dsp.runtime.engine import NOW
from ...dsp.schema import GESTURES, ROUGHNESS, Gesture
from ...presets.reshaping import Axes, Wanted, material_at, require_family
from ..osc.addresses import Call, calls
from ..osc.arguments import Refused, Values
from ..osc.macro_verbs import DICE, MACRO, MORPHING, UNDO
from ..osc.wire import Message
from .engine_messages import changes
from .gesture_ids import Begun
from .limits import Contact
from .object_call import ObjectCall
from .objects import PlayedObject
from .steering import steered_by
from .transaction import Sent, Transaction

Translate = Callable[[Transaction, Call], None]

_HARDER, _HEAVIER, _STRONGER, _ROUGHER = 1000.0, 2.0, 8.0, 10.0
"""Factors of stiffness, mass, force and roughness from the middle of a macro to its end, as MACROS says."""
_FORCES: dict[str, dict[str, float]] = {
    "impact": {"velocity": 1.0, "impulse": 1.0}, "bounce": {"height": 2.0, "velocity": 1.0}, "press": {"force": 1.0},
    "roll": {"speed": 0.5}, "slide": {"force": 1.0}, "spin": {"angle": 0.5}, "rain": {"rate": 1.0},
    "shake": {"speed": 1.0}, "crumple": {"energy": 2.0}, "pour": {"height": 2.0}, "step": {"energy": 2.0},
    "shatter": {"velocity": 1.0},
}  # fmt: skip
"""What the macro `force` changes of each gesture, and the power of its factor: energies go as the square of forces."""
_GRID = 2 * (NODES - 1)
"""Steps of a macro for make-up: an object is measured at these."""
_FINE = 64.0
"""Steps of the macro `material` for contacts, of which each has a law."""
_MOST_THROWS = 64
"""Throws of the dice that can be taken back."""


def _times(most: float, value: float) -> float:
    return float(most ** (2.0 * (value - NEUTRAL)))


def harder(law: Contact, obj: PlayedObject) -> Contact:
    """Return the contact law of a striker on an object, as hard as its macro says."""
    value = obj.macros["hardness"]
    if value == NEUTRAL:
        return law
    return law._replace(stiffness=law.stiffness * _times(_HARDER, value), mass=law.mass * _times(_HEAVIER, value))


def recall(transaction: Transaction, obj: PlayedObject) -> None:
    """Have an object's macros be those at the time of a transaction."""
    if obj.turns:
        obj.recall(_time_of(transaction), float(transaction.engine.position))
        obj.heavier = heavier(transaction, obj)


def _time_of(transaction: Transaction) -> float:
    """Return when a transaction takes effect, samples: what is late does now."""
    return max(float(transaction.time), float(transaction.engine.position))


def touched(obj: PlayedObject) -> Material | None:
    """Return the material of an object where it is struck, as its macro has it."""
    value = round(_FINE * obj.macros["material"]) / _FINE
    return obj.preset.material if value == NEUTRAL else material_at(obj.preset, value)


def _placed(position: float, value: float) -> float:
    """Return where a position lies when a macro draws it to one end or the other."""
    return position * value / NEUTRAL if value < NEUTRAL else position + (1.0 - position) * (value / NEUTRAL - 1.0)


def _stronger(power: float, base: float, value: float) -> float:
    return float(base * _times(_STRONGER, value) ** power)


def _laws(gesture: Gesture) -> dict[str, tuple[str, Callable[[float, float], float]]]:
    """Return what macros change of a gesture: by the name of a value the macro, and the value at a place of it."""
    found: dict[str, tuple[str, Callable[[float, float], float]]] = {}
    for name, power in _FORCES.get(gesture.name, {}).items():
        found[name] = "force", partial(_stronger, power)
    if not gesture.what:
        found["position"] = "place", _placed
    if ROUGHNESS in gesture.keys:
        found[ROUGHNESS.name] = "roughness", lambda base, value: base * _times(_ROUGHER, value)
    return found


_LAWS = {gesture.name: _laws(gesture) for gesture in GESTURES.values()}
_NUMBERS = {
    gesture.name: {each.name: each for each in (*gesture.keys, gesture.argument)} for gesture in GESTURES.values()
}


def as_turned(values: Values, kind: str, obj: PlayedObject) -> Values:
    """Return the values of a gesture's message as the object's macros have them."""
    moved = {
        name: obj.macros[macro] for name, (macro, _) in _LAWS.get(kind, {}).items() if obj.macros[macro] != NEUTRAL
    }
    if not moved:
        return values
    numbers, defaults = dict(values.numbers), dict(values.defaults)
    for name, value in moved.items():
        law = _LAWS[kind][name][1]
        if name == "position":
            defaults.setdefault(name, obj.preset.position)
        for given in (numbers, defaults):
            if name in given and not (name == "position" and "point" in values.vectors):
                given[name] = _fitted(kind, name, law(given[name], value))
    return replace(values, numbers=numbers, defaults=defaults)


def _within(number: Parameter, value: float) -> float:
    """Return a value of a number within its range."""
    return min(max(value, number.low), number.high) if value else value


def pressed(to: ObjectCall, weight: float) -> float:
    """Return the force (N) of a slide that is given none: the striker's weight, as the object's macro has it."""
    to.given = replace(to.given, defaults={"force": weight, **to.given.defaults})
    return weight * _times(_STRONGER, to.obj.macros["force"])


def _set_heavier(to: ObjectCall) -> None:
    """Remember how heavy an object is."""
    before, to.obj.heavier = to.obj.heavier, heavier(to.transaction, to.obj)
    to.transaction.on_undo(lambda: setattr(to.obj, "heavier", before))


def set_macro(translate: Translate, to: ObjectCall) -> None:
    """Turn a macro of an object, and of the copies for its notes."""
    assert to.call.verb
    transaction, name, value, message = to.transaction, to.call.verb.action, _value(to), to.canonical
    for copy in _copies(to):
        translate(transaction, calls(Message(f"/object/{copy}/macro/{name}", to.call.message.args))[0])
    if MACROS[name].of_body:
        _shape(to, message, name == "material" or to.obj.shaped[0], to.obj.shaped[1])
    _keep(to, name, value)
    _add_changes(to, message, MACROS[name].number)
    if MACROS[name].of_body:
        _set_heavier(to)
    else:
        _steer_running(to, message, name)


def _keep(to: ObjectCall, name: str, value: float) -> None:
    """Remember a macro from its time on."""
    obj, time = to.obj, _time_of(to.transaction)
    before, settled = list(obj.turns), dict(obj.settled)

    def take_back() -> None:
        obj.turns, obj.settled, obj.macros = before, settled, dict(settled)

    to.transaction.on_undo(take_back)
    insort(obj.turns, (time, name, value), key=itemgetter(0))
    obj.recall(time, float(to.transaction.engine.position))


def set_morph(translate: Translate, to: ObjectCall) -> None:
    """Bring an object a share of the way to another one."""
    transaction, preset, message = to.transaction, to.values.words["preset"], to.canonical
    require_family(to.name, to.obj.preset, transaction.presets.object(preset))
    for copy in _copies(to):
        translate(transaction, calls(Message(f"/object/{copy}/{MORPH.name}", to.call.message.args))[0])
    _shape(to, message, to.obj.shaped[0], preset)
    _keep(to, MORPH.name, _value(to))
    _add_changes(to, message, MORPH)
    _set_heavier(to)


def _value(to: ObjectCall) -> float:
    ((_, value),) = to.values.numbers.items()
    return value


def _copies(to: ObjectCall) -> list[str]:
    """Return the names of the copies for an object's notes."""
    there = to.transaction.objects
    return [name for name, copy in to.obj.copies.items() if there.at(name, to.transaction.time).get(name) is copy]


def _add_changes(to: ObjectCall, message: Message, number: Parameter) -> None:
    """Add the commands by which a setting changes the modes."""
    for change in changes(Kind.SET, number, to.values):
        _add(to, message, change._replace(parameter=number.name), to.obj.handle)


def _add(to: ObjectCall, message: Message, command: Command, handle: Handle | None = None) -> None:
    """Add a command; `message` stands for all of a call's, and is logged once."""
    transaction = to.transaction
    time = transaction.objects.start_of(to.obj, transaction.time)
    placed = command._replace(time=time, handle=handle)
    transaction.add(placed, Sent(message, to.obj.handle.serial, 0, 0.0))


def _shape(to: ObjectCall, message: Message, of_material: bool, other: str) -> None:
    """Have the engine know how an object's modes change, unless it does."""
    obj, transaction, wanted = to.obj, to.transaction, (of_material, other)
    if obj.shaped == wanted and wanted in obj.tables:
        return
    axes = transaction.axes(_wanted(transaction, obj, wanted))
    if wanted not in obj.tables:
        level = transaction.scale.object(obj.preset)
        obj.tables[wanted] = transaction.engine.lay_out_macros(obj.handle, obj.modes, level, axes)
    before, obj.shaped = obj.shaped, wanted
    transaction.on_undo(lambda: setattr(obj, "shaped", before))
    _add(to, message, Command(NOW, Kind.RESHAPE, value=obj.tables[wanted]), obj.handle)


def _wanted(transaction: Transaction, obj: PlayedObject, shaped: tuple[bool, str]) -> Wanted:
    other = transaction.presets.object(shaped[1]) if shaped[1] else None
    return Wanted(obj.preset, obj.modes, transaction.engine.top_frequency, shaped[0], other)


def heard_as(transaction: Transaction, obj: PlayedObject) -> Modes:
    """Return an object's modes about as its macros have them, for make-up."""
    key = (*obj.shaped, *(round(_GRID * obj.macros[each.name]) for each in SHAPING))
    if all(obj.macros[each.name] == each.default for each in SHAPING):
        return obj.modes
    if key not in obj.heard:
        axes = transaction.axes(_wanted(transaction, obj, obj.shaped))
        places = [round(_GRID * obj.macros[each.name]) / _GRID for each in SHAPING]
        obj.heard.clear()
        obj.heard[key] = changed(obj.modes, [_at(axes[n], place) for n, place in enumerate(places)])
    return obj.heard[key]


def heavier(transaction: Transaction, obj: PlayedObject) -> float:
    """Return the factor of an object's mass by its macros."""
    if not obj.tables:
        return 1.0
    axes: Axes = transaction.axes(_wanted(transaction, obj, obj.shaped))
    amplitude = sum(_at(axes[n], obj.macros[each.name]).amplitude for n, each in enumerate(SHAPING))
    return float(4.0**-amplitude)


def _at(changes: tuple[Change, ...], value: float) -> Change:
    """Return the change at a place of a macro, between two that are known."""
    place = value * (NODES - 1)
    node = min(int(place), NODES - 2)
    return sum_of(share_of(changes[node], 1.0 - (place - node)), share_of(changes[node + 1], place - node))


def _steer_running(to: ObjectCall, message: Message, macro: str) -> None:
    """Steer the gestures on an object that go on."""
    for id in to.transaction.gestures.running():
        begun = id.begun
        if begun is None or begun.serial != to.obj.handle.serial:
            continue
        for name, base in begun.values.items():
            of, law = _LAWS[begun.kind][name]
            if of == macro and name in GESTURES[begun.kind].steerable:
                moved = [_fitted(begun.kind, name, law(base, point.value)) for point in to.values.points]
                points = tuple(
                    point._replace(value=value, over=point.over or GLIDE)
                    for point, value in zip(to.values.points, moved, strict=True)
                )
                for command in steered_by(to.transaction, id, name, points):
                    _add(to, message, command)


def begun_as(kind: str, values: Values, obj: PlayedObject) -> Begun:
    """Return what macros change of a gesture that begins, as its message has it."""
    given = {**values.defaults, **values.numbers}
    given.setdefault("position", obj.preset.position)
    known = {name: given[name] for name in _LAWS[kind] if name in given}
    if "point" in values.vectors:
        del known["position"]
    return Begun(kind, obj.handle.serial, known)


def _fitted(kind: str, name: str, value: float) -> float:
    number = _NUMBERS[kind].get(name)
    return _within(number, value) if number else value


def throw_dice(translate: Translate, to: ObjectCall) -> None:
    """Turn all macros at random: each by a message of its own, which a log keeps."""
    seed = to.values.numbers.get("seed")
    chooser = random.Random(to.transaction.gestures.nameless() if seed is None else int(seed))
    thrown = {name: round(chooser.uniform(*macro.dice), 3) for name, macro in MACROS.items()}
    to.obj.thrown.append({name: to.obj.macros[name] for name in MACROS})
    to.transaction.on_undo(to.obj.thrown.pop)
    _turn(translate, to, thrown)


def undo_dice(translate: Translate, to: ObjectCall) -> None:
    """Turn the macros back to what they were before the last throw."""
    if not to.obj.thrown:
        raise Refused(f"{to.name}: nothing to take back; expected /object/{to.name}/dice before")
    before = to.obj.thrown.pop()
    to.transaction.on_undo(lambda: to.obj.thrown.append(before))
    _turn(translate, to, before)


def _turn(translate: Translate, to: ObjectCall, macros: dict[str, float]) -> None:
    """Turn macros that differ to their values, and answer what all of them are."""
    del to.obj.thrown[:-_MOST_THROWS]
    for name, value in macros.items():
        if to.obj.macros[name] != value:
            translate(to.transaction, calls(Message(f"/object/{to.name}/macro/{name}", (value,)))[0])
    to.transaction.replies.append(
        Message(f"/object/{to.name}/macros", tuple(x for each in macros.items() for x in each))
    )


def messages_of(obj: PlayedObject, name: str) -> list[Message]:
    """Return the messages that turn an object's macros on another one that is new."""
    made = [
        Message(f"/object/{name}/macro/{macro}", (obj.macros[macro],))
        for macro in MACROS if obj.macros[macro] != NEUTRAL
    ]  # fmt: skip
    if obj.macros[MORPH.name]:
        made.append(Message(f"/object/{name}/{MORPH.name}", (obj.shaped[1], obj.macros[MORPH.name])))
    return made


MACRO_HANDLERS: dict[str, Callable[[Translate, ObjectCall], None]] = {
    **{f"{MACRO}/{name}": set_macro for name in MACROS}, MORPHING: set_morph, DICE: throw_dice, UNDO: undo_dice,
}  # fmt: skip
"""Handlers by the address of the verb."""
