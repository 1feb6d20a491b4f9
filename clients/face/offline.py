"""Scores to sounds."""

from collections.abc import Iterable, Sequence
from os import PathLike
from typing import Any

from ._capture import Capture
from ._perform import Folders, Performer
from .clients.actions import Value, plain
from .server.osc.score import LONGEST_SCORE, Line, ScoreError, parse, read
from .server.osc.wire import Message
from .server.render import Options, blocks
from .sound import Sound


def render(
    score: PathLike[str] | str | Iterable[Line | Sequence[Any]],
    rate: int = 48_000,
    *,
    limiter: bool = True,
    seconds: float | None = None,
    stems: bool = False,
    contacts: bool = False,
    contact: str | Sequence[Value] = (),
    presets: Folders = (),
) -> Sound:
    """Render a score, to the bits of `carom render`.

        carom.render("0 /object/new bell church-bell\\n0.1 /object/bell/impact 1.5").save("bell.wav")

    score: a Path to a file of text or of scsynth's binary form, a text, or lines in any order of time, each
    (time in s, address, argument, ...). rate: Hz, 8000 to 192000. seconds: its length (None: until silence).
    limiter, stems, contacts, presets: as for a Scene. contact: how contacts are solved from the start, as the address
    /contact takes it: "verlet", or ("verlet", 4, "correction", "both").
    ScoreError names a line that cannot be read or was refused; RenderError or PresetError say what else cannot be;
    OSError, that the file cannot be read.
    """
    lines = _lines(score)
    choice = (contact,) if isinstance(contact, str) else tuple(map(plain, contact))
    performer = Performer(rate, presets, limiter, stems, contacts, steers_ended=True)
    capture = Capture(performer, 0)
    options = Options(rate=rate, block=capture.step, seconds=seconds, contact=choice)
    for piece in blocks(lines, performer.engine, performer.presets, options, performer.scene, capture.warnings.append):
        capture.add(piece)
    return capture.sound()


def _lines(score: PathLike[str] | str | Iterable[Line | Sequence[Any]]) -> list[Line]:
    if isinstance(score, PathLike):
        return read(score)
    if isinstance(score, str):
        if len(score.split()) == 1 and not score.startswith("#"):
            raise ScoreError(f"{score}: expected a score's text; a file's name is given as pathlib.Path({score!r})")
        return parse(score.encode(), "score")
    return [line if isinstance(line, Line) else _line(line, f"line {n}") for n, line in enumerate(score, 1)]


def _line(line: Sequence[Any], where: str) -> Line:
    match [plain(part) for part in line]:
        case [int() | float() as time, str() as address, *args] if 0 <= time <= LONGEST_SCORE:
            return Line(float(time), Message(address, tuple(args)), where)
    raise ScoreError(f"{where}: {line!r}: expected a time from 0 to {LONGEST_SCORE} s, an address and its arguments")
