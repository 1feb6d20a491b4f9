"""Gestures by their names: what was started, by whom, and how it ended."""

from collections import deque
from dataclasses import dataclass
from typing import Any

from ..dsp.host import Engine
from ..dsp.state import End

_REMEMBERED = 1_024  # gestures that have ended: to stop one of them is no mistake


@dataclass(eq=False)
class Gesture:
    """Something that was started: its id, its number in the engine, the address that started it, who sent that, and
    how often it was told to go on."""

    id: str
    serial: int
    address: str
    source: Any
    turn: int = 0


@dataclass(frozen=True)
class Ended:
    """A gesture that is over."""

    gesture: Gesture
    end: End


class Gestures:
    """The gestures of an engine, by id."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._running: dict[int, Gesture] = {}
        self._over: deque[Gesture] = deque(maxlen=_REMEMBERED)
        self._ends: deque[Ended] = deque(maxlen=8 * _REMEMBERED)
        self._count = 0

    def __len__(self) -> int:
        return len(self._running)

    def new(self, id: str, address: str, source: Any) -> Gesture:
        """A gesture about to be sent; `forget` it if it is not."""
        self._count += 1
        gesture = Gesture(id, self._count, address, source)
        self._running[gesture.serial] = gesture
        return gesture

    def rolling(self, id: str, address: str) -> Gesture | None:
        """The roll of that id that an address has started, if it may still go on."""
        for gesture in reversed(self._running.values()):
            if gesture.id == id and gesture.address == address:
                return gesture
        return None

    def numbered(self, name: str) -> str:
        """An id for a gesture that was given none."""
        return f"{name}-{self._count + 1}"

    def forget(self, gesture: Gesture) -> None:
        """Take back the last `new`: a score of what was not refused counts alike."""
        del self._running[gesture.serial]
        self._count -= 1

    def known(self) -> list[Gesture]:
        """The gestures that run or ended not long ago; several may share an id."""
        return [*self._over, *self._running.values()]

    def runs(self, gesture: Gesture) -> bool:
        return gesture.serial in self._running

    def collect(self) -> None:
        """Learn from the engine what has ended."""
        for serial, turn, end in self._engine.ended():
            gesture = self._running.get(serial)
            if gesture and gesture.turn == turn:  # else it has been started anew meanwhile
                del self._running[serial]
                self._ends.append(Ended(gesture, end))
                self._over.append(gesture)

    def take_ends(self) -> list[Ended]:
        """What has ended since the last call."""
        self.collect()
        ends = list(self._ends)
        self._ends.clear()
        return ends
