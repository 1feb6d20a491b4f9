"""OSCQuery: the address space as JSON, for programs that look up what they can play.

By Vidvox's proposal (github.com/Vidvox/OSCQueryProposal): the node of an address is it and all below it. All comes from
the registry that checks messages. Ranges are those that a fader should cover; values beyond are taken, as the clip mode
says. The proposal has no word for keys: they stand in the description, with their ranges.
"""

from collections.abc import Callable, Collection, Mapping
from typing import Any

from ...dsp.schema import Parameter as Number
from .addresses import VERBS
from .arguments import Either, Note, Parameter, Verb

GIVEN = (
    "FULL_PATH", "CONTENTS", "DESCRIPTION", "TYPE", "ACCESS", "RANGE", "UNIT", "OVERLOADS", "VALUE", "CLIPMODE",
)  # fmt: skip
_EXTENSIONS = ("ACCESS", "VALUE", "RANGE", "CLIPMODE", "UNIT", "OVERLOADS", "LISTEN", "IGNORE", "PATH_ADDED",
               "PATH_REMOVED")  # fmt: skip
_NOT_GIVEN = ("TAGS", "EXTENDED_TYPE", "CRITICAL", "PATH_RENAMED", "PATH_CHANGED", "OSC_STREAMING", "HTML")
ATTRIBUTES = (*GIVEN, "TAGS", "EXTENDED_TYPE", "CRITICAL")
"""Those that may be asked for."""
_UNITS = {"m/s": "speed.m/s", "dB": "gain.db"}  # the proposal's words, where it has one

Names = Mapping[str, Collection[str]]
"""The choices for a word: objects for `NAME` in an address, gestures for `ID`, presets for the argument `preset`."""

Value = Callable[[str], list[Any] | None]
"""The values that an address has now; None if it has none."""

_ADDRESSES = tuple((tuple(address.split("/")[1:]), verb) for address, verb in VERBS.items())


def host_info(osc_port: int) -> dict[str, Any]:
    """The answer to ?HOST_INFO: OSC goes to a UDP port, and in binary frames of a web socket to the port of HTTP."""
    extensions = {**dict.fromkeys(_EXTENSIONS, True), **dict.fromkeys(_NOT_GIVEN, False)}
    return {"NAME": "Carom", "OSC_PORT": osc_port, "OSC_TRANSPORT": "UDP", "EXTENSIONS": extensions}


def _no_value(path: str) -> None:
    return None


def node(path: str, names: Names, value: Value = _no_value) -> dict[str, Any] | None:
    """The JSON object of an address and of all below it; None where there is nothing."""
    given = path.split("/")[1:] if path != "/" else []
    contents: dict[str, Any] = {}
    for parts, verb in _ADDRESSES:
        if not _leads(given, parts, names):
            continue
        if len(parts) == len(given):
            found = {"FULL_PATH": path, "DESCRIPTION": _description(verb), **_arguments(verb, names)}
            now = value(path)
            return found if now is None else {**found, "ACCESS": 3, "VALUE": now}
        following = parts[len(given)]
        for name in names.get(following, ()) if following.isupper() else (following,):
            if name not in contents and (below := node(f"{path.rstrip('/')}/{name}", names, value)):
                contents[name] = below
    if path == "/" or contents:
        return {"FULL_PATH": path, "ACCESS": 0, "CONTENTS": contents}
    return None


def _leads(given: list[str], parts: tuple[str, ...], names: Names) -> bool:
    return len(given) <= len(parts) and all(
        part in names.get(known, ()) if known.isupper() else part == known
        for part, known in zip(given, parts, strict=False)
    )


def _description(verb: Verb) -> str:
    keys = f"; keys: {', '.join(map(str, verb.keys))}" if verb.keys else ""
    return f"{verb.help}: {verb.usage()}{keys}"


def _arguments(verb: Verb, names: Names) -> dict[str, Any]:
    """The arguments of a method: the shortest list, and as overloads the longer ones with optional arguments."""
    least = max(len(verb.required), 1)
    arguments = (*verb.required, *verb.optional, *((verb.many.number,) if verb.many else ()))
    if not arguments:
        return {"ACCESS": 2, "TYPE": "", "RANGE": [], "CLIPMODE": []}
    lists = [_values(arguments[:count], names) for count in range(least, len(arguments) + 1)]
    return {"ACCESS": 2, **lists[0], **({"OVERLOADS": lists[1:]} if lists[1:] else {})}


def _values(arguments: tuple[Parameter, ...], names: Names) -> dict[str, Any]:
    units = [_UNITS.get(a.unit, a.unit) or None if isinstance(a, Number) else None for a in arguments]
    return {
        "TYPE": "".join("f" if isinstance(a, Number | Note) else "s" for a in arguments),
        "RANGE": [_range(a, names) for a in arguments],
        "CLIPMODE": ["none"] * len(arguments),
        **({"UNIT": units} if any(units) else {}),
    }


def _range(argument: Parameter, names: Names) -> dict[str, Any] | None:
    if isinstance(argument, Number):
        low, high = argument.useful or (argument.low, argument.high)
        return {"MIN": low, "MAX": high}
    if isinstance(argument, Note):
        return {"MIN": argument.low, "MAX": argument.high}
    if isinstance(argument, Either):
        return {"VALS": list(argument.words)}
    return {"VALS": list(names[argument.name])} if argument.name in names else None
