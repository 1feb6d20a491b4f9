"""The handler of messages that steer or stop gestures."""

from dataclasses import replace
from itertools import islice

from ...dsp.engine.memory.commands import Command, Kind
from ...dsp.runtime.engine import NOW
from ...dsp.schema import BY_POINT, BY_POSITION, GESTURES, LOAD, POINT, POSITION
from ...dsp.wording import MOST_COMPARED, expected, suggestion, there_are
from ..osc.addresses import VERBS, Call
from ..osc.arguments import GestureEnded, Point, Refused, Values, shown
from ..osc.points import Change, Move
from ..osc.wire import Message
from .engine_messages import changes, send
from .gesture_ids import GestureId
from .makeup import ARGUMENTS
from .touching import position_on, require_surface
from .transaction import Transaction

_ON_SURFACE = ("point", *(each.name for each in POINT))
_ON_OTHER = ("by_point", *(each.name for each in BY_POINT))
_STEERED = {verb.action: verb.number for verb in VERBS.values() if isinstance(verb, Change) and verb.target == "ID"}
"""Numbers that steer gestures, by name."""
CHANGE_WORK = 80
"""Work of carrying out a change on one gesture or object, as in patterns.work."""


def steer(transaction: Transaction, call: Call, values: Values) -> None:
    """Steer or stop all gestures that the ID of an address matches."""
    assert call.verb
    action = call.verb.action
    ids = transaction.gestures.selected(call.target, transaction.selection)
    if not ids:
        error = GestureEnded if transaction.gestures.have_ended(call.target, transaction.selection) else Refused
        raise error(f"{shown(call.target)}: no such gesture is running{_running(transaction, call.target)}")
    commands = [Command(NOW, Kind.STOP)]
    if action in (*_ON_OTHER, BY_POSITION.name):
        ids = _lying(transaction, call, ids, values)
    elif action not in ("stop", "point"):
        _warn_of_nothing(transaction, call, ids)
    elsewhere = _on_paths(transaction, call, ids, values) if isinstance(call.verb, Move) else {}
    if action in _ON_SURFACE:
        _require_surfaces(transaction, [id for id in ids if id.number not in elsewhere], action, values)
    if isinstance(call.verb, Move):
        commands = [
            each._replace(parameter=number.name)
            for number, path in zip(call.verb.numbers, values.paths, strict=True)
            for each in changes(Kind.STEER, number, replace(values, points=path))
        ]
    elif action != "stop":
        assert isinstance(call.verb, Change)
        commands = [each._replace(parameter=action) for each in changes(Kind.STEER, call.verb.number, values)]
    if action == LOAD.name:
        _require_borne(ids, max(each.value for each in commands))
    transaction.selection.charge(CHANGE_WORK * (len(ids) * len(commands) - 1), call.target)
    for id in ids:
        message = Message(f"/gesture/{id.name}/{action}", call.message.args)
        own = [each._replace(gesture=id.number) for each in elsewhere.get(id.number, commands)]
        for command in (*own, *_levels(transaction, id, own)):
            send(transaction, message, command)


def followed_by(id: GestureId, time: float, name: str, points: tuple[Point, ...]) -> list[Command]:
    """Return the commands by which a number of a gesture follows a macro along points at a time (samples), and its
    make-up that."""
    steered = changes(Kind.STEER, _STEERED[name], Values({name: points[-1].value}, points=points))
    commands = [each._replace(time=time, parameter=name, gesture=id.number, follows=True) for each in steered]
    return [*commands, *(id.levels_of(time, commands) if name in ARGUMENTS else [])]


def _levels(transaction: Transaction, id: GestureId, commands: list[Command]) -> list[Command]:
    """Return the commands by which the make-up of a gesture follows its argument, where that is steered."""
    if commands[0].parameter not in ARGUMENTS:
        return []
    time = max(transaction.time, float(transaction.engine.position))
    placed = [each._replace(time=transaction.time) for each in commands]
    transaction.on_undo(transaction.gestures.send_ahead(id, time, placed))
    return id.levels_of(time, placed)


def _warn_of_nothing(transaction: Transaction, call: Call, ids: list[GestureId]) -> None:
    """Warn of steering what none of the gestures has."""
    assert call.verb
    action = call.verb.action
    kinds = dict.fromkeys(address.rsplit("/", 1)[1] for id in ids for address, _ in id.running)
    if not any(action in GESTURES[kind].steerable for kind in kinds):
        known = dict.fromkeys(name for kind in kinds for name in GESTURES[kind].steerable)
        reason = f"what goes on ({', '.join(kinds)}) has no {action}, so nothing changes: {expected(action, known)}"
        transaction.replies.append(Message("/warning", (f"{call.message.address}: {reason}",)))


def _require_borne(ids: list[GestureId], load: float) -> None:
    """Refuse a load (N) that is too much for one of the gestures."""
    for id in ids:
        if load > id.most_load:
            raise Refused(f"load = {load:g}: expected at most {id.most_load:g} N of {id.name}")


def _on_paths(transaction: Transaction, call: Call, ids: list[GestureId], values: Values) -> dict[int, list[Command]]:
    """Return the commands, by number, of gestures on objects without a surface: a point is a position on their path."""
    assert call.verb
    action = call.verb.action
    number = BY_POSITION if action == "by_point" else POSITION
    found = {}
    for id in ids:
        names = [id.under] if action == "by_point" else [address.split("/")[2] for address, _ in id.running]
        there = {name: transaction.objects.at(name, transaction.time).get(name) for name in names}
        known = [(name, obj) for name, obj in there.items() if obj]
        if not known or any(obj.modes.faces is not None for _, obj in known):
            continue
        points = []
        for each in zip(*values.paths, strict=True):
            place = position_on(*known[0], action, tuple(axis.value for axis in each))
            assert place is not None
            points.append(each[0]._replace(value=place))
        steering = changes(Kind.STEER, number, replace(values, points=tuple(points)))
        found[id.number] = [each._replace(parameter=number.name) for each in steering]
    return found


def _require_surfaces(transaction: Transaction, ids: list[GestureId], action: str, values: Values) -> None:
    """Refuse a point of a gesture whose objects all have no surface."""
    point = tuple(values.numbers[each.name] for each in POINT if each.name in values.numbers)
    for id in ids:
        names = {address.split("/")[2] for address, _ in id.running}
        there = {name: transaction.objects.at(name, transaction.time).get(name) for name in names}
        if all(obj and obj.modes.faces is None for obj in there.values()):
            for name, obj in there.items():
                if obj:
                    require_surface(name, obj, action, point)


def _lying(transaction: Transaction, call: Call, ids: list[GestureId], values: Values) -> list[GestureId]:
    """Return those of the gestures that lie on an object; warn where none does, and refuse a point where no such object
    has a surface."""
    assert call.verb
    lying = [id for id in ids if id.under]
    if not lying:
        text = f"{call.message.address}: what goes on lies on no object, so nothing changes"
        transaction.replies.append(Message("/warning", (text,)))
    there = {id.under: transaction.objects.at(id.under, transaction.time).get(id.under) for id in lying}
    known = {name: obj for name, obj in there.items() if obj}
    axes = _ON_OTHER[1:]
    if call.verb.action in axes and known and all(obj.modes.faces is None for obj in known.values()):
        point = tuple(values.numbers[each.name] for each in BY_POINT if each.name in values.numbers)
        for name, obj in known.items():
            require_surface(name, obj, call.verb.action, point)
    return lying


def _running(transaction: Transaction, target: str) -> str:
    """Say which gestures run, for the first errors of a packet."""
    if not transaction.explains():
        return ""
    running = list(islice(transaction.gestures.newest_running(), MOST_COMPARED))
    return f"; {suggestion(target, running) or there_are(running)}"
