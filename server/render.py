"""Offline rendering: a score through the engine into a sound file, or into arrays."""

import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import SupportsIndex

import numpy as np
import soundfile
from numpy.typing import NDArray

from ..dsp.engine.state import QUANTUM, RING
from ..dsp.runtime.engine import Engine
from ..presets import Presets
from .files.soundfiles import WAV_BYTES, open_sound
from .osc.score import LONGEST_SCORE, Line, ScoreError, sample_at
from .osc.wire import Argument, Message
from .scene.limits import LONGEST_BOUNCE
from .scene.session import Session

LOWEST_RATE, HIGHEST_RATE = 8_000, 192_000
LONGEST_TAIL = 600.0
"""s after a score's last event, after which a render ends if all that goes on would go on for ever."""
LONGEST_REST = LONGEST_BOUNCE + LONGEST_TAIL
"""s after a score's last event, after which a render ends even if what goes on would come to rest."""

_PIECE = 1_024  # frames
_ENDINGS = {".wav": "WAV", ".flac": "FLAC"}
_SUBTYPES = {"16": "PCM_16", "24": "PCM_24", "float": "FLOAT"}
_MOST_NAMES = 8  # of gestures, in a warning


class RenderError(ValueError):
    """The render cannot be made; the text says why."""


@dataclass(frozen=True)
class Options:
    """How to render: rate in Hz, block in frames, sample format 16, 24 or float (None: 24 for FLAC, else float),
    seconds (None: until silence), and the arguments of a /contact to begin with."""

    rate: int = 48_000
    block: int = 4_096
    format: str | None = None
    seconds: float | None = None
    contact: tuple[Argument, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.rate, SupportsIndex) or not LOWEST_RATE <= int(self.rate) <= HIGHEST_RATE:
            raise RenderError(f"rate = {self.rate}: expected {LOWEST_RATE} to {HIGHEST_RATE} Hz, a whole number")
        if not 1 <= self.block <= 1 << 20:
            raise RenderError(f"block = {self.block}: expected 1 to {1 << 20} frames")
        _require_format(self.format)
        if self.seconds is not None and not 1 / self.rate <= self.seconds <= LONGEST_SCORE:
            raise RenderError(f"seconds = {self.seconds:g}: expected at least a frame and at most {LONGEST_SCORE}")


class _Timeline:
    """When a score's lines are due, and where its render ends. Times are in frames."""

    def __init__(self, score: Sequence[Line], options: Options) -> None:
        self._rate = options.rate
        self._lines = sorted(score, key=lambda line: line.time)
        self._next = 0
        self._tail, self._rest = (self._after(seconds) for seconds in (LONGEST_TAIL, LONGEST_REST))
        self.end = None if options.seconds is None else round(options.seconds * options.rate)
        """Where the render ends, once that is known."""

    def _after(self, seconds: float) -> int:
        """The first quantum that begins no earlier than some seconds after the last line."""
        return -(-round((self._lines[-1].time + seconds) * self._rate) // QUANTUM) * QUANTUM

    def _quantum(self, line: Line) -> int:
        """The beginning of the quantum in which a line is due."""
        return int(sample_at(line.time, self._rate)) // QUANTUM * QUANTUM

    def due(self, position: int) -> Iterator[Line]:
        """The next lines, as far as they are due in the quantum that begins at a position."""
        while self._next < len(self._lines) and self._quantum(self._lines[self._next]) <= position:
            line = self._lines[self._next]
            self._next += 1
            yield line

    def piece(self, written: int, frames: int) -> int:
        """How many of `frames` frames to compute at once: up to the next quantum at which there is something to do."""
        if self._next < len(self._lines):
            stop = self._quantum(self._lines[self._next])
        elif self.end is not None:
            stop = self.end
        elif written < self._tail:
            stop = self._tail
        else:  # every quantum may be the last
            stop = (written // QUANTUM + 1) * QUANTUM
        return min(frames, _PIECE, max(1, stop - written))

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
) -> Iterator[NDArray[np.float32]]:
    """The sound of a score, block by block, each float32 (frames, 2); ScoreError names a line that is refused.

    session: of the engine, if it has one already.
    Without `seconds` the sound ends with the quantum in which the last object falls silent. If all that goes on would
    go on for ever (a press, a roll without friction) it ends LONGEST_TAIL after the last event, and in any case
    LONGEST_REST after it; `warn` is told of either, and of lines that have no effect. The block size does not matter.
    """
    if not score:
        raise RenderError("the score is empty: expected lines of time, address and arguments")
    session = session or Session(engine, presets, steers_ended=True)
    if options.contact:
        _perform(session, Line(0.0, Message("/contact", options.contact), "contact"), warn)
    timeline = _Timeline(score, options)
    written = 0
    while timeline.end is None or written < timeline.end:
        stop = written + options.block if timeline.end is None else min(written + options.block, timeline.end)
        parts = []
        while written < stop:
            for line in timeline.due(engine.position):
                _perform(session, line, warn)
            piece = timeline.piece(written, stop - written)
            parts.append(engine.process(piece))
            written += piece
            timeline.look_for_end(session, warn)
            if timeline.end is not None:
                surplus = max(0, written - timeline.end)
                parts[-1] = parts[-1][: piece - surplus]
                stop = min(stop, timeline.end)
        sound = np.concatenate(parts)
        if len(sound):
            yield sound


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
) -> Engine:
    """Render a score to a WAV or FLAC file, told by its ending; returns the engine, for its counters.

    The file appears under its name once it is whole. `progress` is told the seconds computed, `warn` that the sound
    ends early, as in `blocks`. RenderError, ScoreError or OSError say what went wrong.
    """
    with writing(out, options.rate, options.format) as write:
        engine = Engine(options.rate)
        for sound in blocks(score, engine, presets, options, warn=warn):
            write(sound)
            progress(engine.position / options.rate)
    return engine


@contextmanager
def writing(out: Path, rate: int, format: str | None) -> Iterator[Callable[[NDArray[np.float32]], None]]:
    """A function that appends float32 (frames, 2) to a WAV or FLAC file, told by its ending, at a rate in Hz.

    format: as in Options. The file appears under its name once it is whole. RenderError or OSError say what went wrong.
    """
    container = _ENDINGS.get(out.suffix.lower())
    if container is None:
        raise RenderError(f"{out}: expected a name that ends in {' or '.join(_ENDINGS)}")
    _require_format(format)
    subtype = _SUBTYPES[format or ("24" if container == "FLAC" else "float")]
    if not soundfile.check_format(container, subtype):
        raise RenderError(f"format = {format}: {container} holds 16 or 24")
    if not out.parent.is_dir():
        raise RenderError(f"{out}: there is no folder {out.parent}")
    with _appearing(out) as descriptor:
        with _naming(out):
            file = open_sound(descriptor, rate, container, subtype)

        def write(sound: NDArray[np.float32]) -> None:
            with _naming(out):
                file.write(sound)
            if container == "WAV" and os.fstat(descriptor).st_size > WAV_BYTES:
                raise RenderError(f"{out}: longer than the 4 GiB that a WAV file holds; FLAC holds more")

        try:
            yield write
        finally:
            with _naming(out):
                file.close()


def _require_format(format: str | None) -> None:
    if format not in (None, *_SUBTYPES):
        raise RenderError(f"format = {format}: expected {', '.join(_SUBTYPES)}")


@contextmanager
def _naming(out: Path) -> Iterator[None]:
    """An error of writing inside names the file."""
    try:
        yield
    except soundfile.LibsndfileError as error:
        raise RenderError(f"{out}: {error} Is the disk full?") from error
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(out)) from error


@contextmanager
def _appearing(out: Path) -> Iterator[int]:
    """A new file (its descriptor) that takes its name once it is whole, and is removed if it never is."""
    descriptor, name = tempfile.mkstemp(prefix=f"{out.name}.", suffix=".part", dir=out.parent)
    part = Path(name)
    try:
        yield descriptor
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(part, 0o666 & ~umask)  # mkstemp's are private
        os.replace(part, out)
    finally:
        os.close(descriptor)
        part.unlink(missing_ok=True)
