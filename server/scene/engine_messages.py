"""Handlers of messages to the engine as a whole, alike in a score and on a server."""

import math
from collections.abc import Callable
from functools import partial

from ...dsp.contact.accuracy import NUMBERS
from ...dsp.engine.memory.commands import Command, Kind
from ...dsp.runtime.engine import NOW
from ...dsp.schema import CURVE, FORMS, MAIN_GAIN, OVER, Parameter
from ..osc.addresses import Call
from ..osc.arguments import Refused, Values
from ..osc.wire import Message
from .transaction import Sent, Transaction

Handler = Callable[[Transaction, Call, Values], None]
"""Adds what a call asks for, by its checked values, to a transaction."""

_AS_TOLD = 1e-6  # by which a float32 may miss a number


def send(transaction: Transaction, message: Message, command: Command) -> None:
    """Add a command that is about no object; `message` is what it stands for."""
    transaction.add(command._replace(time=transaction.time), Sent(message, 0, 0, 0.0))


def changes(kind: Kind, number: Parameter, values: Values) -> list[Command]:
    """Return the commands of a number that may take its time: one for each point that it goes to."""
    return [
        Command(
            NOW, kind, value=number.in_engine(point.value),
            values={"after": point.after, OVER.name: point.over, CURVE.name: point.curve},
        )
        for point in values.points
    ]  # fmt: skip


def _panic(transaction: Transaction, call: Call, values: Values) -> None:
    transaction.on_undo(transaction.objects.forget_ahead(transaction.time))
    send(transaction, call.message, Command(NOW, Kind.PANIC))


def _quality(transaction: Transaction, call: Call, values: Values) -> None:
    send(transaction, call.message, Command(NOW, Kind.QUALITY, value=values.numbers["quality"]))


def _accuracy(transaction: Transaction, call: Call, values: Values) -> None:
    send(transaction, call.message, Command(NOW, Kind.ACCURACY, value=NUMBERS[values.words["accuracy"]]))


def _bank(transaction: Transaction, call: Call, values: Values) -> None:
    send(transaction, call.message, Command(NOW, Kind.BANK, value=FORMS.index(values.words["bank"])))


def _budget(transaction: Transaction, call: Call, values: Values) -> None:
    budget = {name: int(values.numbers[name]) for name in ("steps", "modes")}
    send(transaction, call.message, Command(NOW, Kind.BUDGET, values=budget))


def _gain(transaction: Transaction, call: Call, values: Values) -> None:
    for change in changes(Kind.GAIN, MAIN_GAIN, values):
        send(transaction, call.message, change)


def _switch(kind: Kind, transaction: Transaction, call: Call, values: Values) -> None:
    """Turn the limiter or the level ahead of it on or off."""
    ((name, word),) = values.words.items()
    if word in ("on", "1") and transaction.scale.calibrated:
        text = f"/{name}: no effect: samples are pascals, which nothing limits"
        transaction.replies.append(Message("/warning", (text,)))
        return
    send(transaction, call.message, Command(NOW, kind, value=float(word in ("on", "1"))))


def _play(transaction: Transaction, call: Call, values: Values) -> None:
    makeup, before = transaction.makeup, transaction.makeup.on
    makeup.on = values.words["play"] in ("on", "1")
    transaction.on_undo(lambda: setattr(makeup, "on", before))
    if makeup.on and transaction.scale.calibrated:
        text = "/play: no effect on calibrated sound"
        transaction.replies.append(Message("/warning", (text,)))


def _channels(transaction: Transaction, call: Call, values: Values) -> None:
    asked, there = int(values.numbers["channels"]), transaction.engine.channels
    if asked != there:
        raise Refused(f"channels = {asked}: expected {there}, as many as were opened at the start")


def _sensors(transaction: Transaction, call: Call, values: Values) -> None:
    asked, table, there = int(values.numbers["sensors"]), transaction.sensors, transaction.engine.sensors
    if asked != there and not table.grows:
        raise Refused(f"sensors = {asked}: expected {there}, as many channels as were opened at the start")


def _full_scale(transaction: Transaction, call: Call, values: Values) -> None:
    asked, scale = values.numbers["full_scale"], transaction.scale
    if not scale.calibrated and not math.isclose(asked, scale.full_scale, rel_tol=_AS_TOLD):
        raise Refused(f"full_scale = {asked:g}: expected {scale.full_scale:g} Pa, as was chosen at the start")


def _end(transaction: Transaction, call: Call, values: Values) -> None:
    """Do nothing: a render looks for it before it begins."""


ENGINE_HANDLERS: dict[str, Handler] = {
    "/accuracy": _accuracy,
    "/quality": _quality,
    "/bank": _bank,
    "/budget": _budget,
    "/gain": _gain,
    "/limiter": partial(_switch, Kind.LIMITER),
    "/headroom": partial(_switch, Kind.HEADROOM),
    "/play": _play,
    "/channels": _channels,
    "/sensors": _sensors,
    "/full_scale": _full_scale,
    "/panic": _panic,
    "/end": _end,
}
"""Handlers by address."""
