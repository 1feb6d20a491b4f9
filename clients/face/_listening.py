"""A World's ears that move: a listener to whom sound takes its time, and microphones that ride on bodies."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .dsp.engine.memory.commands import Command, Kind
from .server.bridge.checks import WorldError
from .server.bridge.hearing import Listener, Microphone
from .server.bridge.rows import rotation
from .server.bridge.simulation import Simulation
from .server.bridge.turns import quaternion_of
from .server.osc.wire import Message
from .server.scene.placing import pose_values, turn_of

_STILL = 1e-7
"""m, and share of a turn: by less nothing has moved."""

Told = tuple[Message, Command, str]
"""A message, the command that says the same but for its object's handle, and that object's name."""


class Listening:
    """The places of a simulation's listener and bodies, as far as they are known."""

    def __init__(self, listener: Listener, simulation: Simulation) -> None:
        self._listener, self._simulation = listener, simulation
        self._known: dict[str, NDArray[np.float64]] = {}
        self._pose = np.full(7, np.nan)

    def first(self) -> list[Message]:
        """Return the messages that put the listener and the walls there."""
        listener = self._listener
        angles = ("yaw", listener.yaw, "pitch", listener.pitch, "roll", listener.roll)
        made = [Message("/listener", (*map(float, listener.position), *angles, "layout", listener.layout))]
        if listener.room is not None:
            keys = dict(listener.room)
            size = [keys.pop(name, math.nan) for name in ("length", "width", "height")]
            made.append(Message("/room", (*size, *(part for pair in keys.items() for part in pair))))
        elif listener.floor is not None:
            made.append(Message("/floor", (listener.floor,)))
        return made

    def moved(self, over: float) -> Iterator[Told]:
        """Yield the messages by which bodies and the listener move in a time (s), of those that do."""
        state = self._simulation.state[0]
        for number, body in enumerate(self._simulation.bodies):
            if body.rings:
                place = state["position"][number]
                before = self._known.get(body.name)
                if before is None or np.abs(place - before).max() > _STILL:
                    self._known[body.name] = place.copy()
                    time = 0.0 if before is None else over
                    message = Message(f"/object/{body.name}/place", (*map(float, place), "over", time))
                    yield message, Command(0.0, Kind.POSE, value=1.0, values=pose_values(place, over=time)), body.name
        if self._listener.on:
            yield from self._ridden(over)

    def _ridden(self, over: float) -> Iterator[Told]:
        listener = self._listener
        place, turn = ridden(self._simulation, listener.on, listener.position)
        own = np.reshape(rotation.py_func(*turn_of(listener.yaw, listener.pitch, listener.roll)), (3, 3))
        pose = np.concatenate([place, quaternion_of(turn @ own)])
        if not np.abs(pose - self._pose).max() <= _STILL:
            over = over if np.isfinite(self._pose[0]) else 0.0
            self._pose = pose
            yaw, pitch, roll = angles_of(turn @ own)
            angles = ("yaw", yaw, "pitch", pitch, "roll", roll, "over", over, "layout", listener.layout)
            message = Message("/listener", (*map(float, place), *angles))
            yield message, Command(0.0, Kind.LISTEN, values=pose_values(pose[:3], pose[3:], over)), ""


def angles_of(turn: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return yaw, pitch and roll (degrees) of a rotation (3, 3)."""
    yaw, roll = math.atan2(turn[1, 0], turn[0, 0]), math.atan2(turn[2, 1], turn[2, 2])
    pitch = math.asin(min(max(-turn[2, 0], -1.0), 1.0))
    return math.degrees(yaw), math.degrees(pitch), math.degrees(roll)


def ridden(simulation: Simulation, body: str, place: object) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where a place (m) in the axes of a body is now, and how these are turned, (3, 3)."""
    number = simulation.number(body)
    state = simulation.state[0]
    turn = state["turn"][number].reshape(3, 3).copy()
    return state["position"][number] + turn @ np.array(place, np.float64), turn


def ride(simulation: Simulation, microphones: tuple[Microphone, ...], record: np.void) -> None:
    """Place microphones that ride on bodies where these were in the last step."""
    for n, microphone in enumerate(microphones):
        if microphone.on:
            place, turn = ridden(simulation, microphone.on, microphone.position)
            if not np.isfinite(place).all():
                raise WorldError(f"microphone {n}: body {microphone.on}: no step has given its Pose")
            record["position"][n] = place
            if microphone.direction is not None and (length := math.hypot(*microphone.direction)):
                record["direction"][n] = turn @ (np.array(microphone.direction) / length)
