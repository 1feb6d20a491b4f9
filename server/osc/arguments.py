"""The arguments of an address: their names, kinds and ranges, and the check of a message's arguments by them."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

from ...dsp.errors import CaromError
from ...dsp.schema import Parameter as Number
from ...dsp.wording import expected
from .wire import Argument

_LONGEST_SHOWN = 40  # characters of a value in an error
_NAME = re.compile(r"[^\s#*,/?\[\]{}]{1,64}")
_FORBIDDEN = "# * , / ? [ ] { } or space"


class Refused(CaromError, ValueError):
    """A message that the server does not carry out. The text names the culprit, its value and what was expected."""


class GestureEnded(Refused):
    """A message that steers a gesture that has ended."""


def shown(value: Argument) -> str:
    """Return a value as an error names it: a list as a score has it, and nil and blobs by OSC's names."""
    if isinstance(value, float):
        return min(f"{value:g}", repr(value), key=len)
    if value is None:
        return "nil"
    if isinstance(value, int) and value.bit_length() > 64:  # Python refuses to spell the longest
        return f"a whole number of {value.bit_length()} bits"
    if isinstance(value, bytes):
        return f"a blob of {len(value)} bytes{_IN_SUPERCOLLIDER if _NESTED.match(value) else ''}"
    if isinstance(value, tuple | list):
        return _cut(f"[{' '.join(map(shown, value[:_LONGEST_SHOWN]))}]")
    return _cut(value if isinstance(value, str) and not _looks_like_a_number(value) else repr(value))


_IN_SUPERCOLLIDER = ", which SuperCollider makes of an array (send $[, its values, $])"
_NESTED = re.compile(rb"(?:.{4}){1,64}?,[ifsb]*\0", re.DOTALL)  # its first value, padded, and the tags of the others


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST_SHOWN else text[: _LONGEST_SHOWN - 3] + "..."


def beyond(number: Number, value: Argument) -> str:
    """Return a value that is not within a number's bounds as an error names it: by all digits where six look as if it
    were."""
    text = shown(value)
    rounds = isinstance(value, float) and number.low <= float(text) <= number.high
    return repr(value) if rounds else text


def _looks_like_a_number(text: str) -> bool:
    """True if a text, shown without quotes, is taken for a number, or for nothing."""
    try:
        float(text or "0")
    except ValueError:
        return False
    return True


def require_name(key: str, name: Argument) -> None:
    """Refuse a name that can't be a part of an address."""
    if not isinstance(name, str) or not _NAME.fullmatch(name) or not name.isprintable():
        raise Refused(f"{key} = {shown(name)}: expected 1 to 64 printable characters, none of them {_FORBIDDEN}")


def check_number(number: Number, value: Argument) -> float:
    """Return a numeric argument as a float; raise Refused if it is no number, out of range, or not whole where it must
    be."""
    taken = number.within(value) if isinstance(value, (int, float)) else None
    if taken is None:
        raise Refused(f"{number.name} = {beyond(number, value)}: expected {number.expected}")
    if number.whole and not taken.is_integer():
        raise Refused(f"{number.name} = {shown(value)}: expected a whole number")
    return taken


class Word(NamedTuple):
    """An argument that is a name."""

    name: str
    help: str = ""
    otherwise: str = ""
    """What it is where none is given."""

    def check(self, value: Argument) -> str:
        """Return the value; raise Refused if it is no text, or an empty one."""
        if isinstance(value, str) and value:
            return value
        raise Refused(f"{self.name} = {shown(value)}: expected a name")

    def __str__(self) -> str:
        return self.name


class Either(NamedTuple):
    """An argument that is one of a few words; a number stands for the word that is written like it."""

    name: str
    words: tuple[str, ...]
    help: str = ""
    otherwise: str = ""
    """The word where none is given."""
    old: tuple[str, ...] = ()
    """Words of earlier versions, which are taken, too."""

    def check(self, value: Argument) -> str:
        """Return the word; raise Refused if it is none of them."""
        word = shown(float(value) if isinstance(value, bool) else value) if isinstance(value, int | float) else value
        if isinstance(word, str) and word in (*self.words, *self.old):
            return word
        raise Refused(f"{self.name} = {shown(value)}: {expected(value, self.words)}")

    def __str__(self) -> str:
        return self.name


_NOTE = re.compile(r"([A-Ga-g])(#|b|s)?(-?\d{1,2})")
_STEPS = {"C": 0, "D": 2, "E": 4, "F": 5, "G": 7, "A": 9, "B": 11}
_SIGNS = {"#": 1, "s": 1, "b": -1, None: 0}


class Note(NamedTuple):
    """An argument that is a note: a MIDI number, perhaps between two keys, or a name such as C#4; A4 is 69."""

    name: str
    help: str = ""
    low: float = 0.0
    high: float = 127.0

    def check(self, value: Argument) -> float:
        """Return the MIDI number; raise Refused if it is no note."""
        if isinstance(value, str) and (named := _NOTE.fullmatch(value)):
            letter, sign, octave = named.groups()
            value = 12 * (int(octave) + 1) + _STEPS[letter.upper()] + _SIGNS[sign]
        if not isinstance(value, int | float) or not self.low <= value <= self.high:
            raise Refused(f"{self.name} = {shown(value)}: expected a MIDI number from 0 to 127, or a name such as C#4")
        return float(value)

    def __str__(self) -> str:
        return f"{self.name} 0 to 127, or such as C#4"


class Numbers(NamedTuple):
    """Any number of arguments that are numbers of one kind: one after the other, or a list of them."""

    number: Number
    most: int
    name: str
    help: str = ""

    def check(self, arguments: tuple[Argument, ...]) -> tuple[float, ...]:
        """Return the numbers; raise Refused if they are too many, or one is not as it should be."""
        first = arguments[0] if len(arguments) == 1 else None
        given = first if isinstance(first, tuple) else arguments
        if len(given) > self.most:
            raise Refused(f"{len(given)} {self.name}: expected at most {self.most}")
        return tuple(check_number(self.number, value) for value in given)

    def __str__(self) -> str:
        return f"{self.name}, up to {self.most} of {self.number.bounds}"


class Vector(NamedTuple):
    """An argument that is three numbers: one after the other, a list of them, or a text such as 0.1,0,0.2."""

    name: str
    axes: tuple[Number, ...]
    help: str = ""

    def check(self, value: Argument) -> tuple[float, float, float]:
        """Return the numbers; raise Refused if they are not three, or one is not as it should be."""
        given = value.split(",") if isinstance(value, str) else value
        if not isinstance(given, tuple | list) or len(given) != len(self.axes):
            raise Refused(f"{self.name} = {shown(value)}: expected three numbers: {self}")
        x, y, z = (check_number(axis, spelled(each)) for axis, each in zip(self.axes, given, strict=True))
        return x, y, z

    def __str__(self) -> str:
        return f"{self.name} {' '.join(axis.name for axis in self.axes)} {self.axes[0].bounds}"


def spelled(value: Argument) -> Argument:
    """Return the number that a text spells, or else the value."""
    if not isinstance(value, str):
        return value
    try:
        return float(value)
    except ValueError:
        return value


Parameter = Number | Word | Either | Note
Key = Number | Word | Either | Numbers | Note | Vector


class Point(NamedTuple):
    """A value that a number takes, at once or in time: s until the way there begins, s that it takes, and its curve."""

    value: float
    after: float = 0.0
    over: float = 0.0
    curve: float = 0.0


@dataclass
class Values:
    """The checked arguments of a message, by name: those that it gives, and the defaults of its numbers."""

    numbers: dict[str, float] = field(default_factory=dict)
    words: dict[str, str] = field(default_factory=dict)
    vectors: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    others: dict[str, Argument] = field(default_factory=dict)
    defaults: dict[str, float] = field(default_factory=dict)
    many: tuple[float, ...] = ()
    """Numbers of an argument that is any number of them."""
    points: tuple[Point, ...] = ()
    """Points of an argument that may take its time."""
    paths: tuple[tuple[Point, ...], ...] = ()
    """The same of each number of a vector that may."""

    def number(self, name: str) -> float:
        """Return a number as it is given, else its default."""
        return self.numbers[name] if name in self.numbers else self.defaults[name]

    def add(self, parameter: Key, value: Argument) -> None:
        """Check a value and keep it; Refused if it does not fit or was given before."""
        if parameter.name in self.numbers or parameter.name in self.words or parameter.name in self.vectors:
            raise Refused(f"{parameter.name} = {shown(value)}: given twice")
        if isinstance(parameter, Numbers):
            self.many = parameter.check((value,))
        elif isinstance(parameter, Number):
            self.numbers[parameter.name] = check_number(parameter, value)
        elif isinstance(parameter, Vector):
            self.vectors[parameter.name] = parameter.check(value)
        elif isinstance(parameter, Note):
            self.numbers[parameter.name] = parameter.check(value)
        else:
            self.words[parameter.name] = parameter.check(value)


@dataclass(frozen=True)
class Verb:
    """An address and its arguments: required ones, optional positional numbers, then key value pairs."""

    address: str
    """Address as it is sent, but for a part in capitals, which stands for the name of an object or the id of a
    gesture."""
    help: str
    required: tuple[Parameter, ...] = ()
    optional: tuple[Number, ...] = ()
    keys: tuple[Key, ...] = ()
    many: Numbers | None = None
    """Numbers that may follow instead of optional ones and keys."""
    open_keys: bool = False
    """True if it takes keys that are not declared here: who carries the message out checks them."""
    scored: bool = True
    """True if a score may hold it; the others are for a running server alone."""

    @property
    def target(self) -> str:
        """The word that stands for a name in its address, NAME or ID; empty if none does."""
        return next(filter(str.isupper, self.address.split("/")), "")

    @property
    def action(self) -> str:
        """The last part of the address, such as `impact` or `gain`."""
        return self.address.rsplit("/", 1)[1]

    @property
    def is_bare(self) -> bool:
        """True if it takes no arguments."""
        return not (self.required or self.optional or self.keys or self.many or self.open_keys)

    @cached_property
    def named(self) -> dict[str, Key]:
        """The declared keys by name; an optional argument can be given as one."""
        return {key.name: key for key in (*self.keys, *self.optional)}

    @cached_property
    def defaults(self) -> dict[str, float]:
        """The defaults of its numbers, by name."""
        numbers = (key for key in self.named.values() if isinstance(key, Number))
        return {number.name: number.default for number in numbers if number.default is not None}

    def parse(self, args: tuple[Argument, ...]) -> Values:
        """Return the checked values by name; raise Refused that names the argument that does not fit."""
        if len(args) < len(self.required):
            missing = self.required[len(args)]
            wanted = f", with {missing}" if isinstance(missing, Number) else ""
            raise Refused(f"{missing.name} is missing: expected {self.usage()}{wanted}")
        values = Values(defaults=self.defaults)
        for parameter, value in zip(self.required, args, strict=False):
            values.add(parameter, value)
        if self.many:
            values.many = self.many.check(args[len(self.required) :])
            return values
        rest = list(args[len(self.required) :])
        for number in self.optional:
            if rest and (not isinstance(rest[0], str) or (len(rest) % 2 and rest[0] not in self.named)):
                values.add(number, rest.pop(0))
        for key, value in self.pairs(rest):
            if key in self.named:
                values.add(self.named[key], value)
            elif key in values.others:
                raise Refused(f"{key} = {shown(value)}: given twice")
            else:
                values.others[key] = value
        return values

    def pairs(self, rest: Sequence[Argument]) -> Iterator[tuple[str, Argument]]:
        """Yield keys and their values; raise Refused that names one that is no key.

        A vector is the next three arguments, unless the next one is a list or a text.
        """
        i = 0
        while i < len(rest):
            key = rest[i]
            if not self.named and not self.open_keys:
                raise Refused(f"{shown(key)}: one argument too many: expected {self.usage()}")
            if not isinstance(key, str):
                raise Refused(f"{shown(key)}: expected a key; {self.usage()}")
            if key not in self.named and not self.open_keys:
                raise Refused(f"{shown(key)}: no such key; {expected(key, self.named)}")
            if i + 1 == len(rest):
                raise Refused(f"{key}: its value is missing")
            takes = 3 if isinstance(self.named.get(key), Vector) and not isinstance(rest[i + 1], tuple | str) else 1
            yield key, rest[i + 1] if takes == 1 else tuple(rest[i + 1 : i + 1 + takes])
            i += 1 + takes

    def usage(self) -> str:
        """Return the address and the names of its arguments, optional ones in brackets."""
        words = [a.name for a in self.required] + [f"[{a.name}]" for a in self.optional]
        words += [f"[{self.many.name} ...]"] if self.many else []
        return " ".join([self.address, *words, *(["[key value ...]"] if self.keys or self.open_keys else [])])
