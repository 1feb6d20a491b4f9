"""The command line: `carom COMMAND ...`, a command for each file in `commands`."""

import argparse
import atexit
import gc
import io
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from typing import Any

from . import errors
from .commands.parser import Command, Parser, parse, parser_of

_COLLECTED_AFTER = 50_000
"""New objects after which the youngest are collected: Python's 700 look through all that a start loads many times."""

NAMES = (
    "serve", "render", "strike", "play", "page", "send", "listen", "top", "presets", "fit", "mesh", "export", "compare",
    "dataset", "chart", "devices", "doctor", "completion",
)  # fmt: skip
"""The names of all commands: each is a file in `commands`."""


def commands(names: Sequence[str] = NAMES) -> tuple[Command, ...]:
    """Return commands of some names."""
    return tuple(import_module(f".commands.{name}", __package__).COMMAND for name in names)


def parsers(names: Sequence[str] = NAMES) -> tuple[Parser, dict[str, Parser]]:
    """Return the parser of the whole line, and those of the commands by name."""
    return parser_of(commands(names))


def _asked(words: Sequence[str]) -> Sequence[str]:
    """Return the names of the commands that words may be about: they alone are loaded."""
    return words[:1] if words and words[0] in NAMES and words[0] != "completion" else NAMES


def main(argv: list[str] | None = None) -> int:
    """Run a command; return the exit code: 0 done, 1 failed (one line on stderr says why), 2 wrong usage."""
    gc.set_threshold(_COLLECTED_AFTER)
    atexit.register(gc.freeze)  # or else Python looks through all objects once more as it ends
    if argv is None:
        _spare_stderr()
    words = sys.argv[1:] if argv is None else argv
    try:
        return _run(parse(*parsers(_asked(words)), words))
    finally:
        try:
            if sys.stdout:
                sys.stdout.flush()
        except OSError:  # it was reported. Without this, Python fails once more as it ends, and returns 120
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _run(arguments: argparse.Namespace) -> int:
    """Run the command that was parsed; return the exit code."""
    try:
        code: int = arguments.run(arguments)
        if sys.stdout:
            sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        return 0  # the reader of the output has left
    except errors.KINDS as error:
        if not errors.is_expected(error):
            raise
        errors.tell(arguments.command, errors.plain(error))
        return 1


class _Spared(io.FileIO):
    """A file whose reader may leave, or whose disk may be full, without a fault of who writes."""

    def write(self, data: Any) -> int:
        with suppress(OSError):
            return super().write(data) or len(data)  # None where it would have to wait
        return len(data)


def _spare_stderr() -> None:
    """Have this process go on where nobody reads its stderr any more: no warning ends a server, nor fails a render."""
    given = sys.stderr or open(os.devnull, "w")  # noqa: SIM115
    sys.stderr = given
    if not isinstance(given, io.TextIOWrapper) or (sys.platform == "win32" and given.isatty()):
        return
    given.flush()
    raw = io.BufferedWriter(_Spared(given.fileno(), "w", closefd=False))
    sys.stderr = io.TextIOWrapper(raw, given.encoding, given.errors, line_buffering=True)
