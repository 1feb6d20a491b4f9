"""Scores to sounds."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from ._capture import Capture
from .clients.actions import plain
from .clients.performer import Folders, Performer
from .dsp.arguments import explain_arguments
from .server.osc.score import LONGEST_SCORE, Line, ScoreError, parse, read
from .server.osc.wire import Message
from .server.render import Options, blocks
from .sound import Sound


@explain_arguments
def render(
    score: PathLike[str] | str | Iterable[Line | Sequence[Any]],
    rate: int = 48_000,
    *,
    limiter: bool | None = None,
    gain: float | None = None,
    channels: int | None = None,
    full_scale: float | None = None,
    calibrated: bool = False,
    normalize: float | None = None,
    seconds: float | None = None,
    stems: bool = False,
    contacts: bool = False,
    presets: Folders = (),
) -> Sound:
    r"""Render a score, to the bits of `carom render`.

    Parameters
    ----------
    score : Path, str or list
        File of a text or binary score; a text; or lines (time in s, address, argument, ...) in any order.
    rate : int, default 48000
        Sampling rate in Hz, 8000 to 192000.
    limiter, gain, channels, full_scale : optional
        As for a Scene. Default: as the score sets them at time 0.
    calibrated, stems, contacts, presets : optional
        As for a Scene.
    normalize : float, optional
        Peak of the sound, dB of full scale. There is then no limiter, unless `limiter` is True.
    seconds : float, optional
        Length in s. Default: until silence.

    Returns
    -------
    Sound
        Its `samples` are float32 (frames, channels).

    Raises
    ------
    ScoreError
        A line cannot be read, or is refused; the text names it.
    RenderError, PresetError, OSError
        Another argument is refused, or a file cannot be read; the text says why.

    Examples
    --------
    >>> import carom
    >>> sound = carom.render("0 /object/new bell church-bell\n0.1 /object/bell/impact 1.5", seconds=1.0)
    >>> sound.duration
    1.0
    """
    lines = _lines(score)
    options = Options(
        rate, seconds=plain(seconds), channels=plain(channels), gain=plain(gain), limiter=limiter,
        calibrated=calibrated, normalize=plain(normalize), full_scale=plain(full_scale),
    )  # fmt: skip
    performer = Performer(options, lines, presets, stems, contacts, steers_ended=True)
    capture = Capture(performer, 0)
    options = replace(options, block=capture.step)
    for piece in blocks(lines, performer.engine, performer.presets, options, performer.scene, capture.warnings.append):
        capture.add(piece)
    return _normalized(capture, options)


def _normalized(capture: Capture, options: Options) -> Sound:
    """Normalize the sound that was captured to the peak that is requested."""
    gain = options.gain_of(capture.peak, capture.warnings.append)
    sound = capture.sound()
    if options.normalize is None:
        return sound
    stems = sound.stems and {name: stem * np.float32(gain) for name, stem in sound.stems.items()}
    report = replace(sound.report, normalized_db=20.0 * math.log10(gain))
    return replace(sound, samples=sound.samples * np.float32(gain), stems=stems, report=report)


def _lines(score: PathLike[str] | str | Iterable[Line | Sequence[Any]]) -> list[Line]:
    if isinstance(score, PathLike):
        return read(score)
    if isinstance(score, str):
        if len(score.split()) == 1 and not score.startswith("#"):
            raise ScoreError(f"{score}: expected a score's text; a file's name is given as pathlib.Path({score!r})")
        try:
            return parse(score.encode(), "score")
        except UnicodeEncodeError as error:
            line = score.count("\n", 0, error.start) + 1
            raise ScoreError(f"score:{line}: {score[error.start]!a} is half a character") from None
    if not isinstance(score, Iterable):
        raise ScoreError(f"score = {score!r}: expected a score's text, a path of its file, or its lines")
    return [line if isinstance(line, Line) else _line(line, f"line {n}") for n, line in enumerate(score, 1)]


def _line(line: Sequence[Any], where: str) -> Line:
    match [plain(part) for part in line] if isinstance(line, Iterable) else []:
        case [int() | float() as time, str() as address, *args] if 0 <= time <= LONGEST_SCORE:
            return Line(float(time), Message(address, tuple(args)), where)
    raise ScoreError(f"{where}: {line!r}: expected a time from 0 to {LONGEST_SCORE} s, an address and its arguments")
