"""OSC's address patterns, matched without backtracking."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache, reduce
from operator import or_


def is_pattern(address: str) -> bool:
    """Whether an address, or a part of one, may match others than itself."""
    return any(sign in address for sign in "*?[{")


def match(pattern: str, part: str) -> bool:
    """Whether an OSC address pattern matches one part of an address (what stands between two slashes).

    `?` is any character, `*` any run of them, `[a-z]` and `[!a-z]` one inside and outside a set, `{ab,c}` one
    of some words. A pattern with an unclosed bracket matches nothing.
    All ways to match are followed at once, as the bits of one integer: bit i says that the pattern so far can
    match the first i characters. So a step costs len(part) bits of work, and no pattern makes it try again.
    """
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


@dataclass(frozen=True)
class _Set:
    """Characters between brackets: those in, or if negated outside, the ranges."""

    negated: bool
    ranges: frozenset[tuple[str, str]]

    def places(self, places: dict[str, int]) -> int:
        return _union(places[c] for c in places if self.negated != any(a <= c <= z for a, z in self.ranges))


@lru_cache(maxsize=16)  # a pattern meets every object's name; few, as one may be as long as a datagram
def _steps(pattern: str) -> tuple[str | tuple[str, ...] | _Set, ...] | None:
    """The pattern as steps: "*", "?", the words to choose from (a plain character is one), or a set."""
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
