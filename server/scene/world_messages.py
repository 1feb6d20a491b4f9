"""The handlers of `/world/...`: a simulation is reported, and the gestures that follow from it are carried out."""

from collections.abc import Callable
from functools import partial

from ...dsp.runtime.arena import EngineFull
from ..osc.addresses import Call, calls
from ..osc.arguments import Refused, Values
from ..osc.score import on_grid
from ..osc.wire import Message
from ..osc.world_verbs import BODY
from .makeup import MakeUp
from .transaction import Transaction

Handler = Callable[[Transaction, Call, Values], None]
Translate = Callable[[Transaction, Call], None]

_AHEAD = 0.01  # s between a step without a time tag and its sound


def world_handlers(translate: Translate) -> dict[str, Handler]:
    """Return the handlers by address; translate: what carries out a call."""

    def carry_out(transaction: Transaction, message: Message, time: float) -> None:
        before, transaction.time = transaction.time, time
        try:
            for call in calls(message):
                translate(transaction, call)
        finally:
            transaction.time = before

    def body(transaction: Transaction, call: Call, values: Values) -> None:
        from ..bridge.wire import new_body  # slow to load

        made, simulation = transaction.made_of(call, new_body), transaction.world.simulation
        simulation.put(made)
        transaction.on_undo(lambda: simulation.take_back(made.name))
        if made.sound:
            (its,) = calls(made.message())
            with transaction.has_made(its, made.sound):
                translate(transaction, its)

    def step(transaction: Transaction, call: Call, values: Values) -> None:
        engine = transaction.engine
        transaction.beside = None  # reports are sent once: they cannot wait for a table
        before, told = transaction.world.step(values.numbers["time"])
        begin = max(transaction.time, float(engine.position) + _AHEAD * engine.rate * (transaction.time < 0))
        makeup, transaction.makeup = transaction.makeup, MakeUp()  # a simulation's levels are those of physics
        for each in told:
            at = on_grid(begin + max(each.time - before, 0.0) * engine.rate)
            _try_out(transaction, call, each.message, partial(carry_out, transaction, each.message, at))
        transaction.makeup = makeup

    def end(transaction: Transaction, call: Call, values: Values) -> None:
        transaction.beside = None  # as for a step
        for name in transaction.world.end():
            carry_out(transaction, Message(f"/object/{name}/free", (1,)), transaction.time)

    return {
        BODY: body,
        "/world/pair": _pair,
        "/world/microphones": lambda transaction, call, values: transaction.world.place_microphones(values.many),
        "/world/pose": _pose,
        "/world/touch": _touch,
        "/world/grains": _grains,
        "/world/pour": _pour,
        "/world/step": step,
        "/world/end": end,
    }


def _try_out(transaction: Transaction, call: Call, message: Message, carry_out: Callable[[], None]) -> None:
    """Carry out a message that follows from a call; where it is refused say so, for the rest is heard. What steers or
    ends a gesture whose beginning was refused is left out."""
    _, group, id, *_ = message.address.split("/")
    if group == "gesture" and not transaction.gestures.selected(id, transaction.selection):
        return
    savepoint = transaction.savepoint()
    try:
        carry_out()
    except (Refused, EngineFull) as error:
        transaction.undo_to(savepoint)
        reason = f"{message.address}: {transaction.reason(error)}"
        transaction.replies.append(Message("/fail", (call.message.address, reason)))


def _pair(transaction: Transaction, call: Call, values: Values) -> None:
    a, b = values.words.pop("a"), values.words.pop("b")
    transaction.world.of(a, b).pair(a, b, **values.numbers, **values.words)


def _pose(transaction: Transaction, call: Call, values: Values) -> None:
    transaction.on_undo(transaction.world.pose(values.words["name"], values.many))


def _touch(transaction: Transaction, call: Call, values: Values) -> None:
    transaction.on_undo(transaction.world.touch(values.words["a"], values.words["b"], values.numbers))


def _pour(transaction: Transaction, call: Call, values: Values) -> None:
    transaction.on_undo(transaction.world.pour(values.words["name"], values.words["on"], values.numbers))


def _grains(transaction: Transaction, call: Call, values: Values) -> None:
    name, kinds = values.words["name"], transaction.world.simulation.grains
    exponent = transaction.world.grains(name, values.words.get("bodies", ""), values.words.get("striker", ""))
    transaction.on_undo(lambda: kinds.take_back(name))
    transaction.pulses(exponent)  # a table that is made now, and not amid the steps
