"""carom completion: print a script by which your shell completes commands and options.

shtab writes it from the parser itself, for bash, zsh, fish, tcsh and PowerShell. The script is static, so that a shell
starts no Python to complete an option; only the names of presets are requested, as they may change.
"""

import argparse

from .parser import Command, one_of

SHELLS = ("bash", "zsh", "fish", "tcsh", "powershell")


_FILES = ("score", "scores", "recipe", "recordings", "a", "b", "force", "page", "out", "plot", "record", "log")
"""Arguments that are files."""


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS, type=one_of(*SHELLS), help=", ".join(SHELLS))


def _run(arguments: argparse.Namespace) -> int:
    import shtab

    parser, commands = arguments.parsers
    for name, command in commands.items():
        for action in command.actions():
            _choose(name, action)
    print(shtab.complete(parser, arguments.shell))
    return 0


def _choose(command: str, action: argparse.Action) -> None:
    """Say how a shell finds the words for an argument: its files, its folders or the names of presets."""
    import shtab

    found: object = None
    if command == "presets" and action.dest == "names":
        found = shtab.cmd("carom presets --names")
    elif command == "send" and action.dest == "address":
        from ...server.osc.addresses import VERBS

        action.choices = tuple(VERBS)
    elif action.dest in ("preset", "striker"):
        found = shtab.cmd(f"carom presets --names {'objects' if action.dest == 'preset' else 'strikers'}")
    elif action.dest in ("folder", "presets") or (command == "dataset" and action.dest == "out"):
        found = shtab.DIRECTORY
    elif action.dest in _FILES:
        found = shtab.FILE
    if found:
        action.complete = found  # type: ignore[attr-defined]


COMMAND = Command(
    "completion", "SHELL", "print a script by which your shell completes commands and options", _options, _run
)
