"""Parts of keyboards: the objects that play notes, by channel and range."""

from dataclasses import dataclass

MOST = 128
"""Parts that there may be."""


@dataclass(frozen=True)
class Part:
    """The notes from the lowest to the highest one of a channel (0: any), and the object that plays them."""

    name: str
    channel: int
    low: float
    high: float

    def holds(self, channel: int, note: float) -> bool:
        """True if a note of a channel belongs to it."""
        return self.channel in (0, channel) and self.low <= note <= self.high

    def covers(self, other: "Part") -> bool:
        """True if all notes of another part of the same channel belong to it."""
        return self.channel == other.channel and self.low <= other.low and other.high <= self.high


class Parts:
    """All parts. What names its channel goes before what names none; then the newest one counts."""

    def __init__(self) -> None:
        self._parts: list[Part] = []

    def add(self, part: Part) -> bool:
        """Give notes to an object, in place of the parts that it covers; return False where there are too many."""
        rest = [each for each in self._parts if not part.covers(each)]
        if len(rest) >= MOST:
            return False
        self._parts = sorted([part, *rest], key=lambda each: each.channel == 0)
        return True

    def player(self, channel: int, note: int) -> str:
        """Return the name of the object that plays a note; "" where no part holds it."""
        return next((each.name for each in self._parts if each.holds(channel, note)), "")
