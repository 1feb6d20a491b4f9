"""Macros: how they change an object's modes, and the values of its gestures."""

import math
import random
from bisect import insort
from collections.abc import Callable
from dataclasses import replace
from itertools import chain
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING, NamedTuple

from ...dsp.bodies.macros import changed, retuned
from ...dsp.bodies.material import Material
from ...dsp.bodies.modes import Modes
from ...dsp.engine.memory.commands import Command, Handle, Kind
from ...dsp.macros import GLIDE, MACROS, MORPH, NEUTRAL, SHAPING
from ...dsp.numerics.constants import MACRO_NODES as NODES
from ...dsp.numerics.quantities import Parameter
from ...dsp.runtime.engine import NOW
from ...dsp.schema import GESTURES, ROUGHNESS, STRIKE, Gesture
from ...presets.reshaping import material_at, require_family
from ..osc.addresses import Call, calls
from ..osc.arguments import Refused, Values
from ..osc.macro_verbs import DICE, MACRO, MORPHING, UNDO
from ..osc.wire import Message
from .engine_messages import changes
from .gesture_ids import Begin, Begun, GestureId
from .limits import Contact
from .object_call import ObjectCall
from .objects import RETUNED, PlayedObject, Shaped, Turn
from .steering import followed_by
from .transaction import Sent, Transaction
from .turned import change_at, heavier, time_of, wanted

if TYPE_CHECKING:
    from .makeup import Played

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
_HARDNESS = "hardness"
WITHDRAWN = -1.0
"""Value of a command that takes back the one that it amends."""
_GRID = 2 * (NODES - 1)
"""Steps of a macro for make-up: an object is measured at these."""
_A_THIRD = 3.0
"""Steps an octave of tune and decay for make-up."""
_AS_MADE = (1.0, 1.0, 0.0)
FINE = 64
"""Steps of the macro `material` for contacts, of which each has a law."""
_MOST_THROWS = 64
"""Throws of the dice that can be taken back."""


def _times(most: float, value: float) -> float:
    return float(most ** (2.0 * (value - NEUTRAL)))


def harder(law: Contact, obj: PlayedObject) -> Contact:
    """Return the contact law of a striker on an object, as hard as its macro says."""
    value = obj.macros[_HARDNESS]
    if value == NEUTRAL:
        return law
    stiffness, mass = (LAWS["impact"][name].at(getattr(law, name), value) for name in ("stiffness", "mass"))
    return law._replace(stiffness=_fitted("impact", "stiffness", stiffness), mass=_fitted("impact", "mass", mass))


def touched(obj: PlayedObject) -> Material | None:
    """Return the material of an object where it is struck, as its macro has it."""
    value = round(FINE * obj.macros["material"]) / FINE
    return obj.preset.material if value == NEUTRAL else material_at(obj.preset, value)


def _placed(position: float, value: float) -> float:
    """Return where a position lies when a macro draws it to one end or the other."""
    return position * value / NEUTRAL if value < NEUTRAL else position + (1.0 - position) * (value / NEUTRAL - 1.0)


class Law(NamedTuple):
    """How a macro changes a value of a gesture: by a factor, `most` at its end to a power; most 0: it moves a place."""

    macro: str
    most: float
    power: float = 1.0

    def at(self, base: float, value: float) -> float:
        """Return a value at a place of the macro; base: in the middle."""
        return float(base * _times(self.most, value) ** self.power) if self.most else _placed(base, value)


def _laws(gesture: Gesture) -> dict[str, Law]:
    """Return what macros change of a gesture, by the name of a value."""
    found: dict[str, Law] = {}
    if not gesture.what:
        found["stiffness"], found["mass"] = Law(_HARDNESS, _HARDER), Law(_HARDNESS, _HEAVIER)
    for name, power in _FORCES.get(gesture.name, {}).items():
        found[name] = Law("force", _STRONGER, power)
    if not gesture.what:
        found["position"] = Law("place", 0.0)
    if ROUGHNESS in gesture.keys:
        found[ROUGHNESS.name] = Law("roughness", _ROUGHER)
    return found


LAWS = {gesture.name: _laws(gesture) for gesture in GESTURES.values()}
_NUMBERS = {
    gesture.name: {each.name: each for each in (*STRIKE, *gesture.keys, gesture.argument)}
    for gesture in GESTURES.values()
}


def as_turned(values: Values, kind: str, obj: PlayedObject) -> Values:
    """Return the values of a gesture's message as the object's macros have them, but for the contact law, which
    `harder` has."""
    moved = {
        name: obj.macros[macro]
        for name, (macro, *_) in LAWS.get(kind, {}).items()
        if macro != _HARDNESS and obj.macros[macro] != NEUTRAL
    }
    if not moved:
        return values
    numbers, defaults = dict(values.numbers), dict(values.defaults)
    for name, value in moved.items():
        law = LAWS[kind][name]
        if name == "position":
            defaults.setdefault(name, obj.preset.position)
        for given in (numbers, defaults):
            if name in given and not (name == "position" and "point" in values.vectors):
                given[name] = _fitted(kind, name, law.at(given[name], value))
    return replace(values, numbers=numbers, defaults=defaults)


def _within(number: Parameter, value: float) -> float:
    """Return a value of a number within its range."""
    return min(max(value, number.low), number.high) if value else value


def pressed(to: ObjectCall, weight: float) -> float:
    """Return the force (N) of a slide that is given none: the striker's weight, as the object's macro has it."""
    to.given = replace(to.given, defaults={"force": weight, **to.given.defaults})
    return weight * _times(_STRONGER, to.obj.macros["force"])


def set_macro(translate: Translate, to: ObjectCall) -> None:
    """Turn a macro of an object, and of the copies for its notes."""
    assert to.call.verb
    transaction, name, value, message = to.transaction, to.call.verb.action, _value(to), to.canonical
    for copy in _copies(to):
        translate(transaction, calls(Message(f"/object/{copy}/macro/{name}", to.call.message.args))[0])
    _turn_to(to, message, MACROS[name].number, Turn(time_of(transaction, to.obj), name, value, to.values.points))
    if not MACROS[name].of_body:
        _steer_running(to, message, name)


def _turn_to(to: ObjectCall, message: Message, number: Parameter, turn: Turn) -> None:
    """Turn what changes an object, from the time of a turn on, and have the engine know how its modes change where that
    is another way than before."""
    obj, transaction = to.obj, to.transaction
    before, reshaped = obj.shaped, list(obj.reshaped)
    transaction.on_undo(lambda: setattr(obj, "reshaped", reshaped))
    keep(to, turn)
    _add_changes(to, message, number)  # first, as it stands for the message in a log; it is never taken back
    if obj.shaped != before:
        _reshape(to, message, transaction.time, obj.shaped)
    needed = {time: shaped for time, shaped in obj.shapes() if time > turn.time}
    for time, sent, shaped in reshaped:
        if time > turn.time and needed.pop(time, None) != shaped:
            obj.reshaped.remove((time, sent, shaped))
            back = Command(NOW, Kind.RESHAPE, amends=sent, value=WITHDRAWN)
            transaction.add(back, Sent(message, obj.handle.serial, 0, 0.0))
    for time, shaped in needed.items():
        _reshape(to, message, time, shaped)
    obj.heavier = heavier(transaction, obj)


def keep(to: ObjectCall, turn: Turn) -> None:
    """Remember a macro, or a setting that changes modes, from its time on."""
    obj, now = to.obj, float(to.transaction.engine.position)
    before, settled, shape = list(obj.turns), dict(obj.settled), obj.settled_shape

    def take_back() -> None:
        obj.turns, obj.settled, obj.settled_shape = before, settled, shape
        obj.recall(turn.time, now)

    to.transaction.on_undo(take_back)
    insort(obj.turns, turn._replace(order=_order(to.transaction)), key=attrgetter("time"))
    obj.recall(turn.time, now)
    to.transaction.turned[obj] = min(turn.time, to.transaction.turned.get(obj, math.inf))


def set_morph(translate: Translate, to: ObjectCall) -> None:
    """Bring an object a share of the way to another one."""
    transaction, preset, message = to.transaction, to.values.words["preset"], to.canonical
    require_family(to.name, to.obj.preset, transaction.presets.object(preset))
    for copy in _copies(to):
        translate(transaction, calls(Message(f"/object/{copy}/{MORPH.name}", to.call.message.args))[0])
    turn = Turn(time_of(transaction, to.obj), MORPH.name, _value(to), to.values.points, preset)
    _turn_to(to, message, MORPH, turn)


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


def _reshape(to: ObjectCall, message: Message, time: float, shaped: Shaped | None) -> None:
    """Have the engine know how an object's modes change from a time (samples) on."""
    obj, transaction = to.obj, to.transaction
    assert shaped is not None
    if shaped not in obj.tables:
        axes = transaction.axes(wanted(transaction, obj, shaped))
        level = transaction.scale.object(obj.preset)
        obj.tables[shaped] = transaction.engine.lay_out_macros(obj.handle, obj.modes, level, axes)
    placed = transaction.objects.start_of(obj, time)
    now = float(transaction.engine.position)
    obj.reshaped = [each for each in obj.reshaped if each[0] > now]
    if placed > now:
        obj.reshaped.append((placed, _order(transaction), shaped))
    reshape = Command(placed, Kind.RESHAPE, obj.handle, value=obj.tables[shaped])
    transaction.add(reshape, Sent(message, obj.handle.serial, 0, 0.0))


def heard_as(transaction: Transaction, obj: PlayedObject) -> Modes:
    """Return an object's modes about as its macros and settings have them, for make-up."""
    places = tuple(round(_GRID * obj.macros[each.name]) / _GRID for each in SHAPING)
    usual = all(obj.macros[each.name] == each.default for each in SHAPING)
    set_to = _set_to(obj)
    key = (obj.shaped, *places, *set_to)
    if usual and set_to == _AS_MADE:
        return obj.modes
    if key not in obj.heard:
        modes = obj.modes
        if not usual and obj.shaped:
            axes = transaction.axes(wanted(transaction, obj, obj.shaped))
            modes = changed(modes, [change_at(axes[n], place) for n, place in enumerate(places)])
        obj.heard.clear()
        obj.heard[key] = retuned(modes, *set_to)
    return obj.heard[key]


def _set_to(obj: PlayedObject) -> tuple[float, float, float]:
    """Return the ratio of frequencies, that of decay times and the damping of an object by its settings, on a grid."""
    tune, decay, damp = (obj.macros[name] for name in RETUNED)
    octaves = round(_A_THIRD * math.log2(decay)) / _A_THIRD
    return 2.0 ** (round(_A_THIRD * tune / 12.0) / _A_THIRD), 2.0**octaves, round(_GRID * damp) / _GRID


def _steer_running(to: ObjectCall, message: Message, macro: str) -> None:
    """Steer the gestures on an object that go on."""
    transaction, time = to.transaction, time_of(to.transaction, to.obj)
    sent, start = Sent(message, to.obj.handle.serial, 0, 0.0), transaction.objects.start_of(to.obj, transaction.time)
    for id in transaction.gestures.running():
        for command in _following(id, to.obj, Turn(time, macro, 0.0, to.values.points, order=_order(transaction))):
            transaction.add(command._replace(time=start), sent)


def _order(transaction: Transaction) -> int:
    """Return the number of the command that a transaction sends next."""
    return transaction.engine.sent + len(transaction.commands)


def _following(id: GestureId, obj: PlayedObject, turn: Turn) -> list[Command]:
    """Return the commands by which the gesture that goes on with an id, if it is on an object, follows a macro of
    that."""
    begun = id.begun_at(turn.time, turn.order)
    if begun is None or begun.obj is not obj:
        return []
    found = []
    for name, base in begun.values.items():
        law = LAWS[begun.kind][name]
        if law.macro == turn.name and name in GESTURES[begun.kind].steerable:
            points = tuple(
                each._replace(value=_fitted(begun.kind, name, law.at(base, each.value)), over=each.over or GLIDE)
                for each in turn.points
            )
            found += followed_by(id, turn.time, name, points)
    return found


def begin(to: ObjectCall, kind: str, number: int, played: "Played | None", base: Contact | None) -> None:
    """Remember a gesture that begins with the id of a number, base: its contact law in the middle of `hardness`, and
    have it follow what was sent ahead and comes later: macros, and make-up as the gesture is steered."""
    transaction = to.transaction
    id = transaction.gestures.id_of(number)
    if id is None:
        return
    time, begun = time_of(transaction, to.obj), _begun_as(kind, to.given, to.obj, base)
    if to.memory.begin is None:
        sent_for = max(transaction.time, float(transaction.engine.position))
        to.memory.begin = Begin(sent_for, begun, GESTURES[kind].lasts, played, _order(transaction))
        transaction.on_undo(transaction.gestures.begin(number, to.memory.begin))
    else:
        entry = to.memory.begin
        before = entry.begun, entry.played

        def take_back() -> None:
            entry.begun, entry.played = before

        transaction.on_undo(take_back)
        entry.begun, entry.played = begun, played
    later = [(at, id.levels_of(at, commands)) for at, commands in id.ahead if at > time]
    if not any(each.played for each in id.begins):
        later = []
    for obj in dict.fromkeys(each.begun.obj for each in id.begins):
        turns = [each for each in obj.turns if each.time > time and each.name in MACROS]
        later += [(each.time, _following(id, obj, each)) for each in turns if not MACROS[each.name].of_body]
    if later:
        start = transaction.objects.start_of(to.obj, transaction.time)
        transaction.add(Command(start, Kind.RELEVEL, gesture=number), transaction.sent[-1])
    for command in chain.from_iterable(commands for _, commands in sorted(later, key=itemgetter(0))):
        transaction.add(command, transaction.sent[-1])


def _begun_as(kind: str, values: Values, obj: PlayedObject, base: Contact | None) -> Begun:
    """Return what macros change of a gesture that begins, as its message has it; base: its contact law, unless that is
    of two objects."""
    given = {**values.defaults, **values.numbers}
    given.setdefault("position", obj.preset.position)
    known = {name: given[name] for name in LAWS[kind] if name in given}
    if "point" in values.vectors:
        known.pop("position", None)
    known = {name: value for name, value in known.items() if LAWS[kind][name].macro != _HARDNESS}
    return Begun(kind, obj, known | ({"stiffness": base.stiffness, "mass": base.mass} if base else {}))


def number_of(kind: str, name: str) -> Parameter | None:
    """Return the declaration of a value that a gesture's message can have."""
    return _NUMBERS[kind].get(name)


def _fitted(kind: str, name: str, value: float) -> float:
    number = number_of(kind, name)
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
    if obj.macros[MORPH.name] and obj.shaped:
        made.append(Message(f"/object/{name}/{MORPH.name}", (obj.shaped[1], obj.macros[MORPH.name])))
    return made


MACRO_HANDLERS: dict[str, Callable[[Translate, ObjectCall], None]] = {
    **{f"{MACRO}/{name}": set_macro for name in MACROS}, MORPHING: set_morph, DICE: throw_dice, UNDO: undo_dice,
}  # fmt: skip
"""Handlers by the address of the verb."""
