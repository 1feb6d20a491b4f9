"""The domains of a preset's values: numbers in a range, words, and lists of these.

`fit` gives a value as it is used, or raises Unfit. A list's `parse` gives the list that a text spells, for senders that
can't send one.
"""

from __future__ import annotations

import re
import reprlib
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from ..dsp.errors import CaromError
from ..dsp.numerics.quantities import Parameter, Range
from ..dsp.wording import suggestion

NAME = re.compile(r"[A-Za-z0-9_-]{1,64}")
LONGEST_LIST = 1024  # values: an object has no more modes
_LONGEST_SHOWN = 300  # characters: lists in lists have many, each of them short
_SEPARATOR = re.compile(r"[,\s]+")


class Unfit(CaromError, ValueError):
    """A value that does not fit; the text is "VALUE: expected WHAT", after "item N = " inside a list."""

    def __init__(self, value: object, expected: object, item: int | None = None) -> None:
        self.value, self.expected, self.item = value, expected, item
        place = "" if item is None else f": item {item}"
        meant = suggestion(value, expected.options) if isinstance(expected, Choice) else ""
        super().__init__(f"{place} = {shown(value)}: {meant or f'expected {expected}'}")


def shown(value: object) -> str:
    """Return a value as an error names it, cut where it is long. A tuple looks like the list that it stands for."""
    text = reprlib.repr(list(value) if isinstance(value, tuple) else value)
    return text if len(text) <= _LONGEST_SHOWN else f"{text[: _LONGEST_SHOWN - 3]}..."


class Computed(float):
    """A number that follows from a user's: an error names it by six digits."""

    def __repr__(self) -> str:
        return repr(float(f"{self:.6g}"))


class Quantity(Range):
    """A number in a range, bounds included, and its unit."""

    @classmethod
    def of(cls, number: Parameter) -> Quantity:
        """Return the range of a parameter."""
        return cls(number.low, number.high, number.unit, number.or_zero)

    def __str__(self) -> str:
        return self.expected

    def fit(self, value: object) -> float:
        taken = None if isinstance(value, bool) or not isinstance(value, int | float) else self.within(value)
        if taken is None:
            raise Unfit(value, self)
        return taken


class Whole(Quantity):
    """A whole number in a range; it may be written as a float."""

    def __str__(self) -> str:
        return f"a whole number from {self.low:g} to {self.high:g}"

    def fit(self, value: object) -> int:
        number = super().fit(value)
        if not number.is_integer():
            raise Unfit(value, self)
        return int(value)  # type: ignore[call-overload, no-any-return]  # a float has 53 bits of a seed's 63


class Text:
    """Any text."""

    def __str__(self) -> str:
        return "a text"

    def fit(self, value: object) -> str:
        if not isinstance(value, str):
            raise Unfit(value, self)
        return value


class Name(Text):
    """The name of a preset."""

    def __str__(self) -> str:
        return "a name of up to 64 letters, digits, _ and -"

    def fit(self, value: object) -> str:
        if not isinstance(value, str) or not NAME.fullmatch(value):
            raise Unfit(value, self)
        return value


class Choice(NamedTuple):
    """One of a few words."""

    options: tuple[str, ...]

    def __str__(self) -> str:
        return f"one of {', '.join(self.options)}"

    def fit(self, value: object) -> str:
        if not isinstance(value, str) or value not in self.options:
            raise Unfit(value, self)
        return value


class Row(NamedTuple):
    """A list of a fixed length, whose items fit one domain each."""

    items: tuple[Quantity | Choice, ...]

    def __str__(self) -> str:
        if len(set(self.items)) == 1:
            return f"a list of {len(self.items)}, each {self.items[0]}"
        return f"a list of {len(self.items)}: {', then '.join(map(str, self.items))}"

    def fit(self, value: object) -> tuple[Any, ...]:
        if not isinstance(value, list | tuple) or len(value) != len(self.items):
            raise Unfit(value, self)
        return _fit_items(self.items, value)

    def parse(self, text: str) -> object:
        return _parse_items(text)


class Many(NamedTuple):
    """A list of one to some items of one domain."""

    item: Quantity | Row
    most: int = LONGEST_LIST

    def __str__(self) -> str:
        return f"a list of 1 to {self.most}, each {self.item}"

    def fit(self, value: object) -> Any:
        if not isinstance(value, list | tuple) or not 0 < len(value) <= self.most:
            raise Unfit(value, self)
        return _fit_items((self.item,) * len(value), value)

    def parse(self, text: str) -> object:
        return _parse_items(text)


class OneOrMany(Many):
    """One value, or a list of such."""

    def __str__(self) -> str:
        return f"{self.item}, or a list of such"

    def fit(self, value: object) -> Any:
        if isinstance(value, list | tuple):
            return super().fit(value)
        try:
            return self.item.fit(value)
        except Unfit:
            raise Unfit(value, self) from None

    def parse(self, text: str) -> object:
        items = _parse_items(text)
        return items[0] if len(items) == 1 else items


class Rows(NamedTuple):
    """A list of 1 to LONGEST_LIST lists of one domain, all of one length."""

    item: Quantity

    def __str__(self) -> str:
        return f"a list of lists that are alike long, each value {self.item}"

    def fit(self, value: object) -> tuple[tuple[float, ...], ...]:
        if not isinstance(value, list | tuple) or not 0 < len(value) <= LONGEST_LIST:
            raise Unfit(value, self)
        row = Many(self.item)
        rows = []
        for number, each in enumerate(value, 1):
            try:
                rows.append(row.fit(each))
            except Unfit as error:
                raise Unfit(error.value, error.expected, number) from None
            if len(rows[-1]) != len(rows[0]):
                raise Unfit(each, f"{len(rows[0])} values, as in the first", number)
        return tuple(rows)


class Section:
    """A TOML table with keys of its own."""

    def __str__(self) -> str:
        return "a section of keys"

    def fit(self, value: object) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise Unfit(value, self)
        return value


class Made(NamedTuple):
    """A value that is made of a preset's files: whoever sends keys can't send one."""

    kind: Callable[[], type]
    description: str

    def __str__(self) -> str:
        return self.description

    def fit(self, value: object) -> Any:
        if not isinstance(value, self.kind()):
            raise Unfit(value, self)
        return value


Domain = Quantity | Text | Choice | Row | Many | Rows | Section | Made


def _fit_items(domains: Sequence[Quantity | Choice | Row], values: Sequence[object]) -> tuple[Any, ...]:
    fitted = []
    for number, (domain, value) in enumerate(zip(domains, values, strict=True), 1):
        try:
            fitted.append(domain.fit(value))
        except Unfit as error:
            raise Unfit(error.value, error.expected, number) from None
    return tuple(fitted)


def _parse_items(text: str) -> list[float | str]:
    """Parse the items of a text like "440, 881.5" or "free clamped"; a word that is no number stays a word."""
    return [_number_or_word(word) for word in _SEPARATOR.split(text.strip(", \t\n")) if word]


def _number_or_word(word: str) -> float | str:
    try:
        return float(word)
    except ValueError:
        return word
