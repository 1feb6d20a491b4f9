"""A scene in this process: an engine and a session, and what both report. The public face and data sets use it."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from os import PathLike
from pickle import PicklingError
from threading import Lock
from typing import SupportsFloat
from weakref import proxy

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..dsp.arguments import switch_of
from ..dsp.bodies.modes import Modes
from ..dsp.engine.memory.capacity import MODES, OBJECTS, STEMS
from ..dsp.engine.memory.commands import COMMAND, Handle, write
from ..dsp.engine.memory.state import TRACE
from ..dsp.runtime.arena import EngineFull
from ..dsp.runtime.engine import NOW, Engine
from ..dsp.runtime.fresh import Mark
from ..dsp.schema import GESTURES, SETTINGS
from ..presets import Presets
from ..server.bridge.requests import Request, Slide
from ..server.osc.score import LONGEST_SCORE, Line, sample_at
from ..server.osc.sensor_verbs import SENSOR
from ..server.osc.wire import Argument, Message
from ..server.render import Options
from ..server.scene.direct import Direct
from ..server.scene.forking import forked
from ..server.scene.repeated import Repeated
from ..server.scene.session import Session
from ..server.scene.transaction import Sent
from .actions import CommandError
from .contacts import Striking
from .modes import Settings, gains_of

Folders = Presets | str | PathLike[str] | Iterable[str | PathLike[str]]
"""Presets, or folders of your own presets, which are looked through first."""

_NOTHING = np.empty(0, TRACE)
_compiling = Lock()  # so that threads which make the first scenes at once compile the engine once


@dataclass(frozen=True)
class Placed:
    """An object in the engine: where it is, its modes as they were laid out, its level (amplitude), and the position at
    which it is struck if no position is given."""

    handle: Handle
    modes: Modes
    level: float
    position: float = 0.0


class _Engine(Engine):
    """An engine that remembers the modes of its objects, by serial, for as long as they have a place."""

    def __init__(self, rate: float, channels: int, objects: int, limited: bool, sensors: int) -> None:
        super().__init__(rate, channels, MODES, objects, limited, sensors)
        self.placed: dict[int, Placed] = {}

    def lay_out(self, modes: Modes, level: float) -> tuple[Handle, dict[str, float]]:
        handle, layout = super().lay_out(modes, level)
        self.placed[handle.serial] = Placed(handle, modes, level)
        return handle, layout

    def release(self, handle: Handle) -> None:
        super().release(handle)
        del self.placed[handle.serial]


class Performer:
    """An engine and a scene of its own, and what both report. Errors are CommandErrors.

    score: which may set its channels and its full scale. stems, contacts: whether they are kept. steers_ended: as for a
    Session. amplified: factor on calibrated samples; what ends below the silence of the engine rings on with it.
    """

    def __init__(
        self,
        options: Options,
        score: Sequence[Line],
        presets: Folders,
        stems: bool,
        contacts: bool,
        steers_ended: bool = False,
        amplified: float = 1.0,
    ) -> None:
        self.stems, self.contacts = switch_of("stems", stems), switch_of("contacts", contacts)
        self.presets = chosen(presets)
        scale, room = options.scale_of(score)._replace(amplified=amplified), STEMS if self.stems else OBJECTS
        with _compiling:
            channels, sensors = options.channels_and_sensors(score)
            self.engine = _Engine(options.rate, channels, room, not options.calibrated, sensors)
        self.scene = Session(self.engine, self.presets, steers_ended, scale)
        # A circle would keep the engine's memory until the next search for garbage.
        self.scene.on_sent = partial(Performer._remember, proxy(self))
        self.scene.sensors.grows = not score
        self._first_gain = 10.0 ** ((options.gain or 0.0) / 20.0)
        self.warnings: list[str] = []  # for the next report
        self.off_path: set[str] = set()
        """Names of objects touched in a way that no contact shows: at a point, in a direction, or by a swarm."""
        self._names: dict[int, str] = {}  # of objects, by serial
        self._striking: dict[int, Striking] = {}  # by command
        self._trace = _NOTHING  # what was traced beyond the end of the last sound
        self.engine.stems.keep(self.stems)
        self.engine.trace(self.contacts)

    def fork(self) -> "Performer":
        """Return a copy that goes on from here by itself. CommandError where that cannot be."""
        if self.scene.simulation is not None:
            raise CommandError("fork: the scene holds a simulation (/world/body), which cannot be copied")
        try:
            return forked(self, self.engine)
        except (AttributeError, PicklingError, TypeError) as error:
            raise CommandError(f"fork: the scene holds what cannot be copied: {error}") from None

    def perform(self, messages: Sequence[Message], at: SupportsFloat | None) -> None:
        """Carry out messages together at a time (s; None: now). CommandError says what was refused, and why."""
        time = NOW if at is None else self._sample(at, messages[0].address)
        self._answered(self.scene.perform(messages, time))

    def repeat(self, blows: Repeated, message: Message, at: SupportsFloat) -> bool:
        """Carry out a message at a time (s), if it is a blow on this scene that is remembered; return whether it
        does."""
        return blows.send(message, self._sample(at, message.address))

    def mark(self) -> Mark | None:
        """Return what `rewind` brings it back to, before anything is computed. None where it can't be: something rests,
        or there were warnings, or this system does not report what is written."""
        try:
            return self.engine.mark() if self.is_untouched else None
        except OSError:
            return None

    @property
    def is_untouched(self) -> bool:
        """True if nothing rests, no gesture goes on, and there were no warnings."""
        stand = any(each.stands for each in self.scene.objects.values())
        return not (self.warnings or self.scene.running() or stand)

    def rewind(self, mark: Mark) -> None:
        """Bring it back to a mark, after gestures that make no objects. OSError: it is of no use any more."""
        self.engine.rewind(mark)
        self.scene.rewind()
        self.warnings, self.off_path, self._striking, self._trace = [], set(), {}, _NOTHING

    def _answered(self, replies: Sequence[Message]) -> None:
        """Keep warnings. CommandError says what was refused, and why."""
        self.warnings += [str(reply.args[0]) for reply in replies if reply.address == "/warning"]
        refused = [": ".join(map(str, reply.args)) for reply in replies if reply.address == "/fail"]
        if refused:
            raise CommandError("; ".join(refused))

    @cached_property
    def _direct(self) -> Direct:
        return Direct(self.scene, self._perform_at)

    def do(self, requests: Sequence[tuple[float, Request]]) -> None:
        """Do what a simulation asks, each at its time (s). CommandError where there is no room for it."""
        try:
            self._direct.send([(sample_at(at, self.engine.rate), request) for at, request in requests])
        except EngineFull as error:
            raise CommandError(str(error)) from None

    def placed_at(self, name: str) -> tuple[int, int]:
        """Return the slot and the serial of an object in the engine."""
        handle = self.scene.objects[name].handle
        return handle.slot, handle.serial

    def slide_template(self, slide: Slide) -> tuple[NDArray[np.void], float]:
        """Return the command of a slide, (1,) of COMMAND, and the least radius (m) on its surface."""
        made = np.zeros(1, COMMAND)
        write(made[0], 0, self.scene.command_of(slide.message))
        return made, self.scene.least_radius(str(dict(slide.keys)["surface"]))

    def gesture(self, id: str) -> int:
        """Return the number of a gesture in the engine, by its id; 0 if there is none."""
        return self.scene.gestures.number_of(id)

    def _perform_at(self, message: Message, sample: float) -> None:
        self._answered(self.scene.perform([message], sample))

    def _sample(self, at: SupportsFloat, address: str) -> float:
        try:
            seconds = float(at)
        except (TypeError, ValueError, OverflowError):
            seconds = math.nan
        if 0.0 <= seconds <= LONGEST_SCORE:
            sample = sample_at(seconds, self.engine.rate)
            if sample >= self.engine.position:
                return sample
        raise CommandError(
            f"{address}: at = {at!r}: expected seconds from {self.time!r}, up to where the sound is computed, "
            f"to {LONGEST_SCORE}"
        )

    @property
    def time(self) -> float:
        """s up to which the sound is computed."""
        return self.engine.position / self.engine.rate

    def _remember(self, first: int, sent: list[Sent]) -> None:
        for number, each in enumerate(sent, first):
            gesture = each.message.address.rsplit("/", 1)[1]
            begun = GESTURES.get(gesture)
            if each.message.address == "/object/new":
                name = str(each.message.args[0])
                if self._names.setdefault(each.serial, name) == name and self.contacts:
                    self._striking[number] = Striking(name, "", "", "rest", each.mass, 0.0)  # of one that stands
            elif self.contacts and each.serial and each.message.address != SENSOR:
                striker = self._names.get(each.by, "") if each.by else ""
                keys = _keys(each.message.args[1:] if begun and begun.what else each.message.args)
                its = self.scene.objects.get(striker) if striker else None
                self._striking[number] = Striking(
                    self._names[each.serial], striker, str(keys.get("id", "")), gesture, each.mass,
                    float(keys.get("by_position", its.preset.position if its else 0.0)),  # type: ignore[arg-type]
                )  # fmt: skip
            if each.off_path or (begun and begun.swarms):
                self.off_path |= {self._names[serial] for serial in (each.serial, each.by) if serial in self._names}

    def ended(self) -> list[str]:
        """Return the ids of gestures that have ended since the last call."""
        return [ended.id for ended in self.scene.take_ends()]

    def placed(self, name: str) -> Placed:
        """Return the object of that name."""
        obj = self.scene.objects[name]
        there = self.engine.placed[obj.handle.serial]
        return Placed(there.handle, there.modes, there.level, obj.preset.position)

    def heard_first(self, name: str, own: ArrayLike) -> tuple[Settings, NDArray[np.float64]]:
        """Return what `heard` returns as soon as a new object is there. own: its gains, if any."""
        given = self.scene.objects[name].settings
        settings = Settings(**{key: each.in_engine(given[key]) for key, each in SETTINGS.items()})
        main = self.engine.gain if self.engine.position else self._first_gain
        factors = np.ravel(np.asarray(own, np.float64))
        if not len(factors):
            return settings, gains_of(settings, self.engine.channels, main)
        padded = np.pad(factors, (0, self.engine.channels - len(factors)))
        return settings, settings.gain / settings.distance * main * padded

    def heard(self, placed: Placed) -> tuple[Settings, NDArray[np.float64]] | None:
        """Return the settings of an object, and its gain in each channel; None before it is there."""
        record = self.engine.state[0]["objects"][placed.handle.slot]
        if record["serial"] != placed.handle.serial:
            return None
        settings = Settings(**dict(zip(SETTINGS, record["settings"].item(), strict=False)))  # of these, in their order
        gains = gains_of(settings, self.engine.channels, self.engine.gain)
        if record["place"]["has_own"]:
            own = record["place"]["own"][: self.engine.channels]
            gains = settings.gain / settings.distance * self.engine.gain * own
        return settings, gains

    def slots(self) -> dict[int, str]:
        """Return the names of the objects by their places in the engine."""
        placed = self.engine.placed.items()
        return {each.handle.slot: self._names[serial] for serial, each in placed if serial in self._names}

    def stem_pieces(self, first: int, frames: int) -> dict[str, NDArray[np.float64]]:
        """Return each object's part, (frames, channels), of the last quantum, from its frame `first` on."""
        stems = self.engine.stems.shares()
        pieces: dict[str, NDArray[np.float64]] = {}
        for slot, name in self.slots().items():
            piece = stems[slot, :, first : first + frames].T
            pieces[name] = pieces[name] + piece if name in pieces else piece.copy()
        return pieces

    def traced(self, end: int) -> NDArray[np.void]:
        """Return the trace, of TRACE, since the last call, of frames before `end`; later ones come with the next
        call."""
        trace = self.engine.traced()
        if len(trace) + len(self._trace) == 0:
            return trace
        if len(self._trace):
            trace = np.concatenate([self._trace, trace])
        beyond = trace["sample"] >= end - 1  # a force reaches the frame with which its sample ends
        if not np.count_nonzero(beyond):
            self._trace = _NOTHING
            return trace
        self._trace = trace[beyond]
        return trace[~beyond]

    def striking(self, command: int) -> Striking:
        """Return the names in a command for its contacts."""
        return self._striking[command]


def chosen(presets: Folders) -> Presets:
    """Return the presets that are meant."""
    return presets if isinstance(presets, Presets) else Presets(presets)


def _keys(args: tuple[Argument, ...]) -> dict[Argument, Argument]:
    """Return the keys of a message and their values."""
    first = next((n for n, arg in enumerate(args) if isinstance(arg, str)), len(args))
    return dict(zip(args[first::2], args[first + 1 :: 2], strict=True))
