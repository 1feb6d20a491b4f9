"""The engine from Python: it checks, lays out memory and sends commands; the compiled callback does the rest."""

from collections.abc import Collection, Sequence
from copy import deepcopy
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bodies.macros import Change
from ..bodies.material import Array
from ..bodies.modes import Modes
from ..bodies.striker import StrikerSound
from ..contact.accuracy import LEVELS
from ..counters import Stats
from ..engine.memory.capacity import SHAPE_VALUES, USUAL_MODES, USUAL_OBJECTS, check_sizes
from ..engine.memory.commands import Command, Handle, Kind
from ..engine.memory.state import COUPLING, ENDED, QUANTUM, RING, TAP, End, Quality
from ..native.addresses import address_of, as_bytes
from ..native.atomics import confirm, observe, publish
from ..native.code import Code, load
from ..native.system import clock_ns
from ..resonator.bank import top_of
from ..schema import FORMS
from .arena import Arena, EngineFull
from .entry import MODULE, callback
from .fresh import Mark, copied_state, fresh_state
from .memory import Memory
from .meter import OFFSET, SILENCE, Meter, decibels
from .pulses import PulseTables
from .ring import KEPT_FOR_NOW as KEPT_FOR_NOW
from .ring import NOW as NOW
from .ring import Ring
from .stems import Stems
from .strikers import Strikers

_STEADY = 1e-3  # s by which the clock may turn out to be wrong before its report changes

_NO_TIMES = np.zeros(3)
_NO_TIMES_AT = _NO_TIMES.ctypes.data


class Stamp(float):
    """A time of the clock, as the sample that it is likely to be; in the engine it is `clock`, CLOCK_MONOTONIC in ns,
    that decides."""

    clock: int

    def __new__(cls, sample: float, clock: int) -> "Stamp":
        self = super().__new__(cls, sample)
        self.clock = clock
        return self


def prepare() -> None:
    """Load the engine's code, or compile it, which takes long; after this, an Engine takes milliseconds."""
    for module in (MODULE, observe.__module__, clock_ns.__module__):
        load(module)


class Engine:
    """A running engine at one sampling rate (Hz), with a number of channels, 1 to MOST_CHANNELS (channels.py).

    It holds so many modes and objects at most. Memory is taken as they are made. limited: whether it has a limiter, on
    or off, which delays the sound by a quantum.

    `process` computes sound here and now; a sound card's thread may do the same through `address` and `pointer`, while
    one other thread at a time makes objects and sends commands.
    """

    def __init__(
        self,
        rate: float,
        channels: int = 2,
        modes: int = USUAL_MODES,
        objects: int = USUAL_OBJECTS,
        limited: bool = False,
        sensors: int = 0,
    ) -> None:
        check_sizes(channels, modes, objects, sensors)
        load(MODULE)  # before the memory, which may leave no room for code that lies together
        self.shapes = Arena("values of mode shapes", SHAPE_VALUES)
        """The places in its table of mode shapes."""
        self.state = fresh_state(rate, channels, self.shapes)
        self._record = self.state[0]
        self._record["output"]["delay"] = QUANTUM if limited else 0
        self.ring = Ring(self._record)
        self.meter = Meter(self._record)
        self._pointer, self._channels, self._rate = self.state.ctypes.data, channels, float(rate)
        self.sensors = sensors
        self._pace: tuple[int, float, float] | None = None
        self._memory = Memory(self._record, modes, objects, self.shapes)
        self.stems = Stems(self._record)
        self._strikers = Strikers(self._record, self.top_frequency)
        self.pulses = PulseTables(self._record)
        self._ends_read = self.ends_lost = 0

    def __setstate__(self, kept: dict[str, Any]) -> None:
        """Take over what a copy of an engine holds, in memory of its own."""
        self.__dict__.update(kept)
        self._pointer = self.state.ctypes.data

    def copied_memory(self) -> tuple[NDArray[np.void], Arena]:
        """Return a copy of its state, and of the places of its mode shapes."""
        shapes = deepcopy(self.shapes)
        return copied_state(self.state, shapes), shapes

    def mark(self) -> Mark:
        """Return what `rewind` brings it back to, as long as no objects are made between. OSError where this system
        does not report what is written."""
        return Mark(self.state)

    def rewind(self, mark: Mark) -> None:
        """Bring it back to a mark that was made before any striker sounded. OSError as `mark`: then it is of no use."""
        mark.restore()
        self._strikers.forget()
        self._ends_read = self.ends_lost = 0

    @property
    def rate(self) -> float:
        return self._rate

    @property
    def channels(self) -> int:
        return self._channels

    @property
    def sensors(self) -> int:
        """Channels that follow those of the sound, one for each sensor; to be set where no other thread computes."""
        return self._sensors

    @sensors.setter
    def sensors(self, count: int) -> None:
        self._sensors = count
        self._record["output"]["sensors"] = count

    @property
    def width(self) -> int:
        """Channels of what it computes: those of the sound, and one for each sensor."""
        return self._channels + self._sensors

    @property
    def address(self) -> int:
        """Address of the compiled callback, with PortAudio's signature."""
        return callback.address

    @property
    def pointer(self) -> int:
        """The callback's user data."""
        return self._pointer

    @property
    def measured_rate(self) -> float:
        """Hz, by the clock, as the callbacks come."""
        period = float(self._record["clock"]["period"])
        return 1e9 / period if period else self.rate

    def set_latency(self, latency: float) -> None:
        """Say how long (s) after its callback a sound is heard: events that have a time begin that much earlier, and
        earlier by the limiter's delay."""
        self._record["clock"]["latency"] = latency * self.rate + self.delay

    @property
    def thread(self) -> int:
        """The system's number of the thread in which the callback runs, 0: not known yet."""
        return int(self._record["thread"])

    def forget_thread(self) -> None:
        """Forget the callback's thread: the next callback says in which one it runs."""
        self._record["thread"] = 0

    @property
    def position(self) -> int:
        """Samples computed so far."""
        return int(self._record["position"])

    @property
    def delay(self) -> int:
        """Samples by which the limiter delays the sound; 0 without one."""
        return int(self._record["output"]["delay"])

    @property
    def left(self) -> int:
        """Samples of sound that have left the limiter so far."""
        return max(self.position - self.delay, 0)

    def stamp(self, time: int) -> Stamp:
        """Return the stamp of a time of `clock_ns`, for `send`. Two stamps compare as their times do, unless the clock
        is set meanwhile."""
        clock = self._record["clock"]
        turn = -1
        while turn % 2 or turn != confirm(clock["turn"]):
            turn = observe(clock["turn"])
            origin = int(clock["origin"]) or clock_ns()  # before the first callback, that is now
            period = 1e9 / self.measured_rate
            begin = float(clock["sample"]) - float(clock["time"]) / period - float(clock["latency"])
        if self._pace is None or abs(_sample(time, *self._pace) - _sample(time, origin, begin, period)) > (
            _STEADY * self.rate
        ):
            self._pace = origin, begin, period
        return Stamp(_sample(time, *self._pace), time)

    @property
    def top_frequency(self) -> float:
        """Hz: modes above it are not heard."""
        return float(top_of.py_func(self.rate))

    @property
    def stats(self) -> Stats:
        """The engine's counts and measures, as they are now."""
        return Stats(*self._record["stats"].item())

    @property
    def queued(self) -> int:
        """Events that wait for their time."""
        return int(self._record["queue"]["size"])

    @property
    def quality(self) -> Quality:
        """The quality at which the engine computes now."""
        return Quality(int(self._record["choices"]["quality"]))

    @property
    def budget(self) -> tuple[int, int]:
        """The most that coupled contacts may cost now: steps per sample of each, and modes at once; 0: any number."""
        steps, modes = self._record["choices"]["budget"]
        return int(steps), int(modes)

    @property
    def accuracy(self) -> str:
        """The accuracy of coupled contacts now: one of LEVELS."""
        return LEVELS[self._record["choices"]["accuracy"]]

    @property
    def bank(self) -> str:
        """The form in which the spectral bank keeps its modes now: one of FORMS."""
        return FORMS[self._record["choices"]["bank"]]

    @property
    def gain(self) -> float:
        """The main gain (amplitude) now."""
        return float(self._record["choices"]["gain"])

    @property
    def limiter(self) -> bool:
        """True if the limiter is on now."""
        return bool(self._record["choices"]["limiter"])

    @property
    def headroom(self) -> bool:
        """True if the automatic level ahead of the limiter is on now."""
        return bool(self._record["choices"]["headroom"])

    def take_limit_lowest(self) -> float:
        """Return the limiter's lowest gain since the last call. The audio thread may set it at the same moment: then a
        quantum may be missed."""
        lowest = float(self._record["stats"]["limit_lowest"])
        self._record["stats"]["limit_lowest"] = 1.0
        return lowest

    def take_loudest_dropped(self) -> float:
        """Return the momentary loudness (LUFS) that the loudest contact left out since the last call would have had,
        SILENCE if none was. The audio thread may set it at the same moment: then one may be missed."""
        loudest = float(self._record["stats"]["loudest_dropped"])
        self._record["stats"]["loudest_dropped"] = 0.0
        return OFFSET + decibels(loudest) if loudest > 0.0 else SILENCE

    @property
    def objects(self) -> NDArray[np.void]:
        """The records of objects, of OBJECT, by slot: of those slots that have ever been used."""
        objects: NDArray[np.void] = self._record["objects"][: self._memory.reached]
        return objects

    def process(self, frames: int) -> NDArray[np.float32]:
        """Return the next `frames` frames, float32 (frames, width). A limiter begins with `delay` frames of silence,
        which offline callers drop."""
        out = np.empty((frames, self._channels + self._sensors), np.float32)
        callback.compute(None, address_of(out), frames, _NO_TIMES_AT, 0, self._pointer)
        return out

    def quiet(self) -> bool:
        """True if nothing sounds, and nothing waits to: what rests on something may stay, once it is still."""
        state = self._record
        if state["stats"]["sounding"] or self.queued:  # as most often
            return False
        still = np.count_nonzero((state["contacts"]["asleep"] == 1) & (state["last_command"] > 0))
        return bool(self.stats.contacts_active == still and self.room() == RING and self.position > 0)

    def comes_to_rest(self) -> bool:
        """True if all that goes on ends by itself: bounces, spins, rolls that friction slows, or objects that ring."""
        state = self._record
        lasting = state["contacts"][state["last_command"] > 0]
        friction = state["rolls"]["target"]["friction"][lasting["roll"][lasting["trait"]["rolls"] == 1]]
        return len(lasting) == 0 or bool((friction > 0.0).any() or lasting["trait"]["repeats"].any())

    def most_coupled(self) -> int:
        """Return the slot of the object whose contact is solved together with the most modes now, -1 if none is."""
        contacts = self._record["contacts"]
        coupled = np.flatnonzero((contacts["touching"] == 1) & (contacts["solver"] == COUPLING))
        if not coupled.size:
            return -1
        most = coupled[contacts["modes"][coupled].argmax()]
        return int(contacts["point"]["slot"][most, 0])

    def room(self) -> int:
        """Return how many commands can be sent now."""
        return self.ring.room()

    def send(self, commands: Sequence[Command]) -> None:
        """Send commands all at once, or EngineFull and none of them."""
        self.ring.send(commands)
        self.pulses.count(commands)

    def ended(self) -> list[tuple[int, End]]:
        """Return the gestures (by number) that have ended since the last call, and how: one for each that was sent."""
        count = int(observe(self._record["ends"]["written"]))
        if count == self._ends_read:
            return []
        first, unread, self._ends_read = max(self._ends_read, count - ENDED), self._ends_read, count
        ended = self._record["ends"]["entries"]
        ends = ended[np.arange(first, count) % ENDED].tolist()
        # The engine waits for nobody: what it may have written over meanwhile is lost.
        lost = max(0, int(confirm(self._record["ends"]["written"])) + 1 - ENDED - first)
        self.ends_lost += first + min(lost, len(ends)) - unread
        return [(serial, End(end)) for serial, end in ends[lost:]]

    @property
    def sent(self) -> int:
        """Commands sent so far: the number of the next."""
        return self.ring.sent

    def note(self) -> None:
        """Keep what becomes of commands from here on for `noted`."""
        self._record["notes"]["on"] = 1

    def noted(self) -> list[tuple[int, float]]:
        """Return the fate of commands since the last call, in order: number, and the sample at which each was carried
        out, or less than 0 for one that never is."""
        notes = self._taken("notes", self._record["notes"]["entries"])
        return list(zip(notes["number"].tolist(), notes["time"].tolist(), strict=True))

    def _taken(self, name: str, entries: NDArray[Any], most: int | None = None) -> NDArray[Any]:
        """Return the entries that a ring has got since the last call, the newest of them if there are more than
        `most`."""
        ring = self._record[name]
        written = int(observe(ring["written"]))
        taken = _between(entries, max(int(ring["read"][0]), written - (most or len(entries))), written)
        publish(ring["read"], written)
        return taken

    def record(self) -> None:
        """Keep the sound from here on for `recorded`."""
        self._record["tap"]["on"] = 1

    def recorded(self) -> NDArray[np.float32]:
        """Return the sound since the last call, float32 (frames, width), whatever is missing in it."""
        return np.concatenate([np.empty((0, self.width), np.float32), *(sound for _, sound in self.recorded_parts())])

    def recorded_parts(self) -> list[tuple[int, NDArray[np.float32]]]:
        """Return the sound since the last call in parts of which nothing is missing: the number of the first frame of
        each since the start, and float32 (frames, width)."""
        tap = self._record["tap"]
        read, written = int(tap["read"][0]), int(observe(tap["written"]))
        numbers = _between(tap["first"], read // QUANTUM, written // QUANTUM)
        sound = _between(tap["frames"][: TAP * self.width].reshape(TAP, self.width), read, written)
        publish(tap["read"], written)
        begins = [0, *(np.flatnonzero(np.diff(numbers) != QUANTUM) + 1)] if len(numbers) else []
        return [
            (int(numbers[begin]), sound[begin * QUANTUM : end * QUANTUM])
            for begin, end in pairwise([*begins, len(numbers)])
        ]

    def trace(self, on: bool) -> None:
        """Keep the forces of contacts from here on for `traced`, or no more."""
        self._record["trace"]["on"] = on

    def traced(self, most: int | None = None) -> NDArray[np.void]:
        """Return the forces of contacts since the last call, (n,) of TRACE, the newest if there are more than `most`;
        call it every 1,024 frames, so that none is lost."""
        return self._taken("trace", self._record["trace"]["entries"], most)

    def limited_energy(self) -> NDArray[np.float64]:
        """Return, by slot, the sum of squares of each object's share of the mix, over the quanta that the limiter
        turned down since the last call."""
        energies = self.objects["limited_energy"]
        taken: NDArray[np.float64] = energies.copy()
        energies[:] = 0.0
        return taken

    @property
    def code(self) -> Code:
        """The machine code that runs: its key, for which kind of processor it was made, and where it came from."""
        return callback.code

    def lay_out(self, modes: Modes, level: float) -> tuple[Handle, dict[str, float]]:
        """Put an object's modes up to `top_frequency` into the bank; return its handle, and the layout that its NEW
        command takes.

        `level` (amplitude) is full scale per Pa at 1 m. EngineFull if there is no room.
        """
        return self._memory.lay_out(modes, level, self.top_frequency)

    def lay_out_cover(self, modes: Modes, squares: Array) -> tuple[Handle, dict[str, float]]:
        """Lay out what covers an object of some modes: the silent object whose shapes are their mean squares (P, n)."""
        order = self._memory.plan(modes, self.top_frequency).order
        silent = np.zeros((2, order.size))
        return self.lay_out(Modes(modes.frequency[order], np.ones(order.size), squares[:, order], silent, 1.0), 1.0)

    def plan(self, modes: Modes) -> None:
        """Plan the layout of modes, which `lay_out` takes then if it is requested it soon. Any thread may ask; a plan
        takes up to 40 ms.

        EngineFull if there are more modes than an object holds.
        """
        self._memory.plan(modes, self.top_frequency)

    def add(self, modes: Modes, level: float = 1.0, time: float = NOW, **settings: float) -> Handle:
        """Make an object: lay out its modes and send its NEW command, with settings by name in the engine's units.

        `level` as in `lay_out`. EngineFull if there is no room, ValueError for a setting that there is not; then
        nothing is kept.
        """
        handle, layout = self.lay_out(modes, level)
        try:
            self.send([Command(time, Kind.NEW, handle, {**layout, **settings})])
        except (EngineFull, ValueError):
            self.release(handle)
            raise
        return handle

    def lay_out_macros(self, handle: Handle, modes: Modes, level: float, axes: Sequence[Sequence[Change]]) -> int:
        """Lay out the table of an object's macros: the changes of its modes by setting of SHAPING and place.

        `level` as in `lay_out`. Returns the value of the command RESHAPE. EngineFull if there is no room.
        """
        return self._memory.lay_out_macros(handle, modes, level, self.top_frequency, axes)

    def lay_out_striker(self, sound: StrikerSound) -> dict[str, float]:
        """Find the place of a striker that sounds, or give it one.

        Returns the values `sound` and `sound_serial`, which the commands of its gestures take.
        """
        return self._strikers.lay_out(sound)

    def striker_at(self, place: int) -> StrikerSound | None:
        """Return the striker at a place that `lay_out_striker` gave; None for -1, where nothing sounds."""
        return self._strikers.at(place)

    @property
    def had_plates(self) -> bool:
        """True if it ever had a plate whose modes can be coupled."""
        return self._memory.had_plates

    def lacks_pulses(self, exponent: float) -> bool:
        """True if `lay_out_pulses` has to make a table first, which takes a second."""
        return self.pulses.lacks(exponent)

    def lay_out_pulses(self, exponent: float, kept: Collection[float] = ()) -> dict[str, float]:
        """Make the table of the pulses of a contact law's exponent, 0 for drops, unless there is one.

        It may take the place of one that no swarm needs: commands that were sent count, and exponents in `kept`.
        Returns the value `pulses`, which the commands of swarms take. EngineFull if there is no room.
        """
        return self.pulses.lay_out(exponent, kept)

    def leave(self, handle: Handle) -> None:
        """Remember that an object is being removed; its place is used again once the engine has given it up."""
        self._memory.leave(handle)

    def stay(self, handle: Handle) -> None:
        """Take back `leave`, where the command did not reach the engine."""
        self._memory.stay(handle)

    def release(self, handle: Handle) -> None:
        """Take back the place of an object that the engine doesn't have, or has no more."""
        self._memory.release(handle)


def _between(entries: NDArray[Any], read: int, written: int) -> NDArray[Any]:
    """Return a copy of the entries of a ring from a number up to another."""
    first, last = read % len(entries), written - read + read % len(entries)
    if first == last:
        return entries[:0].copy()
    whole = as_bytes(entries) if entries.dtype.names else entries
    if last <= len(entries):
        taken: NDArray[Any] = whole[first:last].copy()
    else:
        taken = np.concatenate([whole[first:], whole[: last - len(entries)]])
    return taken.view(entries.dtype)


def _sample(time: int, origin: int, begin: float, period: float) -> float:
    return begin + (time - origin) / period
