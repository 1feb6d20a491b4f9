"""Offline rendering: a score through the engine into a sound file, or into arrays."""

import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import soundfile
from numpy.typing import NDArray

from ..dsp.engine.state import QUANTUM
from ..dsp.runtime.engine import Engine
from ..presets.library import Presets
from .files.soundfiles import WAV_BYTES, open_sound
from .osc.score import LONGEST_SCORE, Line, ScoreError, sample_at
from .osc.wire import Argument, Message
from .scene.scene import Scene

LOWEST_RATE, HIGHEST_RATE = 8_000, 192_000
LONGEST_TAIL = 600.0
"""s after a score's last event, after which a render ends even if something still sounds."""

_PIECE = 1_024  # frames
_ENDINGS = {".wav": "WAV", ".flac": "FLAC"}
_SUBTYPES = {"16": "PCM_16", "24": "PCM_24", "float": "FLOAT"}


class RenderError(ValueError):
    """A render that can't be made; the text says why."""


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
        if not LOWEST_RATE <= self.rate <= HIGHEST_RATE:
            raise RenderError(f"rate = {self.rate}: expected {LOWEST_RATE} to {HIGHEST_RATE} Hz")
        if not 1 <= self.block <= 1 << 20:
            raise RenderError(f"block = {self.block}: expected 1 to {1 << 20} frames")
        if self.format not in (None, *_SUBTYPES):
            raise RenderError(f"format = {self.format}: expected {', '.join(_SUBTYPES)}")
        if self.seconds is not None and not 1 / self.rate <= self.seconds <= LONGEST_SCORE:
            raise RenderError(f"seconds = {self.seconds:g}: expected at least a frame and at most {LONGEST_SCORE}")


def blocks(score: Sequence[Line], engine: Engine, presets: Presets, options: Options) -> Iterator[NDArray[np.float32]]:
    """The sound of a score, block by block, each float32 (frames, 2); ScoreError names a line that is refused.

    Without `seconds` it ends with the quantum in which the last sound ends, whatever the block size.
    """
    if not score:
        raise RenderError("the score is empty: expected lines of time, address and arguments")
    scene = Scene(engine, presets)
    if options.contact:
        _perform(scene, Line(0.0, Message("/contact", options.contact), "contact"))
    lines = sorted(score, key=lambda line: line.time)
    tail = round((lines[-1].time + LONGEST_TAIL) * options.rate)
    end = round(options.seconds * options.rate) if options.seconds is not None else None
    written = 0
    performed = 0
    while end is None or written < end:
        frames = options.block if end is None else min(options.block, end - written)
        parts = []
        while frames > 0:
            # A line meets the engine at its own quantum, whatever the block size.
            while performed < len(lines) and sample_at(lines[performed].time, options.rate) < engine.position + QUANTUM:
                _perform(scene, lines[performed])
                performed += 1
            piece = min(frames, _PIECE)
            if performed < len(lines):
                piece = min(piece, max(1, _quantum_of(sample_at(lines[performed].time, options.rate)) - written))
            parts.append(engine.process(piece))
            written += piece
            frames -= piece
            if end is None and performed == len(lines) and (engine.quiet() or engine.position > tail):
                sounded = max(engine.counter("sounded"), _quantum_of(sample_at(lines[-1].time, options.rate)) + QUANTUM)
                end = min(sounded, tail)
                surplus = max(0, written - end)
                parts[-1] = parts[-1][: piece - surplus]
                frames = min(frames, max(0, end - written))
        sound = np.concatenate(parts)
        if len(sound):
            yield sound


def _quantum_of(sample: float) -> int:
    """Where the quantum of a sample begins."""
    return int(sample) // QUANTUM * QUANTUM


def _perform(scene: Scene, line: Line) -> None:
    if scene.engine.room() == 0:
        raise ScoreError(f"{line.where}: too many events at once: {len(scene.engine.state['ring'][0])} at most")
    for reply in scene.perform([line.message], sample_at(line.time, scene.engine.rate)):
        if reply.address == "/fail":
            raise ScoreError(f"{line.where}: {': '.join(map(str, reply.args))}")


def render(
    score: Sequence[Line],
    out: Path,
    presets: Presets,
    options: Options,
    progress: Callable[[float], None] = lambda seconds: None,
) -> Engine:
    """Render a score to a WAV or FLAC file, told by its ending; returns the engine, for what it counted.

    The file appears under its name once it is whole. RenderError, ScoreError or OSError say what went wrong.
    """
    container = _ENDINGS.get(out.suffix.lower())
    if container is None:
        raise RenderError(f"{out}: expected a name that ends in {' or '.join(_ENDINGS)}")
    subtype = _SUBTYPES[options.format or ("24" if container == "FLAC" else "float")]
    if not soundfile.check_format(container, subtype):
        raise RenderError(f"format = {options.format}: {container} holds 16 or 24")
    if not out.parent.is_dir():
        raise RenderError(f"{out}: there is no folder {out.parent}")
    engine = Engine(options.rate)
    with _appearing(out) as descriptor:
        try:
            with open_sound(descriptor, options.rate, container, subtype) as file:
                for sound in blocks(score, engine, presets, options):
                    file.write(sound)
                    progress(engine.position / options.rate)
                    if container == "WAV" and os.fstat(descriptor).st_size > WAV_BYTES:
                        raise RenderError(f"{out}: longer than the 4 GiB that a WAV file holds; FLAC holds more")
        except soundfile.LibsndfileError as error:
            raise RenderError(f"{out}: {error} Is the disk full?") from error
    return engine


@contextmanager
def _appearing(out: Path) -> Iterator[int]:
    """A new file (its descriptor) that takes its name once it is whole, and is gone if it never is."""
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
