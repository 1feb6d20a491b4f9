"""Scores: OSC messages with times, as lines of text, or in the binary form of scsynth's non-real-time mode.

A line is `time address arguments`: seconds, then words with blanks between. Numbers are int or float; every
other word, and any word in quotes, is a string. Single quotes keep what is between them, double quotes read
escapes as JSON does. [ and ] enclose a list, with blanks or commas between its items: [free clamped], [440, 881.5].
A word that starts with # makes the rest of the line a comment.
"""

import gc
import io
import json
import math
import re
from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from ...dsp.errors import CaromError
from ...dsp.numerics.constants import GRID
from . import wire

_WORD = r"""[^\s"'#\[\]][^\s"']*"""
_LISTED_WORD = r"""[^\s"'#\[\],][^\s"'\[\],]*"""
_QUOTED = r""""(?P<escaped>(?:[^"\\]|\\.)*)"|'(?P<kept>[^']*)'"""
_TOKEN = re.compile(rf"\s*(?:(?P<comment>\#.*)|(?P<open>\[)|(?:{_QUOTED}|(?P<word>{_WORD}))(?=\s|$))")
_ITEM = re.compile(rf"[\s,]*(?:(?P<open>\[)|(?P<close>\])|(?:{_QUOTED}|(?P<word>{_LISTED_WORD}))(?=[\s,\]]|$))")
_BLANK = re.compile(r"\s|$")
_PLAIN = re.compile(r"""[^"'#\[\]]*""")
_NUMERIC = frozenset("+-.0123456789")
"""Signs with which a number can begin."""
_NUMBER = re.compile(r"[+-]?(?:\d+(?![\d.eE])|(\d+(?:\.\d*)?(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?))", re.ASCII)
"""A number; its group is there unless it is an integer."""


LONGEST_SCORE = 31 * 86_400
"""s: no event lies further from the start."""


_SOUNDS = (b"RIFF", b"RF64", b"fLaC", b"OggS", b"FORM", b"ID3")
"""First bytes of sound files."""


END = "/end"
"""The address that ends a score's render."""

_END_MARKS = (wire.Message("/c_set", (0, 0)), wire.Message("/none"))
"""Messages that do nothing, by which SuperCollider's scores end."""

_COMMAND_0 = b"\0\0\0\0,\0\0\0", b"\0\0\0\0"
_NONE = wire.encode("/none")
_NONE_SIZE = len(_NONE).to_bytes(4, "big")


class ScoreError(CaromError, ValueError):
    """A score that cannot be read: "FILE:LINE: reason"."""


class Line(NamedTuple):
    """A message, its time (s) and where it stands ("FILE:LINE")."""

    time: float
    message: wire.Message
    where: str


def read(path: str | PathLike[str]) -> list[Line]:
    """Read a text or binary score, in the order of the file; in a binary one LINE counts packets.

    Raises ScoreError, and OSError for a file that cannot be read.
    """
    return parse(Path(path).read_bytes(), path)


def parse(data: bytes, path: str | PathLike[str]) -> list[Line]:
    """Read a score's bytes as `read` does; errors call it `path`."""
    if data.startswith(_SOUNDS):
        raise ScoreError(f"{path}: it is a sound; expected a score")
    collects = gc.isenabled()
    gc.disable()  # lines are no garbage: to look through millions of them for such takes a third of the time
    try:
        # A binary score starts with a size below 16 MB, so with a zero, which no text has.
        return list(_binary(data, path) if data.startswith(b"\0") else _text(data, path))
    finally:
        if collects:
            gc.enable()


def _text(data: bytes, path: str | PathLike[str]) -> Iterator[Line]:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ScoreError(f"{path}:{line}: byte {data[error.start]:#04x} is not UTF-8") from None
    for number, line_text in enumerate(io.StringIO(text, newline=None), 1):
        where = f"{path}:{number}"
        try:
            words = _words(line_text)
            if words:
                yield Line(_time(words[0]), _message(words[1:]), where)
        except ValueError as error:
            raise ScoreError(f"{where}: {error}") from None


def _words(line: str) -> list[wire.Argument]:
    if _PLAIN.fullmatch(line):  # as most often: in a third of the time
        return [_number_or_word(word) for word in line.split()]
    line = line.rstrip()
    words: list[wire.Argument] = []
    at = 0
    while at < len(line):
        token = _TOKEN.match(line, at)
        if token is None:
            raise ValueError(f"column {at + 1}: a quote that is not closed, or a quote or ] that is not between blanks")
        if token["comment"] is not None:
            break
        if token["open"] is not None:
            items, at = _list(line, token.end())
            words.append(items)
        else:
            words.append(_spelled(token))
            at = token.end()
    return words


def _list(line: str, at: int) -> tuple[wire.Argument, int]:
    """Return the list whose [ ends at a place of a line, and where it ends itself."""
    start = at
    lists: list[list[wire.Argument]] = [[]]  # those that are open, each inside the one before
    while True:
        item = _ITEM.match(line, at)
        if item is None:
            raise ValueError(f"column {start}: a list that is not closed, or has a quote or # inside a word")
        at = item.end()
        if item["open"] is not None:
            if len(lists) == wire.MAX_DEPTH:
                raise ValueError(f"column {at}: lists nested deeper than {wire.MAX_DEPTH}")
            lists.append([])
        elif item["close"] is None:
            lists[-1].append(_spelled(item))
        else:
            items = tuple(lists.pop())
            if not lists:
                break
            lists[-1].append(items)
    if not _BLANK.match(line, at):
        raise ValueError(f"column {at + 1}: expected a blank after a list")
    return items, at


def _spelled(token: re.Match[str]) -> wire.Argument:
    """Return the value of a word, in quotes or not."""
    if token["word"] is not None:
        return _number_or_word(token["word"])
    return token["kept"] if token["kept"] is not None else json.loads(f'"{token["escaped"]}"', strict=False)


def value(text: str) -> wire.Argument:
    """Return the number or the list that a text spells as in a score, or else the text."""
    if text.startswith("["):
        try:
            items, end = _list(text, 1)
        except ValueError:
            return text
        return text if text[end:].strip() else items
    return _number_or_word(text)


def _number_or_word(word: str) -> int | float | str:
    """Return the number that a word spells, or else the word: one that no float can hold is none."""
    if word[:1] not in _NUMERIC or not (found := _NUMBER.fullmatch(word)):
        return word
    if found[1] is None:
        return int(word)
    number = float(word)
    return number if math.isfinite(number) else word


def _time(word: wire.Argument) -> float:
    if isinstance(word, int | float) and 0 <= word <= LONGEST_SCORE:
        return float(word)
    comma = isinstance(word, str) and isinstance(_number_or_word(word.replace(",", ".")), int | float)
    sign = ", with a decimal point" if comma else ""
    raise ValueError(f"time {word!r}: expected seconds from 0 to {LONGEST_SCORE}{sign}")


def _message(words: list[wire.Argument]) -> wire.Message:
    if not words:
        raise ValueError("no address after the time")
    address, *args = words
    if not isinstance(address, str):
        raise ValueError(f"address {address!r}: expected it to start with /")
    wire.require_sendable(address, args)  # so that whatever a score says could also have been sent
    return wire.Message(address, tuple(args))


def _binary(data: bytes, path: str | PathLike[str]) -> list[Line]:
    """Return the lines of a binary score. The last bundle of scsynth's scores, which does nothing, is their end: the
    like with anything later are dropped."""
    lines = list(_binary_lines(data, path))
    last = max((line.time for line in lines if line.message not in _END_MARKS), default=0.0)
    end = max((line.time for line in lines if line.message in _END_MARKS), default=0.0)
    found = []
    for line in lines:
        if line.message not in _END_MARKS:
            found.append(line)
        elif line.time == end >= last:
            found.append(line._replace(message=wire.Message(END)))
    return found


def _binary_lines(data: bytes, path: str | PathLike[str]) -> Iterator[Line]:
    start, number = 0, 0
    while start < len(data):
        number += 1
        where = f"{path}:{number}"
        size = int.from_bytes(data[start : start + 4], "big")
        packet = data[start + 4 : start + 4 + size]
        if len(packet) < size or start + 4 > len(data):
            raise ScoreError(f"{where}: the file ends inside the packet")
        try:
            if packet[:8] == wire.BUNDLE and packet[20:] in _COMMAND_0:  # [time, [0]]: no address that can be read
                packet = packet[:16] + _NONE_SIZE + _NONE
            for bundle in wire.parse(packet):
                # Here a time tag counts from the start of the score, and 1 (at once) is that start.
                time = _time(0.0 if bundle.time == wire.IMMEDIATELY else bundle.time / 2**32)
                for message in bundle.messages:
                    yield Line(time, message, where)
        except ValueError as error:
            raise ScoreError(f"{where}: {error}") from None
        start += 4 + size


def on_grid(sample: float) -> float:
    """Return the sample nearest to one where an event that is played live may fall: a log's seconds name it exactly."""
    return round(sample * GRID) / GRID


def sample_at(time: float, rate: float) -> float:
    """Return the sample at which a score's time (s) falls; one that is on the engine's grid, but for rounding, is
    there."""
    sample = time * rate
    nearest = on_grid(sample)
    return nearest if abs(sample - nearest) <= 4 * math.ulp(sample) else sample


def format_line(time: float, message: wire.Message) -> str:
    """Return the line of text that reads back as this time (s) and message, bit for bit; booleans become 1 and 0.

    Raises ValueError for what text has no word for: bytes, None, NaN and infinities.
    """
    return " ".join([repr(_time(time)), *(_written(arg, _WORD) for arg in (message.address, *message.args))])


def _written(arg: wire.Argument, bare_word: str) -> str:
    """Return an argument as text; a string needs no quotes if it matches `bare_word` and spells no number."""
    if isinstance(arg, tuple):
        return f"[{' '.join(_written(item, _LISTED_WORD) for item in arg)}]"
    if isinstance(arg, str):
        bare = re.fullmatch(bare_word, arg) and isinstance(_number_or_word(arg), str)
        return arg if bare else json.dumps(arg, ensure_ascii=False)
    if isinstance(arg, int):
        return str(int(arg))
    if isinstance(arg, float) and math.isfinite(arg):
        return repr(float(arg))
    raise ValueError(f"{arg!r} cannot stand in a score: expected a string, a finite number or a list of such")
