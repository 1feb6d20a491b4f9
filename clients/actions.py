"""The addresses of a score as methods, which a client and a scene share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, SupportsFloat

from ..dsp.arguments import explain_all_arguments, switch_of
from ..dsp.errors import CaromError
from ..server.osc.wire import Message
from .gesture_methods import Gestures, Value, with_gestures, with_shared_help

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .gesture_methods import (
        FloorKeys,
        ListenerKeys,
        MacroKeys,
        NoteKeys,
        PlaceKeys,
        RampKeys,
        RoomKeys,
        SensorKeys,
        SteerKeys,
    )


class CommandError(CaromError, RuntimeError):
    """A message was refused, or cannot be sent; the text says why."""


@explain_all_arguments
@with_shared_help
@with_gestures
class Actions(Gestures, ABC):
    """Every address of a score as a method, but `/object/new`. A method makes messages; a subclass sends them.

    The subclass states the clock of `at`. Values that a gesture is not given are the object's preset's. Keys are those
    of the OSC address of the same name. Numbers may be NumPy's, fractions or decimals, lists may be arrays.
    """

    @abstractmethod
    def _send(self, messages: list[Message], at: SupportsFloat | None) -> None:
        """Send messages that happen together at a time (s), or as soon as possible (None)."""

    def send(self, address: str, *args: Value, at: SupportsFloat | None = None, **keys: Value) -> None:
        """Send any message, such as `send("/object/bar/gain", -6, at=1.0)`.

        Parameters
        ----------
        address : str
            OSC address, or a pattern.
        *args : float, int, str or list
            Arguments of the address.
        **keys
            Keys of the address, with their values.
        """
        self._send([message_of(address, args, keys)], at)

    def _send_keyed(
        self, address: str, value: Value, optional: Value, at: SupportsFloat | None, keys: Mapping[str, Value]
    ) -> None:
        """Send a message of a value and a position, unless they are None, and of keys."""
        if value is None and optional is not None:
            keys, optional = {"position": optional, **keys}, None
        self.send(address, *(each for each in (value, optional) if each is not None), *key_pairs(keys), at=at)

    def _gesture(
        self, gesture: str, name: str, value: Value, position: Value, at: SupportsFloat | None, keys: dict[str, Value]
    ) -> None:
        self._send_keyed(f"/object/{name}/{gesture}", value, position, at, keys)

    def note(
        self,
        name: str,
        note: Value,
        velocity: SupportsFloat,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[NoteKeys],
    ) -> None:
        """Strike a copy of an object that is tuned to a note. It is named NAME.NOTE.

        Parameters
        ----------
        note : float or str
            MIDI number, or a name such as C#4.
        velocity : float, 0 to 127
            MIDI velocity.
        position : float, 0 to 1, optional
            Position on the object's strike path.
        **keys
            `striker`, `play`.
        """
        place = () if position is None else (position,)
        self.send(f"/object/{name}/note", note, velocity, *place, *key_pairs(keys), at=at)

    def damp(self, name: str, amount: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Damp an object, as a hand on it does.

        Parameters
        ----------
        amount : float, 0 to 1
            0 none, 1 the firmest.
        """
        self.send(f"/object/{name}/damp", amount, at=at, **keys)

    def gain(self, name: str, level: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Set an object's level.

        Parameters
        ----------
        level : float, dB
            Level of the object.
        """
        self.send(f"/object/{name}/gain", level, at=at, **keys)

    def pan(self, name: str, place: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Place an object between left and right.

        Parameters
        ----------
        place : float, -1 to 1
            Left (-1) to right (1). On a ring of channels: behind (-1), left, in front (0), right, behind (1).
        """
        self.send(f"/object/{name}/pan", place, at=at, **keys)

    def gains(self, name: str, *gains: Value, at: SupportsFloat | None = None) -> None:
        """Set a factor for each channel, in place of the pan. Without factors, restore the pan.

        Parameters
        ----------
        *gains : float or array (channels,), -100 to 100
            Factors, one by one or as a list.
        """
        self.send(f"/object/{name}/gains", *gains, at=at)

    def distance(self, name: str, metres: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Set the distance from an object to the listener.

        Parameters
        ----------
        metres : float, 0.1 to 1000 m
            Twice as far is half the pressure.
        """
        self.send(f"/object/{name}/distance", metres, at=at, **keys)

    def tune(self, name: str, semitones: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Shift all frequencies of an object.

        Parameters
        ----------
        semitones : float, -60 to 60
            Shift from the preset's pitch.
        """
        self.send(f"/object/{name}/tune", semitones, at=at, **keys)

    def decay(self, name: str, ratio: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Multiply all decay times of an object.

        Parameters
        ----------
        ratio : float, 0.001 to 100
            Factor of the preset's decay times.
        """
        self.send(f"/object/{name}/decay", ratio, at=at, **keys)

    def free(self, name: str, at_once: bool = False, at: SupportsFloat | None = None) -> None:
        """Remove an object and the copies for its notes, once they are silent. Its name is free immediately.

        Parameters
        ----------
        at_once : bool, default False
            Whether it is removed immediately, with a short fade.
        """
        address = f"/object/{name}/free"
        self.send(address, *([1] if switch_of(f"{address}: at_once", at_once, CommandError) else []), at=at)

    def steer(
        self, id: str, at: SupportsFloat | None = None, over: Value = None, curve: Value = None,
        **values: Unpack[SteerKeys],
    ) -> None:  # fmt: skip
        """Change running gestures, all values together: `steer("ball", speed=0.8, gain=-6)`.

        Parameters
        ----------
        over : float, optional
            Duration of the change, s. Default: at once.
        curve : float, -20 to 20, optional
            Shape of the change: 0 even, below 0 fast at first, above 0 slow at first.
        **values : float or list
            Keys that can be steered, with their new values.

        Raises
        ------
        CommandError
            No value is given.
        """
        if not values:
            raise CommandError(f"/gesture/{id}: expected a value to steer, such as speed=0.5")
        ramp = {key: value for key, value in (("over", over), ("curve", curve)) if value is not None}
        self._send([message_of(f"/gesture/{id}/{name}", (value,), ramp) for name, value in values.items()], at)

    def macro(
        self, name: str, at: SupportsFloat | None = None, over: Value = None, curve: Value = None,
        **values: Unpack[MacroKeys],
    ) -> None:  # fmt: skip
        """Turn macros of an object, all of them together: `macro("bell", size=0.7, brightness=0.2)`.

        Parameters
        ----------
        over : float, optional
            Duration of the change, s.
        curve : float, -20 to 20, optional
            Shape of the change: 0 even, below 0 fast at first, above 0 slow at first.
        **values : float or list, 0 to 1
            Macros, with their new values; 0.5 changes nothing.

        Raises
        ------
        CommandError
            No macro is named.
        """
        if not values:
            raise CommandError(f"/object/{name}/macro: expected a macro, such as size=0.7")
        ramp = {key: value for key, value in (("over", over), ("curve", curve)) if value is not None}
        self._send([message_of(f"/object/{name}/macro/{macro}", (each,), ramp) for macro, each in values.items()], at)

    def dice(self, name: str, seed: int | None = None, at: SupportsFloat | None = None) -> None:
        """Set all macros of an object at random, in ranges that sound good.

        Parameters
        ----------
        seed : int, optional
            Equal seeds choose the same. Default: another each time.
        """
        self.send(f"/object/{name}/dice", *([] if seed is None else [seed]), at=at)

    def undo(self, name: str, at: SupportsFloat | None = None) -> None:
        """Take back the last throw of the dice of an object."""
        self.send(f"/object/{name}/undo", at=at)

    def morph(
        self, name: str, preset: str, share: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]
    ) -> None:
        """Move an object part of the way to another preset of the same shape.

        Parameters
        ----------
        preset : str
            Name of the preset.
        share : float, 0 to 1
            Share of the way.
        """
        self.send(f"/object/{name}/morph", preset, share, at=at, **keys)

    def stop(self, id: str, at: SupportsFloat | None = None) -> None:
        """End running gestures."""
        self.send(f"/gesture/{id}/stop", at=at)

    def place(self, name: str, *place: Value, at: SupportsFloat | None = None, **keys: Unpack[PlaceKeys]) -> None:
        """Place an object in space, or move it. Without a place, restore its pan.

        Parameters
        ----------
        *place : float or array (3,), m
            x, y, z, one by one or as a list.
        **keys
            `over`: duration of the way there, s.
        """
        self.send(f"/object/{name}/place", *_spread(place), at=at, **keys)

    def listener(self, *place: Value, at: SupportsFloat | None = None, **keys: Unpack[ListenerKeys]) -> None:
        """Place the listener, who looks along x, with y to the left and z up.

        Parameters
        ----------
        *place : float or array (3,), m
            x, y, z, one by one or as a list.
        **keys
            `yaw`, `pitch`, `roll` (degrees), `over` (s), `layout` ("pan", "binaural" or "ambisonics"), `head` (m),
            `temperature` (degrees Celsius), `humidity` (%), `air` (factor of its absorption).
        """
        self.send("/listener", *_spread(place), at=at, **keys)

    def floor(self, z: SupportsFloat | None = None, at: SupportsFloat | None = None, **keys: Unpack[FloorKeys]) -> None:
        """Lay a floor that reflects.

        Parameters
        ----------
        z : float, m, optional
            Height of the floor. None removes floor and room.
        **keys
            `absorption` (0 to 1).
        """
        self.send("/floor", *([] if z is None else [z]), at=at, **keys)

    def room(self, *size: Value, at: SupportsFloat | None = None, **keys: Unpack[RoomKeys]) -> None:
        """Put everything into a box that reflects and reverberates.

        Parameters
        ----------
        *size : float or array (3,), m
            Lengths along x, y and z, one by one or as a list.
        **keys
            `x`, `y`, `z` (m, lowest corner), `absorption` (0 to 1), `t60`, `t60_high` (s), `late` (0 or 1).
        """
        self.send("/room", *_spread(size), at=at, **keys)

    def sensor(
        self, sensor: str, object: str, position: SupportsFloat | None = None, at: SupportsFloat | None = None,
        **keys: Unpack[SensorKeys],
    ) -> None:  # fmt: skip
        """Mount a sensor on an object. It has a channel of its own, after those of the sound.

        Parameters
        ----------
        sensor : str
            Name of the sensor.
        object : str
            Name of the object.
        position : float, 0 to 1, optional
            Position on the object's strike path. Default: where its preset is struck.
        **keys
            `preset` ("ideal", "accelerometer", "mems", "piezo-20", "piezo-27", "piezo-35", "velocity"), `quantity`
            ("acceleration" in m/s^2, or "velocity" in m/s), `resonance` (Hz), `damping` (ratio), `full` (value of a
            sample of 1.0); on a mesh `point` and `direction`.
        """
        place = () if position is None else (position,)
        self.send("/sensor/new", sensor, object, *place, *key_pairs(keys), at=at)

    def unmount(self, sensor: str, at: SupportsFloat | None = None) -> None:
        """Remove a sensor; its channel is silent.

        Parameters
        ----------
        sensor : str
            Name of the sensor.
        """
        self.send(f"/sensor/{sensor}/free", at=at)

    def accuracy(self, level: str | int, at: SupportsFloat | None = None) -> None:
        """Set the accuracy of later contacts with objects that yield.

        Parameters
        ----------
        level : {"-50", "-60", "-80", "exact"}
            Error of the object's velocity, dB of its maximum, in nine contacts of ten. At first: -60.
        """
        self.send("/accuracy", level, at=at)

    def bank(self, form: str, at: SupportsFloat | None = None) -> None:
        """Set the number format of freely ringing modes.

        Parameters
        ----------
        form : {"float64", "float32"}
            float32 is faster and less exact. At first: float64.
        """
        self.send("/bank", form, at=at)

    def budget(self, steps: int, modes: int, at: SupportsFloat | None = None) -> None:
        """Bound the cost of contacts that are coupled to modes. 0 is no bound.

        Parameters
        ----------
        steps : int
            Steps per sample of each contact, on average. Beyond them its force is held.
        modes : int
            Modes coupled at once. A contact for which no room is left is not coupled.
        """
        self.send("/budget", steps, modes, at=at)

    def quality(self, level: int, at: SupportsFloat | None = None) -> None:
        """Set how much is left out from then on to save time.

        Parameters
        ----------
        level : int, 0 to 8
            0: nothing (at first), 8: the most.
        """
        self.send("/quality", level, at=at)

    def contact(self, *_given: object, **_keys: object) -> None:
        """Raise CommandError: the solver of contacts is no choice any more."""
        from ..server.osc.addresses import GONE

        raise CommandError(f"/contact: {GONE['/contact']}")

    def main_gain(self, level: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Set the level of everything.

        Parameters
        ----------
        level : float, dB
            Level of the sum of all objects.
        """
        self.send("/gain", level, at=at, **keys)

    def limiter(self, on: bool, at: SupportsFloat | None = None) -> None:
        """Turn the limiter on or off. It keeps the sound within full scale.

        Parameters
        ----------
        on : bool
            At first: True.
        """
        self.send("/limiter", "on" if switch_of("/limiter: on", on, CommandError) else "off", at=at)

    def headroom(self, on: bool, at: SupportsFloat | None = None) -> None:
        """Turn the slow automatic level on or off, which turns down what goes on being too loud.

        Parameters
        ----------
        on : bool
            At first: False in a score or a Scene, True on a server.
        """
        self.send("/headroom", "on" if switch_of("/headroom: on", on, CommandError) else "off", at=at)

    def play(self, on: bool, at: SupportsFloat | None = None) -> None:
        """Turn make-up on or off for later gestures: a gain that makes every striker audible on every object.

        Parameters
        ----------
        on : bool
            At first: False.
        """
        self.send("/play", "on" if switch_of("/play: on", on, CommandError) else "off", at=at)

    def panic(self, at: SupportsFloat | None = None) -> None:
        """End all gestures. The sound fades; objects stay."""
        self.send("/panic", at=at)


def message_of(address: str, args: tuple[Value, ...], keys: dict[str, Value]) -> Message:
    """Return a message of arguments, followed by keys and their values. CommandError for what is no address."""
    if not isinstance(address, str):
        raise CommandError(f"address = {address!r}: expected an OSC address, as /object/bell/impact")
    return Message(address, tuple(map(plain, (*args, *key_pairs(keys)))))


def _spread(numbers: tuple[Value, ...]) -> tuple[Value, ...]:
    """Return numbers that are given one by one, or as one list."""
    if len(numbers) == 1 and not isinstance(numbers[0], int | float):
        listed: tuple[Value, ...] = plain(numbers[0])
        return listed
    return numbers


def key_pairs(keys: Mapping[str, Value]) -> list[Value]:
    """Return keys and their values in turn, as messages hold them."""
    return [part for pair in keys.items() for part in pair]


def plain(value: Value) -> Any:
    """Return a value as Python's own types, lists as tuples; NumPy's scalars and arrays know how to become such, and
    fractions and decimals become floats."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return tuple(map(plain, value))
    return float(value) if isinstance(value, SupportsFloat) and not isinstance(value, int | float) else value
