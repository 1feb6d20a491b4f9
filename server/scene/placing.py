"""Handlers of the messages that put objects, the listener and walls into space."""

import math
from typing import Any

import numpy as np

from ...dsp.engine.memory.commands import Command, Kind
from ...dsp.engine.memory.space_record import LINES
from ...dsp.runtime.engine import NOW
from ...dsp.space.air import absorption, speed_of_sound
from ..osc.addresses import Call
from ..osc.arguments import Refused, Values
from ..osc.space_verbs import FLOOR, LAYOUTS, LISTENER, ROOM
from ..osc.wire import Message
from .engine_messages import send
from .object_call import ObjectCall
from .transaction import Transaction

_KNOWN = 8_000.0  # Hz, at which the air's absorption is exact
_LIMIT = 0.4  # of the sampling rate, where that is lower
_UPRIGHT = (1.0, 0.0, 0.0, 0.0)
_SABINE = 24.0 * math.log(10.0)  # V/(c A), of T60
_NOTHING = (0.0,) * 16
ORDERS = {4: 1, 9: 2, 16: 3}
"""Orders of ambisonics by their channels."""


def pose_values(place: Any, turn: Any = _UPRIGHT, over: float = 0.0, values: Any = _NOTHING) -> dict[str, Any]:
    """Return the values of a command of space: x y z (m), the quaternion w x y z, the time it takes (s), and others."""
    filled = (*values, *_NOTHING)[:16]
    return {"pose": (*map(float, place), *map(float, turn)), "over": over, "values": filled}


def turn_of(yaw: float, pitch: float, roll: float) -> tuple[float, ...]:
    """Return the quaternion of a turn (degrees): yaw about z, then pitch about the new y, then roll about the new x."""
    a, b, c = (math.radians(0.5 * each) for each in (yaw, pitch, roll))
    z, y, x = (
        np.array([math.cos(a), 0.0, 0.0, math.sin(a)]),
        np.array([math.cos(b), 0.0, math.sin(b), 0.0]),
        np.array([math.cos(c), math.sin(c), 0.0, 0.0]),
    )
    return tuple(_product(_product(z, y), x).tolist())


def _product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return the product of quaternions."""
    return np.array([
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    ])  # fmt: skip


def listening(
    layout: str, channels: int, rate: float, head: float, air: float, temperature: float, humidity: float
) -> tuple[float, ...]:
    """Return the values of a listener. Refused for a layout that the channels cannot carry."""
    if layout == "binaural" and channels != 2:
        raise Refused(f"layout = binaural: expected 2 channels, and there are {channels}")
    if layout == "ambisonics" and channels not in ORDERS:
        raise Refused(f"layout = ambisonics: expected 4, 9 or 16 channels, and there are {channels}")
    known = min(_KNOWN, _LIMIT * rate)
    lost = air * absorption(known, temperature, humidity)
    speed = speed_of_sound(temperature)
    number = float(LAYOUTS.index(layout))
    return number, float(ORDERS.get(channels, 0)), head, speed, lost, 2.0 * math.pi * known / rate


def _listener(transaction: Transaction, call: Call, values: Values) -> None:
    engine, place = transaction.engine, [values.numbers[axis] for axis in "xyz"]
    layout = values.words.get("layout", transaction.space.layout)
    told = listening(layout, engine.channels, engine.rate,
                     *(values.number(name) for name in ("head", "air", "temperature", "humidity")))  # fmt: skip
    turn = turn_of(*(values.number(name) for name in ("yaw", "pitch", "roll")))
    before = transaction.space.layout
    transaction.space.layout = layout
    transaction.on_undo(lambda: setattr(transaction.space, "layout", before))
    about = pose_values(place, turn, values.number("over"), told)
    message = call.message  # in a log it may come after one that was sent later
    if "layout" not in values.words:
        message = Message(message.address, (*message.args, "layout", layout))
    send(transaction, message, Command(NOW, Kind.LISTEN, value=1.0, values=about))


def place_object(to: ObjectCall) -> Command:
    """Return the command of `/object/NAME/place`. Refused where there is no room for another object in space."""
    numbers, table, serial = to.values.numbers, to.transaction.space, to.obj.handle.serial
    given = [axis for axis in "xyz" if axis in numbers]
    if not given:
        table.places.pop(serial, None)
        return Command(NOW, Kind.POSE, values=pose_values((0.0, 0.0, 0.0)))
    if len(given) < 3:
        said = ", ".join(f"{axis} = {numbers[axis]:g}" for axis in given)
        raise Refused(f"{said}: expected x, y and z (m), or none of them")
    there = {obj.handle.serial for obj in to.transaction.objects.values()}
    table.places = {each: place for each, place in table.places.items() if each in there}
    if len(table.places.keys() | {serial}) > LINES:
        raise Refused(f"place: expected at most {LINES} objects in space")
    table.places[serial] = place = (numbers["x"], numbers["y"], numbers["z"])
    values = pose_values(place, over=to.values.number("over"))
    return Command(NOW, Kind.POSE, value=1.0, values=values)


def _floor(transaction: Transaction, call: Call, values: Values) -> None:
    walls, height = float("z" in values.numbers), values.numbers.get("z", 0.0)
    reflected = math.sqrt(1.0 - values.number("absorption"))
    about = pose_values((0.0,) * 3, values=(walls, 0.0, 0.0, height, 0.0, 0.0, 0.0, reflected))
    send(transaction, call.message, Command(NOW, Kind.FURNISH, values=about))


def _room(transaction: Transaction, call: Call, values: Values) -> None:
    numbers = values.numbers
    low = [values.number(axis) for axis in "xyz"]
    size = [numbers[name] for name in ("length", "width", "height")]
    volume = math.prod(size)
    surface = 2.0 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0])
    speed = speed_of_sound()
    if "absorption" in numbers:
        lost = numbers["absorption"]
        t60 = numbers.get("t60", min(max(eyring(volume, surface, lost, speed), 0.05), 60.0))
    else:
        t60 = numbers.get("t60", 0.5)
        lost = 1.0 - math.exp(-_SABINE * volume / (speed * surface * t60))
    late = t60 if values.number("late") else 0.0
    high = [a + b for a, b in zip(low, size, strict=True)]
    level = math.sqrt(16.0 * math.pi * 6.0 * math.log(10.0) / (_SABINE / speed * volume))
    path = 4.0 * volume / (surface * speed)
    about = (6.0, *low, *high, math.sqrt(1.0 - lost), late, numbers.get("t60_high", t60), level, path)
    command = Command(NOW, Kind.FURNISH, values=pose_values((0.0,) * 3, values=about))
    send(transaction, call.message, command)


def eyring(volume: float, surface: float, absorption: float, speed: float) -> float:
    """Return the T60 (s) of a room of a volume (m^3) whose surface (m^2) absorbs a share: C. F. Eyring, 1930."""
    return _SABINE * volume / (-speed * surface * math.log(max(1.0 - absorption, 1e-9)))


SPACE_HANDLERS = {LISTENER: _listener, FLOOR: _floor, ROOM: _room}
"""Handlers by address."""
