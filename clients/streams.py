"""Scores from stdin and sounds to stdout, which the word - stands for."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..dsp.errors import CaromError
from ..dsp.wording import listed, near
from ..presets import BUILT_IN
from ..server.files.whole import require_name
from ..server.osc.score import Line, ScoreError, parse, read
from .export.scene_file import MAGIC, require_no_scene

STREAM = "-"
"""Stands for stdin where a file is read, and for stdout where one is written."""


class StreamError(CaromError, RuntimeError):
    """Stdin has no score, or stdout cannot take a sound; the text says why."""


def score_name(word: str) -> str:
    """Return a score's name in errors: its file's name."""
    return "stdin" if word == STREAM else word


def read_score(word: str) -> list[Line]:
    """Read the lines of a score from a file, from stdin, or of one of Carom's own by its name.

    SceneError where the file is a scene that was exported.
    """
    if word != STREAM:
        path = score_path(word)
        with suppress(OSError), path.open("rb") as file:  # an error is told as it is read
            if file.read(len(MAGIC)) == MAGIC:
                require_no_scene(path.read_bytes(), word)
        return read(path)
    if sys.stdin is None:
        raise StreamError("stdin is closed: expected a score there")
    return parse(sys.stdin.buffer.read(), score_name(word))


def score_path(word: str) -> Path:
    """Return the file of a score. A word that is no file's name, and could not be one with a folder or an ending, is
    the name of one of Carom's own; ScoreError, which asks for a near name, if there is none."""
    path = Path(word)
    if path.exists() or path.suffix or path.name != word:
        return path
    own = own_scores()
    if word in own:
        return own[word]
    here = {each.stem: each.name for each in Path().iterdir() if each.is_file()}
    found = near(word, [*here, *own])
    meant = f"did you mean {' or '.join(here.get(name, name) for name in found)}?" if found else ""
    raise ScoreError(f"no score {word!r}: {meant or f'expected a file, or one of {listed(list(own))}'}")


def own_scores() -> dict[str, Path]:
    """Return Carom's own scores: their names and files."""
    return {path.stem: path for path in sorted((BUILT_IN / "scores").glob("*.txt"))}


def require_out(out: str) -> None:
    """Raise RenderError or StreamError for a name to which no sound can be written."""
    if out != STREAM:
        require_name(Path(out))
    elif sys.stdout is None:
        raise StreamError("stdout is closed: expected a program, or a file, that takes WAV")
    elif sys.stdout.isatty():
        raise StreamError("stdout is a terminal: expected a pipe to a program, or a file, that takes WAV")


@contextmanager
def sound_file(out: str) -> Iterator[Path]:
    """Yield the path of a sound file to write. One for stdout goes there once it is whole, as it begins with its
    length."""
    if out != STREAM:
        yield Path(out)
        return
    require_out(out)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "stdout.wav")
        yield path
        with path.open("rb") as file:
            shutil.copyfileobj(file, sys.stdout.buffer)
        sys.stdout.buffer.flush()
