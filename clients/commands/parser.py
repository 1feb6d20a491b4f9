"""The parser of the command line: an error is one line with the culprit, the near word and the command's usage."""

import argparse
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from ...dsp.wording import expected, suggestion
from ..folding import columns_of, folded

_VALUE = re.compile(r"[-+]?\d*\.?\d+([eE][-+]?\d+)?")  # a number
_NUMBER = re.compile(r"-\.?\d")  # how a negative number begins, "-3.5e-1" too, and what no option looks like


class Command(NamedTuple):
    """A command: its name, its arguments as the usage shows them, a line of help, its options, and what it does.

    `run` returns the exit code. Its errors are printed in one line if they are Carom's own or the system's.
    """

    name: str
    usage: str
    help: str
    add_options: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int]


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, and which takes options and arguments in any order."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**{"allow_abbrev": False, **options})

    def error(self, message: str) -> NoReturn:
        """End with the error and the usage of this command in one line, folded on a terminal."""
        line = f"{self.prog}: {message} ({' '.join(self.format_usage().split())})"
        self.exit(2, folded(line, columns_of(sys.stderr)) + "\n")

    def actions(self) -> list[argparse.Action]:
        """Return the options and arguments of the command."""
        return list(self._actions)

    def ordered(self, words: Sequence[str]) -> list[str]:
        """Return the words with options first, then -- and the arguments, as argparse then takes each for what it is.

        A word that begins with - is an option, but for -, negative numbers and those after --. It is an error if there
        is no such option.
        """
        known = {option: action for action in self._actions for option in action.option_strings}
        options: list[str] = []
        others: list[str] = []
        waiting = list(reversed(words))
        while waiting:
            word = waiting.pop()
            name, equals, _ = word.partition("=")
            if word == "--":
                others += reversed(waiting)
                break
            if not _is_option(word):
                others.append(word)
            elif name not in known:
                self.error(f"{name}: no such option; {_options(name, known)}")
            elif isinstance(number := known[name].nargs, int) and number > 1:
                values = (waiting.pop() for _ in range(number) if waiting and not _is_option(waiting[-1]))
                options += [word, *values]
            elif equals or not waiting or _is_option(waiting[-1]) or not _takes(known[name], waiting[-1]):
                options.append(word)
            else:
                options.append(f"{word}={waiting.pop()}")
        self._require_room(others)
        return [*options, "--", *others] if others else options

    def _require_room(self, words: Sequence[str]) -> None:
        """End with an error if there are more arguments than the command takes."""
        actions = [action for action in self._actions if not action.option_strings]
        if len(words) > len(actions) and not any(action.nargs in ("*", "+") for action in actions):
            self.error(f"{words[len(actions)]}: one argument too many")


def _is_option(word: str) -> bool:
    return word.startswith("-") and word != "-" and not _NUMBER.match(word)


def _takes(option: argparse.Action, word: str) -> bool:
    """True if an option takes the word that follows. One whose value may be left out takes a number, and to refuse it a
    word that is no file's name."""
    if option.nargs != "?":
        return option.nargs != 0
    return bool(_VALUE.fullmatch(word)) or (word.isalpha() and not Path(word).exists())


def _options(option: str, known: Iterable[str]) -> str:
    if option in ("--contact", "--correction", "--oversampling"):
        from ...server.osc.addresses import GONE  # slow to load

        return GONE["/contact"]
    return suggestion(option, known) or f"expected {', '.join(known)}, or -- before an argument that begins with -"


class _Version(argparse.Action):
    """Writes Carom's version, and ends the program."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version  # slow to load

        print(f"carom {version('carom')}")
        parser.exit()


def parser_of(commands: Sequence[Command]) -> tuple[Parser, dict[str, Parser]]:
    """Return the parser of the whole line, and those of the commands by name."""
    text = "Hear bodies hit, bounce and roll: play them over OSC, or render a score."
    parser = Parser(prog="carom", usage="%(prog)s COMMAND ...", description=text)
    parser.add_argument("--version", action=_Version, nargs=0, help="show program's version number and exit")
    chosen = parser.add_subparsers(dest="command", metavar="COMMAND", title="commands", prog=parser.prog)
    parsers = {}
    for command in commands:
        text = command.help[0].upper() + command.help[1:] + "."
        usage = f"%(prog)s [options] {command.usage}".rstrip()
        sub = chosen.add_parser(command.name, help=command.help, description=text, usage=usage)
        sub.set_defaults(run=command.run)
        command.add_options(sub)
        parsers[command.name] = sub
    return parser, parsers


def parse(parser: Parser, parsers: dict[str, Parser], words: Sequence[str]) -> argparse.Namespace:
    """Parse the words; `help COMMAND` is `COMMAND --help`.

    SystemExit, with one line on stderr, where they are wrong.
    """
    if not words:
        parser.error(f"no command; expected one of {', '.join(parsers)}")
    if words[0] == "help":
        words = [*words[1:2], "--help"]
    if not words[0].startswith("-") and words[0] not in parsers:
        parser.error(f"{words[0]}: no such command; {expected(words[0], parsers)}")
    if words[0] in parsers:
        arguments = parsers[words[0]].parse_args(parsers[words[0]].ordered(words[1:]))
        arguments.command, arguments.parsers = words[0], (parser, parsers)
        return arguments
    return parser.parse_args(parser.ordered(words))


def one_of(*words: str) -> Callable[[str], str]:
    """Return the type of an option that is one of a few words."""

    def check(word: str) -> str:
        if word in words:
            return word
        raise argparse.ArgumentTypeError(f"{word!r}: {expected(word, words)}")

    return check


def whole(word: str) -> int:
    """Return the type of an option that is a whole number."""
    try:
        return int(word)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{word!r}: expected a whole number") from None


def pascals(word: str) -> float:
    """Return the type of an option that is a pressure in Pa, with its unit or without it."""
    return number(word.removesuffix("Pa").rstrip())


def number(word: str) -> float:
    """Return the type of an option that is a number."""
    try:
        return float(word)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{word!r}: expected a number") from None


_SIZE = re.compile(r"(\d+(?:\.\d+)?) ?([kMGT]?)B?", re.IGNORECASE)


def size(word: str) -> int:
    """Return the type of an option that is a number of bytes, such as 500MB or 1.5G."""
    if not (given := _SIZE.fullmatch(word)):
        raise argparse.ArgumentTypeError(f"{word!r}: expected bytes, such as 500MB or 10GB")
    return int(float(given[1]) * 1000.0 ** " kmgt".index(given[2].lower() or " "))
