"""A world: the microphone of a simulation, which is stepped with it."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import groupby
from numbers import Real
from operator import attrgetter, itemgetter
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._capture import Capture
from ._grains import Grained
from ._listening import Listening, ride
from .clients.actions import CommandError, plain
from .clients.client import Client
from .clients.commands.progress import shown_mesh
from .clients.performer import Folders, Performer, chosen
from .dsp.arguments import explain_all_arguments, switch_of
from .dsp.bodies.material import CONTACT_RADIUS
from .dsp.engine.memory.state import QUANTUM
from .dsp.numerics.quantities import Range
from .dsp.resonator.bank import top_of
from .dsp.runtime.batch import Batch
from .dsp.wording import near
from .scene import Scene
from .server.bridge.blows import Counts, Hit
from .server.bridge.bodies import ABOUT, Body
from .server.bridge.checks import WorldError, require_kind, require_number
from .server.bridge.gestures import template
from .server.bridge.hearing import Hearing, Listener, Microphone, microphones_of
from .server.bridge.requests import Lying, Request, Said, Slide, in_order
from .server.bridge.simulation import RANGES, Simulation
from .server.bridge.step import Contacts, Pose, Poses
from .server.bridge.telling import PER_BLOW, tell
from .server.closing import Closing
from .server.osc.score import format_line
from .server.osc.wire import Message
from .sound import Sound

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .clients.gesture_methods import BodyKeys, PairKeys, SensorKeys

Blocks = NDArray[np.float32]

_FADED = 16 * QUANTUM  # frames in which a panic fades
_BUDGET = 1_000_000, 0  # steps and modes: any number, but counted, so that no striker is kept: the simulator moves it
_LONGEST, _RATE = 3600, Range(1.0, 1e6, "Hz")  # s of sound at once; a render takes fewer rates
_AHEAD = 0.03  # s between a live step and its sound
_DRIFT = 0.1  # s by which a simulation may run ahead of the clock or behind, before its sound is set to the clock again


@explain_all_arguments
class World(Grained, Closing):
    """The sound of a simulation of rigid bodies, computed in step with it, or played on a server.

    Bodies become objects. Contacts become blows, slides, rolls and rests, by the contact law of both materials.
    Samples are pascals at the microphones. Equal steps make equal bits. The sound comes `latency` (s) after its time:
    64 frames.

    Parameters
    ----------
    rate : int, default 48000
        Sampling rate in Hz.
    microphones : list of Microphone or (x, y, z) in m
        A channel for each. Default: one at (0, 0, 1.5).
    hearing : Hearing, optional
        Microphones, and how much is computed.
    listener : Listener, optional
        In place of microphones: delay, doppler, air, direction and room.
    client : Client, optional
        Plays on that client's server. Steps then return empty blocks; take them in real time.
    keep : bool, default False
        Whether to keep the sound for `sound`, and the messages for `score`.
    stems, contacts : bool, default False
        As for a Scene; they need `keep`.
    presets : path, list of paths or Presets, optional
        As for a Scene.
    gravity : float, default 9.81
        In m/s^2.
    start : float, default 0
        Time of the simulation before the first step, in s.

    Raises
    ------
    WorldError
        An argument of a body or a step is refused, and changes nothing; the text names it.

    Examples
    --------
    >>> import carom
    >>> with carom.World(microphones=[(0, -1, 0.5)]) as world:
    ...     number = world.body("floor", "plate", (2, 2, 0.02), "wood", held=True)
    ...     number = world.body("ball", "sphere", 0.02, "glass")
    ...     touch = carom.Touch("floor", "ball", point=(0, 0, 0.01), normal=(0, 0, 1), approach=1.5)
    ...     block = world.step(0.01, [touch])
    ...     print(block.shape, len(world.hits))
    (480, 1) 1
    """

    def __init__(
        self,
        rate: int = 48_000,
        *,
        microphones: Sequence[Microphone | Sequence[float]] = (Microphone((0.0, 0.0, 1.5)),),
        hearing: Hearing | None = None,
        listener: Listener | None = None,
        client: Client | None = None,
        keep: bool = False,
        stems: bool = False,
        contacts: bool = False,
        presets: Folders = (),
        gravity: float = 9.81,
        start: float = 0.0,
    ) -> None:
        stems, contacts, keep = switch_of("stems", stems), switch_of("contacts", contacts), switch_of("keep", keep)
        if (stems or contacts) and not keep:
            raise WorldError(f"stems = {stems}, contacts = {contacts}: expected keep=True with them")
        require_number("rate", rate, _RATE)
        require_kind("hearing", hearing, Hearing)
        require_kind("listener", listener, Listener)
        require_kind("client", client, Client)
        if listener is not None:
            microphones = (Microphone(listener.position, on=listener.on),)
            hearing = replace(hearing, microphones=microphones) if hearing else None
        hearing = hearing or Hearing(microphones_of(microphones))
        library = chosen(presets)
        self.rate = int(rate)
        self.latency = 0.0 if client else QUANTUM / rate
        self.simulation = Simulation(
            library, top_of.py_func(rate), hearing, gravity=gravity, start=start, progress=shown_mesh
        )
        """The simulation as it is reported, and its sounds; bridges reach into it."""
        self._client = client
        self._scene = None
        if client is None:
            channels = listener.channels if listener else len(hearing.microphones)
            self._scene = Scene(
                rate, channels=channels, calibrated=True, stems=stems, contacts=contacts, presets=library
            )
            self._scene.accuracy(hearing.accuracy)
            self._scene.quality(hearing.quality)
            self._scene.budget(*_BUDGET)
        self._listening = Listening(listener, self.simulation) if listener else None
        self._rides = any(each.on for each in hearing.microphones)
        if listener is not None:
            self.simulation.hears_nearby()
        self._contacts = contacts
        self._straight = self._scene is not None and not keep
        if self._scene and self._straight:
            self.simulation.link(self._scene._open.engine.state, self.latency)
        self._capture = Capture(self._scene._open, 0) if self._scene and keep else None
        self._kept: list[tuple[float, Request]] | None = [] if keep else None
        self._origin = math.nan  # Unix time of the simulation's time 0, of a live server
        self._frames = self._surfaces = 0
        self._whole = np.empty((0, self.channels), np.float32)
        if self._listening:
            self._send([Said(start, message) for message in self._listening.first()])

    def close(self) -> None:
        """Free its memory, or its bodies' objects on the server.

        Sounds stay.
        """
        if self._scene:
            self._scene.close()
        elif self._client:
            for body in self.simulation.bodies:
                if body.rings:
                    self._client.free(body.name)

    def __repr__(self) -> str:
        """Return its rate, its time, and how many bodies it has."""
        return f"<carom.World {self.rate} Hz, at {self.time:g} s, bodies {len(self.bodies)}>"

    def __reduce_ex__(self, protocol: SupportsIndex) -> NoReturn:
        raise TypeError("a World is an engine at work: it cannot be copied or pickled; make one in each process")

    @property
    def time(self) -> float:
        """Time (s) of the last step."""
        return self.simulation.time

    @property
    def channels(self) -> int:
        """Number of channels of its sound."""
        return self._scene.channels if self._scene else self.simulation.channels

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of their numbers."""
        return tuple(body.name for body in self.simulation.bodies)

    @property
    def hits(self) -> list[Hit]:
        """The blows of the last step, including inaudible ones."""
        return self.simulation.hits

    @property
    def counts(self) -> Counts:
        """Counts of what happened since the beginning, and of what was left out."""
        return self.simulation.counts

    def body(
        self, name: str, shape: str, size: ArrayLike, material: str, pose: Pose | None = None,
        **about: Unpack[BodyKeys],
    ) -> int:  # fmt: skip
        """Add a body before it touches anything.

        Parameters
        ----------
        name : str
            Name of the body.
        shape : {"box", "plate", "sphere", "cylinder", "capsule", "mesh"}
            The axis of a cylinder and a capsule is z.
        size : float or array, m
            Box and plate: three edges. Sphere: radius. Cylinder: radius and length. Capsule: radius and length
            between the centres of its ends. Mesh: vertices (n, 3), or these and faces (m, 3); with faces it rings by
            its own modes.
        material : str
            Preset of the material.
        pose : Pose, optional
            Its pose until a step reports another.
        **about
            As below, and further keys of `/object/new`, such as `most_modes`, `damp` or `gain`.

        Other Parameters
        ----------------
        density, mass : float, optional
            In kg/m^3, or in kg. Default: a solid body of the material.
        inertia : (3,), optional
            Moments about its axes, kg m^2.
        held : bool, default False
            Whether it does not move.
        rings : bool, default True
            Whether it sounds.
        object : str, optional
            Preset that rings in its place.
        wall : float, optional
            Thickness of the wall of a hollow body, m.
        surface : bool, default False
            Whether a solid free box or cylinder rings as such, and is struck at points of its surface.

        Returns
        -------
        int
            Number of the body.

        Raises
        ------
        WorldError
            The name is taken, or a value cannot be.
        """
        given: dict[str, Any] = {key: plain(value) for key, value in about.items()}
        try:
            requests = self.simulation.add(name, shape, size, material, pose, **given)
        except WorldError as error:
            for key, value in given.items():
                known = "shape", "size", "wall", *ABOUT
                if key not in known and (found := near(key, known)) and f"{key} = " in str(error):
                    raise WorldError(f"body {name}: {key} = {value}: did you mean {found[0]}?") from None
            raise
        try:
            self._send(requests)
        except CommandError as error:
            self.simulation.take_back(name)
            raise WorldError(f"body {name}: {error}") from None
        number = self.simulation.number(name)
        if self._scene and self.simulation.bodies[number].rings:
            self.simulation.has_object(name, *self._scene._open.placed_at(name))
            self._know_surfaces(self._scene._open, self.simulation.bodies[number])
        return number

    def _know_surfaces(self, performer: Performer, body: Body) -> None:
        """Prepare slides on the surfaces of the bodies there are, as one on a body that rings."""
        for surface in self.simulation.surfaces[self._surfaces :]:
            least = performer.scene.least_radius(surface)
            command, least = performer.slide_template(template(body, surface, max(least, CONTACT_RADIUS)))
            self.simulation.has_template(surface, command, least)
            self._surfaces += 1

    def pair(self, a: str, b: str, **keys: Unpack[PairKeys]) -> None:
        """Set the contact of two bodies, in place of the one that follows from their materials.

        Parameters
        ----------
        a, b : str
            Names of the bodies.
        **keys
            `surface` (a preset), `support` (felt, foam, finger or palm), `restitution` (0 to 1), `roughness` (times),
            `patch` (m), `static`, `dynamic`, `stribeck` (m/s), `tangential` (N/m), `along` (0 to 1).

        Raises
        ------
        WorldError
            A body that is not there, or a value out of range.
        """
        given: dict[str, Any] = {key: plain(value) for key, value in keys.items()}
        self.simulation.pair(a, b, **given)

    def sensor(
        self,
        name: str,
        body: str,
        position: float | None = None,
        *,
        place: Sequence[float] | None = None,
        **keys: Unpack[SensorKeys],
    ) -> None:
        """Mount a contact microphone or an accelerometer on a body; `sensed` has its signal.

        It senses vibration along the normal, not the motion of the body as a whole.

        Parameters
        ----------
        name : str
            Name of the sensor.
        body : str
            Name of a body that rings.
        position : float, optional
            0 to 1 on the strike path; or
        place : (x, y, z), optional
            m, in the axes of the body; the nearest point is taken.
        **keys
            `preset`, `quantity`, `resonance` (Hz), `damping`, `full`; on a mesh `direction` (x, y, z).

        Raises
        ------
        WorldError
            A body that is not there or is silent, or a value that cannot be.
        """
        number = self.simulation.number(body)
        its = self.simulation.bodies[number]
        if not its.rings:
            raise WorldError(f"sensor {name}: body {body} is silent: expected one that rings")
        if (position is None) == (place is None):
            raise WorldError(f"sensor {name}: position = {position}, place = {place}: expected one of the two")
        where: tuple[Any, ...] = (position,)
        if place is not None:
            nearest = self.simulation.position_of(number, place, f"sensor {name}")
            where = ("point", *map(float, place)) if its.surfaced else (nearest,)
        given: dict[str, Any] = {**keys}
        vectors: list[Any] = [
            part for key, each in given.items() if np.ndim(each) == 1 for part in (key, *map(float, each))
        ]
        pairs = vectors + [part for pair in given.items() if np.ndim(pair[1]) == 0 for part in pair]
        try:
            self._send([Said(self.time, Message("/sensor/new", (name, body, *where, *pairs)))])
        except CommandError as error:
            raise WorldError(f"sensor {name}: {error}") from None

    @property
    def sensed(self) -> dict[str, NDArray[np.float32]]:
        """The signals of sensors over the last block, by name, float32 (frames,), in the unit of each.

        Empty for a World with a client: its server has them as channels.
        """
        if self._scene is None:
            return {}
        performer = self._scene._open
        first, width = performer.engine.channels, self._whole.shape[1]
        mounted = sorted(performer.scene.sensors.channels.items())
        whole = self._whole if width > first + len(mounted) - 1 else np.zeros((0, first + len(mounted)), np.float32)
        return {name: whole[:, first + n] for n, (name, _) in mounted}

    def step(self, time: float, contacts: Contacts = (), poses: Poses | None = None) -> Blocks:
        """Take the simulation's state at a time after the last step's, and return the sound up to it.

        Parameters
        ----------
        time : float
            In s.
        contacts : list of Touch, or arrays by name
            All points that touch now.
        poses : dict of Pose, optional
            Bodies that have moved, by name.

        Returns
        -------
        array
            float32 (frames, channels), in Pa; empty with a client.

        Raises
        ------
        WorldError
            An argument is refused, and the step changes nothing; the text names it.
        """
        before = self.simulation.time
        if self._scene and isinstance(time, float | Real) and before + _LONGEST < time < math.inf:
            where = f"step {self.simulation.steps + 1}"
            raise WorldError(f"{where}: time = {time}: expected at most {_LONGEST} s after {before}")
        self._ride()
        told = self.simulation.step(time, contacts, poses)
        self._move(before)
        self._send(told)
        return self._up_to(time)

    def _ride(self) -> None:
        """Place microphones that ride on bodies where these were in the last step."""
        if self._rides:
            ride(self.simulation, tuple(self.simulation.hearing.microphones), self.simulation.microphones)

    def _move(self, before: float) -> None:
        """Report how bodies and the listener have moved since the time of the step before."""
        if self._listening is None:
            return
        told = list(self._listening.moved(max(self.time - before, 0.0)))
        if self._scene is None or self._kept is not None:
            self._send([Said(before, message) for message, _, _ in told])
            return
        performer = self._scene._open
        sample = max(before - self.simulation.began + self.latency, self._scene.time) * self.rate
        commands = []
        for _, command, name in told:
            handle = performer.scene.objects[name].handle if name else None
            commands.append(command._replace(time=sample, handle=handle))
        performer.engine.send(commands)

    def reporter(self, arrays: int, time: int, points: int, behind: int = 0, kept: object = None) -> Callable[[], int]:
        """Return a function that reports a step, for bridges.

        Parameters
        ----------
        arrays : int
            Address of a record of `carom.server.bridge.mujoco.arrays.ARRAYS`: the addresses of poses and contacts.
        time : int
            Address of the time (s), a float64.
        points : int
            Address of the number of contacts, an int32.
        behind : int, default 0
            Address of the time (s) by which contacts lie before `time`, a float64; 0 if they do not.
        kept : object, optional
            Owner of this memory.

        Returns
        -------
        callable
            Takes no arguments and returns the number of blows of the step.
        """
        simulation, run = self.simulation, tell.brief
        telling = simulation.telling(arrays, time, points, behind)
        address, holds = telling.ctypes.data, (telling, kept)

        def told() -> int:
            moves = self._listening is not None
            before = self.time if moves else 0.0
            self._ride()
            found: int = run(address)
            if moves and found >= 0:
                self._move(before)
            if found == 0:
                return 0
            self._send(simulation.told(holds[0], found))
            return found // PER_BLOW

        return told

    def block(self, batch: Batch | None = None) -> Blocks:
        """Return the sound from the last block up to the last step.

        Parameters
        ----------
        batch : Batch of `carom.dsp.runtime.batch`, optional
            The block is filled by its `finish`, to be called before the next step. A World that keeps its sound fills
            it at once.

        Returns
        -------
        array
            float32 (frames, channels), in Pa.

        Raises
        ------
        WorldError
            `batch` is no Batch.
        """
        if batch is not None and not isinstance(batch, Batch):
            raise WorldError(f"batch = {batch!r}: expected a Batch")
        return self._up_to(self.time, batch)

    def whole_block(self, batch: Batch | None = None) -> Blocks:
        """Return the sound as `block` does, with the signals of sensors as further channels."""
        self.block(batch)
        return self._whole

    def restart(self, time: float) -> None:
        """Restart at a time of the simulation, in silence. Bodies stay; nothing touches. A kept score lacks it.

        Parameters
        ----------
        time : float
            In s.

        Raises
        ------
        WorldError
            The World has a client.
        """
        if self._scene is None:
            raise WorldError("restart: expected a World without a client")
        require_number("time", time, RANGES["time"])
        self._scene.panic()
        self._process(_FADED + -self._frames % QUANTUM)
        self.simulation.begin(time - self._frames / self.rate)
        self.simulation.restart(time)

    @property
    def memory(self) -> NDArray[np.void]:
        """The columns of bodies and contacts, a record of `carom.server.bridge.tracking.state.STATE`."""
        return self.simulation.state

    def ring(self, seconds: float) -> Blocks:
        """Render the sound of some more seconds without a step. Steps may follow.

        Parameters
        ----------
        seconds : float
            0 to 3600 s.

        Returns
        -------
        array
            float32 (frames, channels), in Pa.
        """
        require_number("seconds", seconds, Range(0.0, _LONGEST, "s"))
        until = self.time + seconds
        self.simulation.wait(until)
        return self._up_to(until)

    def sound(self) -> Sound:
        """Return the sound up to now.

        Returns
        -------
        Sound
            Its `samples` are float32 (frames, channels), in Pa.

        Raises
        ------
        WorldError
            The sound was not kept.
        """
        if self._capture is None:
            raise WorldError("sound: expected a World(keep=True) without a client")
        return self._capture.sound()

    def score(self, path: str | PathLike[str] | None = None) -> str:
        """Return the messages up to now as a score; `carom.render(..., calibrated=True)` gives the same bits.

        Parameters
        ----------
        path : path, optional
            File to which the score is also written.

        Returns
        -------
        str
            The score.

        Raises
        ------
        WorldError
            The messages were not kept.
        """
        if self._kept is None:
            raise WorldError("score: expected a World(keep=True)")
        ordered = sorted(self._kept, key=lambda each: each[0])
        text = "".join(f"{format_line(at, request.message)}\n" for at, request in ordered)
        begun = (
            f"channels {self.channels}",
            f"accuracy {self.simulation.hearing.accuracy}",
            f"quality {self.simulation.hearing.quality}",
            f"budget {_BUDGET[0]} {_BUDGET[1]}",
        )
        head = "".join(f"0.0 /{each}\n" for each in begun)
        if path is not None:
            Path(path).write_text(head + text, encoding="utf-8")
        return head + text

    def _send(self, requests: list[Request]) -> None:
        """Carry requests out at their times."""
        if not requests:
            return
        ordered = in_order(requests)
        if self._scene is None:
            self._play(ordered)
            return
        now = self._scene.time
        timed = [(max(request.time - self.simulation.began + self.latency, now), request) for request in ordered]
        self._keep(timed)
        if not self._contacts:
            performer = self._scene._open
            performer.do(timed)
            for request in ordered if self._straight else ():
                if isinstance(request, Slide | Lying):
                    self.simulation.has_gesture(request.id, performer.gesture(request.id))
            return
        for at, group in groupby(timed, key=itemgetter(0)):  # contacts are kept by their messages
            self._scene._send([request.message for _, request in group], at)

    def _play(self, requests: list[Request]) -> None:
        """Send requests to the server, for their times by the clock."""
        assert self._client
        for time, group in groupby(requests, key=attrgetter("time")):
            together = list(group)
            now = clock.time()
            if not abs(self._origin + time + _AHEAD - now) < _DRIFT + _AHEAD:  # at first, too
                self._origin = now - time
            self._keep([(max(time - self.simulation.began, 0.0), request) for request in together])
            self._client._send([request.message for request in together], self._origin + time + _AHEAD)

    def _keep(self, timed: list[tuple[float, Request]]) -> None:
        if self._kept is not None:
            self._kept += timed

    def _up_to(self, time: float, batch: Batch | None = None) -> Blocks:
        """Return the sound up to a time."""
        if self._scene is None:
            return np.empty((0, self.channels), np.float32)
        return self._process(round((time - self.simulation.began) * self.rate) - self._frames, batch)

    def _process(self, frames: int, batch: Batch | None = None) -> Blocks:
        """Return the next frames of the sound."""
        assert self._scene
        self._frames += frames
        engine = self._scene._open.engine
        if self._capture is None:
            self._whole = batch.add(engine, frames) if batch else engine.process(frames)
            return self._whole if engine.sensors == 0 else self._whole[:, : engine.channels]
        pieces = [np.empty((0, engine.width), np.float32)]
        while left := self._frames - self._capture.end:
            pieces.append(engine.process(min(left, self._capture.room())))
            self._capture.add(pieces[-1])
        self._whole = np.concatenate(pieces)
        return self._whole[:, : engine.channels]
