"""Scores: OSC messages with times, as lines of text, or in the binary form of scsynth's non-real-time mode.

A line is `time address arguments`: seconds, then words with blanks between. Numbers are int or float; every
other word, and any word in quotes, is a string. Single quotes keep what is between them, double quotes read
escapes as JSON does. A word that starts with # makes the rest of the line a comment.
"""

import io
import json
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from . import wire

_WORD = r"""[^\s"'#][^\s"']*"""
_TOKEN = re.compile(
    rf"""\s*(?:(?P<comment>\#.*)|"(?P<escaped>(?:[^"\\]|\\.)*)"|'(?P<kept>[^']*)'|(?P<word>{_WORD}))(?=\s|$)"""
)
_INT = re.compile(r"[+-]?\d+", re.ASCII)
_REAL = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)


LONGEST_SCORE = 31 * 86_400
"""s: no event lies further from the start."""


_GRID = 256.0  # places between two samples where the engine lets what was played live fall


class ScoreError(ValueError):
    """A score that cannot be read: "FILE:LINE: reason"."""


@dataclass(frozen=True)
class Line:
    """A message, its time (s) and where it stands ("FILE:LINE")."""

    time: float
    message: wire.Message
    where: str


def read(path: str | PathLike[str]) -> list[Line]:
    """Reads a text or binary score, in the order of the file; in a binary one LINE counts packets.

    Raises ScoreError, and OSError for a file that cannot be read.
    """
    data = Path(path).read_bytes()
    # A binary score starts with a size below 16 MB, so with a zero, which no text has.
    return list(_binary(data, path) if data.startswith(b"\0") else _text(data, path))


def _text(data: bytes, path: str | PathLike[str]) -> Iterator[Line]:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ScoreError(f"{path}:{line}: byte {data[error.start]:#04x} is not UTF-8") from None
    for number, line_text in enumerate(io.StringIO(text, newline=None), 1):
        where = f"{path}:{number}"
        try:
            words = list(_words(line_text))
            if words:
                yield Line(_time(words[0]), _message(words[1:]), where)
        except ValueError as error:
            raise ScoreError(f"{where}: {error}") from None


def _words(line: str) -> Iterator[wire.Argument]:
    line = line.rstrip()
    at = 0
    while at < len(line):
        token = _TOKEN.match(line, at)
        if token is None:
            raise ValueError(f"column {at + 1}: a quote that is not closed, or not between blanks")
        at = token.end()
        if token["comment"] is not None:
            return
        if token["word"] is not None:
            yield value(token["word"])
        elif token["kept"] is not None:
            yield token["kept"]
        else:
            yield json.loads(f'"{token["escaped"]}"', strict=False)


def value(word: str) -> int | float | str:
    """The number that a bare word of a score spells, or else the word."""
    if _INT.fullmatch(word):
        return int(word)
    return float(word) if _REAL.fullmatch(word) else word


def _time(word: wire.Argument) -> float:
    if isinstance(word, int | float) and 0 <= word <= LONGEST_SCORE:
        return float(word)
    raise ValueError(f"time {word!r}: expected seconds from 0 to {LONGEST_SCORE}")


def _message(words: list[wire.Argument]) -> wire.Message:
    match words:
        case [str(address), *args]:
            for arg in args:
                if isinstance(arg, float) and not math.isfinite(arg):
                    raise ValueError(f"a number in {address} is too large")
            wire.encode(address, *args, real="d")  # so that whatever a score says could also have been sent
            return wire.Message(address, tuple(args))
        case [other, *_]:
            raise ValueError(f"address {other!r}: expected it to start with /")
    raise ValueError("no address after the time")


def _binary(data: bytes, path: str | PathLike[str]) -> Iterator[Line]:
    start, number = 0, 0
    while start < len(data):
        number += 1
        where = f"{path}:{number}"
        size = int.from_bytes(data[start : start + 4], "big")
        packet = data[start + 4 : start + 4 + size]
        if len(packet) < size or start + 4 > len(data):
            raise ScoreError(f"{where}: the file ends inside the packet")
        try:
            for bundle in wire.parse(packet):
                # Here a time tag counts from the start of the score, and 1 (at once) is that start.
                time = _time(0.0 if bundle.time == wire.IMMEDIATELY else bundle.time / 2**32)
                for message in bundle.messages:
                    yield Line(time, message, where)
        except ValueError as error:
            raise ScoreError(f"{where}: {error}") from None
        start += 4 + size


def sample_at(time: float, rate: float) -> float:
    """The sample at which a score's time (s) falls; one that is on the engine's grid, but for rounding, is there."""
    sample = time * rate
    nearest = round(sample * _GRID) / _GRID
    return nearest if abs(sample - nearest) <= 4 * math.ulp(sample) else sample


def format_line(time: float, message: wire.Message) -> str:
    """The line of text that reads back as this time (s) and message, bit for bit; booleans become 1 and 0.

    Raises ValueError for what text has no word for: bytes, None, NaN and infinities.
    """
    return " ".join([repr(_time(time)), *map(_written, (message.address, *message.args))])


def _written(arg: wire.Argument) -> str:
    if isinstance(arg, str):
        bare = re.fullmatch(_WORD, arg) and isinstance(value(arg), str)
        return arg if bare else json.dumps(arg, ensure_ascii=False)
    if isinstance(arg, int):
        return str(int(arg))
    if isinstance(arg, float) and math.isfinite(arg):
        return repr(float(arg))
    raise ValueError(f"{arg!r} cannot stand in a score: expected a string or a finite number")
