"""The handlers of messages that mount sensors on objects."""

from typing import Any

from ...dsp.bodies.sensor import Sensor
from ...dsp.engine.memory.commands import Command, Kind
from ...dsp.wording import there_are
from ...presets.sensors import sensor_of
from ..osc.addresses import Call
from ..osc.arguments import Refused, Values, require_name, shown
from ..osc.patterns import is_pattern, match
from ..osc.sensor_verbs import SENSOR
from ..osc.wire import Message
from .sensors import Mounted
from .touching import sensed_place
from .transaction import Sent, Transaction


def sensor_asked(values: Values) -> Sensor:
    """Return the sensor that a message asks for. PresetError if its preset is none."""
    changes: dict[str, Any] = {key: values.numbers[key] for key in ("resonance", "damping") if key in values.numbers}
    changes |= {"quantity": values.words["quantity"]} if "quantity" in values.words else {}
    return sensor_of(values.words.get("preset", "ideal"))._replace(**changes)


def meaning_of(values: Values) -> str:
    """Return the value of a sample of 1.0 of a sensor that a message asks for, with its unit."""
    return f"{values.number('full'):g} {sensor_asked(values).unit}"


def last_of_sensors(count: int) -> str:
    """Describe channels that several sensors may have, one after the other."""
    return f"the last {count} channels are sensors': m/s^2 or m/s over `full`"


def _mount(transaction: Transaction, call: Call, values: Values) -> None:
    name, target = values.words["name"], values.words["object"]
    require_name("name", name)
    table = transaction.sensors
    if name == "new":
        raise Refused("name = new: expected another name, as /sensor/new is an address")
    if name in table.there:
        raise Refused(f"name = {name}: there is such a sensor already; free it first")
    asked = table.time_of(transaction.time)
    found = {} if is_pattern(target) else transaction.objects.at(target, asked)
    if target not in found:
        known = list(transaction.objects.there(asked))
        near = transaction.suggestion(target, known) or there_are(known)
        raise Refused(f"object = {shown(target)}: no such object; {near}")
    obj = found[target]
    sensor, full, number = sensor_asked(values), values.number("full"), table.free_number(name)
    place = sensed_place(target, obj, values)
    transaction.on_undo(table.add(name, Mounted(target, place["position"], number, sensor, full)))
    mounted = {
        "acceleration": int(sensor.quantity == "acceleration"),
        **place,
        "filter": sensor.filter(transaction.engine.rate),
        "scale": 1.0 / full,
    }
    time = transaction.objects.start_of(obj, asked)
    transaction.on_undo(table.took_place(time))
    command = Command(time, Kind.MOUNT, obj.handle, mounted, value=1.0, channel=number)
    transaction.add(command, Sent(call.message, obj.handle.serial, 0, 0.0))


def _free(transaction: Transaction, call: Call, values: Values) -> None:
    table = transaction.sensors
    names = [name for name in table.there if match(call.target, name)]
    if not names:
        raise Refused(f"{shown(call.target)}: no such sensor; {there_are(table.there)}")
    time = table.time_of(transaction.time)
    transaction.on_undo(table.took_place(time))
    for name in names:
        mounted = table.there.pop(name)
        transaction.on_undo(lambda name=name, mounted=mounted: table.there.update({name: mounted}))  # type: ignore[misc]
        nowhere = {"position": 0.0, "on_surface": 0, "spot": (0.0, 0.0, 0.0), "direction": (0.0, 0.0, 0.0)}
        blank = {"acceleration": 0, **nowhere, "filter": (1.0, 0.0, 0.0, 0.0, 0.0), "scale": 0.0}
        command = Command(time, Kind.MOUNT, values=blank, channel=mounted.number)
        transaction.add(command, Sent(Message(f"/sensor/{name}/free"), 0, 0, 0.0))


SENSOR_HANDLERS = {SENSOR: _mount, "/sensor/NAME/free": _free}
"""Handlers by address."""
