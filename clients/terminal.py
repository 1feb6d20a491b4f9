"""A terminal that can be written anew: bars, colours and screens of it."""

import os
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

BOLD, RED, YELLOW = "1", "31", "33"
ALARM = f"{BOLD};{RED}"
"""Styles, as terminals number them."""

_SCREEN, _SCREEN_LEFT = "\x1b[?1049h\x1b[?25l\x1b[?7l", "\x1b[?7h\x1b[?25h\x1b[?1049l"
_TOP, _REST_CLEARED = "\x1b[H", "\x1b[J"


def moves(stream: TextIO | None) -> bool:
    """True if a stream goes to a terminal on which text can be written anew."""
    if stream is None or not stream.isatty() or os.environ.get("TERM") == "dumb":
        return False
    if sys.platform == "win32":
        from colorama import just_fix_windows_console

        just_fix_windows_console()
    return True


def styled(text: str, style: str) -> str:
    """Return a text in a style; as it is where that is empty."""
    return f"\x1b[{style}m{text}\x1b[0m" if style else text


def bar(share: float, width: int) -> str:
    """Return a bar of so many characters, of which a share is full."""
    full = round(min(max(share, 0.0), 1.0) * width)
    return "#" * full + "-" * (width - full)


def clock(seconds: float) -> str:
    """Return a time as hours, minutes and seconds."""
    whole = int(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"


@contextmanager
def screen(stream: TextIO) -> Iterator[Callable[[list[str]], None]]:
    """Give a terminal's whole screen to pictures for a while; what stood there comes back.

    Yield a function that shows lines in place of those before, as many as there is room for.
    """

    def show(lines: list[str]) -> None:
        room = shutil.get_terminal_size().lines
        stream.write(_TOP + "\n".join(f"{line}\x1b[K" for line in lines[:room]) + _REST_CLEARED)
        stream.flush()

    stream.write(_SCREEN)
    try:
        yield show
    finally:
        stream.write(_SCREEN_LEFT)
        stream.flush()
