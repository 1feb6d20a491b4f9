"""OSC's address patterns, matched without backtracking."""

import re
from collections.abc import Collection, Iterable
from functools import lru_cache, reduce
from operator import or_
from typing import Protocol

from ...dsp.errors import CaromError

MOST_WORK = 300_000.0
"""The highest cost of a packet's patterns, in the units of `work`: some 30 ms."""


class TooMuch(CaromError, ValueError):
    """A packet costs more than it may; the text names the pattern or the target that was too much."""

    def __init__(self, culprit: str) -> None:
        super().__init__(f"{culprit[:40]}: too much for one packet; expected fewer patterns in it")


class Versioned(Protocol):
    """A table of names that counts how often these change."""

    version: int

    @property
    def names(self) -> Collection[str]: ...


_SIGNS = frozenset("*?[{")
_STARS = re.compile(r"\*+")


def is_pattern(address: str) -> bool:
    """True if an address, or a part of one, may match others than itself."""
    return not _SIGNS.isdisjoint(address)


def match(pattern: str, part: str) -> bool:
    """True if an OSC address pattern matches one part of an address (what stands between two slashes).

    `?` is any character, `*` any run of them, `[a-z]` and `[!a-z]` one inside and outside a set, `{ab,c}` one
    of some words. A pattern with an unclosed bracket matches nothing.
    All ways to match are followed at once, as the bits of one integer: bit i says that the pattern so far can
    match the first i characters. So a step costs len(part) bits of work, and no pattern makes it try again.
    """
    pieces = _pieces(pattern)
    if pieces is not None:
        return _in_order(pieces, part)
    steps = _steps(pattern)
    if steps is None:
        return False
    places: dict[str, int] = {}
    for i, character in enumerate(part):
        places[character] = places.get(character, 0) | 1 << i
    everywhere = (2 << len(part)) - 1
    reached = 1
    for step in steps:
        if step == "*":
            reached = everywhere & -(reached & -reached)
        elif step == "?":
            reached = everywhere & reached << 1
        elif isinstance(step, _Set):
            reached = (reached & step.places(places)) << 1
        else:
            reached = _union(_follow(reached, word, places) for word in step)
        if not reached:
            return False
    return bool(reached >> len(part))


def work(pattern: str) -> int:
    """Return the most work that it is to match a pattern against one name, in units of some 0.1 µs."""
    return 4 + len(pattern) // (8 if _pieces(pattern) is not None else 1)


@lru_cache(maxsize=16)
def _pieces(pattern: str) -> tuple[str, ...] | None:
    """Return the text between the stars of a pattern that has no other sign; else None."""
    return tuple(_STARS.sub("*", pattern).split("*")) if not any(sign in pattern for sign in "?[{") else None


def _in_order(pieces: tuple[str, ...], part: str) -> bool:
    """True if a part begins with the first piece, ends with the last, and has the others in between in their order."""
    first, *others = pieces
    if not others:
        return part == first
    end = len(part) - len(others[-1])
    if not part.startswith(first) or end < len(first) or not part.endswith(others[-1]):
        return False
    at = len(first)
    for piece in others[:-1]:
        at = part.find(piece, at, end)
        if at < 0:
            return False
        at += len(piece)
    return True


class Selection:
    """The names that patterns match, as long as that costs no more than `work` in all. Results are kept.

    A packet is carried out with one of these, so that no packet can hold up the others for long.
    """

    def __init__(self, work: float = MOST_WORK) -> None:
        self._left = work
        self._kept: dict[tuple[str, int], tuple[int, tuple[str, ...]]] = {}

    def names(self, pattern: str, table: Versioned) -> tuple[str, ...]:
        """Return the names of a table that a pattern matches, in its order. TooMuch if the work is used up."""
        version, kept = self._kept.get((pattern, id(table)), (-1, ()))
        fresh = version != table.version
        # Whoever asks will do something for each of the names.
        self.spend(8 + len(kept) + (work(pattern) * len(table.names) if fresh else 0), pattern)
        if fresh:
            kept = tuple(name for name in table.names if match(pattern, name))
            self._kept[pattern, id(table)] = table.version, kept
        return kept

    def spend(self, work: float, culprit: str) -> None:
        """Take the work of matching a pattern from the work that is left. TooMuch if there is not so much."""
        if work > self._left:
            raise TooMuch(culprit)
        self._left -= work

    def charge(self, work: float, culprit: str) -> None:
        """Charge the work on what was matched likewise; that of one message is done in any case, if any work is
        left."""
        if work > 0.0 and self._left <= 0.0:
            raise TooMuch(culprit)
        self._left -= work


class _Set(dict[str, bool]):
    """Characters between brackets: whether each that was looked for is in the ranges, or if negated outside."""

    def __init__(self, negated: bool, ranges: frozenset[tuple[str, str]]) -> None:
        self._negated, self._ranges = negated, ranges

    def __missing__(self, character: str) -> bool:
        self[character] = self._negated != any(a <= character <= z for a, z in self._ranges)
        return self[character]

    def places(self, places: dict[str, int]) -> int:
        found = 0
        for character, bits in places.items():
            if self[character]:
                found |= bits
        return found


@lru_cache(maxsize=16)  # a pattern meets every object's name; few, as one may be as long as a datagram
def _steps(pattern: str) -> tuple[str | tuple[str, ...] | _Set, ...] | None:
    """Return the pattern as steps: "*", "?", the words to choose from (a plain character is one), or a set."""
    steps: list[str | tuple[str, ...] | _Set] = []
    start = 0
    while start < len(pattern):
        character = pattern[start]
        end = start
        if character in "[{":
            end = pattern.find("]" if character == "[" else "}", start)
            if end < 0:
                return None
            inside = pattern[start + 1 : end]
            steps.append(tuple(inside.split(",")) if character == "{" else _set(inside))
        elif character in "*?":
            if not (character == "*" and steps and steps[-1] == "*"):
                steps.append(character)
        else:
            steps.append((character,))
        start = end + 1
    return tuple(steps)


def _set(inside: str) -> _Set:
    negated = inside.startswith("!")
    found = re.findall("(.)-(.)|(.)", inside[negated:], re.DOTALL)
    return _Set(negated, frozenset((low or single, high or single) for low, high, single in found))


def _follow(reached: int, word: str, places: dict[str, int]) -> int:
    for character in word:
        reached = (reached & places.get(character, 0)) << 1
        if not reached:
            break
    return reached


def _union(sets: Iterable[int]) -> int:
    return reduce(or_, sets, 0)
