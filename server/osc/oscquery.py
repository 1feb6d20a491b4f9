"""OSCQuery: the address space as JSON, for programs that look up what they can play.

By Vidvox's proposal (github.com/Vidvox/OSCQueryProposal): the node of an address is it and all below it. All comes from
the registry that checks messages. Ranges are those that a fader should cover; values beyond are taken, as the clip mode
says. The proposal has no word for keys: they stand in the description, with their ranges.
"""

import json
from collections.abc import Callable, Collection, Iterator, Mapping
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
"""Attributes that may be requested."""
_UNITS = {"m/s": "speed.m/s", "dB": "gain.db"}  # the proposal's words, where it has one

Names = Mapping[str, Collection[str]]
"""The choices for a word: objects for `NAME` in an address, gestures for `ID`, presets for the argument `preset`."""

Value = Callable[[str], list[Any] | None]
"""The values that an address has now; None if it has none."""

_Tree = dict[str, Any]  # by the next part of addresses: a verb, or a tree


def _tree() -> _Tree:
    tree: _Tree = {}
    for address, verb in VERBS.items():
        *above, last = address.split("/")[1:]
        here = tree
        for part in above:
            here = here.setdefault(part, {})
        here[last] = verb
    return tree


_ADDRESSES = _tree()


def host_info(osc_port: int) -> dict[str, Any]:
    """Return the answer to ?HOST_INFO: OSC goes to a UDP port, and in binary frames of a web socket to the port of
    HTTP."""
    extensions = {**dict.fromkeys(_EXTENSIONS, True), **dict.fromkeys(_NOT_GIVEN, False)}
    return {"NAME": "Carom", "OSC_PORT": osc_port, "OSC_TRANSPORT": "UDP", "EXTENSIONS": extensions}


def _no_value(path: str) -> None:
    return None


def node(path: str, names: Names, value: Value = _no_value) -> dict[str, Any] | None:
    """Return the JSON object of an address and of all below it; None where there is nothing."""
    pieces = text(path, names, value)
    return None if pieces is None else dict(json.loads("".join(pieces)))


def text(path: str, names: Names, value: Value = _no_value, attribute: str = "") -> Iterator[str] | None:
    """Return the text of that object, or of one of its attributes (nothing if it has none), in pieces of a method each.

    Whoever waits for Python's lock gets it between two pieces.
    """
    here = _at(path, names)
    if here is None:
        return None
    return _Described(names, value).text(path, here, attribute)


def _at(path: str, names: Names) -> Verb | _Tree | None:
    """Return what is at an address: a method, or the tree below it."""
    here: Any = _ADDRESSES
    for part in path.split("/")[1:] if path != "/" else ():
        if isinstance(here, Verb):
            return None
        word = part if not part.isupper() else ""
        if word not in here:
            word = next((known for known in here if known.isupper() and part in names.get(known, ())), "")
        here = here.get(word)
        if here is None:
            return None
    return here if here is _ADDRESSES or isinstance(here, Verb) or _has_any(here, names) else None


def _has_any(tree: _Tree, names: Names) -> bool:
    """True if there is anything below an address."""
    return any(not part.isupper() or names.get(part) for part in tree)


class _Described:
    """The texts of nodes, with names and values as they are now."""

    def __init__(self, names: Names, value: Value) -> None:
        self._names, self._value = names, value
        self._methods: dict[str, dict[str, Any]] = {}
        self._texts: dict[str, str] = {}

    def text(self, path: str, here: Verb | _Tree, attribute: str = "") -> Iterator[str]:
        """Yield a node in pieces, or one of its attributes."""
        if not isinstance(here, Verb):
            yield from self._container(path, here, attribute)
        elif attribute:
            given = {**self._own(path), **self._method(here)}
            if attribute in given:
                yield json.dumps({attribute: given[attribute]})
        else:
            yield f"{json.dumps(self._own(path))[:-1]}, {self._text(here)}"

    def _container(self, path: str, here: _Tree, attribute: str) -> Iterator[str]:
        own = {"FULL_PATH": path, "ACCESS": 0}
        if attribute in own:
            yield json.dumps({attribute: own[attribute]})
        if attribute not in ("", "CONTENTS"):
            return
        yield "{" if attribute else f"{json.dumps(own)[:-1]}, "
        between = '"CONTENTS": {'
        for part, below in here.items():
            if isinstance(below, Verb) or _has_any(below, self._names):
                for name in self._names.get(part, ()) if part.isupper() else (part,):
                    yield f"{between}{json.dumps(name)}: "
                    yield from self.text(f"{path.rstrip('/')}/{name}", below)
                    between = ", "
        yield "}}"

    def _own(self, path: str) -> dict[str, Any]:
        """Return the part of a method's node that is of its address alone."""
        now = self._value(path)
        return {"FULL_PATH": path, "ACCESS": 2} if now is None else {"FULL_PATH": path, "ACCESS": 3, "VALUE": now}

    def _method(self, verb: Verb) -> dict[str, Any]:
        """Return the part of a method's node that is the same at all its addresses."""
        if verb.address not in self._methods:
            self._methods[verb.address] = {"DESCRIPTION": _description(verb), **_arguments(verb, self._names)}
        return self._methods[verb.address]

    def _text(self, verb: Verb) -> str:
        if verb.address not in self._texts:
            self._texts[verb.address] = json.dumps(self._method(verb))[1:]
        return self._texts[verb.address]


def _description(verb: Verb) -> str:
    keys = f"; keys: {', '.join(map(str, verb.keys))}" if verb.keys else ""
    return f"{verb.help}: {verb.usage()}{keys}"


def _arguments(verb: Verb, names: Names) -> dict[str, Any]:
    """Return the arguments of a method: the shortest list, and as overloads the longer ones with optional arguments."""
    least = max(len(verb.required), 1)
    arguments = (*verb.required, *verb.optional, *((verb.many.number,) if verb.many else ()))
    if not arguments:
        return {"TYPE": "", "RANGE": [], "CLIPMODE": []}
    lists = [_values(arguments[:count], names) for count in range(least, len(arguments) + 1)]
    return {**lists[0], **({"OVERLOADS": lists[1:]} if lists[1:] else {})}


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
