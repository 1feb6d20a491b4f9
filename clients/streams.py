"""Scores from stdin and sounds to stdout, which the word - stands for."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType

from ..dsp.errors import CaromError
from ..dsp.wording import listed, near
from ..presets import BUILT_IN
from ..server.files.whole import require_name
from ..server.midi.midi_file import ANY, HEAD, score_of
from ..server.osc.score import Line, ScoreError, parse
from .export.scene_file import MAGIC, require_no_scene

_CHANNELS = 16
STREAM = "-"
"""Stands for stdin where a file is read, and for stdout where one is written."""


class StreamError(CaromError, RuntimeError):
    """Stdin has no score, or stdout cannot take a sound; the text says why."""


def score_name(word: str) -> str:
    """Return a score's name in errors: its file's name."""
    return "stdin" if word == STREAM else word


def read_score(word: str, objects: Mapping[int, str] = MappingProxyType({})) -> list[Line]:
    """Read the lines of a score from a file, from stdin, or of one of Carom's own by its name.

    objects: presets that play the channels of a MIDI file, as `score_of` takes them. SceneError where the file is a
    scene that was exported.
    """
    if word != STREAM:
        path = score_path(word)
        data = path.read_bytes()
        if data.startswith(MAGIC):
            require_no_scene(data, word)
        return _parsed(data, str(path), objects)
    if sys.stdin is None:
        raise StreamError("stdin is closed: expected a score there")
    return _parsed(sys.stdin.buffer.read(), score_name(word), objects)


def _parsed(data: bytes, name: str, objects: Mapping[int, str]) -> list[Line]:
    if not data.startswith(HEAD):
        if objects:
            raise ScoreError(f"{name}: expected a MIDI file, as --object plays its notes")
        return parse(data, name)
    if not objects:
        raise ScoreError(f"{name}: it is a MIDI file: expected --object PRESET, which plays it")
    try:
        return score_of(data, name, objects)
    except ModuleNotFoundError as error:
        raise StreamError(f"{name}: {error.name} is missing: pip install 'carom[midi]'") from None


def playing(words: Sequence[str]) -> dict[int, str]:
    """Return the presets that play the channels of a MIDI file, from words such as `tom` and `10:tom`. ScoreError names
    one that cannot be."""
    found: dict[int, str] = {}
    for word in words:
        channel, colon, preset = word.rpartition(":")
        number = int(channel) if channel.isdecimal() else ANY
        if not preset or (colon and not 1 <= number <= _CHANNELS):
            raise ScoreError(f"object = {word}: expected a preset, or a channel from 1 to {_CHANNELS} as in 10:tom")
        if number in found:
            raise ScoreError(f"object = {word}: {found[number]} plays these notes already")
        found[number] = preset
    return found


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
