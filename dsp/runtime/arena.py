"""Spans of an array of fixed size, taken and given back."""

from dataclasses import dataclass


class EngineFull(RuntimeError):
    """The engine has no room for what was asked; the message says what is full."""


@dataclass
class Arena:
    """First-fit allocation of spans in an array of fixed size."""

    what: str
    size: int

    def __post_init__(self) -> None:
        self._taken: dict[int, int] = {}  # first -> size

    def take(self, size: int) -> int:
        first = 0
        for start in sorted(self._taken):
            if start - first >= size:
                break
            first = start + self._taken[start]
        if first + size > self.size:
            free = self.size - sum(self._taken.values())
            raise EngineFull(f"no room for {size} {self.what}: {free} of {self.size} are free")
        self._taken[first] = size
        return first

    def give(self, first: int) -> None:
        del self._taken[first]
