"""The command line's reference, from its parsers."""

import argparse
from collections.abc import Sequence

from carom.clients.cli import commands, parsers
from carom.clients.commands.parser import Command
from tests.documents.markdown import table

PLAYING = ("serve", "render", "strike", "play", "page", "send", "listen", "top")


def playing() -> str:
    """Return the reference of the commands that play, or talk to what plays."""
    return _reference([command for command in commands() if command.name in PLAYING])


def others() -> str:
    """Return the reference of all other commands."""
    return _reference([command for command in commands() if command.name not in PLAYING])


def _reference(commands: Sequence[Command]) -> str:
    """Return a section for each command: its usage, what it does, its arguments and options."""
    _, found = parsers()
    sections = []
    for command in commands:
        rows = [(_signature(action), _help(action)) for action in _told(found[command.name])]
        if command.name == "page":
            of_serve = {(_signature(action), _help(action)) for action in _told(found["serve"])}
            rows = [*(row for row in rows if row not in of_serve), ("options of `carom serve`", "as for `carom serve`")]
        head = f"## `carom {command.name}{f' {command.usage}' * bool(command.usage)}`"
        does = f"{command.help[0].upper()}{command.help[1:]}."
        sections.append("\n\n".join([head, does, *([table(("argument or option", "meaning"), rows)] if rows else [])]))
    return "\n\n".join(sections)


def _told(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """Return the arguments and options that need to be told of."""
    return [action for action in parser._actions if action.help and action.dest != "help"]


def _signature(action: argparse.Action) -> str:
    choices = "|".join(map(str, action.choices)) if action.choices else ""
    named = action.metavar or choices or action.dest.upper()
    value = named if isinstance(named, str) else " ".join(named)
    if not action.option_strings:
        return f"`{value}`"
    if action.nargs == 0:
        return f"`{action.option_strings[-1]}`"
    return f"`{action.option_strings[-1]} {f'[{value}]' if action.nargs == '?' else value}`"


def _help(action: argparse.Action) -> str:
    return (action.help or "") % vars(action)
