"""Gestures that are sent ahead of their time: where macros change an object before they begin, they begin as these have
it.

The engine keeps such a gesture until its time. What it was sent as is remembered here; once a message turns a macro
that comes before it, the gesture's message is carried out anew, and its command gets other values. So it does not
matter which of both was sent first, and a log renders to what was heard.
"""

import math
from bisect import insort
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from operator import attrgetter

from ...dsp.engine.memory.commands import Command, Kind
from ...dsp.runtime.arena import EngineFull
from ...dsp.runtime.engine import NOW
from ...dsp.schema import GESTURES
from ...presets import PresetError
from ..osc.addresses import Call
from ..osc.arguments import Refused, Values
from ..osc.wire import Message
from .macros import WITHDRAWN, as_turned
from .object_call import Memory, ObjectCall
from .objects import PlayedObject
from .transaction import Sent, Transaction
from .turned import recall

MOST = 500
"""Gestures that are carried out anew at once: of 3,000 it took 0.5 s of the server's time, and 4.5 ms of one block."""


@dataclass(eq=False)
class Ahead:
    """A gesture that was sent ahead of its time (samples): its message, as a handler takes it, what that chose, and the
    commands that it became, by their numbers."""

    time: float
    call: Call
    name: str
    obj: PlayedObject
    given: Values
    memory: Memory
    handle: Callable[[ObjectCall], None]
    order: int
    """Number of the command that came next as it was sent."""
    commands: dict[int, tuple[Command, Sent]] = field(default_factory=dict)


@contextmanager
def sent_ahead(to: ObjectCall, handle: Callable[[ObjectCall], None]) -> Iterator[None]:
    """Remember the gesture that is carried out meanwhile, if it begins later."""
    transaction, first, given = to.transaction, len(to.transaction.commands), to.given
    yield
    assert to.call.verb
    time = max((each.time for each in transaction.commands[first:] if _begins(each)), default=NOW)
    if to.call.verb.action in GESTURES and time > float(transaction.engine.position):
        order = transaction.engine.sent + first
        ahead = Ahead(time, to.call, to.name, to.obj, given, to.memory, handle, order)
        ahead.commands = {
            n: made_of for n, made_of in enumerate(_pairs(transaction, first), first) if _begins(made_of[0])
        }
        transaction.ahead.append(ahead)
        transaction.on_undo(lambda: transaction.ahead.remove(ahead))


def _begins(command: Command) -> bool:
    return isinstance(command.kind, str)


def _pairs(transaction: Transaction, first: int) -> list[tuple[Command, Sent]]:
    return list(zip(transaction.commands[first:], transaction.sent[first:], strict=True))


def remember(transaction: Transaction, first: int) -> None:
    """Remember the gestures that a transaction sent ahead, with the number of its first command, and forget those that
    have begun."""
    now = float(transaction.engine.position)
    for ahead in transaction.ahead:
        ahead.commands = {first + n: pair for n, pair in ahead.commands.items()}
        for obj in (ahead.obj, *ahead.memory.others):
            obj.ahead = [each for each in obj.ahead if each.time > now and each is not ahead]
            insort(obj.ahead, ahead, key=attrgetter("time"))


def renew(transaction: Transaction) -> None:
    """Carry out anew the gestures that were sent ahead and come after a macro that a transaction turns. Those that are
    refused now are taken back. EngineFull if they are too many."""
    later: dict[Ahead, None] = {}
    for obj, time in transaction.turned.items():
        later |= dict.fromkeys(each for each in obj.ahead if each.time > time)
    if len(later) > MOST:
        raise EngineFull(f"{len(later):,} gestures that were sent ahead would change: expected at most {MOST}")
    for ahead in sorted(later, key=attrgetter("time")):
        _renew(transaction, ahead)
    for obj in transaction.turned:
        recall(transaction, obj)


def _renew(transaction: Transaction, ahead: Ahead) -> None:
    """Carry out a gesture anew, and have its commands be as they are now."""
    assert ahead.call.verb
    savepoint, first, now = transaction.savepoint(), len(transaction.commands), transaction.time
    transaction.time, transaction.order = ahead.time, ahead.order
    try:
        recall(transaction, ahead.obj)
        turned = as_turned(ahead.given, ahead.call.verb.action, ahead.obj)
        memory = ahead.memory
        ahead.handle(ObjectCall(transaction, ahead.call, turned, ahead.name, ahead.obj, ahead.given, memory=memory))
    except (Refused, PresetError) as error:
        transaction.undo_to(savepoint)
        transaction.replies.append(Message("/fail", (ahead.call.message.address, str(error))))
        for number, (command, sent) in ahead.commands.items():
            transaction.add(command._replace(time=NOW, amends=number, value=WITHDRAWN), sent)
        _forget(transaction, ahead)
        id, begin = transaction.gestures.id_of(ahead.memory.number), ahead.memory.begin
        if id and begin in id.begins:
            id.begins.remove(begin)
            transaction.on_undo(partial(insort, id.begins, begin, key=attrgetter("time")))
        return
    finally:
        transaction.time, transaction.order = now, math.inf
    made = _pairs(transaction, first)
    del transaction.commands[first:], transaction.sent[first:]
    begins = [pair for pair in made if _begins(pair[0])]
    if len(begins) != len(ahead.commands):
        return
    if all(_is_same(*pairs) for pairs in zip(begins, ahead.commands.values(), strict=True)):
        return
    renewed = replace(ahead, commands={})
    for number, (command, sent) in zip(ahead.commands, begins, strict=True):
        renewed.commands[len(transaction.commands)] = command, sent
        transaction.add(command._replace(time=NOW, amends=number), sent)
    for command, sent in made:
        if command.follows or command.kind is Kind.RELEVEL:
            transaction.add(command, sent)
    _forget(transaction, ahead)
    transaction.ahead.append(renewed)


def _is_same(one: tuple[Command, Sent], other: tuple[Command, Sent]) -> bool:
    return one[0].values == other[0].values and one[1].message == other[1].message


def _forget(transaction: Transaction, ahead: Ahead) -> None:
    """Forget a gesture that is carried out anew, or taken back."""
    there = [obj for obj in (ahead.obj, *ahead.memory.others) if ahead in obj.ahead]
    for obj in there:
        obj.ahead.remove(ahead)
        transaction.on_undo(partial(insort, obj.ahead, ahead, key=attrgetter("time")))
