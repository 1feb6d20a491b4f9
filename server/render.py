"""Offline rendering: a score through the engine into a sound file, or into arrays."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from operator import index
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from ..dsp.arguments import switch_of
from ..dsp.engine.memory.capacity import MODES, MOST_CHANNELS, OBJECTS, STEMS
from ..dsp.engine.memory.mounted import SENSORS
from ..dsp.engine.memory.state import QUANTUM, RING
from ..dsp.runtime.engine import Engine
from ..dsp.schema import CHANNELS, FORMS, FULL_SCALE, MAIN_GAIN, ROOM, SENSED, STEPS, Parameter
from ..dsp.wording import expected
from ..presets import PresetError, Presets
from .costs import CostWatch
from .files.spool import Spool, StemSpools
from .files.whole import RenderError, require_format, writing
from .limiting import LimiterWatch, Limiting
from .new_object import NEW
from .osc.addresses import VERBS, calls
from .osc.arguments import Refused, check_number, shown
from .osc.score import END, LONGEST_SCORE, Line, ScoreError, sample_at
from .osc.sensor_verbs import SENSOR
from .osc.wire import Argument, Message
from .scene.limits import LONGEST_BOUNCE
from .scene.scale import Scale
from .scene.sensing import last_of_sensors, meaning_of
from .scene.session import Session

LOWEST_RATE, HIGHEST_RATE = 8_000, 192_000
PIECE = 1_024
"""Frames that are computed at once, at most: between looks at what the limiter did, and at the record of contacts."""

LONGEST_TAIL = 600.0
"""s after a score's last event, after which a render ends if all that goes on would go on for ever."""
LONGEST_REST = LONGEST_BOUNCE + LONGEST_TAIL
"""Time (s) after a score's last event at which a render ends, even if gestures go on that would come to rest."""

_MOST_NAMES = 8  # of gestures, in a warning

_BUDGET = "/budget"
_PEAK = Parameter("normalize", -100.0, 0.0, "dBFS")


def _is_rate(value: SupportsIndex) -> bool:
    """True for a whole number of Hz that there may be."""
    try:
        return LOWEST_RATE <= index(value) <= HIGHEST_RATE
    except TypeError:  # of an array, too
        return False


@dataclass(frozen=True)
class Options:
    """Options of a render: rate in Hz, block in frames, sample format 16, 24 or float (None: 24 for FLAC, else float),
    seconds (None: until the score's /end, or silence).

    channels, gain (dB), limiter and bank (one of FORMS) hold from the start, in place of what the score says of them at
    time 0 (None: as it says, else 2 channels, 0 dB, on, and float64). full_scale: the pressure (Pa) of a sample of 1.0,
    of an object of level 0 (None: as the score says, else FULL_SCALE_PRESSURE). budget: steps and modes, as /budget has
    them, in place of all that the score says of them. calibrated: samples are pascals, without a limiter, as floats.
    normalize: the peak (dBFS) to which the whole is brought; without a limiter, unless one is requested.
    """

    rate: int = 48_000
    block: int = 16_384
    format: str | None = None
    seconds: float | None = None
    channels: int | None = None
    gain: float | None = None
    limiter: bool | None = None
    calibrated: bool = False
    normalize: float | None = None
    bank: str | None = None
    full_scale: float | None = None
    budget: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if not _is_rate(self.rate):
            raise RenderError(f"rate = {self.rate}: expected {LOWEST_RATE} to {HIGHEST_RATE} Hz, a whole number")
        if not 1 <= self.block <= 1 << 20:
            raise RenderError(f"block = {self.block}: expected 1 to {1 << 20} frames")
        require_format(self.format)
        known = self.seconds is None or isinstance(self.seconds, int | float)
        if not known or (self.seconds is not None and not 1 / self.rate <= self.seconds <= LONGEST_SCORE):
            raise RenderError(f"seconds = {shown(self.seconds)}: expected at least a frame and at most {LONGEST_SCORE}")
        steps, room = self.budget or (None, None)
        for number, value in (
            (CHANNELS, self.channels), (MAIN_GAIN, self.gain), (_PEAK, self.normalize), (FULL_SCALE, self.full_scale),
            (STEPS, steps), (ROOM, room),
        ):  # fmt: skip
            require(number, value)
        if self.limiter is not None:
            switch_of("limiter", self.limiter, RenderError)
        switch_of("calibrated", self.calibrated, RenderError)
        if self.bank not in (None, *FORMS):
            raise RenderError(f"bank = {self.bank}: {expected(str(self.bank), FORMS)}")
        if self.calibrated:
            self._require_pascals()

    def _require_pascals(self) -> None:
        if self.limiter:
            raise RenderError("limiter = on: expected none, as calibrated samples are pascals")
        if self.normalize is not None:
            raise RenderError(f"normalize = {self.normalize:g}: expected none, as calibrated samples are pascals")
        if self.full_scale is not None:
            raise RenderError(f"full_scale = {self.full_scale:g}: expected none, as calibrated samples are pascals")
        if self.format not in (None, "float"):
            raise RenderError(f"format = {self.format}: expected float, as calibrated samples are pascals")

    @property
    def head(self) -> list[Message]:
        """The messages with which the render begins."""
        limiter = False if self.calibrated or (self.normalize is not None and self.limiter is None) else self.limiter
        return [
            *([Message("/limiter", ("on" if limiter else "off",))] if limiter is not None else []),
            *([Message("/gain", (self.gain,))] if self.gain is not None else []),
            *([Message("/bank", (self.bank,))] if self.bank is not None else []),
            *([Message(_BUDGET, self.budget)] if self.budget is not None else []),
        ]

    def gain_of(self, peak: float, warn: Callable[[str], object]) -> float:
        """Return the gain (amplitude) that normalizes a sound with this largest magnitude; 1 for silence, of which it
        warns, and where nothing is to be normalized."""
        if self.normalize is None:
            return 1.0
        if peak == 0.0:
            warn("the sound is silence: it is not normalized")
            return 1.0
        return float(10.0 ** (self.normalize / 20.0)) / peak

    def channels_of(self, score: Sequence[Line]) -> int:
        """Return how many channels the render of a score has; ScoreError names a line that says no number of them."""
        return int(_chosen(CHANNELS, self.channels, score))

    def scale_of(self, score: Sequence[Line]) -> Scale:
        """Return the scale of the samples in the render of a score. ScoreError names a line that says no full scale."""
        return Scale(True) if self.calibrated else Scale(False, _chosen(FULL_SCALE, self.full_scale, score))

    def channels_and_sensors(self, score: Sequence[Line]) -> tuple[int, int]:
        """Return how many channels the render of a score has, and how many more for sensors. RenderError if these are
        too many, ScoreError as in `channels_of`."""
        channels, sensors = self.channels_of(score), sensors_of(score)
        if sensors > (most := min(SENSORS, MOST_CHANNELS - channels)):
            raise RenderError(f"{sensors} sensors: expected at most {most} beside {channels} channels")
        return channels, sensors

    def engine(self, score: Sequence[Line], objects: int = OBJECTS) -> Engine:
        """Make an engine for the render of a score. Errors are those of `channels_and_sensors`."""
        channels, sensors = self.channels_and_sensors(score)
        return Engine(self.rate, channels, MODES, objects, limited=not self.calibrated, sensors=sensors)

    def lines_of(self, score: Sequence[Line]) -> list[Line]:
        """Return the lines of a score but for those in whose place the options are: at time 0, and of the budget all.
        RenderError if none is left."""
        given = {message.address for message in self.head}
        given |= {f"/{name}" for name in ("channels", "full_scale") if getattr(self, name) is not None}
        lines = [line for line in score if line.time > 0.0 or line.message.address not in given]
        if self.budget is not None:
            lines = [line for line in lines if not _is_of_budget(line)]
        if not lines:
            raise RenderError("the score is empty: expected lines of time, address and arguments")
        return lines


def require_objects(score: Sequence[Line], presets: Presets, seconds: float | None = None) -> None:
    """Raise ScoreError for a line, up to a time, that makes an object of a preset which is not there.

    A render says so, too, but only once the engine is compiled.
    """
    for line in score:
        address, args = line.message.address, line.message.args
        if address == NEW and len(args) > 1 and isinstance(args[1], str) and line.time <= (seconds or math.inf):
            try:
                presets.object(args[1])
            except PresetError as error:
                raise ScoreError(f"{line.where}: {address}: {error}") from None


def _is_of_budget(line: Line) -> bool:
    """True if a line sets the budget, be it by a pattern."""
    return any(call.verb is VERBS[_BUDGET] for call in calls(line.message))


def _chosen(number: Parameter, given: float | None, score: Sequence[Line]) -> float:
    """Return the value of what holds for a whole render: as an option gives it, else as the score does, else the usual
    one."""
    address = f"/{number.name}"
    said = [line for line in score if line.message.address == address]
    if given is not None or not said:
        return float(number.default or 0.0) if given is None else float(given)
    try:
        return VERBS[address].parse(said[0].message.args).numbers[number.name]
    except Refused as error:
        raise ScoreError(f"{said[0].where}: {address}: {error}") from None


def sensors_said(score: Sequence[Line], channels: int) -> str:
    """Describe the channels of a score's sensors, which follow so many. ScoreError names a line that mounts none."""
    said: dict[Argument, list[str]] = {}
    for line in sorted(score, key=lambda line: line.time):
        if line.message.address == SENSOR:
            try:
                values = VERBS[SENSOR].parse(line.message.args)
                meanings, meaning = said.setdefault(line.message.args[0], []), meaning_of(values)
            except (Refused, PresetError) as error:
                raise ScoreError(f"{line.where}: {SENSOR}: {error}") from None
            meanings += [] if meanings[-1:] == [meaning] else [meaning]
    count = sensors_of(score)
    if count < len(said):
        return last_of_sensors(count)
    names = [str(name).encode("ascii", "replace").decode() for name in said]
    told = enumerate(zip(names, said.values(), strict=True), channels + 1)
    return "; ".join(f"channel {n} ({name}): 1.0 is {', then '.join(meanings)}" for n, (name, meanings) in told)


def sensors_of(score: Sequence[Line]) -> int:
    """Return how many channels a score has for sensors: as many as it says, else one for each name. ScoreError names a
    line that says no number of them."""
    if any(line.message.address == f"/{SENSED.name}" for line in score):
        return int(_chosen(SENSED, None, score))
    return len({line.message.args[:1] for line in score if line.message.address == SENSOR})


def require(number: Parameter, value: object) -> None:
    """Raise RenderError if a value, which is not None, is not as a parameter allows."""
    try:
        if value is not None:
            check_number(number, value)  # type: ignore[arg-type]
    except Refused as error:
        raise RenderError(str(error)) from None


class Rendered(NamedTuple):
    """The outcome of a render: its engine, the limiter's work, and the gain (dB) that normalized it, if one did."""

    engine: Engine
    limiting: Limiting
    normalized: float | None = None


class _Timeline:
    """The times at which a score's lines are due, and the end of its render. Times are in frames."""

    def __init__(self, score: Sequence[Line], options: Options, delay: int) -> None:
        """Begin the timeline; the limiter begins with `delay` frames before the sound."""
        self._delay = delay
        self._rate = options.rate
        self._lines = sorted(score, key=lambda line: line.time)
        self._next = 0
        self._tail, self._rest = (self._after(seconds) for seconds in (LONGEST_TAIL, LONGEST_REST))
        seconds = options.seconds
        if seconds is None:
            seconds = max(
                (line.time for line in score if line.message.address == END and line.time > 0.0), default=None
            )
        self.end = None if seconds is None else max(1, round(seconds * options.rate))
        """Frame at which the render ends, once that is known."""

    def _after(self, seconds: float) -> int:
        """Return the first quantum that begins no earlier than some seconds after the last line."""
        return -(-round((self._lines[-1].time + seconds) * self._rate) // QUANTUM) * QUANTUM

    def _quantum(self, line: Line) -> int:
        """Return the beginning of the quantum in which a line is due."""
        return int(sample_at(line.time, self._rate)) // QUANTUM * QUANTUM

    def due(self, position: int) -> Iterator[Line]:
        """Yield the next lines, as far as they are due in the quantum that begins at a position."""
        while self._next < len(self._lines) and self._quantum(self._lines[self._next]) <= position:
            line = self._lines[self._next]
            self._next += 1
            yield line

    def piece(self, written: int, frames: int) -> int:
        """Return how many of `frames` frames to compute at once: up to the next quantum at which there is something to
        do."""
        computed = written + self._delay
        if self._next < len(self._lines):
            stop = self._quantum(self._lines[self._next])
        elif self.end is not None:
            stop = self.end + self._delay
        elif computed < self._tail:
            stop = self._tail
        else:  # every quantum may be the last
            stop = (computed // QUANTUM + 1) * QUANTUM
        return min(frames, PIECE, max(1, stop - computed))

    def look_for_end(self, session: Session, warn: Callable[[str], object]) -> None:
        """Set the end if nothing sounds any more, or if the score has gone on for long enough since its last line."""
        engine = session.engine
        if self.end is not None or self._next < len(self._lines):
            return
        if engine.quiet():
            self.end = max(engine.stats.sounded, self._quantum(self._lines[-1]) + QUANTUM)
        elif engine.position >= self._rest or (engine.position >= self._tail and not engine.comes_to_rest()):
            self.end = engine.position
            warn(self._early_end(session))

    def _early_end(self, session: Session) -> str:
        session.gestures.collect()
        names = [id.name for id in session.gestures.running()]
        more = ", ..." if len(names) > _MOST_NAMES else ""
        listed = ", ".join(names[:_MOST_NAMES]) + more
        after = session.engine.position / self._rate - self._lines[-1].time
        going = f"these gestures go on: {listed}; stop them in the score" if names else "an object still sounds"
        return f"the sound ends {round(after, 1):g} s after the last event, though {going}, or give a length in seconds"


def blocks(
    score: Sequence[Line],
    engine: Engine,
    presets: Presets,
    options: Options,
    session: Session | None = None,
    warn: Callable[[str], object] = lambda text: None,
    look: Callable[[], object] = lambda: None,
) -> Iterator[NDArray[np.float32]]:
    """Yield the sound of a score, block by block, each float32 (frames, channels); raise ScoreError that names a line
    that is refused.

    engine: `options.engine(score)`. session: of the engine, if it has one already.
    Without `seconds` the sound ends where the score's last /end stands, or else with the quantum in which the last
    object falls silent. If all that goes on would go on for ever (a press, a roll without friction) it ends
    LONGEST_TAIL after the last event, and in any case LONGEST_REST after it; `warn` gets a sentence of either, of lines
    that have no effect, and of a sound that took more time of a processor than it lasts. The block size does not
    matter.
    look: is called after each PIECE frames at the latest.
    """
    lines = options.lines_of(score)
    session = session or Session(engine, presets, steers_ended=True, scale=options.scale_of(score))
    for message in options.head:
        _perform(session, Line(0.0, message, message.address[1:]), warn)
    timeline = _Timeline(lines, options, engine.delay)
    written = -engine.delay
    silence = engine.delay  # that a limiter begins with: it is dropped
    costs = CostWatch(engine, session.objects.slots)
    while timeline.end is None or written < timeline.end:
        stop = written + options.block if timeline.end is None else min(written + options.block, timeline.end)
        parts = []
        while written < stop:
            for line in timeline.due(engine.position):
                _perform(session, line, warn)
            piece = timeline.piece(written, stop - written)
            parts.append(costs.process(piece))
            look()
            written += piece
            timeline.look_for_end(session, warn)
            if timeline.end is not None:
                surplus = max(0, written - timeline.end)
                parts[-1] = parts[-1][: piece - surplus]
                stop = min(stop, timeline.end)
        sound = np.concatenate(parts)
        dropped = min(silence, len(sound))
        silence -= dropped
        if len(sound) > dropped:
            yield sound[dropped:]
    if said := costs.warning():
        warn(said)


def _perform(session: Session, line: Line, warn: Callable[[str], object]) -> None:
    if session.engine.room() == 0:
        raise ScoreError(f"{line.where}: too many events at once: expected at most {RING}")
    for reply in session.perform([line.message], sample_at(line.time, session.engine.rate)):
        if reply.address == "/fail":
            raise ScoreError(f"{line.where}: {': '.join(map(str, reply.args))}")
        if reply.address == "/warning":
            warn(f"{line.where}: {reply.args[0]!s}")


def render(
    score: Sequence[Line],
    out: Path,
    presets: Presets,
    options: Options,
    progress: Callable[[float], object] = lambda seconds: None,
    warn: Callable[[str], object] = lambda text: None,
    stems: Path | None = None,
) -> Rendered:
    """Render a score to a WAV or FLAC file, chosen by its ending.

    The file appears under its name once it is whole. `progress` gets the seconds computed, `warn` that the sound
    ends early, as in `blocks`. stems: a folder, made if missing, for a file of the same kind for each object, with its
    part of the sound before the limiter. RenderError, ScoreError or OSError say what went wrong.
    """
    engine = options.engine(score, STEMS if stems else OBJECTS)
    session = Session(engine, presets, steers_ended=True, scale=options.scale_of(score))
    watch = LimiterWatch(engine, lambda: session.objects.slots)
    with ExitStack() as stack:
        format = "float" if options.calibrated else options.format
        scale = session.scale.said if options.normalize is None else ""
        if engine.sensors and (format not in (None, "float") or out.suffix.lower() != ".wav"):
            raise RenderError(f"{out}: format = {format}: expected a WAV file of floats, as sensors are in SI units")
        comment = "; ".join(filter(None, (scale, sensors_said(score, engine.channels))))
        write = stack.enter_context(writing(out, options.rate, engine.width, format, comment))
        if stems:
            _make_folder(stems)
            options = replace(options, block=QUANTUM)
            engine.stems.keep(True)
        if stems or options.normalize is not None:
            folder = Path(stack.enter_context(TemporaryDirectory(prefix=".carom-", dir=stems or out.parent)))
        spool = None if options.normalize is None else Spool(folder / "whole", engine.width, engine.sensors)
        parts = StemSpools(folder, engine.channels) if stems else None
        keep = spool.append if spool else write
        frames = 0
        for sound in blocks(score, engine, presets, options, session, warn, watch.look):
            if parts:
                parts.add(session.objects.slots, engine.stems.shares(), engine.stems.sounding(), frames)
            keep(sound)
            frames += len(sound)
            progress(engine.position / options.rate)
        gain = options.gain_of(spool.peak, warn) if spool else 1.0
        for piece in spool.pieces(gain) if spool else ():
            write(piece)
        if stems and parts:
            parts.save(lambda name: stems / f"{name}{out.suffix}", options.rate, format, frames, gain, scale)
    limiting = watch.take().within(0.0, frames / options.rate)
    return Rendered(engine, limiting, None if options.normalize is None else 20.0 * math.log10(gain))


def _make_folder(path: Path) -> None:
    """Make a folder, unless it is there. RenderError if something else is."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise RenderError(f"{path}: expected a folder, and a file is there") from None
