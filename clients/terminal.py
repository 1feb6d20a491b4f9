"""Lines and screens of a terminal that are written anew, bars and colours."""

import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import TextIO

BOLD, RED, YELLOW = "1", "31", "33"
ALARM = f"{BOLD};{RED}"
"""Styles, as terminals number them."""

_CLEARED = "\r\x1b[K"
_SCREEN, _SCREEN_LEFT = "\x1b[?1049h\x1b[?25l\x1b[?7l", "\x1b[?7h\x1b[?25h\x1b[?1049l"
_TOP, _REST_CLEARED = "\x1b[H", "\x1b[J"
_VIRTUAL_TERMINAL = 4  # of Windows: the console heeds what begins with an escape


def moves(stream: TextIO | None) -> bool:
    """True if a stream goes to a terminal on which text can be written anew."""
    if stream is None or not stream.isatty() or os.environ.get("TERM") == "dumb":
        return False
    if sys.platform == "win32":
        import ctypes
        import msvcrt

        kernel, mode = ctypes.windll.kernel32, ctypes.c_ulong()
        console = msvcrt.get_osfhandle(stream.fileno())
        found = kernel.GetConsoleMode(console, ctypes.byref(mode))
        return bool(found and kernel.SetConsoleMode(console, mode.value | _VIRTUAL_TERMINAL))
    return True


def styled(text: str, style: str) -> str:
    """Return a text in a style; as it is where that is empty."""
    return f"\x1b[{style}m{text}\x1b[0m" if style else text


def bar(share: float, width: int) -> str:
    """Return a bar of so many characters, of which a share is full."""
    full = round(min(max(share, 0.0), 1.0) * width)
    return "#" * full + "-" * (width - full)


def moving_bar(seconds: float, width: int) -> str:
    """Return a bar of so many characters for work that may take any time: a part of it moves to and fro."""
    part, way = width // 5, width - width // 5
    at = round(abs((seconds / 2.0) % 2.0 - 1.0) * way)  # 2 s there, and 2 s back
    return "-" * at + "#" * part + "-" * (way - at)


def clock(seconds: float) -> str:
    """Return a time as hours, minutes and seconds."""
    whole = int(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"


class Line:
    """A line at the bottom of a terminal, written anew; what others write to the stream `above` comes before it."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._lock = Lock()
        self._is_shown = False
        self._is_begun = False  # a line of others, which has no end yet
        self.above = _Above(self)

    def show(self, text: str) -> None:
        """Write the line, cut to the terminal's width; not while somebody else is amid a line."""
        with self._lock:
            if not self._is_begun:
                columns = shutil.get_terminal_size().columns
                self._put(_CLEARED + text[: columns - 1])
                self._is_shown = True

    def write(self, text: str) -> None:
        """Write a text of others in place of the line, which comes after it when it is shown again."""
        with self._lock:
            self._put((_CLEARED if self._is_shown else "") + text)
            self._is_shown = False
            self._is_begun = not text.endswith("\n") if text else self._is_begun

    def clear(self) -> None:
        """Take the line away."""
        self.write("")

    def _put(self, text: str) -> None:
        self._stream.write(text)
        self._stream.flush()


class _Above:
    """A stream to the place above a line."""

    def __init__(self, line: Line) -> None:
        self._line = line

    def write(self, text: str) -> int:
        self._line.write(text)
        return len(text)

    def __getattr__(self, name: str) -> object:
        return getattr(self._line._stream, name)


@contextmanager
def screen(stream: TextIO) -> Iterator["Screen"]:
    """Give a terminal's whole screen to pictures for a while; what stood there comes back."""
    stream.write(_SCREEN)
    try:
        yield Screen(stream)
    finally:
        stream.write(_SCREEN_LEFT)
        stream.flush()


class Screen:
    """The whole of a terminal."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def show(self, lines: list[str]) -> None:
        """Write lines in place of those before, as many as there is room for."""
        room = shutil.get_terminal_size().lines
        self._stream.write(_TOP + "\n".join(f"{line}\x1b[K" for line in lines[:room]) + _REST_CLEARED)
        self._stream.flush()
