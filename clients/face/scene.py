"""A scene in this process: objects that are made, struck, bounced and rolled on, and computed as fast as it goes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import TYPE_CHECKING, NoReturn, SupportsFloat, SupportsIndex

from ._capture import Capture
from ._documented import documented
from .clients.actions import Actions, CommandError, plain
from .clients.gesture_methods import ObjectMethods, with_methods_of
from .clients.modes import ModeTable, Settings, mode_table
from .clients.performer import Folders, Performer, Placed
from .dsp.arguments import explain_all_arguments
from .server.closing import Closing
from .server.costs import CostWatch
from .server.files.whole import RenderError
from .server.osc.score import LONGEST_SCORE
from .server.osc.wire import Argument, Message
from .server.render import Options
from .sound import Sound

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from typing_extensions import Unpack

    from .clients.gesture_methods import NewKeys, SensorKeys


@explain_all_arguments
@documented
class Scene(Actions, Closing):
    """An engine in this process: objects and gestures as methods, and `render` for the sound.

    Each address of a score is a method. Sound is computed by `render` alone, so that calls may come in any order of
    time, but not before the time that is computed. Equal calls make equal sounds, bit for bit; a score of the same
    messages makes them, too. Scenes may work in parallel, each in one thread at a time.

    Parameters
    ----------
    rate : int, default 48000
        Sampling rate in Hz, 8000 to 192000.
    limiter : bool, optional
        Whether the sum of all objects stays within full scale. Default: True, unless `calibrated`.
    gain : float, default 0
        Level of everything, dB.
    channels : int, default 2
        1 to 64; 2 are left and right, any other number is a ring around the listener.
    full_scale : float, optional
        Pressure of a sample of 1.0, of an object of level 0, in Pa. Default: 4.
    calibrated : bool, default False
        Whether samples are pascals, without the levels of presets and without a limiter.
    stems : bool, default False
        Whether each object's part of the sound is kept.
    contacts : bool, default False
        Whether each contact's time, force and impulse are kept.
    presets : path, list of paths or Presets, optional
        Folders of your own presets, which come first.

    Raises
    ------
    CommandError
        A message was refused, and changed nothing. Of several values to `steer`, the others hold.
    RenderError
        An option or a length is out of range.

    Notes
    -----
    `at` is a time in s from the scene's beginning; None is as soon as possible. A name may be a pattern (`*`,
    `[a-c]`, `{a,b}`). Keys are those of the OSC address of the same name. Some 6,000 events can wait: render longer
    scenes in parts.

    Examples
    --------
    >>> import carom
    >>> with carom.Scene() as scene:
    ...     bar = scene.new("bar", "marimba-bar")
    ...     bar.impact(1.0, position=0.3, at=0.25)
    ...     sound = scene.render(seconds=1.5)
    >>> sound.samples.shape
    (72000, 2)
    """

    def __init__(
        self,
        rate: int = 48_000,
        *,
        limiter: bool | None = None,
        gain: float = 0.0,
        channels: int = 2,
        full_scale: float | None = None,
        calibrated: bool = False,
        stems: bool = False,
        contacts: bool = False,
        presets: Folders = (),
    ) -> None:
        options = Options(
            rate, limiter=limiter, gain=plain(gain), channels=plain(channels), full_scale=plain(full_scale),
            calibrated=calibrated,
        )  # fmt: skip
        self._performer: Performer | None = Performer(options, (), presets, stems, contacts)
        self._performer.perform(options.head, None)
        self.rate = int(rate)
        """Hz."""
        self.channels = self._performer.engine.channels
        """Number of channels of its sounds."""
        self._frames = 0
        self._busy = Lock()

    def __repr__(self) -> str:
        """Return its rate, its channels, how far it is computed, and how many objects it has."""
        if self._performer is None:
            return "<carom.Scene closed>"
        objects = len(self._performer.scene.objects)
        return f"<carom.Scene {self.rate} Hz, channels {self.channels}, at {self.time:g} s, objects {objects}>"

    @contextmanager
    def _alone(self, what: str) -> Iterator[Performer]:
        """Hold the scene for one thread. CommandError where another one is at work in it."""
        if not self._busy.acquire(blocking=False):
            raise CommandError(f"{what}: another thread is at work in this scene; expected one at a time, or one each")
        try:
            yield self._open
        finally:
            self._busy.release()

    def close(self) -> None:
        """Free its memory. Sounds stay; the scene and its objects are of no more use."""
        self._performer = None

    @property
    def _open(self) -> Performer:
        if self._performer is None:
            raise CommandError("the scene is closed")
        return self._performer

    @property
    def time(self) -> float:
        """The earliest time (s) at which anything can still happen.

        The engine computes 64 frames at a time, and the limiter, on or off, looks 64 frames ahead. So after a `render`
        the time lies up to 127 frames behind the end of the sound that was given; up to 63 in a calibrated scene.
        """
        return self._open.time

    def render(self, seconds: SupportsFloat | None = None, *, frames: SupportsIndex | None = None) -> Sound:
        """Render the sound of the next seconds, or frames, from the end of the last one on.

        Parameters
        ----------
        seconds : float, optional
            Length in s; or
        frames : int, optional
            length in frames.

        Returns
        -------
        Sound
            Its `samples` are float32 (frames, channels).

        Raises
        ------
        RenderError
            Neither or both are given, or the length is less than a frame.
        """
        if (seconds is None) == (frames is None):
            raise RenderError(f"seconds = {seconds}, frames = {frames}: expected one of the two")
        most = LONGEST_SCORE * self.rate
        if frames is None and not 0.5 < _number(seconds) * self.rate <= most:
            raise RenderError(f"seconds = {_said(seconds)}: expected at least a frame, and at most {LONGEST_SCORE}")
        if frames is not None and not (1 <= _number(frames) <= most and _number(frames).is_integer()):
            raise RenderError(f"frames = {_said(frames)}: expected a whole number from 1 to {most}")
        with self._alone("render") as performer:
            capture = Capture(performer, self._frames)
            if performer.engine.position == 0:
                performer.engine.process(performer.engine.delay)  # the silence that the limiter begins with
            self._frames += round(_number(seconds) * self.rate) if frames is None else int(_number(frames))
            costs = CostWatch(performer.engine, performer.scene.objects.slots)
            while left := self._frames - capture.end:
                capture.add(costs.process(min(left, capture.room())))
            capture.warnings += filter(None, [costs.warning()])
            return capture.sound()

    def fork(self) -> Scene:
        """Return a scene that goes on from here: what sounds, what waits, objects, settings, ids and random numbers.

        From then on neither changes the other. Each renders what a scene that got all of its calls would. Name its
        objects: an `Object` stays the first scene's. With ten objects that sound a fork takes 2 to 5 ms and 5 MB; with
        Linux before 6.7 some ms more, and half a second on systems that do not report which memory was written.

        Returns
        -------
        Scene
            Open, and to be closed by itself. It shares the presets.

        Raises
        ------
        CommandError
            The scene is closed, another thread is at work in it, or it holds a simulation (`/world/body`).

        Examples
        --------
        >>> import carom
        >>> with carom.Scene() as scene:
        ...     scene.new("bell", "church-bell").impact(1.0)
        ...     before = scene.render(seconds=0.5)
        ...     with scene.fork() as other:
        ...         other.damp("bell", 1.0)
        ...         held = other.render(seconds=1.0)
        ...     free = scene.render(seconds=1.0)
        >>> bool(held.samples[-1].any()), bool(free.samples[-1].any())
        (False, True)
        """
        with self._alone("fork") as performer:
            fork = Scene.__new__(Scene)
            fork._performer = performer.fork()
            fork.rate, fork.channels, fork._frames, fork._busy = self.rate, self.channels, self._frames, Lock()
        return fork

    def __reduce_ex__(self, protocol: SupportsIndex) -> NoReturn:
        raise TypeError("a Scene is an engine at work: it cannot be pickled; fork() returns one that goes on from here")

    def _send(self, messages: list[Message], at: SupportsFloat | None) -> None:
        named = [each._replace(args=tuple(map(self._name_of, each.args))) for each in messages]
        with self._alone(messages[0].address) as performer:
            performer.perform(named, at)

    def _name_of(self, value: Argument) -> Argument:
        """Return the name of an Object, and anything else as it is."""
        if not isinstance(value, Object):
            return value
        if value.scene is not self:
            raise CommandError(f"{value!r}: expected an object of this scene")
        return value.name

    def new(self, name: str, preset: str, at: SupportsFloat | None = None, **keys: Unpack[NewKeys]) -> Object:
        """Make an object from a preset.

        Parameters
        ----------
        name : str
            Name of the new object.
        preset : str
            Name of its preset.
        at : float, optional
            Time in s.
        **keys
            The preset's keys (`length`, `material`, `size`, ...), or the object's first `gain` (dB), `pan`, `gains`,
            `distance` (m), `tune` (semitones), `decay` and `damp`.

        Returns
        -------
        Object
            Its methods are the scene's, without the name.

        Raises
        ------
        CommandError
            The name is taken, or a key does not fit.
        """
        self.send("/object/new", name, preset, at=at, **keys)
        own = keys.get("gains", ())
        return Object(self, name, self._open.placed(name), self._open.heard_first(name, own))

    def ended(self) -> list[str]:
        """Return the ids of gestures that have ended since the last call, up to the scene's time, the oldest first."""
        return self._open.ended()


@explain_all_arguments
@with_methods_of(Actions)
class Object(ObjectMethods):
    """An object of a scene; its methods are the scene's, without the name.

    It may be given wherever a name is expected.

    Attributes
    ----------
    name : str
        Its name.
    mass : float
        Mass of the whole body, kg.
    """

    def __init__(
        self, scene: Scene, name: str, placed: Placed, heard: tuple[Settings, NDArray[np.float64]]
    ) -> None:  # fmt: skip
        self.scene = scene
        self.name = name
        self.mass = placed.modes.mass
        self._placed = placed
        self._heard_first = heard

    def __repr__(self) -> str:
        return f"<carom.Object {self.name}>"

    def __str__(self) -> str:
        return self.name

    def modes(self, position: SupportsFloat | None = None) -> ModeTable:
        """Return the modes that a strike excites, as the object is tuned, damped and placed now.

        Parameters
        ----------
        position : float, optional
            0 to 1 on the strike path. Default: the preset's.

        Returns
        -------
        ModeTable
            Frequencies (Hz), decays (1/s) and gains (Pa per N s).

        Raises
        ------
        RenderError
            A position beyond 0 to 1.
        """
        place = self._placed.position if position is None else _number(position)
        if not 0.0 <= place <= 1.0:
            raise RenderError(f"position = {_said(position)}: expected 0 to 1")
        performer = self.scene._performer
        settings, gains = (performer and performer.heard(self._placed)) or self._heard_first
        return mode_table(self._placed.modes, self._placed.level, settings, gains, place, self.scene.rate)

    def sensor(
        self, name: str, position: SupportsFloat | None = None, at: SupportsFloat | None = None,
        **keys: Unpack[SensorKeys],
    ) -> None:  # fmt: skip
        """Mount a sensor on it, as the scene's `sensor` does."""
        self.scene.sensor(name, self.name, position, at, **keys)


def _number(value: object) -> float:
    """Return a number as a float, NaN for anything else."""
    value = plain(value)
    if isinstance(value, bool | str) or not isinstance(value, SupportsFloat | SupportsIndex):
        return math.nan
    return float(value)


def _said(value: object) -> str:
    """Return a value as an error names it: a text in quotes, which a number is not."""
    return repr(value) if isinstance(value, str) else str(value)
