"""The command line: `carom COMMAND ...`, a command for each file in `commands`."""

import os
import sys

from . import errors
from .commands import (
    chart,
    compare,
    completion,
    dataset,
    devices,
    doctor,
    export,
    fit,
    listen,
    mesh,
    page,
    play,
    presets,
    render,
    send,
    serve,
    strike,
    top,
)
from .commands.parser import Parser, parse, parser_of

_MODULES = (
    serve, render, strike, play, page, send, listen, top, presets, fit, mesh, export, compare, dataset, chart, devices,
    doctor, completion,
)  # fmt: skip
COMMANDS = tuple(module.COMMAND for module in _MODULES)


def parsers() -> tuple[Parser, dict[str, Parser]]:
    """Return the parser of the whole line, and those of the commands by name."""
    return parser_of(COMMANDS)


def main(argv: list[str] | None = None) -> int:
    """Run a command; return the exit code: 0 done, 1 failed (one line on stderr says why), 2 wrong usage."""
    arguments = parse(*parsers(), sys.argv[1:] if argv is None else argv)
    try:
        code: int = arguments.run(arguments)
        return code
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        # The reader of the output has left. Without this, Python complains once more as it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except errors.KINDS as error:
        if not errors.is_expected(error):
            raise
        errors.tell(arguments.command, errors.plain(error))
        return 1
