"""The addresses of a score as methods, which a client and a scene share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, SupportsFloat

from ..dsp.arguments import explain_all_arguments, switch_of
from ..dsp.errors import CaromError
from ..server.osc.wire import Message
from .gesture_methods import Gestures, Value, with_gestures

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
@with_gestures
class Actions(Gestures, ABC):
    """Every address of a score as a method, but `/object/new`. A method makes messages; a subclass sends them.

    name, id: of objects and gestures, or an OSC pattern. at: the time (s) at which the sound is heard, on the clock
    that the subclass states; None is as soon as possible. Values that a gesture is not given are the object's preset's.
    keys: those of the OSC address of the same name; where a number changes, `over` says how many seconds that takes.
    Numbers may be NumPy's, fractions or decimals, lists may be arrays.
    """

    @abstractmethod
    def _send(self, messages: list[Message], at: SupportsFloat | None) -> None:
        """Send messages that happen together at a time (s), or as soon as possible (None)."""

    def send(self, address: str, *args: Value, at: SupportsFloat | None = None, **keys: Value) -> None:
        """Send any message, say `send("/object/bar/gain", -6, at=1.0)`."""
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
        """Strike a copy of an object that is tuned to a note: a MIDI number, or a name such as C#4.

        velocity: of MIDI, 0 to 127. The copy is named NAME.NOTE, and made when the note is first played.
        """
        place = () if position is None else (position,)
        self.send(f"/object/{name}/note", note, velocity, *place, *key_pairs(keys), at=at)

    def damp(self, name: str, amount: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Lay a hand on an object: 0 none, 1 the firmest."""
        self.send(f"/object/{name}/damp", amount, at=at, **keys)

    def gain(self, name: str, level: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Set an object's level (dB)."""
        self.send(f"/object/{name}/gain", level, at=at, **keys)

    def pan(self, name: str, place: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Place an object between left (-1) and right (1).

        On a ring of channels it goes from behind (-1) over left, in front (0) and right to behind (1).
        """
        self.send(f"/object/{name}/pan", place, at=at, **keys)

    def gains(self, name: str, *gains: Value, at: SupportsFloat | None = None) -> None:
        """Place an object by a factor for each channel, one by one or as a list.

        Without any, it is placed by its pan again.
        """
        self.send(f"/object/{name}/gains", *gains, at=at)

    def distance(self, name: str, metres: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Set how far (m) the listener is from an object: twice as far is half the pressure."""
        self.send(f"/object/{name}/distance", metres, at=at, **keys)

    def tune(self, name: str, semitones: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Move all frequencies of an object by some semitones from the preset's."""
        self.send(f"/object/{name}/tune", semitones, at=at, **keys)

    def decay(self, name: str, ratio: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Multiply all decay times of the preset by a ratio."""
        self.send(f"/object/{name}/decay", ratio, at=at, **keys)

    def free(self, name: str, at_once: bool = False, at: SupportsFloat | None = None) -> None:
        """Remove an object and the copies for its notes, once silent or at once, with a fade; its name is free."""
        address = f"/object/{name}/free"
        self.send(address, *([1] if switch_of(f"{address}: at_once", at_once, CommandError) else []), at=at)

    def steer(
        self, id: str, at: SupportsFloat | None = None, over: Value = None, curve: Value = None,
        **values: Unpack[SteerKeys],
    ) -> None:  # fmt: skip
        """Change the running gestures of an id or pattern, all values together: `steer("ball", speed=0.8, gain=-6)`.

        The change takes `over` s, by a `curve`, if these are given. CommandError if no value is.
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

        Each goes from 0 to 1; at 0.5 it changes nothing. The change takes `over` s, by a `curve`, if these are given.
        CommandError if no macro is named.
        """
        if not values:
            raise CommandError(f"/object/{name}/macro: expected a macro, such as size=0.7")
        ramp = {key: value for key, value in (("over", over), ("curve", curve)) if value is not None}
        self._send([message_of(f"/object/{name}/macro/{macro}", (each,), ramp) for macro, each in values.items()], at)

    def dice(self, name: str, seed: int | None = None, at: SupportsFloat | None = None) -> None:
        """Turn all macros of an object at random, within what sounds good; equal seeds choose the same."""
        self.send(f"/object/{name}/dice", *([] if seed is None else [seed]), at=at)

    def undo(self, name: str, at: SupportsFloat | None = None) -> None:
        """Take back the last throw of the dice of an object."""
        self.send(f"/object/{name}/undo", at=at)

    def morph(
        self, name: str, preset: str, share: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]
    ) -> None:
        """Bring an object a share (0 to 1) of the way to another preset of its shape."""
        self.send(f"/object/{name}/morph", preset, share, at=at, **keys)

    def stop(self, id: str, at: SupportsFloat | None = None) -> None:
        """End the running gestures of an id or pattern."""
        self.send(f"/gesture/{id}/stop", at=at)

    def place(self, name: str, *place: Value, at: SupportsFloat | None = None, **keys: Unpack[PlaceKeys]) -> None:
        """Put an object into space at x, y, z (m), one by one or as a list, or have it go there.

        It is then heard from where `listener` is: by its time, its distance and its direction. keys: over (s), the time
        that it takes. Without a place it is placed by its pan again.
        """
        self.send(f"/object/{name}/place", *_spread(place), at=at, **keys)

    def listener(self, *place: Value, at: SupportsFloat | None = None, **keys: Unpack[ListenerKeys]) -> None:
        """Place the listener at x, y, z (m), who looks along x, with y to the left and z up.

        keys: yaw, pitch, roll (degrees), over (s), layout ("pan", "binaural" or "ambisonics"), head (m), temperature
        (degrees Celsius), humidity (%), air (times its absorption).
        """
        self.send("/listener", *_spread(place), at=at, **keys)

    def floor(self, z: SupportsFloat | None = None, at: SupportsFloat | None = None, **keys: Unpack[FloorKeys]) -> None:
        """Lay a floor that reflects.

        z: its height (m); None: nothing reflects. keys: absorption (0 to 1).
        """
        self.send("/floor", *([] if z is None else [z]), at=at, **keys)

    def room(self, *size: Value, at: SupportsFloat | None = None, **keys: Unpack[RoomKeys]) -> None:
        """Put all into a box of lengths along x, y and z (m): first reflections, and a late part.

        keys: x, y, z (m, of its lowest corner), absorption (0 to 1), t60, t60_high (s), late (0: reflections alone).
        """
        self.send("/room", *_spread(size), at=at, **keys)

    def sensor(
        self, sensor: str, object: str, position: SupportsFloat | None = None, at: SupportsFloat | None = None,
        **keys: Unpack[SensorKeys],
    ) -> None:  # fmt: skip
        """Mount a sensor on an object: a channel of its own after those of the sound, which no gain changes.

        sensor: its name. position: 0 to 1 along the object's strike path (None: where its preset is struck). keys:
        preset (ideal, accelerometer, mems, piezo-20, piezo-27, piezo-35, velocity), quantity (acceleration, in m/s^2,
        or velocity, in m/s), resonance (Hz), damping (its ratio), full (the value of a sample of 1.0).
        """
        place = () if position is None else (position,)
        self.send("/sensor/new", sensor, object, *place, *key_pairs(keys), at=at)

    def unmount(self, sensor: str, at: SupportsFloat | None = None) -> None:
        """Take a sensor away."""
        self.send(f"/sensor/{sensor}/free", at=at)

    def accuracy(self, level: str | int, at: SupportsFloat | None = None) -> None:
        """Set the accuracy of later contacts with objects that yield: -50, -60 (dB, the default), -80 or "exact".

        It is the error of the object's velocity, as a share of its greatest, in nine contacts of ten.
        """
        self.send("/accuracy", level, at=at)

    def bank(self, form: str, at: SupportsFloat | None = None) -> None:
        """Choose the numbers in which freely ringing modes are kept: "float64" (the default) or "float32".

        float32 halves the cost; after ten seconds it errs by -95 dB in place of -115.
        """
        self.send("/bank", form, at=at)

    def budget(self, steps: int, modes: int, at: SupportsFloat | None = None) -> None:
        """Bound the cost of coupled contacts: steps per sample of each, on average, and modes coupled at once.

        0 is no bound. A force is held where steps lack, and a contact is not coupled where there is no room.
        """
        self.send("/budget", steps, modes, at=at)

    def quality(self, level: int, at: SupportsFloat | None = None) -> None:
        """Set how much is left out from then on to save time, from 0 (nothing, the default) to 8."""
        self.send("/quality", level, at=at)

    def contact(self, *_given: object, **_keys: object) -> None:
        """Raise CommandError: the solver of contacts is no choice any more."""
        from ..server.osc.addresses import GONE

        raise CommandError(f"/contact: {GONE['/contact']}")

    def main_gain(self, level: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Set the level of everything (dB)."""
        self.send("/gain", level, at=at, **keys)

    def limiter(self, on: bool, at: SupportsFloat | None = None) -> None:
        """Keep the sound within full scale (the default), or leave it as it is."""
        self.send("/limiter", "on" if switch_of("/limiter: on", on, CommandError) else "off", at=at)

    def headroom(self, on: bool, at: SupportsFloat | None = None) -> None:
        """Turn what goes on being too loud down slowly, ahead of the limiter, or leave it (the default)."""
        self.send("/headroom", "on" if switch_of("/headroom: on", on, CommandError) else "off", at=at)

    def play(self, on: bool, at: SupportsFloat | None = None) -> None:
        """Give later gestures make-up, so that any striker is heard on any object, or leave them to physics (the
        default)."""
        self.send("/play", "on" if switch_of("/play: on", on, CommandError) else "off", at=at)

    def panic(self, at: SupportsFloat | None = None) -> None:
        """End everything: all sound fades within 11 ms; objects stay."""
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
