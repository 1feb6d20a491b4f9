"""A cache of what took time to make, for those who ask for it again soon."""

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock
from typing import Any, Generic, TypeVar
from weakref import WeakSet

_Key = TypeVar("_Key", bound=Hashable)
_Value = TypeVar("_Value")

SECONDS = 20.0
"""Time (s) for which something that nobody asks for is kept: a server's memory settles within a minute, whatever it is
sent."""


def forget() -> None:
    """Forget all that nobody has requested lately."""
    for each in tuple(_everything):
        each.forget()


class Kept(Generic[_Key, _Value]):
    """Values by keys, those requested last: no more than so many bytes, none older than SECONDS once one is requested.

    Any thread may ask.
    """

    def __init__(self, most: int, size: Callable[[_Value], int]) -> None:
        """Prepare to keep at most `most` bytes; `size` returns the bytes that a value takes."""
        _everything.add(self)
        self.most = most
        self._size = size
        self._lock = Lock()
        self._values: OrderedDict[_Key, tuple[_Value, float, int]] = OrderedDict()  # when last requested (s), bytes
        self._bytes = 0

    def get(self, key: _Key) -> _Value | None:
        """Return the value of a key, if it is kept."""
        now = time.monotonic()
        with self._lock:
            found = self._values.pop(key, None)
            if found:
                self._values[key] = found[0], now, found[2]
            self._forget(now)
            return found[0] if found else None

    def all(self) -> list[tuple[_Key, _Value]]:
        """Return all keys and values."""
        with self._lock:
            return [(key, value) for key, (value, _, _) in self._values.items()]

    def put(self, key: _Key, value: _Value) -> None:
        """Keep a value; where another thread was faster, that one's."""
        entry = value, time.monotonic(), self._size(value)
        with self._lock:
            if self._values.setdefault(key, entry) is entry:
                self._bytes += entry[2]
                self._forget(entry[1])

    def forget(self) -> None:
        """Forget what nobody has requested lately."""
        with self._lock:
            self._forget(time.monotonic())

    def _forget(self, now: float) -> None:
        oldest = now - SECONDS
        while self._values and (self._bytes > self.most or next(iter(self._values.values()))[1] < oldest):
            self._bytes -= self._values.popitem(last=False)[1][2]


_everything: WeakSet[Kept[Any, Any]] = WeakSet()
