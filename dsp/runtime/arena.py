"""Spans of an array of fixed size, taken and given back."""

from bisect import bisect_left
from dataclasses import dataclass

from ..errors import CaromError


class EngineFull(CaromError, RuntimeError):
    """The engine has no room for what was asked; the message says what is full."""


@dataclass
class Arena:
    """First-fit allocation of spans in an array of fixed size."""

    what: str
    size: int

    def __post_init__(self) -> None:
        self._taken: dict[int, int] = {}  # first -> size
        self._free = [(0, self.size)]  # first and size, in order, none next to another
        self._left = self.size
        self.reached = 0
        """The first so many are all that was ever taken."""

    def take(self, size: int) -> int:
        for place, (first, room) in enumerate(self._free):
            if room >= size:
                self._free[place : place + 1] = [(first + size, room - size)] if room > size else []
                self._taken[first] = size
                self._left -= size
                self.reached = max(self.reached, first + size)
                return first
        raise EngineFull(f"no capacity for {size} {self.what}: {self._left} of {self.size} are free")

    def give(self, first: int) -> int:
        """Give a span back; return its size."""
        size = self._taken.pop(first)
        self._left += size
        place = bisect_left(self._free, (first, 0))
        begin, end, low, high = first, first + size, place, place
        if place < len(self._free) and self._free[place][0] == end:
            end, high = end + self._free[place][1], place + 1
        if place > 0 and sum(self._free[place - 1]) == first:
            begin, low = self._free[place - 1][0], place - 1
        self._free[low:high] = [(begin, end - begin)]
        return size
