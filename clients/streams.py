"""Scores from stdin and sounds to stdout, which the word - stands for."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..server.osc.score import Line, parse, read

STREAM = "-"
"""Stands for stdin where a file is read, and for stdout where one is written."""


class StreamError(RuntimeError):
    """Stdout cannot take a sound; the text says why."""


def score_name(word: str) -> str:
    """How errors call a score: by its file's name."""
    return "stdin" if word == STREAM else word


def read_score(word: str) -> list[Line]:
    """The lines of a score from a file, or from stdin."""
    return parse(sys.stdin.buffer.read(), score_name(word)) if word == STREAM else read(word)


@contextmanager
def sound_file(out: str) -> Iterator[Path]:
    """The path of a sound file to write. One for stdout goes there once it is whole, as it begins with its length."""
    if out != STREAM:
        yield Path(out)
        return
    if sys.stdout.isatty():
        raise StreamError("stdout is a terminal: expected a pipe to a program, or a file, that takes WAV")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "stdout.wav")
        yield path
        with path.open("rb") as file:
            shutil.copyfileobj(file, sys.stdout.buffer)
        sys.stdout.buffer.flush()
